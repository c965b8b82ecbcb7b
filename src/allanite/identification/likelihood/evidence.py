"""What a term must gain to be claimed, and the evidence for angle noise in the levels of the spectrum itself."""

from collections.abc import Sequence

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.terms import TERMS

from .band import Portion
from .selection import PENALTY

FEWEST = 4
"""Coefficients of a bin that takes part."""

LEAST = 1e-9
"""Level over the highest, at least: of less there is no logarithm."""

MEDIAN = 1.25
"""Standard error of a median over that of the mean."""

SURE = 2.0
"""Standard errors by which a fall or a rise must exceed zero."""

RISE = 1.5
"""Ratio of the level of the top octave to one below it, from which angle noise may stand beside resonances."""

REACH = 4
"""Octaves below the top in which that lower level lies."""

BEHIND, NEVER = 4.0, 1e9
"""Penalties of angle noise: behind a filter, as it is looked for behind each of them and gains more than 4 behind the
best in 17 % of records that have none; and where the spectrum does not rise."""

EVIDENCE = 12.0
"""What a Gauss-Markov term must gain in 2 L: for its size, for a time constant that was searched for, and for replacing
flicker, which is the usual noise: it displaces true flicker in about 1 % of records.
"""

ANYWHERE = 8.0
"""What a term must gain besides for each further parameter: 2 ln 50, as of some fifty resonances that noise may mimic.
"""

Octaves = tuple[FloatArray, FloatArray]


def octaves(part: Portion, *, per: int = 1) -> Octaves:
    """Logarithms of the median level in octaves of what is read, or parts of these, and their standard errors.

    The highest comes last.
    """
    seen, used = part.seen, part.used & (part.seen.count >= FEWEST)
    if not used.any():
        return np.zeros(1), np.full(1, np.inf)
    first, count = seen.first[used], seen.count[used]
    level = (seen.power - part.added)[used]
    octave = np.floor(per * np.log2(first[-1] / first)).astype(int)
    there = [one for j in range(octave.max(), -1, -1) if (one := octave == j).any()]
    middle = np.array([np.median(level[one]) for one in there])
    error = MEDIAN * np.sqrt([2 / count[one].sum() for one in there])
    return np.log(np.maximum(middle, max(LEAST * middle.max(), np.finfo(float).tiny))), error


def rises_to_top(part: Portion) -> bool:
    """Whether the top octave is above one of the octaves below it, beyond chance, and does not fall to its end.

    Beside resonances, whose powers are not known as well, it must be above by a factor of `RISE`.
    """
    level, error = octaves(part)
    (*_, lower, upper), (*_, before, last) = octaves(part, per=2) if level.size > 1 else (level[[0, 0]], error[[0, 0]])
    if upper < lower - SURE * np.hypot(before, last):
        return False  # a hump below the top
    below = slice(max(level.size - 1 - REACH, 0), level.size - 1)
    rise = level[-1] - level[below]
    least = SURE * np.hypot(error[-1], error[below])
    if part.excess is not None:
        least = np.maximum(least, np.log(RISE))
    return bool((rise > least).any())


def shows_angle(part: Portion) -> bool:
    """Whether angle noise may be claimed: it was asked for, or the spectrum rises, or a filter hides that it does."""
    return part.vouched or part.filter is not None or rises_to_top(part)


def angle_price(part: Portion) -> float:
    """What angle noise must gain in 2 L beyond another term."""
    return (BEHIND if part.filter is not None else 0.0) if shows_angle(part) else NEVER


def penalties(part: Portion) -> FloatArray:
    """What each term must gain in 2 L to be selected, a term with a shape the last of them, shape (p,)."""
    rows = [TERMS[symbol] for symbol in part.noise]
    shaped = [EVIDENCE + ANYWHERE * (len(row.parameters) - 1) if row.parameters else PENALTY for row in rows]
    return np.array(shaped) + angle_price(part) * np.array([row.edge > 0 for row in rows])


def flicker_in(symbols: Sequence[str]) -> int | None:
    """The place of the term that a Gauss-Markov term may stand in for; None if it is not there."""
    return next((i for i, symbol in enumerate(symbols) if TERMS[symbol].substitute), None)
