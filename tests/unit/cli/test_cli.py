"""The command line: exit codes, files, and what goes where."""

import csv
import io
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import click
import numpy as np
import pytest
from tests import ROOT
from tests.commands import ends, run
from tests.rows import rows

import allanite.study.analysis
from allanite.cli import main

OUTPUTS = {"report": "out.html", "plot": "out.png", "json": "out.json", "csv": "out.csv"}


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("data") / "gyro.csv"
    rng = np.random.default_rng(7)
    data = np.column_stack([np.arange(4000) / 10, rng.standard_normal((4000, 2)), np.zeros(4000)])
    np.savetxt(path, data, delimiter=",", fmt="%.9g", header="time [s],x [deg/h],y [deg/h],flat [deg/h]", comments="")
    return str(path)


@pytest.mark.slow("takes more than half a second")
def test_everything_is_written_and_named(file, tmp_path):
    paths = {name: tmp_path / file_name for name, file_name in OUTPUTS.items()}
    result = run("analyze", file, *(part for name, path in paths.items() for part in (f"--{name}", path)), code=0)
    assert result.stdout.splitlines()[-4:] == [f"{name}: {path}" for name, path in paths.items()]
    assert sorted(os.listdir(tmp_path)) == sorted(path.name for path in paths.values())
    assert paths["report"].read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert paths["plot"].read_bytes().startswith(b"\x89PNG")
    assert json.loads(paths["json"].read_text(encoding="utf-8"))["type"] == "Study"
    assert {row["channel"] for row in csv.DictReader(io.StringIO(paths["csv"].read_text(encoding="utf-8")))} == {
        "x",
        "y",
    }
    # json on standard output is alone there
    result = run("analyze", file, "--json", "-", "--csv", tmp_path / "a.csv")
    data = json.loads(result.stdout, parse_constant=pytest.fail)
    assert [channel["name"] for channel in data["channels"]] == ["x", "y", "flat"]
    assert "a.csv" in result.stderr
    # quiet prints nothing
    result = run("analyze", file, "--quiet", "--plot", tmp_path / "a.svg")
    assert (result.exit_code, result.output) == (0, "")
    assert (tmp_path / "a.svg").exists()


def test_options_win_over_the_recipe(file, tmp_path):
    recipe = tmp_path / "recipe.toml"
    recipe.write_text('channels = ["x"]\nlevel = 0.9\ntaus = "octave"\nterms = "QN"\n')
    result = run("analyze", file, "--recipe", recipe, "--level", "0.8", "--json", "-", "--taus", "1,10,20")
    data = json.loads(result.stdout)
    assert data["recipe"]["level"] == 0.8
    assert data["channels"][0]["curves"][0]["tau"] == [1.0, 10.0, 20.0]
    assert [term["symbol"] for term in data["channels"][0]["fit"]["terms"]] == ["Q", "N"]
    assert len(data["channels"]) == 1


def test_the_choices_reach_the_recipe(monkeypatch):
    seen = []

    def spy(path, recipe, *, progress):
        seen.append((path, recipe.to_dict()))
        raise KeyboardInterrupt

    monkeypatch.setattr(allanite.study.analysis, "analyze", spy)
    choices = (
        "--rate 5 --unit g --kind rate --scale 2 --channels a,b --time t --from 1 --until 9 --statistic adev "
        "--taus decade --terms QN --method ls --band 0.1,2 --level 0.9"
    )
    assert run("analyze", "some.csv", *choices.split()).exit_code == 130
    assert seen == [
        (
            "some.csv",
            {
                "rate": 5.0, "unit": "g", "kind": "rate", "scale": 2.0, "channels": ["a", "b"], "time": "t",
                "start": 1.0, "until": 9.0, "statistic": "adev", "taus": "decade", "terms": "QN", "method": "ls",
                "band": [0.1, 2.0], "level": 0.9,
            },
        )
    ]  # fmt: skip


@rows("name", OUTPUTS)
def test_a_file_that_exists_is_refused_before_the_work(name, file, tmp_path, monkeypatch):
    path = tmp_path / OUTPUTS[name]
    path.write_text("old")
    monkeypatch.setattr(allanite.study.analysis, "analyze", lambda *_, **__: pytest.fail("the work began"))
    ends(run("analyze", file, f"--{name}", path), 2, "--force")
    assert path.read_text() == "old"


