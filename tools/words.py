"""The language of messages, help, docstrings and pages: one vocabulary, and no phrase that is on the list.

    python tools/words.py

Name each phrase of the list that source, README or docs have, and each message of the package that writes an option as
it is typed at the command line alone; the exit code is 1 if there is one.
"""

import ast
import io
import re
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src" / "allanite"
READ = ("src/allanite/**/*.py", "src/allanite/**/*.j2", "README.md", "docs/*.md", "docs/generate/*.md")

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

COMMANDS = {"core/errors.py", "phrases/phrase.py", "study/channels.py", "readers/clock/findings.py", "web/requests.py",
            "web/faces.py"}  # fmt: skip
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


def phrases() -> Iterator[str]:
    """Where a phrase of the list is used."""
    banned = [re.compile(phrase) for phrase in BANNED]
    for path in (path for pattern in READ for path in sorted(ROOT.glob(pattern))):
        for line, text in texts(path):
            name = f"{path.relative_to(ROOT).as_posix()}:{line}"
            yield from (f"{name}: {phrase.pattern}: {text[:90]}" for phrase in banned if phrase.search(text))


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


def options() -> Iterator[str]:
    """Where a message names an option of the command line, which Python does not have."""
    for path in sorted(PACKAGE.rglob("*.py")):
        name = path.relative_to(PACKAGE).as_posix()
        if name not in COMMANDS and not name.startswith(("cli/", "reporting/", "testing/")):
            written = options_in(ast.parse(path.read_text(encoding="utf-8")))
            yield from (f"src/allanite/{name}: an option: {text[:90]}" for text in written)


if __name__ == "__main__":
    used = [*phrases(), *options()]
    print(*used, sep="\n", end="\n" if used else "")
    sys.exit(bool(used))
