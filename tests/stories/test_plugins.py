"""What another package adds is there as if it were the package's own: a sample is installed, and others are broken."""

import json
import os
import subprocess
import sys
import tomllib
from dataclasses import replace
from importlib.metadata import PathDistribution
from pathlib import Path
from types import SimpleNamespace

import click
import pytest
from tests import ROOT
from tests.rows import refused, rows

import allanite as al
from allanite.cli import Verb
from allanite.plugins import package_of
from allanite.terms import TERMS
from allanite.testing import (
    CHECKS,
    check_data_sheet,
    check_reader,
    check_statistic,
    check_target,
    check_term,
    check_verb,
)

SAMPLE = ROOT / "tests" / "plugin"
SAID = "; update or remove it"

BEFORE = """
import json, os, shlex
from pathlib import Path
import numpy as np
from click.testing import CliRunner
import allanite as al
from allanite.cli import VERBS, main
def allanite(line, code=0):
    done = CliRunner().invoke(main, shlex.split(line))
    assert done.exit_code == code, (line, done.output)
    return " ".join(done.output.split())
"""
"""What every process begins with."""


def install(folder, name, points):
    """Metadata of a package with these entry points, as an installation writes them."""
    about = folder / f"{name}-1.0.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n", "utf-8")
    groups = (f"[{group}]\n" + "".join(f"{key} = {at}\n" for key, at in rows.items()) for group, rows in points.items())
    (about / "entry_points.txt").write_text("\n".join(groups), "utf-8")
    return folder


