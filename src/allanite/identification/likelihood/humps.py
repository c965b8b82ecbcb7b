"""Frequencies that stand out of their surroundings: resonances, unsteady lines and clusters of them."""

import math

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray

from .families import Found
from .whittle import PER_OCTAVE

SURROUNDINGS = 16
"""Quiet bins on either side of one that say what its power should be: an octave."""

STANDS_OUT, EXCESS = 5.0, 0.1
"""Standard deviations, and share of the power, by which a bin must exceed its surroundings."""

SLOPE, FOOT = 2.0, 0.03
"""The same for its neighbours, which are left out with it."""

MARGIN = 2
"""Least number of bins on either side that are left out as well: the foot of a hump is below the scatter."""

HARMLESS = 0.02
"""Power of a resonance's skirt over that of the noise from which on it is read."""

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
    """Bins that stand out with their slopes and skirts, shape (bins,)."""
    top = able & (above > STANDS_OUT * error) & (above > EXCESS)
    slope = able & (above > SLOPE * error) & (above > FOOT)
    out = np.zeros(above.size, dtype=bool)
    for peak in np.flatnonzero(top):
        left = right = int(peak)
        while left > 0 and slope[left - 1]:
            left -= 1
        while right < above.size - 1 and slope[right + 1]:
            right += 1
        reach = _skirt(above[left : right + 1])
        highest = left + int(above[left : right + 1].argmax())
        out[max(min(left - MARGIN, highest - reach), 0) : max(right + MARGIN, highest + reach) + 1] = True
    return out


def _skirt(above: FloatArray) -> int:
    """Bins from the top of a hump to where a resonance of its height and width is `HARMLESS`.

    Its power over that of the noise is A / (1 + Q^2 (x - 1/x)^2) at x times its frequency, and 1 / Q its width.
    """
    excess = np.expm1(above)
    width = np.count_nonzero(excess > excess.max() / 2) / PER_OCTAVE * math.log(2)
    return math.ceil(PER_OCTAVE * math.log2(max(1.0, width * math.sqrt(float(excess.max()) / HARMLESS))))
