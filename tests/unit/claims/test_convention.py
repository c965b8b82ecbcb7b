"""Factors and what explains them."""

import math

import pytest
from tests.rows import rows

from allanite.claims.convention import CONVENTIONS, NAN, Place, explaining, pooled


def place(row, **more):
    symbol = row.symbols[0] if row.symbols else "N"
    return Place(symbol, **{"claimed": 2.3e-4, "rate": 128.0, "time": 300.0, "other": 4.1e-3, "uniform": True} | more)


@rows("inverse", [False, True])
@rows("row", CONVENTIONS, ids=lambda row: f"{row.name} {row.symbols[:1]}")
def test_a_convention_is_named_where_its_factor_lies_in_narrow_limits_and_nowhere_else(row, inverse):
    where = place(row)
    factor = row.factor(where)
    if inverse:
        factor = 1 / factor if row.inverse else 1.37 * factor
    low, high = sorted((0.995 * factor, 1.005 * factor))
    found = [one for _, one in explaining(low, high, where)]
    assert (row in found) == (not inverse or row.inverse)
    assert len(found) <= 1 or row.name in ("57.3", "60")
    assert not explaining(0.99, 1.01, where)


@rows("row", CONVENTIONS, ids=lambda row: f"{row.name} {row.symbols[:1]}")
def test_what_is_not_known_explains_nothing(row):
    unknown = place(row, claimed=NAN, rate=NAN, time=NAN, other=NAN, uniform=False)
    factor = row.factor(unknown)
    wide = [one for _, one in explaining(1e-12, 1e12, unknown)]
    assert math.isnan(factor) == (row not in wide) or factor < 0


def test_several_are_ordered_by_their_distance():
    assert [name for name, _ in explaining(9, 11, Place("N", 1e-4, 100.0))] == ["sqrt(rate)", "9.81"]
    assert [name for name, _ in explaining(50, 66, Place("N", 1e-4, 9.0))] == ["57.3", "60"]


@rows("limits, low, high", [
    ([(1.2, 1.6)], 1.2, 1.6), ([(1, 4)] * 4, 2 / math.sqrt(2), 2 * math.sqrt(2)), ([(0, 2), (1, 3)], 1, 2),
    ([(1, math.inf), (2, 3)], 2, 3), ([(1, 2), (3, 4)], 3, 2),
])  # fmt: skip
def test_limits_of_axes_are_pooled_by_their_widths(limits, low, high):
    assert pooled(limits) == pytest.approx((low, high))
