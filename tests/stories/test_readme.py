"""What the README says is run."""

import re
import shlex
import shutil
import subprocess
import sys

import pytest
from click.testing import CliRunner
from tests import ROOT

from allanite.cli import main

README = (ROOT / "README.md").read_text(encoding="utf-8")
SAMPLE = "examples/tactical_gyro.csv"


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```", README, re.DOTALL | re.MULTILINE)


PYTHON = blocks("python")
COMMANDS = [line for block in blocks("sh") for line in block.splitlines() if line.startswith("allanite ")]


@pytest.fixture
def desk(tmp_path):
    """A folder as somebody who follows the README has it: the sample, and a plain column of numbers."""
    (tmp_path / "examples").mkdir()
    shutil.copy(ROOT / SAMPLE, tmp_path / SAMPLE)
    rows = (ROOT / SAMPLE).read_text(encoding="utf-8").splitlines()[5:]
    (tmp_path / "FILE").write_text("\n".join(row.split(",")[1] for row in rows), encoding="utf-8")
    return tmp_path


def run(command, desk):
    return subprocess.run(command, cwd=desk, capture_output=True, text=True, check=False)


@pytest.mark.slow("takes more than half a second")
@pytest.mark.parametrize("block", PYTHON, ids=range(len(PYTHON)))
def test_python_blocks_run_and_print_what_they_say(desk, block):
    done = run([sys.executable, "-c", block], desk)
    assert done.returncode == 0, done.stderr
    for said in re.findall(r"^print\(.*\)  # (.*)$", block, re.MULTILINE):
        assert said in done.stdout


@pytest.mark.slow("takes more than half a second")
@pytest.mark.parametrize("command", COMMANDS)
def test_commands_run_and_leave_what_they_name(desk, monkeypatch, command):
    """In this process; the program itself is started for the excerpt below."""
    monkeypatch.chdir(desk)
    _, *words = shlex.split(command)
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 0, done.output
    for option in ("--report", "--plot", "--csv"):
        if option in words:
            assert (desk / words[words.index(option) + 1]).stat().st_size > 1000


def test_there_are_examples_to_run():
    assert len(PYTHON) >= 1
    assert "allanite analyze FILE --rate 100 --unit deg/s --report report.html" in COMMANDS


def test_it_is_short_and_has_its_figure_in_light_and_dark():
    assert len(README.splitlines()) <= 125
    figures = [*re.findall(r'(?:src|srcset)="([^"]+)"', README), *re.findall(r"!\[[^]]+\]\(([^)]+)", README)]
    assert len(figures) == 3
    for figure in figures:
        assert (ROOT / figure).stat().st_size > 10_000


def test_the_first_screen_says_for_whom_it_is_and_has_a_result():
    first = README.splitlines()[:60]
    for words in (
        "is for engineers who",
        "Status:",
        "git clone",
        "pip install .",
        "$ allanite analyze",
        "R  rate ramp",
    ):
        assert any(words in line for line in first), words
    assert README.index("pip install .") < README.index("make ")


def test_links_lead_somewhere():
    links = [link for link in re.findall(r"\]\(([^)#]+)", README) if "://" not in link]
    assert links
    assert [link for link in links if not (ROOT / link).exists()] == []


@pytest.mark.slow("takes more than half a second")
def test_the_sample_is_what_its_script_makes():
    sys.path.insert(0, str(ROOT / "examples"))
    try:
        from make_sample import sample
    finally:
        sys.path.pop(0)
    kept = (ROOT / SAMPLE).read_text(encoding="utf-8").splitlines()
    made = sample().splitlines()
    assert made[:5] == kept[:5]
    # the transform's last digit is the library's: a hundredth of a deg/h may round the other way
    for a, b in zip(made[5:], kept[5:], strict=True):
        assert [float(v) for v in a.split(",")] == pytest.approx([float(v) for v in b.split(",")], abs=0.0101)


@pytest.mark.slow("takes more than half a second")
def test_the_sample_teaches_what_it_should():
    """Every channel's terms are found, no other is, and every interval holds its truth."""
    import allanite as al

    sys.path.insert(0, str(ROOT / "examples"))
    try:
        from make_sample import TRUTH
    finally:
        sys.path.pop(0)
    recording = al.read(ROOT / SAMPLE)
    for name, truth in TRUTH.items():
        fit = al.identify(recording[name])
        assert fit.goodness.explained
        assert {e.symbol for e in fit if e.claimed} == {t.symbol for t in truth}
        for term in truth:
            low, high = fit[term.symbol].interval(0.95)
            assert low <= term.value <= high
