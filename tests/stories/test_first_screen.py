"""The first screen of every verb: at most 20 lines of 100 columns, with the answer in the first five."""

import re

import pytest
from tests import ROOT
from tests.rows import rows
from tests.verbs import ROWS, run

FIRST = [screen for row in ROWS.values() for screen in list(row.screens.items())[:1]]
FURTHER = [screen for row in ROWS.values() for screen in list(row.screens.items())[1:]]
OTHERS = [screen for row in ROWS.values() for screen in row.others.items()]


def look(line, answer):
    """The bounds of a screen, its answer, and no number of the form 1e+05."""
    text = run(line).stdout
    lines = text.splitlines()
    assert len(lines) <= 20
    assert max(map(len, lines)) <= 100
    assert re.search(answer, "\n".join(lines[:5]) + "\n"), text
    assert not re.search(r"\de\+0\d", text)


@rows("line, answer", FIRST)
def test_the_first_screen_is_short_and_begins_with_the_answer(line, answer, monkeypatch):
    monkeypatch.chdir(ROOT / "examples")
    look(line, answer)


@pytest.mark.slow("further screens of the verbs")
@rows("line, answer", FURTHER)
def test_so_do_further_screens(line, answer, monkeypatch):
    monkeypatch.chdir(ROOT / "examples")
    look(line, answer)


@pytest.mark.slow("screens of files that are made")
@rows("line, answer", OTHERS)
def test_so_do_those_of_files_that_are_made(line, answer, furnished, to_the_end, monkeypatch):
    monkeypatch.chdir(furnished)
    look(line, answer)
