"""Measured numbers of README and documentation are those of the committed tables, and tables name a known commit."""

import cells
from table import Page

import re

import pytest

import figures
import promises
import stale


def test_a_figure_that_was_changed_is_brought_back():
    page, sentence, numbers = next(row for row in figures.SENTENCES if row[1].startswith("squares: "))
    right = f"{sentence.format(*numbers())} (benchmarks/results/compensation.md)."
    wrong = re.sub(r"\d+ to \d+", "12 to\n  13", right)
    assert figures.counted(page, wrong, []) == right


def test_a_number_whose_table_has_not_been_made_is_shown_as_such():
    filled = figures.filled("in {:g} to {:.0f} % of records", lambda: cells.figures("never.md", "", "share"))
    assert filled == "in … to … % of records"
    assert figures.pattern("in {:g} to {:s} %").search("in … to N and B %")


def test_a_link_to_a_table_that_has_not_been_made_leads_to_the_index():
    made, coming = "[rate](generated/benchmarks/rate.md)", "[never](generated/benchmarks/never.md)"
    shown = promises.arrived(f"{made}, {coming}")
    assert shown == f"{made}, [never, not made yet](generated/benchmarks/index.md)"
    assert promises.arrived(shown.replace("never", "rate")).count(made) == 2


def test_promises_are_on_the_pages_that_are_said_to_make_them():
    assert list(promises.broken()) == []


def test_a_link_says_what_its_table_is_of():
    commit, date = stale.stamp(cells.read("rate.md"))
    link = "[a](benchmarks/results/rate.md)"
    noted = figures.noted("README.md", link)
    assert noted == f"[a, measured {date} at {commit}](benchmarks/results/rate.md)"
    assert figures.noted("README.md", noted) == noted


PAGE = "# A\n\n- commit {}, 2026-11-21, x\n- command: `python benchmarks/{}.py`\n\n| a |\n|---|"


def test_a_release_waits_for_tables_of_the_code_as_it_is(monkeypatch):
    if not stale.whole():
        pytest.skip(stale.SHALLOW)
    head, first = stale.git("rev-parse", "HEAD")[:7], stale.git("rev-list", "--max-parents=0", "HEAD")[:7]
    none = "stale: not of a commit of the history"
    for commit, script, verdict, unfit in ((head, "methods", "fresh", False), (first, "methods", "stale", True),
                                           (f"before {head}", "methods", none, True), (head, "nothing", none, True),
                                           ("0000000", "methods", none, True)):  # fmt: skip
        page = Page(PAGE.format(commit, script))
        assert stale.age(page, "a.md").verdict == verdict
        monkeypatch.setattr(stale, "pages", lambda page=page: [("a.md", page)])
        assert [line.partition(":")[0] for line in stale.unfit()] == ["a.md"] * unfit
    monkeypatch.setattr(stale, "whole", lambda: False)
    assert stale.unfit() == [stale.SHALLOW]
