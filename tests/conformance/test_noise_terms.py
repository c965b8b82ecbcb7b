"""Every row of `TERMS` agrees with itself, and a row with a fault in any column does not."""

from dataclasses import fields, replace

import numpy as np
from tests import ALL
from tests.rows import rows

from allanite.terms import TERMS, NoiseTerm
from allanite.testing.terms import CHECKS, MODERATE, demand, sampled, simulated


def moderate(row):
    """The row at a rate where it is neither white nor a walk."""
    return next(iter(sampled(row, (MODERATE,)).values()))


ROWS = {name: one for row in TERMS.values() for name, one in sampled(row).items()}


@rows("name", ROWS)
def test_the_columns_of_a_row_agree(name):
    for check in CHECKS:
        demand(check, ROWS[name], name)


@rows("symbol", TERMS)
def test_a_simulation_has_the_moments_of_its_row(symbol):
    simulated(moderate(TERMS[symbol]))


# faults


def twice(x):
    """A factor, and something in place of nothing."""
    return np.nan_to_num(2.0 * x + (x == 0), nan=1.0)


def negative(x):
    """The wrong sign, and something in place of nothing."""
    return np.nan_to_num(-1.0 * x - (x == 0), nan=-1.0)


def with_fault(function, fault):
    """A function with a fault in its value, which it has also where it ought to refuse."""

    def column(*at):
        try:
            return fault(function(*at))
        except ValueError:
            return fault(np.zeros(1))

    return column


COMPOSED = {
    "block": lambda block: [
        lambda size, shape, h: block(2 * size, shape, h),
        lambda size, shape, h: block(size, shape, h / 2),
    ],
    "shaped": lambda shaped: [lambda shape, rate: shaped(shape, 2 * rate)],
    "shape": lambda shape: [tuple(2 * x for x in shape)],
    "parameters": lambda parameters: [tuple(replace(p, time=p.time + 1) for p in parameters)],
}
"""What may be wrong with a column that is neither a number nor a function with one as its value."""

FREE = ("typical", "automatic")  # an example and a choice, which nothing can contradict


def spoiled(row, column):
    """Values of a column with a fault each."""
    value = getattr(row, column)
    if column in COMPOSED:
        return COMPOSED[column](value) if value else []
    if isinstance(value, bool):
        return [not value]
    if callable(value):
        return [with_fault(value, fault) for fault in (twice, negative)]
    return [float(fault(value)) for fault in (twice, negative)] if isinstance(value, int | float) else []


NAMES = [f.name for f in fields(NoiseTerm) if f.name not in FREE]
PLANTED = [(symbol, name) for symbol, row in TERMS.items() for name in NAMES if spoiled(row, name)]


def agrees(row):
    """Whether the columns of a row agree."""
    try:
        with np.errstate(all="ignore"):
            for check in CHECKS:
                check(row)
    except (AssertionError, ValueError):
        return False
    return True


@rows("symbol, column", PLANTED if ALL else [row for row in PLANTED if row[0] == "GM"])
def test_a_fault_in_any_column_is_found(symbol, column):
    row = moderate(TERMS[symbol])
    assert agrees(row)
    passed = [i for i, wrong in enumerate(spoiled(row, column)) if agrees(replace(row, **{column: wrong}))]
    assert not passed
