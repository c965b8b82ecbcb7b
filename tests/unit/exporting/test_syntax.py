"""Names, units and paths of any characters in the files of other programs: a parser of each sees the same keys."""

import json
import re
import shutil
import subprocess
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st
from tests import ROOT, examples
from tests.commands import run
from tests.rows import rows
from tests.unit.exporting.syntaxes import PARSERS
from tests.unit.exporting.test_export import six

import allanite as al
from allanite.core.files import encoded
from allanite.core.syntax import KEYWORDS, toml_text
from allanite.exporting.content import Content, Entry
from allanite.exporting.exports import TEMPERATURE
from allanite.exporting.imported import noise_in

FORMS = [(name, suffix) for name, row in al.exporting.EXPORTS.items() for suffix in row.forms]
FIRST, SECOND = "ZZ ONE", "ZZ TWO"

PIECES = [
    "\n", "\r", "\r\n", "\x85", "\u2028", "\u2029", "\0", "\f", "\v", "\x1a", "\x1b[2J", "\x7f", "\udcff", "\ud83d",
    "\ufeff", "\ufffe", "\u202e", "\u2066", "-->", "]]>", "--", "-", "<!--", "<b>", "&amp;", "*/", "/*", "*", "/",
    "??/", "\\", "\\\n", "%{", "%}", "\n%{\n", "...", "'", '"', "`", "\t", ": ", "#", " ", "{", "}", "$", "^^M", "~",
    "[", "](x)", "|", "_x_", "http://x.y", "coding=utf-7", "coding: latin-1", "+AAo-", "import os", "evil: 1",
    "EK3_GYRO_P_NSE,9", "noise_density: 9", "BiasInstability 9", "=1+1", ",=1", ";@x", ',"', "end", "ω", "x" * 97,
]  # fmt: skip
"""What has a meaning somewhere."""

NAMES = st.lists(st.sampled_from(PIECES) | st.characters(exclude_categories=()), min_size=1, max_size=8).map("".join)


@pytest.fixture(scope="module")
def contents():
    """What each form was given, of channels whose names, file and remarks can be replaced."""
    found = {}
    gyros = [replace(one, name=name) for one, name in zip(six(), (FIRST, SECOND), strict=False)]
    source = [*gyros, *six()[3:]]
    for name, suffix in FORMS:
        row = al.exporting.EXPORTS[name]
        caught = []
        spy = replace(row, forms={suffix: lambda content, caught=caught: caught.append(content) or ""})
        with al.exporting.EXPORTS.trying(name, spy):
            al.export(source, name, rate=100.0, axis="worst" if row.fields else "each", form=suffix)
        (content,) = caught
        found[name, suffix] = replace(content, header=(*content.header, f"source: {FIRST}, sha256"))
    return found


def called(content, first, second):
    """A content with other names."""

    def named(text):
        return str(text).replace(FIRST, first).replace(SECOND, second)

    header, axes = map(named, content.header), (replace(axis, name=named(axis.name)) for axis in content.axes)
    entries = (replace(e, channels=tuple(map(named, e.channels)), remark=named(f"{e.remark} {FIRST}."))
               for e in content.entries)  # fmt: skip
    return Content(tuple(header), tuple(entries), tuple(axes), content.rate)


def written(content, target, suffix):
    made = al.exporting.EXPORTS[target].forms[suffix](content)
    return made if isinstance(made, bytes) else encoded(made)


def variables(live, comments):
    """A file of matrices whose variables are numbered, and the variables; without which channel each one is."""
    text = json.dumps(live, ensure_ascii=False)
    found = list(dict.fromkeys(re.findall(r"\b(\w+)[._]R\b", text)))
    for i, one in enumerate(found):
        text = re.sub(rf"\b{one}([._](Phi|Qd|H|R|P0)\b)", rf"variable{i}\1", text)
        comments = [re.sub(rf"^{one}: ", f"variable{i}: ", line) for line in comments]
    return text, [line for line in comments if not re.match(r"variable\d: channel ", line)], found