def test_defects_and_too_little_memory(file, monkeypatch):
    def broken(*_, **__):
        raise ZeroDivisionError("by zero")

    monkeypatch.setattr(allanite.study.analysis, "analyze", broken)
    result = run("analyze", file, code=1)
    assert "internal error (ZeroDivisionError: by zero)" in result.stderr
    assert len(result.stderr.splitlines()) == 1
    for asked in (run("--debug", "analyze", file), run("analyze", file, env={"ALLANITE_DEBUG": "1"})):
        assert asked.exit_code == 1
        assert asked.stderr.startswith("error: ")
        assert "Traceback" in asked.stderr

    # too little memory is not a defect
    def greedy(*_, **__):
        raise MemoryError

    monkeypatch.setattr(allanite.study.analysis, "analyze", greedy)
    ends(run("analyze", file), 3, "--from")


def test_help_and_its_summaries():
    assert run("--version").stdout.startswith("allanite, version ")
    assert run("--help").exit_code == 0
    assert "--report" in run("analyze", "-h").stdout
    assert run().exit_code == 2
    # no summary of a verb is cut
    for words, command in commands():
        summary = command.help.partition("\n")[0]
        assert len(summary) <= 58, words
        assert command.get_short_help_str(60) == summary, words
    # of many options twelve are shown, all on demand; the examples have options that there are
    examples = tomllib.loads((ROOT / "src" / "allanite" / "cli" / "examples.toml").read_text("utf-8"))
    for (verb,), command in (row for row in commands() if len(row[0]) == 1 and row[0] != ("angle",)):
        every = {name for param in command.params for name in param.opts} | {"--help"}
        first, whole = (set(re.findall(r"^  (?:-\w, )?(--[a-z-]+)", run(verb, "--help", *more).stdout, re.MULTILINE))
                        for more in ((), ("all",)))  # fmt: skip
        first, whole = first & every, whole & every
        assert len(first) <= 15, verb
        assert whole > first or whole == first, verb
        assert len(examples[verb]) == 3, verb
        for line in examples[verb]:
            words = shlex.split(line)
            assert words[0] == verb
            assert {w for w in words if re.match("--?[a-z]", w)} <= every, line
    # each option is declared in one file
    declared = {}
    for path in sorted((ROOT / "src" / "allanite" / "cli").glob("*.py")):
        for name in re.findall(r'(?:click\.option\(\s*"--|path_option\(")([a-z-]+)', path.read_text(encoding="utf-8")):
            declared.setdefault(name, set()).add(path.name)
    assert {"lang", "model", "corrected"} < set(declared)
    assert {name: files for name, files in declared.items() if len(files) > 1} == {}


HEAVY = ("numpy", "numba", "scipy", "matplotlib", "pyarrow", "rich", "jinja2")


