"""The table of the terms that are asked for: found, unbiased, within their limits, and not where they are absent."""

from table import read

import math
import re

import pytest

import terms

PAGE = read("terms.md")
ROWS = PAGE.rows()


def first(cell):
    return float(cell.split()[0])


def test_it_says_how_it_was_made():
    assert re.search(r"commit [0-9a-f]{7}, \d{4}-\d\d-\d\d", PAGE.head)
    assert {row["cell"] for row in ROWS} == {str(cell.model) for cell in terms.CELLS}


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row['cell'].split()[0]} {row['parameter']}")
def test_the_limits_cover(row):
    """95 % within what the records in which the term was found show of 93 %."""
    found = int(row["records"]) * first(row["found, %"]) / 100
    assert first(row["coverage, %"]) >= 93 - 260 * math.sqrt(0.93 * 0.07 / found)


@pytest.mark.parametrize("cell", terms.CELLS, ids=lambda cell: cell.extra.symbol)
def test_it_is_found_where_it_is_and_nowhere_else(cell):
    row = next(row for row in ROWS if row["parameter"] == cell.extra.symbol)
    assert first(row["found, %"]) >= 95
    assert abs(float(row["bias, %"])) <= 5
    absent = int(row["records"]) // 3
    assert first(row["false, %"]) <= 5 + 260 * math.sqrt(0.05 * 0.95 / absent)