def run(script, *folders, cwd):
    """What a script prints, and what it says beside, where the packages in these folders are installed."""
    path = os.pathsep.join([*map(str, folders), os.environ.get("PYTHONPATH", "")])
    words, around = [sys.executable, "-c", BEFORE + script], os.environ | {"PYTHONPATH": path}
    done = subprocess.run(words, cwd=cwd, env=around, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout, done.stderr


@pytest.fixture(scope="module")
def sample(tmp_path_factory):
    """The folders of the sample: its metadata, and its modules."""
    project = tomllib.loads((SAMPLE / "pyproject.toml").read_text("utf-8"))["project"]
    return install(tmp_path_factory.mktemp("installed"), "allanite_sample", project["entry-points"]), SAMPLE


FILES = r"""
rng = np.random.default_rng(1)
values = al.simulate(al.N(0.1, "deg/sqrt(h)"), 4096, 50.0, rng=rng).values
Path("a.tones").write_text("\n".join(["TONES 50", *(f"{v * 180 / np.pi:.9g}" for v in values)]))
"""

PASSING = """
import pytest, sys
sys.exit(pytest.main(["-q", "-c", "/dev/null", "--noconftest", "-p", "no:cacheprovider", "-W", "error", sys.argv[1]]))
"""


@pytest.mark.slow("takes more than half a second")
def test_the_sample_passes_the_public_checks(sample, tmp_path):
    out, _ = run(PASSING.replace("sys.argv[1]", repr(str(SAMPLE / "test_rows.py"))), *sample, cwd=tmp_path)
    assert "6 passed" in out


USED = """
from allanite.cli.tasks import Reports
from allanite.web.requests import Request
from allanite.web.faces import tables
os.environ["ALLANITE_DETAILS"] = "1"
shown = {"help": allanite("--help"), "info": allanite("info a.tones"), "list": allanite("explain")}
shown["statistic"], shown["target"] = allanite("explain fdev"), allanite("explain pilot")
shown["sheet"], shown["plan"] = allanite("explain sg1"), allanite("plan --datasheet sg1 --rate 10")
shown["verb"] = allanite("extent a.tones --json extent.json --csv extent.csv --report extent.html --lang ru")
shown["curve"] = allanite("deviation a.tones --statistic fdev --json curve.json")
shown["fit"] = allanite("analyze a.tones --terms N,RR --json fit.json --report page.html")
shown["export"] = allanite("export a.tones --model 'N 60 ug/sqrt(Hz)' --to pilot --output pilot.cfg --json export.json")
shown["back"] = allanite("convert --from pilot pilot.cfg")
shown["converted"] = allanite("convert sg1 '60 ug/sqrt(Hz)' --to pilot")
Path("b.bin").write_bytes(bytes(100))
shown["unknown"] = allanite("info b.bin", 3)
shown["types"] = [type(al.from_dict(json.loads(p.read_text("utf-8")))).__name__ for p in sorted(Path().glob("*.json"))]
result = al.from_dict(json.loads(Path("extent.json").read_text("utf-8")))
al.report(result, "again.html")
shown["low"] = [result["gz"].low, float(al.read("a.tones")["gz"].values.min())]
shown["term"] = str(al.RR(1, "rad/s^2.5"))
shown["page"] = tables("en")
request = Request.of("extent", {"start": 10})
shown["line"] = request.line(["a.tones"])
shown["done"] = request.task.run(["a.tones"], request.recipe, request.settings, Reports())["gz"].record.size
print(json.dumps(shown))
"""


@pytest.fixture(scope="module")
def used(sample, tmp_path_factory):
    """What the program shows in a process in which the sample is installed, and the folder of its files."""
    folder = tmp_path_factory.mktemp("used")
    out, err = run(FILES + USED, *sample, cwd=folder)
    assert err == ""
    return json.loads(out), folder


OUTSIDE = {
    "help": ["in the browser. extent Show the least and the greatest sample. Simulate and plan:"],
    "verb": ["least greatest"], "info": ["rate 50.0 Hz from its first line"], "unknown": [", tones of a recorder, "],
    "list": ["pilot settings of Pilot", "fdev fourth-difference deviation", "RR driven relaxation",
             "SG-1 SG-1 data sheet, Rev. A"],
    "statistic": ["fourth-difference deviation"], "target": ["manual of Pilot, section 3"],
    "back": ["N velocity random walk 0.0353039"], "converted": ["gyro_noise 5.81776e-05 rad/s/√Hz"],
    "sheet": ["Angle random walk 0.2"], "plan": ["N = 0.2 °/√h, B = 1.505 °/h"], "fit": ["driven relaxation"],
    "term": ["RR = 4.455e+10 deg/h^2.5"],
}  # fmt: skip


@pytest.mark.slow("the sample in a process of its own")
def test_what_comes_from_outside_is_shown(used):
    assert [text for where, texts in OUTSIDE.items() for text in texts if text not in used[0][where]] == []


@pytest.mark.slow("the sample in a process of its own")
def test_results_from_outside_are_stored_and_read_again(used):
    shown, folder = used
    assert shown["types"] == ["Survey", "Export", "Extents", "Study"]
    assert shown["low"][0] == shown["low"][1] < 0
    assert (folder / "extent.csv").read_text("utf-8").startswith("channel,least,greatest")
    for name, words in (("extent.html", "Extent of a.tones"), ("again.html", "Extent of a.tones"),
                        ("page.html", "driven relaxation"), ("pilot.cfg", "gyro_noise = ")):  # fmt: skip
        assert words in (folder / name).read_text("utf-8")


@pytest.mark.slow("the sample in a process of its own")
def test_the_page_offers_what_comes_from_outside(used):
    page = used[0]["page"]
    assert {"name": "fdev", "title": "fourth-difference deviation"} in page["statistics"]
    assert [row["title"] for row in page["terms"] if row["symbol"] == "RR"] == ["driven relaxation"]
    assert "extent" in page["verbs"]
    assert (used[0]["line"], used[0]["done"]) == ("allanite extent --from 10 a.tones", 4096 - 500)
    assert "rate" in page["options"]["extent"]
    assert "pilot" in [row["name"] for row in page["exports"]]


@pytest.mark.slow("takes more than half a second")
def test_a_plugin_that_is_broken_is_named_and_left_out(sample, tmp_path):
    lines = ("from allanite.cli import Verb", "from allanite_sample.command import extent", "ROW = object()",
             'VERB = Verb("extent", "Learn", extent)', "def sniff(head, suffix): return 1 / 0")  # fmt: skip
    (tmp_path / "theirs.py").write_text("\n".join(lines), "utf-8")
    (tmp_path / "ending.py").write_text("raise SystemExit(3)\n", "utf-8")
    points = {
        "allanite.statistics": {"mine": "theirs:ROW", "other": "theirs:absent", "ended": "ending:row"},
        "allanite.verbs": {"info": "theirs:VERB", "more": "no_such_module:VERB"},
        "allanite.readers": {"half": "theirs"},
    }
    script = FILES + 'print(len(al.STATISTICS), "fdev" in al.STATISTICS, len(al.read("a.tones")), len(VERBS))'
    install(tmp_path / "theirs", "their_package", points)
    out, err = run(script, *sample, tmp_path / "theirs", tmp_path, cwd=tmp_path)
    assert out == "18 True 1 26\n"
    said = " ".join(err.split())
    for plugin, why in {
        "statistic plugin 'mine'": "it is a object, not a Statistic",
        "statistic plugin 'other'": "it cannot be loaded: AttributeError: module 'theirs' has no attribute 'absent'",
        "statistic plugin 'ended'": "it cannot be loaded: SystemExit: 3",
        "verb plugin 'info'": "the name 'extent' exists already",
        "verb plugin 'more'": "it cannot be loaded: ModuleNotFoundError: No module named 'no_such_module'",
        "reader plugin 'half'": "it has no TITLE, read",
    }.items():
        assert f"the {plugin} of the package 'their_package' is broken ({why}){SAID}" in said, said


@pytest.mark.slow("takes more than half a second")
def test_a_name_that_exists_is_refused(tmp_path):
    """A row, a format, a verb and the type of a result of the package itself."""
    text = """
from dataclasses import replace
from allanite.cli import VERBS
from allanite.readers.formats import text
from allanite.reporting.views.fit import fit_view
from allanite.statistics import STATISTICS
ROW, VERB = replace(STATISTICS["adev"], order=1), replace(VERBS["info"], group="Other")
"""
    (tmp_path / "theirs.py").write_text(text, "utf-8")
    points = {
        "allanite.statistics": {"new": "theirs:ROW"}, "allanite.readers": {"text": "theirs:text"},
        "allanite.verbs": {"new": "theirs:VERB"}, "allanite.views": {"Fit": "theirs:fit_view"},
    }  # fmt: skip
    install(tmp_path, "theirs", points)
    script = "from allanite.readers.formats.registry import added\nfrom allanite.reporting.views import VIEWS\n"
    script += 'print(al.statistics.STATISTICS["adev"].order, len(added()), VERBS["info"].group, VIEWS["Fit"])\n'
    out, err = run(script + "print(len(al.statistics.STATISTICS), len(VERBS), len(VIEWS) > 9)", tmp_path, cwd=tmp_path)
    assert out == "2 0 Analyze fit.fit_view\n17 25 True\n"
    for name in ("adev", "text", "info", "Fit"):
        assert f"(the name {name!r} exists already)" in err


READING = r"""
Path("a.mine").write_text("MINE\n1.5\n2.5\n")
try:
    print(len(al.read("a.mine", rate=1, unit="deg/s")))
except al.AllaniteError as error:
    print(error)
"""


@rows("body, why", [
    ("return 3", "read returned a int instead of a Recording"),
    ("return 1 / 0", "read failed: ZeroDivisionError: division by zero"),
])  # fmt: skip
def test_a_reader_that_fails_is_named_with_the_file(tmp_path, body, why):
    lines = ('TITLE = "ours"', 'sniff = lambda head, suffix: head[:4] == b"MINE"', f"def read(path, options): {body}")
    (tmp_path / "theirs.py").write_text("\n".join(lines), "utf-8")
    install(tmp_path, "theirs", {"allanite.readers": {"mine": "theirs"}})
    said, _ = run(READING, tmp_path, cwd=tmp_path)
    assert said == f"a.mine: the reader plugin 'mine' of the package 'theirs' is broken ({why}){SAID}\n"


ODD = """
import click
from allanite.cli import VERBS, Verb
def verb(*parts, **more): return Verb(*parts, **more)
class Raising(Verb):
    def __getattribute__(self, name): raise RuntimeError("no " + name)
class Mute(Exception):
    def __str__(self): raise RuntimeError("mute")
class Silent(Verb):
    def imported(self, part="command"): raise Mute
class Hidden(click.Command):
    def get_short_help_str(self, limit=45): raise SystemExit(4)
absent, empty = verb("absent", "Analyze", "nope.nope"), verb("empty", "Analyze", "")
number, spaced = verb(5, "Analyze", "analyze.info"), verb(" x", "Analyze", "analyze.info")
grouped, listed = verb("grouped", [], "analyze.info"), verb("listed", "Analyze", "analyze.info", synonyms=(5,))
function, tasked = verb("function", "Analyze", len), verb("tasked", "Analyze", "analyze.info", 5)
raising, silent = Raising("raising", "Analyze", "analyze.info"), Silent("silent", "Analyze", "analyze.info")
hidden = verb("hidden", "Analyze", Hidden("hidden"))
taking = verb("taking", "Analyze", "analyze.deviation", old=("info", "budget"))
@click.command()
def dividing(): "Divide by zero."; 1 / 0
divided = verb("divided", "Analyze", dividing)
"""
ODD_VERBS = {
    "absent": "ModuleNotFoundError", "empty": "ModuleNotFoundError", "number": "its name must be a string, not 5",
    "spaced": "' x' is no name", "grouped": "its group must be a string, not []",
    "listed": "its synonyms must be a tuple of strings, not (5,)",
    "function": "its command must be a string or a Command, not <built-in function len>",
    "tasked": "AttributeError: 'int' object has no attribute 'kind'", "raising": "RuntimeError: no ",
    "silent": "Mute", "hidden": "SystemExit: 4",
}  # fmt: skip
RUN = r"""
print(allanite("--help"), allanite("info --help"), allanite("quantization --help"))
print(allanite("divided", 1))
"""


@pytest.mark.slow("takes more than half a second")
def test_verbs_that_are_broken_take_nothing_from_the_others(tmp_path):
    (tmp_path / "theirs.py").write_text(ODD, "utf-8")
    points = {"allanite.verbs": {name: f"theirs:{name}" for name in (*ODD_VERBS, "taking", "divided")}}
    out, err = run(RUN, install(tmp_path, "their_package", points), cwd=tmp_path)
    said = " ".join((out + err).split())
    for name, why in ODD_VERBS.items():
        assert said.count(f"the verb plugin {name!r} of the package 'their_package' is broken ({why}") == 1, said
    texts = ("allanite: the verb plugin", "Special jobs:", "Usage: allanite info", "Usage: allanite quantization")
    assert [text for text in texts if text not in said] == []
    ended = "internal error in the package 'their_package' (ZeroDivisionError: division by zero)"
    assert f"{ended}; please report it with the command and the file to its maintainers" in said


MALFORMED = (b"[allanite.verbs]\nb\n", b"[console_scripts]\nb\n", b"[allanite.verbs]\n\xff = x\n")


@pytest.mark.slow("takes more than half a second")
@rows("text", MALFORMED)
def test_malformed_entry_points_of_any_package_stop_no_verb(sample, tmp_path, text):
    (install(tmp_path, "theirs", {}) / "theirs-1.0.dist-info" / "entry_points.txt").write_bytes(text)
    script = FILES + 'print(allanite("analyze a.tones --brief"), "extent" in VERBS)'
    out, err = run(script, *sample, tmp_path, cwd=tmp_path)
    assert "velocity random walk" in out or "in-run" in out
    assert out.endswith("True\n")
    named = "the entry points of the package 'theirs' cannot be read"
    assert (named in out + err) == (b"allanite" in text)


def test_a_package_whose_metadata_are_no_text_is_named_by_its_module(tmp_path):
    about = install(tmp_path, "theirs", {"allanite.verbs": {"x": "theirs:x"}}) / "theirs-1.0.dist-info"
    (about / "METADATA").write_bytes(b"\xff\xfe")
    (entry,) = PathDistribution(about).entry_points
    assert package_of(entry) == "theirs:x"


def test_a_check_that_is_expected_to_fail_has_a_reason_and_fails():
    mine = replace(ADEV, order=3, meaning="")
    known = {"order": "a walk is wanted in it", "texts": "not written yet"}
    refused(AssertionError, r"meaning is empty \(check 'texts'\)", lambda: check_statistic(mine))
    check_statistic(mine, expected_failed_checks=known)
    words = r"statistic 'adev': the check 'texts' passes, but is expected to fail \(not written yet\)"
    refused(AssertionError, words, lambda: check_statistic(replace(mine, meaning="x"), expected_failed_checks=known))
    unknown = lambda: check_term(TERMS["K"], expected_failed_checks={"sum": "a typing error"})  # noqa: E731
    refused(al.UsageError, "unknown check 'sum'; did you mean sums?", unknown)


def test_the_documentation_names_every_check():
    text = (ROOT / "docs" / "architecture.md").read_text("utf-8")
    assert [name for names in CHECKS.values() for name in names if f"`{name}`" not in text] == []


def reader(**parts):
    """A reader of numbers, a line each, with other parts."""

    def read(path, options):
        numbers = [float(word) for word in Path(path).read_text("utf-8").split()]
        return al.Recording((al.Record([numbers[0], *numbers], 1.0, "deg/s", name="gz"),))

    usual = {"TITLE": "numbers", "sniff": lambda head, suffix: suffix == ".mine", "read": read}
    return SimpleNamespace(**usual | parts)


KALIBR, ADEV = al.exporting.EXPORTS["kalibr"], al.statistics.STATISTICS["adev"]
SHEET = al.planning.DATASHEETS["ADIS16470"]
TWICE = replace(SHEET, claims=SHEET.claims[:1] * 2)
METERS = replace(KALIBR, fields=(replace(KALIBR.fields[0], unit="m"),))


DOUBLED = ("structure", "summed", "derivative", "increments", "spectrum", "dct", "block")
"""Columns of a term, none of which may be twice what the others say."""


def double(name):
    column = getattr(TERMS["K"], name)
    return lambda *at: 2.0 * column(*at)


SILENT = click.Command("silent")


@rows("check, row, words", [
    (check_statistic, replace(ADEV, meaning=""), "statistic 'adev': meaning is empty"),
    (check_statistic, replace(ADEV, sums=lambda x, m: 2 * ADEV.sums(x, m)), "but those of its windows"),
    (check_statistic, replace(ADEV, order=3), r"order is 3, but t\^2 is not left out"),
    *((check_term, replace(TERMS["K"], **{name: double(name)}), "noise term K") for name in DOUBLED),
    (check_target, replace(KALIBR, forms={}), "target 'kalibr': it has no form of a file"),
    (check_target, replace(KALIBR, fields=KALIBR.fields * 2), "fields have the same name"),
    (check_target, METERS, "the unit m of .* is not that of N"),
    (check_data_sheet, TWICE, "data sheet 'ADIS16470': a line is there twice"),
    (check_data_sheet, replace(SHEET, claims=(replace(SHEET.claims[0], unit="deg/h"),)), "is not a unit of N"),
    (check_data_sheet, replace(SHEET, claims=(replace(SHEET.claims[0], place=""),)), "it has no page or table"),
    (check_data_sheet, replace(SHEET, claims=(replace(SHEET.claims[0], sensor="accelerometer"),)), "of the gyro"),
    (check_reader, SimpleNamespace(TITLE="x"), "reader of 'x': it has no sniff, read"),
    (check_reader, reader(sniff=lambda head, suffix: False), "sniff does not recognize a.mine"),
    (check_reader, reader(read=lambda path, options: [1.0]), "read returns a list, not a Recording"),
    (check_reader, reader(), "cut off after 0 bytes, it raises IndexError.* instead of a DataError"),
    (check_verb, Verb("silent", "", SILENT), "it has no heading of the help"),
    (check_verb, Verb("silent", "Other", SILENT), "it has no help"),
])  # fmt: skip
def test_a_check_says_what_is_wrong(tmp_path, check, row, words):
    (tmp_path / "a.mine").write_text("1.5\n2.5\n" * 40, "utf-8")
    refused(AssertionError, words, lambda: check(row, *([tmp_path / "a.mine"] if check is check_reader else [])))


def test_a_row_that_is_tried_is_gone_afterwards_and_the_others_keep_their_places():
    names = list(al.statistics.STATISTICS)
    with al.statistics.STATISTICS.trying("adev", replace(ADEV, order=3)), al.statistics.STATISTICS.trying("new", ADEV):
        assert al.statistics.STATISTICS["adev"].order == 3
        assert "new" in al.statistics.STATISTICS
    assert list(al.statistics.STATISTICS) == names
    assert al.statistics.STATISTICS.get("adev") is ADEV
    assert al.statistics.STATISTICS.get("new") is None


# nothing is looked for before it is needed

IDLE = """
from allanite import plugins
al.N(0.1, "deg/sqrt(h)"), al.statistics.STATISTICS["oadev"], VERBS["analyze"]
print(plugins._loaded)
"""


def test_nothing_is_looked_for_where_no_table_is_listed(tmp_path):
    assert run(IDLE, cwd=tmp_path) == ("{}\n", "")


def test_nothing_is_imported_with_the_package():
    code = "import sys, allanite, allanite.cli; print({'importlib.metadata', 'allanite.testing'} & {*sys.modules})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"
