"""A paper's before and after: the page is computed, and its numbers move with what goes in."""

import re
import sys

import pytest
from tests import ROOT

from allanite.comparison.change import OUTCOMES

DOCS = ROOT / "docs"


@pytest.fixture(scope="module")
def page():
    sys.path.insert(0, str(DOCS))
    try:
        from generate import compensation
    finally:
        sys.path.pop(0)
    return compensation


def numbers(lines, symbol):
    """Cells of the row of a term in the table of the comparison."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith(f"| {symbol} ")]
    (found,) = (row for row in rows if row[-1] in OUTCOMES)
    return found


def test_the_numbers_move_with_the_input(page, tmp_path):
    louder = {symbol: 1.1 * value for symbol, value in page.TABLE_2.items()}
    before, after = (page.compensation_page(tmp_path, values, seconds=120.0) for values in (page.TABLE_2, louder))
    for symbol, column in (("N", 2), ("N", 4), ("N", 5), ("Q", 2)):
        assert numbers(before, symbol)[column] != numbers(after, symbol)[column]
    ratio = float(numbers(after, "N")[2]) / float(numbers(before, "N")[2])
    assert ratio == pytest.approx(1.1, rel=0.01)
    changes = [float(numbers(lines, "N")[5].rstrip(" %")) for lines in (before, after)]
    assert changes[1] - changes[0] == pytest.approx(100 * (1 / 1.1 - 1) * 0.9365, abs=1.0)
    printed = [re.findall(r"For K its own numbers give ([\d.]+) %", "\n".join(lines)) for lines in (before, after)]
    assert printed[0] != printed[1]
