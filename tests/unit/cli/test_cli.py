"""The command line: exit codes, files, and what goes where."""

import csv
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib

import click
import numpy as np
import pytest
from tests import ROOT
from tests.commands import ends, run
from tests.rows import rows

import allanite.study.analysis
from allanite.cli import main

SAMPLE = ROOT / "examples" / "tactical_gyro.csv"
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
    assert {row["channel"] for row in table(paths["csv"])} == {"x", "y"}
    # json on standard output is alone there
    result = run("analyze", file, "--json", "-", "--csv", tmp_path / "a.csv")
    data = json.loads(result.stdout, parse_constant=pytest.fail)
    assert [channel["name"] for channel in data["channels"]] == ["x", "y", "flat"]
    assert "a.csv" in result.stderr
    # quiet prints nothing
    assert run("analyze", file, "--quiet", "--plot", tmp_path / "a.svg", code=0).output == ""
    assert (tmp_path / "a.svg").exists()


def table(path):
    return list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))


def test_options_win_over_the_recipe(file, tmp_path):
    recipe = tmp_path / "recipe.toml"
    recipe.write_text('channels = ["x"]\nlevel = 0.9\ntaus = "octave"\nterms = "QN"\n')
    result = run("analyze", file, "--recipe", recipe, "--level", "0.8", "--json", "-", "--taus", "1,10,20")
    data = json.loads(result.stdout)
    assert data["recipe"]["level"] == 0.8
    assert data["channels"][0]["curves"][0]["tau"] == [1.0, 10.0, 20.0]
    assert [term["symbol"] for term in data["channels"][0]["fit"]["terms"]] == ["Q", "N"]
    assert len(data["channels"]) == 1


@rows("name", OUTPUTS)
def test_a_file_that_exists_is_refused_before_the_work(name, file, tmp_path, monkeypatch):
    path = tmp_path / OUTPUTS[name]
    path.write_text("old")
    monkeypatch.setattr(allanite.study.analysis, "analyze", lambda *_, **__: pytest.fail("the work began"))
    ends(run("analyze", file, f"--{name}", path), 2, "--force")
    assert path.read_text() == "old"


def raising(monkeypatch, error):
    """An analysis that ends with an error."""

    def analyze(*_, **__):
        raise error

    monkeypatch.setattr(allanite.study.analysis, "analyze", analyze)


def test_defects_and_too_little_memory_and_an_end_by_the_user(file, monkeypatch):
    raising(monkeypatch, ZeroDivisionError("by zero"))
    result = run("analyze", file)
    ends(result, 1, "internal error (ZeroDivisionError: by zero)")
    assert len(result.stderr.splitlines()) == 1
    for asked in (run("--debug", "analyze", file, code=1), run("analyze", file, env={"ALLANITE_DEBUG": "1"}, code=1)):
        assert asked.stderr.startswith("error: ")
        assert "Traceback" in asked.stderr
    raising(monkeypatch, MemoryError())
    ends(run("analyze", file), 3, "--from")
    raising(monkeypatch, KeyboardInterrupt())
    run("analyze", file, code=130)


def test_help_and_its_summaries():
    assert run("--version").stdout.startswith("allanite, version ")
    assert run("--help").exit_code == 0
    assert "--report" in run("analyze", "-h").stdout
    assert run().exit_code == 2
    # no summary of a verb is cut
    for words, command in commands():
        summary = command.help.partition("\n")[0]
        assert len(summary) <= (45 if len(words) == 1 else 58), words
        assert command.get_short_help_str(60) == summary, words
    # of many options twelve are shown, all on demand; the examples have options that there are
    examples = tomllib.loads((ROOT / "src" / "allanite" / "cli" / "examples.toml").read_text("utf-8"))
    for (verb,), command in (row for row in commands() if len(row[0]) == 1 and row[0] != ("angle",)):
        every = {name for param in command.params for name in param.opts} | {"--help"}
        first, whole = (set(re.findall(r"^  (?:-\w, )?(--[a-z-]+)", run(verb, "--help", *more).stdout, re.MULTILINE))
                        for more in ((), ("all",)))  # fmt: skip
        first, whole = first & every, whole & every
        assert len(first) <= 15, verb
        assert whole >= first, verb
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


@rows("arguments", [["--help"], ["analyze", "--help"], ["--version"]])
def test_help_imports_nothing_heavy(arguments):
    heavy = ("numpy", "numba", "scipy", "matplotlib", "pyarrow", "rich", "jinja2")
    code = (
        "import sys\nfrom allanite.cli import main\n"
        f"try: main({arguments!r})\nexcept SystemExit: sys.exit(any(name in sys.modules for name in {heavy!r}))"
    )
    subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)