@rows(("target", "suffix"), FORMS)
def test_a_parser_sees_the_same_keys_whatever_the_names(contents, target, suffix):
    content, parse = contents[target, suffix], PARSERS[suffix]
    plain, remarks = parse(written(called(content, FIRST, SECOND), target, suffix))

    @settings(max_examples=examples(40), deadline=None)
    @given(NAMES, NAMES)
    @example("gx\nevil: 1", "gy*/ int evil; /*")
    @example("".join(PIECES), "g x")
    @example("g x", "g_x")
    @example("\n", "-0")
    @example("coding=utf-7 +AAo-import os+AAo-", "=cmd|' /C calc'!A0")
    def check(first, second):
        live, comments = parse(written(called(content, first, second), target, suffix))
        expected = [line.replace(FIRST, first).replace(SECOND, second) for line in remarks]
        if suffix in {".param", ".params"}:
            bare = [name.replace(" ", "") for name in (first, second)]
            expected = [remarks[0].replace("ZZONE", bare[0]).replace("ZZTWO", bare[1])]
        if target == "statespace":
            head = len(content.header)
            assert comments[:head] == expected[:head]
            live, comments, names = variables(live, comments[head:])
            seen, expected, _ = variables(plain, remarks[head:])
            assert (live, len({name.lower() for name in names})) == (seen, len(content.axes))
            assert all(re.fullmatch(r"[A-Za-z]\w{0,62}", name, re.ASCII) and name not in KEYWORDS for name in names)
        else:
            assert live == plain
        if suffix == ".md":  # it has no blanks at either end, and no two side by side
            comments, expected = ([line.strip() for line in lines] for lines in (comments, expected))
        assert comments == expected

    check()


ACCELEROMETER = al.Model("N 60 ug/sqrt(Hz), K 20 ug/sqrt(h)")


@pytest.fixture(scope="module")
def tactical():
    return al.analyze(ROOT / "examples" / "tactical_gyro.csv")


@rows("target", [name for name, row in al.exporting.EXPORTS.items() if row.fields])
def test_nothing_of_a_name_is_read_back(tactical, target):
    """A comment once held the value of a field that the file lacks, and the rest of a long one was a parameter."""
    evil = [f"{field.name}: 9 {field.section}" for field in al.exporting.EXPORTS[target].fields]
    name = f"{'x' * 97}{' '.join(evil)}\nEK3_GYRO_P_NSE,9 {' '.join(evil)} ".replace("-", "")
    plain = al.export(six(), target, rate=100.0)
    hostile = al.export([replace(six()[0], name=name), *six()[1:]], target, rate=100.0)
    parse, row = PARSERS[hostile.suffix], al.exporting.EXPORTS[target]
    assert parse(hostile.data)[0] == parse(plain.data)[0]
    assert noise_in(hostile.text, row, 100.0).models == noise_in(plain.text, row, 100.0).models


@rows("path", ["x\nimport os\n.npz", "a\u2028import os", "coding=utf-7 +AAo-import os+AAo-", "\x0cimport os\x0c"])
def test_a_path_is_no_line_of_a_script(tactical, path):
    """That of the encoding is the second line, where Python looks for it."""
    hostile = replace(tactical, provenance=tactical.provenance | {"source": path})
    live, comments = PARSERS[".py"](al.export([hostile, ACCELEROMETER], "gtsam").data)
    assert live == PARSERS[".py"](al.export([tactical, ACCELEROMETER], "gtsam").data)[0]
    assert comments[1].startswith(f"source: {path}, sha256")


