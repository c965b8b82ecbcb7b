"""The language of messages, help, docstrings and pages: one vocabulary, and no phrase that is on the list."""

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner
from tests import ROOT

from allanite.cli import VERBS, main

PACKAGE = ROOT / "src" / "allanite"

ROOTS = (
    "src/allanite/**/*.py",
    "src/allanite/**/*.j2",
    "README.md",
    "docs/*.md",
)
"""What is read."""

BANNED = (
    # the field's words
    r"overlapped (Allan|Hadamard)",
    r"effective value",
    r"half bandwidth",
    r"lost (reading|sample)s?\b",
    r"readings? (is|are) lost",
    r"kind of noise rules",
    r"chance of more",
    r"amplitude density",
    r"maximum error of the angle",
    r"(rms|RMS) error of the angle",
    # -ize
    r"\b(re)?analys(e|ed|es|ing)\b",
    r"\b(general|diagonal|maxim|discret|standard|recogn|quant|normal|summar|optim|initial)is(e|es|ed|ing|ation)\b",
    r"(?<![.`_(])\bminimis(e|es|ed|ing)\b(?![(`])",
    # "not a", not "no", before a noun that is predicated
    r"(?<!there )\bis no (noise|integer|multiple|unit|description|sinusoid|recording|number)\b(?! to)",
    r"(?<!there )\bare no (outliers|recordings|sinusoids|noise)\b",
    # phrases of another language
    r"\bhonest\b",
    r"\bis (told|said)\b",
    r"\bstands? for\b",
    r"\blies? apart\b",
    r"\bon their way\b",
    r"\bcounts them in\b",
    r"\bcounted in\b",
    r"(?<!for )\bin words\b",
    r"\bin silence\b",
    r"\breckoned with\b",
    r"\bleads? (one|you) to expect\b",
    r"\bgoes? together (fast|slowly)\b",
    r"\bthe luck of\b|\bby luck\b",
    r"\bworth a word\b",
    r"\bof no one's\b",
    r"\bkeeps? its word\b",
    r"\bforgets itself\b",
    r"\bnobody asked for\b",
    r"\btake[ns]? off\b",
    r"\bestimated along\b",
    r"\bthe record (does not|cannot) tell\b",
    r"\bwhat (the|a) models? leaves? of\b",
    r"\bas (was|is) asked\b",
    r"\bwhat is being done and the fraction\b",
    r"^Of (the|a|an|all|this) ",
)
"""Regular expressions; a new text that one of them finds is to be written otherwise."""

COMMANDS = {"phrases/wording.py", "study/drift.py", "readers/clock/findings.py", "web/requests.py", "web/tables.py"}
"""Files outside the command line that write an option: the rendering of both forms, and whole commands."""


def texts(path: Path) -> Iterator[tuple[int, str]]:
    """Strings, docstrings and comments of a module; lines of any other file."""
    source = path.read_text(encoding="utf-8")
    if path.suffix != ".py":
        yield from enumerate(source.splitlines(), 1)
        return
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, " ".join(node.value.split())
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string


def test_no_phrase_of_the_list_is_used():
    paths = [path for pattern in ROOTS for path in sorted(ROOT.glob(pattern))]
    lines = [(path.relative_to(ROOT).as_posix(), line, text) for path in paths for line, text in texts(path)]
    banned = [re.compile(phrase) for phrase in BANNED]
    found = [f"{p}:{line}: {b.pattern}: {t[:90]}" for p, line, t in lines for b in banned if b.search(t)]
    assert not found, "\n".join(found)


def test_the_list_finds_what_it_names(tmp_path):
    file = tmp_path / "x.py"
    file.write_text('"""The overlapped Allan deviation."""\nx = f"{3} lost readings"  # an honest interval\n')
    said = [text for _, text in texts(file)]
    assert sum(bool(re.search(phrase, text)) for phrase in BANNED for text in said) == 3


def options_in(tree: ast.AST) -> list[str]:
    """Strings with an option, outside of docstrings, of what renders options and arguments, and of what to type."""
    alone = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    rendered = {
        id(part)
        for node in ast.walk(tree)
        if (isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("spelled", "choice"))
        or (isinstance(node, ast.keyword) and node.arg == "cure")
        for part in ast.walk(node)
    }
    strings = (node for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str))
    left = (node.value for node in strings if id(node) not in alone | rendered)
    return [text for text in left if re.search(r"(^|[\s('])--[a-z]", text)]


def test_messages_name_options_at_the_command_line_and_arguments_in_python():
    for path in sorted(PACKAGE.rglob("*.py")):
        name = path.relative_to(PACKAGE).as_posix()
        if name in COMMANDS or name.startswith(("cli/", "reporting/", "testing/")):
            continue
        assert not options_in(ast.parse(path.read_text(encoding="utf-8"))), name


def test_the_same_refusal_in_python_and_at_the_command_line(tmp_path):
    import allanite as al

    file = tmp_path / "x.csv"
    file.write_text("gx [deg/s]\n" + "1.5\n2.5\n" * 200)
    with pytest.raises(al.UsageError, match="rate=100") as refused:
        al.read(file)
    assert "--rate" not in str(refused.value)
    said = CliRunner().invoke(main, ["info", str(file)]).stderr
    assert "--rate HZ" in said
    assert "rate=100" not in said


def test_every_verb_is_listed_in_one_group_and_its_summary_is_not_cut():
    shown = CliRunner().invoke(main, ["--help"]).stdout
    assert shown.count("...") == 1  # of the usage
    assert all(shown.count(f"{heading}:") == 1 for heading in {verb.group for verb in VERBS.values()})
    for verb in VERBS:
        assert f"\n  {verb} " in shown
        text = CliRunner().invoke(main, [verb, "--help"]).stdout
        summary = text.split("\n\n")[1].strip()
        assert len(summary) <= 45, (verb, summary)
        assert not any(re.search(phrase, " ".join(text.split())) for phrase in BANNED), verb
