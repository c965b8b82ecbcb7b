"""What README and the documentation say is run, and what pages show below a command is what it prints today."""

import re
import subprocess
import sys

import pytest
from tests import ROOT, thinned
from tests.pages import commands, fenced, furnish, stated, text_of, typed
from tests.rows import refused, rows

import allanite as al
import excerpts
from allanite.papers.paper import PAPERS, paper

WITH_COMMANDS = (
    "README.md", "tutorial.md", "command.md", "simulation.md", "install.md", "files.md", "compare.md",
    "how_long.md", "why_absent.md", "choosing_statistic.md", "angle_paper.md", "stabilizer_paper.md", "theoh_paper.md",
    "drift.md",
)  # fmt: skip
WITH_PYTHON = (
    "README.md", "simulation.md", "files.md", "compare.md", "rate_paper.md", "data_sheet.md", "migrating.md",
    "command.md", "published_formulas.md", "log_to_filter.md", "vertical.md", "stream.md", "architecture.md",
    "check.md", "drift.md",
)  # fmt: skip
"""Pages whose commands, and whose Python, are run by the tests below."""

COMMANDS = dict.fromkeys(command for page in WITH_COMMANDS for command in commands(page))
COMMANDS = [command for command in COMMANDS if not command.startswith("allanite example")]
"""Of README, and of the pages behind it; examples have a test of their own."""


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """The folder in which one works."""
    monkeypatch.chdir(furnish(tmp_path))
    return tmp_path


@pytest.mark.slow("takes more than half a second")
def test_the_tutorial_prints_what_it_says(desk):
    script = "".join(fenced("tutorial.md", "python"))
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    said = stated(script)
    assert len(said) >= 8
    for wanted, line in zip(said, done.stdout.splitlines(), strict=True):
        assert line.startswith(wanted)
    shown = re.findall(r"\]\(generated/tutorial/(.*?)\)", text_of("tutorial.md"))
    assert sorted(shown) == sorted(path.name for path in desk.iterdir() if path.is_file() and path.name != "FILE")


@pytest.mark.slow("takes more than half a second")
@rows("command", thinned(COMMANDS, 12, "every command"))
def test_commands_run_and_leave_what_they_name(tmp_path, monkeypatch, command):
    monkeypatch.chdir(furnish(tmp_path))
    typed(command)


@pytest.mark.slow("takes more than half a second")
def test_commands_of_a_page_that_follow_each_other(desk):
    every = commands("log_to_filter.md")
    assert len(every) == 8
    for command in every:
        typed(command, writing=())
    for name in ("imu.yaml", "vins.yaml", "orb.yaml"):
        assert re.search(r"(?m)^[\w.]*(noise_density|gyr_n|NoiseGyro): [\d.]+(e-\d+)?$", (desk / name).read_text())


ADIS = "adis_16405_imu1.rda"


@pytest.mark.nightly("commands of one page on a recording of 2.8 h")
def test_commands_of_the_gyro_vertical(desk, request):
    exec("".join(fenced("vertical.md", "python")), {})  # noqa: S102 - our own page
    every = commands("vertical.md")
    assert [ADIS in command for command in every] == [False, False, True]
    for command in every:
        if ADIS in command:
            (desk / ADIS).symlink_to(request.getfixturevalue("recordings").resolve() / ADIS)
        printed = " ".join(typed(command, "--force", writing=()).split())
    assert min((desk / name).stat().st_size for name in ("page.html", "angles.csv")) > 100_000
    for said in ("time constant 0.46", "predicted: 111 arcsec", "standard deviation 198 arcsec",
                 "predicted: 313 arcsec", "standard deviation 367 arcsec", "it would be 357 arcsec"):  # fmt: skip
        assert said in printed


@pytest.mark.slow("programs of all pages")
@rows("page", WITH_PYTHON)
def test_programs_of_a_page_print_what_they_say(tmp_path, page, monkeypatch, capsys):
    """In this process; the tutorial's is started on its own."""
    monkeypatch.chdir(furnish(tmp_path))
    script = "".join(fenced(page, "python"))
    exec(script, {"__name__": "__main__"})  # noqa: S102 - our own page
    printed = capsys.readouterr().out.splitlines()
    for said in stated(script):
        assert any(line.startswith(said) for line in printed), said


PAGES = [page for page in excerpts.pages() if excerpts.BLOCK.search(page.read_text("utf-8"))]


@pytest.mark.slow("takes more than half a second")
@rows("page", PAGES, ids=lambda page: page.stem)
def test_the_output_on_a_page_is_that_of_its_commands(page):
    text = page.read_text("utf-8")
    assert excerpts.renewed(text) == text, "python tools/excerpts.py renews it"


@pytest.mark.slow("takes more than half a second")
def test_a_stale_page_is_renewed_and_the_pipes_shorten():
    stale = "# A page\n\n```console\n$ allanite plan --details --sensor fog --rate 100 | grep fog\nold\n```\n"
    fresh = excerpts.renewed(stale)
    assert "old" not in fresh
    assert fresh.count("\n") == stale.count("\n")
    assert "fog  100 Hz" in fresh
    assert excerpts.renewed(fresh.replace("| grep", "| tail -1 | grep")).count("\n") == stale.count("\n") - 1
    refused(SystemExit, "exit code 3", lambda: excerpts.renewed("```console\n$ allanite analyze no.csv\n```\n"))


README = text_of("README.md")


def test_the_readme_is_short_with_its_figure_in_light_and_dark_and_links_that_lead_somewhere():
    assert fenced("README.md", "python")
    assert len(README.splitlines()) <= 125
    figures = [*re.findall(r'(?:src|srcset)="([^"]+)"', README), *re.findall(r"!\[[^]]+\]\(([^)]+)", README)]
    assert [(ROOT / figure).stat().st_size > 10_000 for figure in figures] == [True] * 3
    links = [link for link in re.findall(r"\]\(([^)#]+)", README) if "://" not in link]
    assert [link for link in links if not (ROOT / link).exists()] == []


def test_readme_and_index_name_the_system_of_every_paper_with_its_commands():
    for row in map(paper, PAPERS):
        page, verb = row.page.rpartition("/")[2], row.own[-1].partition(" ")[0]
        for text, wanted in ((README, (f"](docs/{page})", f"`{row.short}`", f"`{verb} ")),
                             (text_of("index.md"), (f"]({page})", f"`allanite example {row.short}`"))):  # fmt: skip
            assert [words for words in wanted if words not in text] == [], row.short


@pytest.mark.slow("takes more than half a second")
def test_the_sample_is_what_its_script_makes_and_teaches_what_it_should(monkeypatch):
    """Every channel's terms are found, no other is, and every interval holds its truth."""
    monkeypatch.syspath_prepend(str(ROOT / "examples"))
    from make_sample import TRUTH, sample

    path = ROOT / "examples" / "tactical_gyro.csv"
    kept, made = path.read_text(encoding="utf-8").splitlines(), sample().splitlines()
    assert made[:5] == kept[:5]
    # the transform's last digit is the library's: a hundredth of a deg/h may round the other way
    for a, b in zip(made[5:], kept[5:], strict=True):
        assert [float(v) for v in a.split(",")] == pytest.approx([float(v) for v in b.split(",")], abs=0.0101)
    recording = al.read(path)
    for name, truth in TRUTH.items():
        fit = al.identify(recording[name])
        assert fit.goodness.explained
        assert {e.symbol for e in fit if e.claimed} == {t.symbol for t in truth}
        for term in truth:
            low, high = fit[term.symbol].interval(0.95)
            assert low <= term.value <= high