@rows("arguments", [["--help"], ["analyze", "--help"], ["--version"]])
def test_help_imports_nothing_heavy(arguments):
    code = (
        "import sys\nfrom allanite.cli import main\n"
        f"try: main({arguments!r})\nexcept SystemExit: pass\n"
        f"print([name for name in {HEAVY!r} if name in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "[]"


def command(*arguments):
    return [sys.executable, "-c", "from allanite.cli import main; main()", *arguments]


@pytest.mark.slow("a process of its own")
def test_a_reader_that_has_seen_enough_is_no_error(file, tmp_path):
    read, wrote = os.pipe()
    os.close(read)
    done = subprocess.run(command("analyze", file), stdout=wrote, stderr=subprocess.PIPE, text=True, check=False)
    os.close(wrote)
    assert (done.returncode, done.stderr) == (0, "")
    # files are written although nobody reads the table
    read, wrote = os.pipe()
    os.close(read)
    paths = [tmp_path / "out.json", tmp_path / "out.csv"]
    line = command("analyze", file, "--json", str(paths[0]), "--csv", str(paths[1]), "--strict")
    done = subprocess.run(line, stdout=wrote, stderr=subprocess.PIPE, text=True, check=False)
    os.close(wrote)
    assert done.returncode == 3
    assert "flat" in done.stderr
    assert json.loads(paths[0].read_text(encoding="utf-8"))["type"] == "Study"
    assert paths[1].read_text(encoding="utf-8").startswith("channel,")
    # a terminal without the letters gets the table
    path = tmp_path / "gÿro.csv"
    path.write_bytes(Path(file).read_bytes())
    env = os.environ | {"PYTHONIOENCODING": "ascii"}
    done = subprocess.run(command("analyze", str(path)), capture_output=True, env=env, check=False)
    assert done.returncode == 0, done.stderr
    assert b"g\\xffro.csv" in done.stdout


# the summaries and the options


def commands(group=main, path=()):
    """Every command with the words that call it."""
    for name in group.list_commands(None):
        command = group.get_command(None, name)
        yield (*path, name), command
        if isinstance(command, click.Group):
            yield from commands(command, (*path, name))


@pytest.mark.slow("takes more than half a second")
def test_what_is_read_off_the_curve_is_said_everywhere(file, tmp_path):
    paths = [tmp_path / name for name in ("a.html", "a.json", "a.csv")]
    result = run("analyze", file, "--report", paths[0], "--json", paths[1], "--coefficients", paths[2])
    assert re.search(r"in-run bias stability +\S+ .* °/h", result.stdout)
    assert "in-run bias stability" in paths[0].read_text(encoding="utf-8")
    x, _, flat = json.loads(paths[1].read_text(encoding="utf-8"))["channels"]
    assert flat["readings"] is None
    rows = list(csv.DictReader(io.StringIO(paths[2].read_text(encoding="utf-8"))))
    of_x = {row["term"] or row["name"]: row for row in rows if row["channel"] == "x"}
    assert set(of_x) >= {"Q", "N", "B", "K", "R", "deviation at 1 s", "minimum / 0.664"}
    assert float(of_x["deviation at 1 s"]["value"]) == x["readings"]["shown"][0]["value"]
    assert (of_x["N"]["status"], of_x["K"]["status"], of_x["K"]["value"]) == ("identified", "absent", "")
    assert float(of_x["N"]["low"]) < float(of_x["N"]["value"]) < float(of_x["N"]["high"])
    assert float(of_x["N"]["si_value"]) == x["fit"]["terms"][1]["value"]


@pytest.mark.slow("takes more than half a second")
@rows("other", [("--statistic", "mdev"), ("--taus", "1,10")])
def test_readings_do_not_depend_on_the_curve_that_is_shown(file, other):
    found = [run("analyze", file, "--coefficients", "-", *options).stdout for options in ((), other)]
    kept = [[line for line in text.splitlines() if ",reading," in line] for text in found]
    assert kept[0] == kept[1]
    assert len(kept[0]) > 10


@pytest.mark.slow("takes more than half a second")
def test_a_method_that_cannot_know_the_sign_of_a_ramp_prints_its_size(tmp_path):
    sample, paths = ROOT / "examples" / "tactical_gyro.csv", [tmp_path / "a.html", tmp_path / "a.svg"]
    result = run("analyze", sample, "--channels", "gz", "--method", "gls", "--report", paths[0], "--plot", paths[1])
    assert re.search(r"\|R\| +rate ramp +57 +41 \.\. 69 +°/h²", result.stdout)
    assert "+57" not in result.stdout
    assert 'style="color: ' in re.search(r"<th[^>]*>\|R\|", paths[0].read_text(encoding="utf-8"))[0]
    assert re.search(r" R +rate ramp +-57\.9 ", run("analyze", sample, "--channels", "gz").stdout)


def test_a_negative_square_is_explained():
    sample = ROOT / "examples" / "tactical_gyro.csv"
    result = run("analyze", sample, "--channels", "gy", "--method", "ls")
    assert re.search(r" R +rate ramp +-46\.46 +°/h² +negative", result.stdout)
    assert "negative: the estimated square of the coefficient is negative" in result.stdout
    assert "negative:" not in run("analyze", sample, "--channels", "gy").stdout


@pytest.mark.slow("runs a batch")
def test_other_spellings_of_verbs(file, tmp_path):
    """A verb called by an old name, or by an option of another one."""
    folder = tmp_path / "units"
    folder.mkdir()
    shutil.copy(file, folder)
    for ways in (
        (("deviation", file, "--channels", "x", "--window", 30), ("dynamic", file, "--channels", "x", "--window", 30)),
        (("budget", "--help"), ("quantization", "--help")),
        (("plan", "--verify", "--help"), ("selfcheck", "--help")),
        (("analyze", folder, "--out", "r", "--help"), ("batch", folder, "--out", "r", "--help")),
    ):
        one, other = (run(*words).stdout.split("\n")[1:-2] for words in ways)
        assert one == other != []
    assert run("analyze", folder, "--out", tmp_path / "r", "--channels", "x", "--workers", 1).exit_code == 0
    assert run("analyze", tmp_path / "r").stdout == run("lot", tmp_path / "r").stdout != ""