PROGRAM = [sys.executable, "-m", "allanite.cli"]


def unread(*arguments):
    """How a command ends whose standard output nobody reads."""
    read, wrote = os.pipe()
    os.close(read)
    done = subprocess.run([*PROGRAM, *arguments], stdout=wrote, stderr=subprocess.PIPE, text=True, check=False)
    os.close(wrote)
    return done


@pytest.mark.slow("a process of its own")
def test_a_reader_that_has_seen_enough_is_no_error(file, tmp_path):
    done = unread("analyze", file)
    assert (done.returncode, done.stderr) == (0, "")
    # files are written although nobody reads the table
    paths = [tmp_path / "out.json", tmp_path / "out.csv"]
    done = unread("analyze", file, "--json", str(paths[0]), "--csv", str(paths[1]), "--strict")
    assert done.returncode == 3
    assert "flat" in done.stderr
    assert json.loads(paths[0].read_text(encoding="utf-8"))["type"] == "Study"
    assert paths[1].read_text(encoding="utf-8").startswith("channel,")
    # a terminal without the letters gets the table
    path = shutil.copy(file, tmp_path / "gÿro.csv")
    env = os.environ | {"PYTHONIOENCODING": "ascii"}
    done = subprocess.run([*PROGRAM, "analyze", path], capture_output=True, env=env, check=True)
    assert b"g\\xffro.csv" in done.stdout


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
    of_x = {row["term"] or row["name"]: row for row in table(paths[2]) if row["channel"] == "x"}
    assert set(of_x) >= {"Q", "N", "B", "K", "R", "deviation at 1 s", "minimum / 0.664"}
    assert float(of_x["deviation at 1 s"]["value"]) == x["readings"]["shown"][0]["value"]
    assert (of_x["N"]["status"], of_x["K"]["status"], of_x["K"]["value"]) == ("identified", "absent", "")
    assert float(of_x["N"]["low"]) < float(of_x["N"]["value"]) < float(of_x["N"]["high"])
    assert float(of_x["N"]["si_value"]) == x["fit"]["terms"][1]["value"]
    # readings do not depend on the curve that is shown
    readings = [line for line in paths[2].read_text(encoding="utf-8").splitlines() if ",reading," in line]
    assert len(readings) > 10
    for other in (("--statistic", "mdev"), ("--taus", "1,10")):
        lines = run("analyze", file, "--coefficients", "-", *other).stdout.splitlines()
        assert [line for line in lines if ",reading," in line] == readings


@pytest.mark.slow("takes more than half a second")
def test_ramps_of_methods_that_know_their_size_or_square_alone(tmp_path):
    paths = [tmp_path / "a.html", tmp_path / "a.svg"]
    result = run("analyze", SAMPLE, "--channels", "gz", "--method", "gls", "--report", paths[0], "--plot", paths[1])
    assert re.search(r"\|R\| +rate ramp +57 +41 \.\. 69 +°/h²", result.stdout)
    assert "+57" not in result.stdout
    assert 'style="color: ' in re.search(r"<th[^>]*>\|R\|", paths[0].read_text(encoding="utf-8"))[0]
    assert re.search(r" R +rate ramp +-57\.9 ", run("analyze", SAMPLE, "--channels", "gz").stdout)
    # a negative square is explained
    result = run("analyze", SAMPLE, "--channels", "gy", "--method", "ls")
    assert re.search(r" R +rate ramp +-46\.46 +°/h² +negative", result.stdout)
    assert "negative: the estimated square of the coefficient is negative" in result.stdout
    assert "negative:" not in run("analyze", SAMPLE, "--channels", "gy").stdout


@pytest.mark.slow("eight processes")
def test_the_number_of_processors_changes_the_time_only(file, tmp_path):
    (tmp_path / "two.toml").write_text("threads = 2\n", encoding="utf-8")
    for verb in ("deviation", "spectrum"):
        choices = ([], ["--threads", 1], ["--threads", 3], ["--recipe", tmp_path / "two.toml"])
        outputs = {run(verb, file, "--channels", "x,y", "--json", "-", *more, code=0).stdout for more in choices}
        assert len(outputs) == 1


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
    run("analyze", folder, "--out", tmp_path / "r", "--channels", "x", "--workers", 1, code=0)
    assert run("analyze", tmp_path / "r").stdout == run("lot", tmp_path / "r").stdout != ""
