"""What CONTRIBUTING.md says of additions: each is made in a copy of the package, in the places it lists, and used."""

import os
import re
import shutil
import subprocess
import sys

import pytest
from tests import ROOT
from tests.rows import rows

GUIDE = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
ROWS = re.findall(r"^\| ([^|]+) \| (.+) \|$", GUIDE.partition("## Adding things")[2], re.MULTILINE)
PLACES = {row: re.findall(r"`([^` ]+)`", places) for row, places in ROWS}

BEFORE = """
import json, shlex
from pathlib import Path
import numpy as np
from click.testing import CliRunner
import allanite as al
from allanite.cli import main
def allanite(line, code=0):
    done = CliRunner().invoke(main, shlex.split(line))
    print(" ".join(done.output.split()))
    assert done.exit_code == code, (line, done)
def simulated(model, n=4096):
    return al.simulate(model, n, 1.0, rng=np.random.default_rng(1), name="gz")
al.write(simulated(al.N(0.1, "deg/sqrt(h)")), "z.csv")
"""
"""What every process begins with."""


def own(name):
    """A module of the sample plug-in as one of the package."""
    text = (ROOT / "tests" / "plugin" / "allanite_sample" / f"{name}.py").read_text("utf-8")
    return text.replace("from .job import", "from allanite.study.extent import")


ADDITIONS = {
    "statistic": ({"statistics/fourth.py": own("fourth")}, (
        ("statistics/table.py", "PDEV, THEO1, THEOBR, THEOH, TIERMS\n", "from .fourth import FDEV\n"),
        ("statistics/table.py", "PDEV, HAAR, MTIE, TIERMS),\n", "    FDEV,\n")), """
allanite("deviation z.csv --statistic fdev")
print(al.deviation(al.read("z.csv")["gz"], "fdev"))""", ("fourth-difference deviation", "<Curve")),
    "noise term": ({"terms/relaxation.py": own("relaxation")}, (
        ("terms/__init__.py", "RATE_RANDOM_WALK, ramp_coefficients\n", "from .relaxation import RELAXED\n"),
        ("terms/__init__.py", " OSCILLATION,", " RELAXED,"),
        ("core/model.py", '("F", "GM", "GMA", "GM2", "GML", "Sine"))\n', 'RR = constructor("RR")\n'),
        ("__init__.pyi", "from .core.model import R as R\n", "from .core.model import RR as RR\n")), """
assert al.RR(1, "rad/s^2.5").shape == (20.0,) and "RR" in dir(al)
allanite("analyze z.csv --terms N,RR --to rad/s^2.5")
allanite("simulate made.csv --model 'RR 1 rad/s^2.5' --rate 1 --samples 9")""", ("driven relaxation", "RR = ")),
    "format": ({"readers/formats/tones.py": own("tones")}, (
        ("readers/formats/registry.py", '    "kfgins": Format("kfgins", looks=True),\n',
         '    "tones": Format("tones", looks=True),\n'),), r"""
values = simulated(al.N(0.1, "deg/sqrt(h)")).values
Path("a.tones").write_text("\n".join(["TONES 50", *(f"{v:.9g}" for v in values)]))
allanite("info a.tones")""", ("rate 50.0 Hz from its first line",)),
    "target of export": ({"exporting/targets/pilot.py": own("pilot")}, (
        ("exporting/exports.py", "from .target import Target\n", "from .targets.pilot import PILOT\n"),
        ("exporting/exports.py", "PSINS, NAVEGO,", " PILOT,")), """
allanite("export --model 'N 0.1 deg/sqrt(h)' --model 'N 60 ug/sqrt(Hz)' --to pilot --output pilot.cfg")
print(Path("pilot.cfg").read_text("utf-8"))
allanite("explain pilot")""", ("\ngyro_noise = 2.9", "manual of Pilot, section 3")),
    "verb, result": ({
        "study/extent.py": own("job"), "cli/extent.py": own("command"), "reporting/views/extent.py": own("view")}, (
        ("cli/__init__.py", '"serve.serve", synonyms=("gui", "web")),\n',
         '    Verb("extent", "Analyze", "extent.extent", "extent.EXTENT"),\n'),
        ("reporting/views/__init__.py", '    "Lot": "lot.lot_view",', ' "Extents": "extent.extents_view",')), """
allanite("--help")
allanite("extent z.csv --from 10 --json out.json --report page.html")
assert "Extent of z.csv" in Path("page.html").read_text("utf-8")
found = al.from_dict(json.loads(Path("out.json").read_text("utf-8")))
from allanite.web.faces import tables
assert "extent" in tables("en")["verbs"]
print(type(found).__name__, found.recipe.start, found["gz"].low == al.read("z.csv")["gz"].values[10:].min())""",
        ("extent Show the least and the greatest sample.", "least greatest", "Extents 10.0 True")),
    "choice of a recipe": ({}, (
        ("study/recipe.py", 'synonyms=("decimate", "downsample"))\n',
         '    settle: float | None = choice("", "Time to leave out.", group="selecting", parts=())\n'),
        ("study/channels.py", "(recipe.exclude) if recipe.exclude else ())\n",
         "    whole = trim(whole, recipe.settle, None)\n")), """
from allanite.web.requests import Request
from allanite.web.faces import tables
row = {"name": "settle", "group": "selecting", "control": "number", "options": ("--settle",)}
assert row in tables("en")["choices"]
print(Request.of("analyze", {"settle": "96"}).line(["z.csv"]))
Path("recipe.toml").write_text("settle = 96.0")
for line in ("--settle 96", "--recipe recipe.toml"):
    allanite(f"info z.csv {line} --json out.json --force")
    assert json.loads(Path("out.json").read_text("utf-8"))["recipe"]["settle"] == 96
for recipe in (al.Recipe(settle=96.0), al.Recipe.load("recipe.toml")):
    print("samples:", al.analyze("z.csv", recipe).channels[0].record.size)
allanite("info --help all")
np.save("z.npy", np.zeros(4096))
allanite("analyze z.npy --rate 1 --unit deg/h --settle 96 --memory 1kB", 2)
allanite("plan --sensor fog --rate 1 --settle 96", 2)""",
        ("allanite analyze --settle 96 z.csv", "4000 samples", "\nsamples: 4000\nsamples: 4000\n",
         "--settle FLOAT Time", "no --settle: omit it", "--settle applies to a recording")),
    "language": ({}, (
        ("reporting/language.py", 'LANGUAGES = {"en": "English", ', '"de": "Deutsch", '),
        ("web/static/words.js", 'const ORDER = ["en", "ru", "zh"', ', "de"')), """
import catalogues
catalogues.main()
assert 'msgid "angle random walk"' in (catalogues.LOCALE / "de.po").read_text("utf-8")
allanite("analyze z.csv --lang de")
allanite("analyze z.csv --lang xx", 2)""", (
        "de: ", "sentences are shown in English", "random walk", "known languages: en, de")),
    "sentence": ({}, (
        ("reporting/views/jobs.py", "    record = channel.record\n",
         '    parts = [Note(say("first at {time:.1f} s", time=0.0)), *parts]\n'),), """
import catalogues, sys; sys.argv.append("--check"); catalogues.main()
allanite("analyze z.csv --lang ru")""", ("ru: 1 sentence is shown in English", "first at 0.0 s", "блуждание")),
}  # fmt: skip
"""The rows of the guide: new files, lines that are there with what is put behind each, a use, and what that prints."""


