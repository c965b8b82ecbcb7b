"""The first screen of every verb: at most 20 lines of 100 columns, with the answer in the first five."""

import re

import pytest
from tests import ROOT
from tests.rows import rows
from tests.verbs import ROWS, run

SCREENS = {line: answer for row in ROWS.values() for line, answer in row.screens.items()}
OTHERS = {line: answer for row in ROWS.values() for line, answer in row.others.items()}
OFTEN = [next(iter(ROWS[verb].screens)) for verb in ("info", "analyze", "deviation", "compare")]
"""Screens that every change is looked at by."""


def look(line, answer):
    """The bounds of a screen, its answer, and no number of the form 1e+05."""
    text = run(line).stdout
    lines = text.splitlines()
    assert len(lines) <= 20
    assert max(map(len, lines)) <= 100
    assert re.search(answer, "\n".join(lines[:5]) + "\n"), text
    assert not re.search(r"\de\+0\d", text)


@rows("line", OFTEN)
def test_the_first_screen_is_short_and_begins_with_the_answer(line, monkeypatch):
    monkeypatch.chdir(ROOT / "examples")
    look(line, SCREENS[line])


@pytest.mark.slow("screens of all verbs")
@rows("line", [line for line in SCREENS if line not in OFTEN])
def test_so_are_those_of_the_other_verbs(line, monkeypatch):
    monkeypatch.chdir(ROOT / "examples")
    look(line, SCREENS[line])


@pytest.mark.slow("screens of files that are made")
@rows("line", OTHERS)
def test_so_are_those_of_files_that_are_made(line, furnished, to_the_end, monkeypatch):
    monkeypatch.chdir(furnished)
    look(line, OTHERS[line])
