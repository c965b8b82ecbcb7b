"""Every table, figure and claim of the papers has a verdict, and a reason where ours differs."""

import re

import pytest

from allanite.papers.paper import AGREES, DIFFERS, PAPERS, VERDICTS, paper

ASKED = {
    "000": "Fig. 1; Fig. 2; Fig. 3; eq. 9; eq. 10; conclusion 1; conclusion 2; conclusion 3; conclusion 4; "
    "conclusion 5; p. 148",
    "001": "Fig. 5; Fig. 7; Fig. 9; Fig. 10; Table 1; Table 2; Table 3; eq. 5",
    "002": "Table 1; Fig. 2; Fig. 3",
    "003": "Table 1; Table 2; Table 3; Fig. 1; Fig. 2; Figs. 3, 4, 5, 7; Fig. 6; Fig. 8; Fig. 9; Fig. 10",
    "004": "Table 2; Table 3; Fig. 5; Fig. 6",
    "005": "abstract",
}

WIDTHS = (32, 16, 24)
"""Letters of an item with its claim, of what the paper prints, and of the first clause of the reason; ours have 22."""


@pytest.mark.parametrize("name", PAPERS)
def test_every_table_and_figure_is_there(name):
    listed = " ".join(item.item for item in paper(name).items)
    assert [wanted for wanted in ASKED[name].split("; ") if not re.search(rf"{wanted}\b", listed)] == []


@pytest.mark.parametrize("name", PAPERS)
def test_items_are_complete(name):
    for item in paper(name).items:
        assert all((item.claim, item.paper, item.here or item.verdict)), item
        assert item.verdict in ("", *VERDICTS), item
        assert item.why or item.tolerance or item.verdict in ("", AGREES), item
        assert item.why or item.verdict != DIFFERS, item


@pytest.mark.parametrize("name", PAPERS)
def test_a_line_of_the_first_screen_is_not_too_wide(name):
    for item in paper(name).items:
        shown = (f"{item.item}: {item.claim}", item.paper, re.split("[:;] ", item.why)[0])
        assert [(text, most) for text, most in zip(shown, WIDTHS, strict=True) if len(text) > most] == [], item.item