def test_the_guide_is_short_and_every_path_in_it_exists():
    assert len(GUIDE.splitlines()) <= 70
    assert set(PLACES) == {row for rows in ADDITIONS for row in rows.split(", ")}
    named = [name for name in re.findall(r"`([\w./-]+)`", GUIDE) if re.search(r"/|\.(py|pyi|toml|md|js)$", name)]
    rooms = ("tests/conformance", "tests/reference", "tests/stories", "src/allanite", ".")
    assert [name for name in named if not any((ROOT / room / name).exists() for room in rooms)] == []


@pytest.mark.nightly("additions in copies of the package")
@rows("rows", ADDITIONS)
def test_an_addition_needs_the_places_of_the_guide_and_no_other(rows, tmp_path):
    (files, lines, use, said), listed = ADDITIONS[rows], [place for row in rows.split(", ") for place in PLACES[row]]
    package, rest = tmp_path / "src" / "allanite", shutil.ignore_patterns("*.pyc")  # compiled kernels are copied too
    shutil.copytree(ROOT / "src" / "allanite", package, ignore=rest)
    shutil.copytree(ROOT / "tools", tmp_path / "tools", ignore=rest)
    for path, text in files.items():
        assert f"{os.path.dirname(path)}/" in listed, path
        (package / path).write_text(text, "utf-8")
    for path, line, more in lines:
        assert path in listed or rows == "sentence", path
        before, *behind = (package / path).read_text("utf-8").split(line)
        assert len(behind) == 1, (path, line)
        (package / path).write_text(f"{before}{line}{more}{behind[0]}", "utf-8")
    path = os.pathsep.join(map(str, (package.parent, tmp_path / "tools")))
    around = os.environ | {"PYTHONPATH": path, "ALLANITE_DETAILS": "1"}
    words = [sys.executable, "-c", BEFORE + use]
    done = subprocess.run(words, cwd=tmp_path, env=around, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert [words for words in said if words not in done.stdout] == [], done.stdout