@rows("autopilot", list(TEMPERATURE))
def test_names_are_no_parameters_of_a_temperature_calibration(autopilot):
    row = TEMPERATURE[autopilot]
    layout = row.forms[row_suffix := next(iter(row.forms))]
    name = f"gx {'x' * 97} TC_G_ENABLE,1\n1\t1\tTC_G_ENABLE\t1\t6"
    entry = Entry("INS_TCAL1_TMIN", "gyro", "", "degC", "minimum", (1.0,), (name,), name)
    live, _ = PARSERS[row_suffix](layout(Content((name,), (entry,), (), None)).encode())
    assert len(live) == 1


def test_a_compiler_takes_what_is_in_a_comment_for_a_comment():
    compiler = shutil.which("cc") or shutil.which("gcc")
    if not compiler:
        pytest.skip("there is no compiler")
    names = ["gx*/ evil /*", "gx??/\n*??/", "\\", *PIECES, "".join(PIECES)]
    gyros = [replace(six()[0], name=name) for name in names]
    header = al.export([*gyros, *six()[3:]], "statespace", form=".h", rate=100.0, axis="each").data
    check = [compiler, "-trigraphs", "-std=c11", "-Wall", "-Wno-unused-variable", "-Werror", "-fsyntax-only", "-x", "c"]
    done = subprocess.run([*check, "-"], input=header, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr


TEXTS = NAMES.filter(lambda text: not any(0xD800 <= ord(sign) < 0xE000 for sign in text))  # TOML can hold the others
PLAIN = st.recursive(
    st.booleans() | st.integers() | st.floats(allow_nan=False) | TEXTS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXTS, inner, max_size=3),
)


@given(PLAIN)
def test_choices_are_read_back_from_toml(value):
    assert tomllib.loads(f"key = {toml_text(value)}\n")["key"] == value


@settings(max_examples=25, deadline=None)
@given(NAMES, NAMES)
@example("\n", "x,=cmd|' /C calc'!A0")
def test_a_recording_is_read_back_with_its_names(tmp_path_factory, first, second):
    """The first line of a CSV file describes it; neither a spreadsheet nor a line break makes more of it."""
    path = tmp_path_factory.mktemp("csv") / "x.csv"
    names = [first, second if second != first else f"{second}2"]
    al.write(al.Recording(tuple(al.Record(np.arange(30.0), 10.0, "deg/h", name=name) for name in names)), path)
    assert [record.name for record in al.read(path)] == names
    lines = path.read_text().splitlines()
    assert len(lines) == 32
    assert not [cell for cell in re.split("[,;]", lines[0]) if re.match("[=@+-]", cell)]


DEEP = "[" * 100_000 + "]" * 100_000


@rows("key, value, words", [
    ("limits", "5", r"channels\[0\].fit.terms\[0\].limits: a table is expected, not 5"),
    ("signal", "[1]", r"channels\[0\].fit.terms\[0\].signal: the name of a quantity is expected, not a list"),
    ("signal", '"x"', r"channels\[0\].fit.terms\[0\].signal: unknown quantity 'x'"),
    ("type", "[1]", r"channels\[0\].fit.terms\[0\].type: a text is expected, not a list|\[1\]"),
    ("value", DEEP, "it is not JSON|a number is expected, not a list"),
    ("value", "1" * 400, "a number that is not above"),
    ("status", '"x"', r"channels\[0\].fit.terms\[0\].status: unknown status 'x'"),
])  # fmt: skip
def test_a_changed_result_is_refused_by_the_path_of_its_field(tactical, tmp_path, key, value, words):
    data = tactical.to_dict()
    data["channels"][0]["fit"]["terms"][0][key] = "HERE"
    file = tmp_path / "result.json"
    file.write_text(json.dumps(data).replace('"HERE"', value))
    done = run("export", file, "--to", "datasheet", "-o", "-")
    assert done.exit_code in {2, 3}, done.output
    assert not isinstance(done.exception, Exception) or isinstance(done.exception, SystemExit)
    assert re.search(words, " ".join(done.stderr.split())), done.stderr
