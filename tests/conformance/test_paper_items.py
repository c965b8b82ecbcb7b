"""Every table, figure and claim of the papers has a verdict, and a reason where ours differs."""

import re

import pytest
from tests.rows import rows

from allanite.papers.paper import AGREES, DIFFERS, PAPERS, VERDICTS, Item, compared, paper

WIDTHS = (32, 16, 24)
"""Letters of an item with its claim, of what the paper prints, and of the first clause of the reason; ours have 22."""


@rows("name", PAPERS)
def test_items_are_complete(name):
    for item in paper(name).items:
        assert all((item.claim, item.paper, item.here or item.verdict)), item
        assert item.verdict in ("", *VERDICTS), item
        assert item.why or item.tolerance or item.verdict in ("", AGREES), item
        assert item.why or item.verdict != DIFFERS, item
        read = any(": " in place for place in item.here)
        assert not read or item.numbers or item.ours, f"a verdict that cannot fail: {item}"
        assert item.verdict != AGREES or item.numbers, f"nothing is compared: {item}"


def test_a_verdict_fails_where_the_files_hold_other_numbers(tmp_path):
    (tmp_path / "a.csv").write_text("value\n7\n", "utf-8")
    for more, verdict in (
        ({"numbers": (7.0,)}, True), ({"numbers": (8.0,)}, False), ({"ours": (7.0,), "verdict": "computed"}, True),
        ({"ours": (8.0,), "verdict": "computed"}, False), ({"numbers": (7.0,), "verdict": "misprint"}, False),
        ({"numbers": (8.0,), "verdict": "misprint", "ours": (9.0,)}, False),
    ):  # fmt: skip
        found = compared(Item("eq. 1", "a claim", "7", here=("a.csv: value",), tolerance=0.01, **more), tmp_path)
        assert found.expected is verdict, more
    with pytest.raises(LookupError, match=r"a\.csv has no row value=9"):
        compared(Item("eq. 1", "a claim", "7", here=("a.csv: value @ value=9",)), tmp_path)


@rows("name", PAPERS)
def test_a_line_of_the_first_screen_is_not_too_wide(name):
    for item in paper(name).items:
        shown = (f"{item.item}: {item.claim}", item.paper, re.split("[:;] ", item.why)[0])
        assert [(text, most) for text, most in zip(shown, WIDTHS, strict=True) if len(text) > most] == [], item.item
