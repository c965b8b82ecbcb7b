"""Every table is made again in one sequence, which goes on where it was stopped and ends by telling what has failed."""

import sys

import pytest
from tests import ROOT

import evidence
import fuzz
import nightly
import stale
from evidence import Job

PAGE = "# A\n\n- commit {commit}, 2026-11-21, x\n- command: `python benchmarks/streams.py{options}`\n\n| a |\n|---|\n"


@pytest.fixture
def made(tmp_path, monkeypatch):
    """What runs the sequence: its exit code, and the tables in the order in which their scripts ended."""
    jobs = {"late": Job(lane="quiet"), "bad": Job(), "good": Job(), "first": Job(lane="pool"), "known": Job()}
    order = tmp_path / "order"
    script = "import sys; open(sys.argv[1], 'a').write(sys.argv[2] + ' '); sys.exit(sys.argv[2] == 'bad')"
    monkeypatch.setattr(evidence, "TABLES", jobs)
    monkeypatch.setattr(evidence, "LOGS", tmp_path / "logs")
    monkeypatch.setattr(evidence, "fresh", lambda name: name == "known")
    monkeypatch.setattr(evidence, "commit", lambda: "0000000")
    monkeypatch.setattr(evidence, "command", lambda name: [sys.executable, "-S", "-c", script, str(order), name])

    def run(*words):
        order.write_text("")
        monkeypatch.setattr(sys, "argv", ["evidence.py", *words])
        return evidence.main(), order.read_text().split()

    return run


def test_a_script_that_fails_stops_no_other(made, capsys):
    code, order = made()
    assert code == 1
    assert (order[0], set(order[1:3]), order[3]) == ("first", {"bad", "good"}, "late")
    printed = capsys.readouterr().out
    assert "bad            exit code 1, see build/evidence/bad.log after" in printed
    assert "known          is of the code as it is" in printed
    assert "1 of 5 have failed" in printed


def test_names_select_and_all_makes_what_is_fresh(made):
    assert made("good", "known") == (0, ["good"])
    assert made("known", "--all") == (0, ["known"])


def test_what_cannot_be_made_is_refused(made, monkeypatch, capsys):
    with pytest.raises(SystemExit):
        made("nothing")
    assert "unknown: nothing; the tables are late, bad" in capsys.readouterr().err
    monkeypatch.setattr(evidence, "commit", lambda: "0000000 + uncommitted changes")
    with pytest.raises(SystemExit):
        made("good")
    assert "commit what has changed" in capsys.readouterr().err


def test_a_table_is_fresh_until_what_it_describes_changes(tmp_path, monkeypatch):
    if not stale.whole():
        pytest.skip(stale.SHALLOW)
    monkeypatch.setattr(evidence, "RESULTS", tmp_path)
    monkeypatch.setattr(evidence, "TABLES", {"streams": Job("--records 9")})

    def fresh(commit, options=" --records 9 --hours 1"):
        (tmp_path / "streams.md").write_text(PAGE.format(commit=commit, options=options))
        return evidence.fresh("streams")

    head, first = stale.git("rev-parse", "HEAD")[:7], stale.git("rev-list", "--max-parents=0", "HEAD")[:7]
    assert not evidence.fresh("streams")
    assert fresh(head)
    assert not fresh(first)
    assert not fresh(head, " --records 8 --hours 1")
    assert not fresh(f"{head} + uncommitted changes")


def test_a_script_is_known_with_what_it_imports():
    names = {path.relative_to(ROOT).as_posix() for path in evidence.beside(ROOT / "benchmarks" / "fuzz.py")}
    assert {"benchmarks/table.py", "tests/hostile.py", "tests/web/hostile.py", "tests/bag_files.py"} <= names


def test_every_night_has_seeds_of_its_own():
    words = nightly.words(nightly.PARTS["fuzz: files"])
    nights, rest = divmod(int(words[words.index("--first") + 1]), nightly.SEEDS_A_NIGHT)
    assert (nights > 0, rest) == (True, 0)
    assert max(max(target.kinds.values()) for target in fuzz.TARGETS.values()) <= nightly.SEEDS_A_NIGHT


def test_every_script_of_a_table_is_in_the_sequence():
    scripts = {path.stem for path in (ROOT / "benchmarks").glob("*.py") if " begin(" in path.read_text("utf-8")}
    assert scripts - {"table"} == set(evidence.TABLES)
    assert {path.stem for path in evidence.RESULTS.glob("*.md")} == set(evidence.TABLES)
