"""Frequencies that stand out of their surroundings: resonances, unsteady lines and clusters of them."""

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray

from .families import Found

SURROUNDINGS = 16
"""Quiet bins on either side of one that say what its power should be: an octave."""

STANDS_OUT, EXCESS = 5.0, 0.1
"""Standard deviations, and share of the power, by which a bin must exceed its surroundings."""

SLOPE, FOOT = 2.0, 0.03
"""The same for its neighbours, which are left out with it."""

MARGIN = 2
"""Least number of bins on either side that are left out as well: the foot of a hump is below the scatter."""

FEWEST = 4
"""Coefficients of a bin whose power is known well enough to stand out."""

ROUNDS = 4


def humps(found: Found) -> BoolArray:
    """Bins of a spectrum that stand out of their surroundings, whatever the model says of these, shape (bins,)."""
    seen, used = found.seen, found.used
    m = found.chosen.likelihood.expectation(found.chosen.theta)
    ratio = np.log(seen.power / np.interp(seen.first, seen.first[used], m))
    able = seen.count >= FEWEST
    out = np.zeros(used.size, dtype=bool)
    for _ in range(ROUNDS):
        above = ratio - _surrounding(ratio, able & ~out)
        now = _clusters(above, np.sqrt(2 / seen.count), able)
        if (now == out).all():
            break
        out = now
    return out


def _surrounding(ratio: FloatArray, quiet: BoolArray) -> FloatArray:
    """Median of the quiet bins around each."""
    at = np.flatnonzero(quiet)
    if not at.size:
        return ratio
    middle = np.searchsorted(at, np.arange(ratio.size))
    start = np.clip(middle - SURROUNDINGS, 0, max(at.size - 2 * SURROUNDINGS, 0))
    return np.array([np.median(ratio[at[a : a + 2 * SURROUNDINGS]]) for a in start])


def _clusters(above: FloatArray, error: FloatArray, able: BoolArray) -> BoolArray:
    """Bins that stand out with their slopes and a margin, shape (bins,)."""
    top = able & (above > STANDS_OUT * error) & (above > EXCESS)
    slope = able & (above > SLOPE * error) & (above > FOOT)
    out = np.zeros(above.size, dtype=bool)
    for peak in np.flatnonzero(top):
        left = right = int(peak)
        while left > 0 and slope[left - 1]:
            left -= 1
        while right < above.size - 1 and slope[right + 1]:
            right += 1
        margin = max(MARGIN, (right - left + 1) // 2)  # a skirt falls with the square of the distance
        out[max(left - margin, 0) : right + 1 + margin] = True
    return out
