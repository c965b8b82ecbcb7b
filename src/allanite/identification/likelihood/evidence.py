"""Evidence for a filter and for angle noise in the levels of the spectrum itself, which no model bends.

Two components that cancel, a filter and angle noise behind it, explain any spectrum. Neither is believed unless the
median power of the octaves shows it: the fall beyond a filter's corner, the rise of angle noise.
"""

from collections.abc import Sequence

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.terms import TERMS

from .band import Portion, Tuned
from .selection import PENALTY

FEWEST = 4
"""Coefficients of a bin that takes part."""

LEAST = 1e-9
"""Level over the highest, at least: of less there is no logarithm."""

MEDIAN = 1.25
"""Standard error of a median over that of the mean."""

SURE = 2.0
"""Standard errors by which a fall or a rise must exceed zero."""

CORNER, SEEN = 0.8, 0.5
"""Gain below which an octave lies beyond a corner; share of the filter's fall, in the logarithm, that must be seen."""

RISE = 1.5
"""Ratio of the highest level of the upper octaves to one below it, from which angle noise may stand before a filter."""

REACH = 4
"""Octaves below the highest level in which that lower level lies."""

NEVER = 1e9
"""Penalty of angle noise where the spectrum does not rise."""

EVIDENCE = 12.0
"""What a Gauss-Markov term must gain in 2 L: for its size, for a time constant that was searched for, and for replacing
flicker, which is the usual noise: it displaces true flicker in about 1 % of records.
"""

ANYWHERE = 8.0
"""What a term must gain besides for each further parameter: 2 ln 50, as of some fifty resonances that noise may mimic.
"""

Octaves = tuple[FloatArray, FloatArray]


def octaves(part: Portion, values: FloatArray | None = None, *, per: int = 1) -> Octaves:
    """Logarithms of the median level in octaves of what is read, or parts of these, and their standard errors.

    The highest comes last.
    """
    seen, used = part.seen, part.used & (part.seen.count >= FEWEST)
    if not used.any():
        return np.zeros(1), np.full(1, np.inf)
    first, count = seen.first[used], seen.count[used]
    level = (seen.power - part.added if values is None else values)[used]
    octave = np.floor(per * np.log2(first[-1] / first)).astype(int)
    there = [one for j in range(octave.max(), -1, -1) if (one := octave == j).any()]
    middle = np.array([np.median(level[one]) for one in there])
    error = MEDIAN * np.sqrt([2 / count[one].sum() for one in there])
    return np.log(np.maximum(middle, max(LEAST * middle.max(), np.finfo(float).tiny))), error


def falls(part: Portion) -> float:
    """Share of the power that is missing at the top, in the last quarter of an octave.

    Less than the highest level of the upper octaves; beside a hump that is omitted, whose skirts rise above the noise,
    less than the lowest.
    """
    level, _ = octaves(part)
    upper, top = level[level.size // 2 :], octaves(part, per=4)[0][-1]
    return 1 - float(np.exp(top - (upper.max() if part.used.all() else upper[:-2].min(initial=upper[0]))))


def shows_corner(part: Portion, filter: Tuned) -> bool:  # noqa: A002
    """Whether the power falls beyond the corner of a filter, up to the top of what is read, as the filter says."""
    (level, error), (gain, _) = octaves(part), octaves(part, filter.gain(part.seen))
    beyond = np.flatnonzero(gain < np.log(CORNER))
    if gain.size < 2 or not beyond.size:
        return False
    start = min(int(beyond[0]), gain.size - 2)
    fall, doubt = float(level[-1] - level[start]), SURE * float(np.hypot(error[-1], error[start]))
    return fall + doubt < 0 and fall - doubt < SEEN * float(gain[-1] - gain[start])


def rises_before(part: Portion) -> bool:
    """Whether the power rises, by a factor of `RISE` at least, to the highest level of the upper octaves."""
    level, _ = octaves(part)
    half = level.size // 2
    top = half + int(level[half:].argmax())
    return bool(level[top] > np.log(RISE) + level[max(top - REACH, 0) : top].min(initial=np.inf))


def rises_to_top(part: Portion) -> bool:
    """Whether the top octave is above one of the octaves below it, beyond chance, and does not fall to its end.

    Beside resonances, whose powers are not known as well, it must be above by a factor of `RISE`; behind a filter the
    rise ends below the top.
    """
    if part.filter is not None:
        return rises_before(part)
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
    """Whether angle noise may be claimed: it was asked for, or the spectrum rises."""
    return part.vouched or rises_to_top(part)


def penalties(part: Portion) -> FloatArray:
    """What each term must gain in 2 L to be selected, a term with a shape the last of them, shape (p,)."""
    rows = [TERMS[symbol] for symbol in part.noise]
    shaped = [EVIDENCE + ANYWHERE * (len(row.parameters) - 1) if row.parameters else PENALTY for row in rows]
    return np.array(shaped) + NEVER * np.array([row.edge > 0 for row in rows]) * (not shows_angle(part))


def flicker_in(symbols: Sequence[str]) -> int | None:
    """The place of the term that a Gauss-Markov term may stand in for; None if it is not there."""
    return next((i for i, symbol in enumerate(symbols) if TERMS[symbol].substitute), None)
