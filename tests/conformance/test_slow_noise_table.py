"""The table of slow things that are no noise holds what is claimed of it, and a part of it can be made again."""

from table import read

import math
import re

import pytest

import slow_noise

PAGE = read("slow_noise.md")
SLOW, CLEAN = PAGE.rows("Slow"), PAGE.rows("Clean")
RECORDS = int(re.search(r"--records (\d+)", PAGE.head)[1])


def beyond_chance(share, sign):
    """A share, %, that this many records show with a true one of `share` in all but 1 of 200 cases."""
    return share + sign * 260 * math.sqrt(share / 100 * (1 - share / 100) / RECORDS)


def test_it_says_how_it_was_made():
    assert re.search(r"commit [0-9a-f]{7}, \d{4}-\d\d-\d\d", PAGE.head)
    assert [(r["record"], r["noise"], int(r["n"])) for r in (*SLOW, *CLEAN)] == [
        cell for clean in (False, True) for cell in slow_noise.CELLS if (cell[0] == "clean") == clean
    ]


@pytest.mark.parametrize("row", SLOW, ids=lambda r: f"{r['record']}-{r['noise']}")
def test_three_in_five_are_named(row):
    name = {"w": "warm-up", "f": "flicker exponent", "b": "popcorn"}[row["record"][0]]
    assert float(row[f"{name} %"]) >= beyond_chance(60, -1)


@pytest.mark.parametrize("row", SLOW, ids=lambda r: f"{r['record']}-{r['noise']}")
def test_what_is_advised_helps(row):
    assert float(row["cured %"]) >= 80


@pytest.mark.parametrize("row", CLEAN, ids=lambda r: f"{r['noise']}-{r['n']}")
@pytest.mark.parametrize("name", slow_noise.NAMES)
def test_noise_alone_is_seldom_called_so(row, name):
    assert float(row[f"{name} %"]) <= beyond_chance(1, 1)
