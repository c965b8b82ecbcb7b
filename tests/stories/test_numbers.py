"""Measured numbers of README and documentation are those of the committed tables, and tables name a known commit."""

from table import Page

import re

import pytest

import allanite as al
import figures
import stale


def test_a_figure_that_was_changed_is_brought_back():
    page, sentence, numbers = next(row for row in figures.SENTENCES if row[0] == "docs/data_sheet.md")
    right = f"{sentence.format(*numbers())} (benchmarks/results/recordings.md)."
    wrong = re.sub(r"\b[\d.]+ to", "12 to", right.replace(" times", "\n  times"))
    assert "12 to" in wrong
    assert figures.counted(page, wrong, []) == right


def test_a_link_says_what_its_table_is_of():
    commit, date = stale.stamp(figures.table.read("methods.md"))
    link = "[a](benchmarks/results/methods.md)"
    noted = figures.noted("README.md", link)
    assert noted == f"[a, measured {date} at {commit}](benchmarks/results/methods.md)"
    assert figures.noted("README.md", noted) == noted


@pytest.fixture
def head():
    if not stale.whole():
        pytest.skip(stale.SHALLOW)
    return stale.git("rev-parse", "HEAD")[:7]


def page(commit, script="methods"):
    return Page(f"# A\n\n- commit {commit}, 2026-11-21, x\n- command: `python benchmarks/{script}.py`\n\n| a |\n|---|")


def test_a_table_of_the_commit_before_a_rewrite_is_stale(head):
    assert stale.age(page(head), "a.md").verdict == "fresh"
    first = stale.git("rev-list", "--max-parents=0", "HEAD")[:7]
    assert stale.age(page(first), "a.md").verdict == "stale"
    for lost in (page(f"before {head}"), page("0000000"), page(head, "nothing")):
        assert stale.age(lost, "a.md").verdict.startswith("stale: ")


def test_a_release_waits_for_tables_of_the_code_as_it_is(head, monkeypatch):
    first = stale.git("rev-list", "--max-parents=0", "HEAD")[:7]
    for commit, names in ((head, []), (first, ["a.md"]), ("0000000", ["a.md"])):
        monkeypatch.setattr(stale, "pages", lambda commit=commit: [("a.md", page(commit))])
        assert [line.partition(":")[0] for line in stale.unfit()] == names
    monkeypatch.setattr(stale, "whole", lambda: False)
    assert stale.unfit() == [stale.SHALLOW]


def test_counts_of_statistics_are_those_of_the_program():
    assert "**Seventeen statistics**" in (figures.ROOT / "README.md").read_text("utf-8")
    assert len(al.statistics.STATISTICS) == 17
