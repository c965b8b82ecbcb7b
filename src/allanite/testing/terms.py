"""A noise term against itself: its structure function, increments, spectrum, transform, states and simulation."""

from collections.abc import Callable, Sequence

import numpy as np

from allanite.core.aliases import public
from allanite.terms.row import NoiseTerm

from .term_columns import COLUMNS
from .term_forms import FORMS, simulated

CHECKS: tuple[Callable[[NoiseTerm], None], ...] = (*COLUMNS, *FORMS)
"""What is demanded of a row at each of its shapes."""

RATES = (0.013, 0.047, 0.31, 2.1, 5.0)
"""Sampling rates, at which the times of a term are fractions of a sample to many samples."""

MODERATE = 0.31
"""One at which a term is neither white nor a walk."""


@public
def check_term(row: NoiseTerm) -> None:
    """Check that the columns of a row agree with its structure function D, at many rates, and its simulation, too.

    Raises
    ------
    AssertionError
        A column contradicts the others; the message says which, and where: ``noise term X: this does not hold: Each
        order by differences of the one below.``

    Examples
    --------
    >>> from allanite import TERMS
    >>> check_term(TERMS["K"])
    """
    for name, one in sampled(row).items():
        for check in CHECKS:
            demand(check, one, name)
    demand(simulated, next(iter(sampled(row, (MODERATE,)).values())), row.symbol)


def sampled(row: NoiseTerm, rates: Sequence[float] = RATES) -> dict[str, NoiseTerm]:
    """A row, or those of its shapes, by name."""
    if row.shaped is None:
        return {row.symbol: row}
    typical = tuple(p.typical for p in row.parameters)
    # what is no time changes the form of the functions
    others = (
        (*typical[:i], value, *typical[i + 1 :])
        for i, p in enumerate(row.parameters)
        if not p.time
        for value in (0.6, 1.5)
    )
    return {f"{row.symbol} {shape} {rate:g}": row.shaped(shape, rate) for shape in (typical, *others) for rate in rates}


def demand(check: Callable[[NoiseTerm], None], row: NoiseTerm, name: str) -> None:
    """Raise what a check finds, and say which it is."""
    try:
        with np.errstate(all="ignore"):
            check(row)
    except Exception as error:
        what = " ".join((check.__doc__ or "").split())
        raise AssertionError(
            f"noise term {name}: this does not hold: {what} {type(error).__name__}: {error}"
        ) from error
