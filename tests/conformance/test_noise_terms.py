"""Every row of `TERMS` agrees with itself, and has the moments that it simulates."""

from tests.rows import rows

from allanite.terms import TERMS
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
