"""What the documentation says is run."""

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from tests import ROOT
from tests.rows import rows

import allanite as al
from allanite.cli import main

DOCS = ROOT / "docs"
SAMPLE = Path("examples", "tactical_gyro.csv")


def fenced(text, language):
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


def blocks(page, language):
    return fenced((DOCS / page).read_text("utf-8"), language)


def commands(text):
    return [line for block in fenced(text, "sh") for line in block.splitlines() if line.startswith("allanite ")]


WITH_COMMANDS = (
    "tutorial.md", "command.md", "simulation.md", "install.md", "files.md", "compare.md", "how_long.md",
    "why_absent.md", "choosing_statistic.md", "angle_paper.md", "stabilizer_paper.md", "theoh_paper.md", "drift.md",
)  # fmt: skip
WITH_PYTHON = (
    "simulation.md", "files.md", "compare.md", "rate_paper.md", "data_sheet.md", "migrating.md", "command.md",
    "published_formulas.md", "log_to_filter.md", "vertical.md", "stream.md", "architecture.md", "check.md", "drift.md",
)  # fmt: skip
"""Pages whose commands, and whose Python, are run by the tests below."""

IN_README = commands((ROOT / "README.md").read_text("utf-8"))
"""Commands that are run by the test of the README."""

COMMANDS = [
    command
    for command in dict.fromkeys(
        command for page in WITH_COMMANDS for command in commands((DOCS / page).read_text("utf-8"))
    )
    if command not in IN_README and not command.startswith("allanite example")  # run by the test of the examples
]


@rows("symbol", al.TERMS)
def test_every_term_is_put_into_words(symbol):
    row = al.TERMS[symbol]
    assert len(row.origin) > 80
    assert len(row.advice) > 80
    assert row.density or row.waveform is not None


def furnish(tmp_path):
    (tmp_path / "examples").mkdir()
    shutil.copy(ROOT / SAMPLE, tmp_path / SAMPLE)
    return tmp_path


@pytest.mark.slow("takes more than half a second")
def test_the_tutorial_prints_what_it_says(tmp_path):
    desk = furnish(tmp_path)
    script = "".join(blocks("tutorial.md", "python"))
    done = subprocess.run([sys.executable, "-c", script], cwd=desk, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    said = re.findall(r"^print\(.*\)  # (.*)$", script, re.MULTILINE)
    assert len(said) >= 8
    printed = done.stdout.splitlines()
    assert len(printed) == len(said)
    for wanted, line in zip(said, printed, strict=True):
        assert line.startswith(wanted)
    shown = re.findall(r"\]\(generated/tutorial/(.*?)\)", (DOCS / "tutorial.md").read_text("utf-8"))
    assert sorted(shown) == sorted(path.name for path in desk.iterdir() if path.is_file())


@pytest.mark.slow("takes more than half a second")
@rows("command", COMMANDS)
def test_commands_run_and_leave_what_they_name(tmp_path, monkeypatch, command):
    desk = furnish(tmp_path)
    monkeypatch.chdir(desk)
    _, *words = shlex.split(command)
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 0, done.output
    for option in ("--report", "--plot", "--csv"):
        if option in words:
            assert (desk / words[words.index(option) + 1]).stat().st_size > 1000


@pytest.mark.slow("takes more than half a second")
def test_commands_of_a_page_that_follow_each_other(tmp_path, monkeypatch):
    desk = furnish(tmp_path)
    monkeypatch.chdir(desk)
    every = commands((DOCS / "log_to_filter.md").read_text("utf-8"))
    assert len(every) == 8
    for command in every:
        done = CliRunner().invoke(main, shlex.split(command)[1:])
        assert done.exit_code == 0, (command, done.output)
    for name in ("imu.yaml", "vins.yaml", "orb.yaml"):
        assert re.search(
            r"^[\w.]*(noise_density|gyr_n|NoiseGyro): [\d.]+(e-\d+)?$", (desk / name).read_text(), re.MULTILINE
        )


ADIS = "adis_16405_imu1.rda"


@pytest.mark.slow("takes more than half a second")
def test_commands_of_the_gyro_vertical(tmp_path, monkeypatch, request):
    desk = furnish(tmp_path)
    monkeypatch.chdir(desk)
    exec("".join(blocks("vertical.md", "python")), {})  # noqa: S102 - our own page
    every = commands((DOCS / "vertical.md").read_text("utf-8"))
    assert [ADIS in command for command in every] == [False, False, True]
    printed = []
    for command in every:
        if ADIS in command:
            (desk / ADIS).symlink_to(request.getfixturevalue("recordings").resolve() / ADIS)
        done = CliRunner().invoke(main, [*shlex.split(command)[1:], "--force"])
        assert done.exit_code == 0, (command, done.output)
        printed.append(" ".join(done.output.split()))
    assert (desk / "page.html").stat().st_size > 100_000
    assert (desk / "angles.csv").stat().st_size > 100_000
    for said in ("time constant 0.46 s", "predicted: 111 arcsec", "standard deviation 198 arcsec",
                 "predicted: 313 arcsec", "standard deviation 367 arcsec", "it would be 357 arcsec"):  # fmt: skip
        assert said in printed[-1]


@pytest.mark.slow("programs of all pages")
@rows("page", WITH_PYTHON)
def test_programs_of_a_page_print_what_they_say(tmp_path, page, monkeypatch, capsys):
    """In this process; the tutorial's is started on its own."""
    desk = furnish(tmp_path)
    monkeypatch.chdir(desk)
    script = "".join(blocks(page, "python"))
    exec(script, {"__name__": "__main__"})  # noqa: S102 - our own page
    printed = capsys.readouterr().out.splitlines()
    for said in re.findall(r"^print\(.*\)  # (.*)$", script, re.MULTILINE):
        assert any(line.startswith(said) for line in printed), said
