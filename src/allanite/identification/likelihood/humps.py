"""Frequencies that exceed their surroundings: resonances, unsteady lines and clusters of them."""

import math

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray

from .bins import PER_OCTAVE
from .families import Found

SURROUNDINGS = 16
"""Quiet bins on either side of one that say what its power should be: an octave."""

STANDS_OUT, EXCESS = 5.0, 0.1
"""Standard deviations, and share of the power, by which a bin must exceed its surroundings."""

SLOPE, FOOT = 2.0, 0.03
"""The same for its neighbours, which are omitted with it."""

MARGIN = 2
"""Least number of bins on either side that are omitted as well: the foot of a hump is below the scatter."""

HARMLESS = 0.02
"""Power of a resonance's skirt over that of the noise from which on it is read."""

FEWEST = 4
"""Coefficients of a bin whose power is known well enough to stand out."""

ROUNDS = 4


def humps(found: Found) -> BoolArray:
    """Bins of a spectrum that stand out of their surroundings, whatever the model says of these, shape (bins,)."""
    seen, used = found.seen, found.used
    m = found.chosen.likelihood.expectation(found.chosen.theta)
    expected = np.interp(seen.first, seen.first[used], m)
    ratio = np.log(seen.power / expected)
    able = seen.count >= FEWEST
    out = np.zeros(used.size, dtype=bool)
    for _ in range(ROUNDS):
        around = _surrounding(ratio, able & ~out)
        now = _clusters(ratio - around, np.sqrt(2 / seen.count), able, np.log(expected) + around)
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


def _clusters(above: FloatArray, error: FloatArray, able: BoolArray, floor: FloatArray) -> BoolArray:
    """Bins that stand out of a floor, given by its logarithm, with their slopes and skirts, shape (bins,)."""
    top = able & (above > STANDS_OUT * error) & (above > EXCESS)
    slope = able & (above > SLOPE * error) & (above > FOOT)
    out = np.zeros(above.size, dtype=bool)
    for peak in np.flatnonzero(top):
        left = right = int(peak)
        while left > 0 and slope[left - 1]:
            left -= 1
        while right < above.size - 1 and slope[right + 1]:
            right += 1
        out[max(left - MARGIN, 0) : right + MARGIN + 1] = True
        out |= _skirt(above, floor, left, right)
    return out


def _skirt(above: FloatArray, floor: FloatArray, left: int, right: int) -> BoolArray:
    """Where a resonance of a hump's height and width is more than `HARMLESS`, shape (bins,).

    Its power is A / (1 + Q^2 (x - 1/x)^2) at x times its frequency, and 1 / Q its width.
    """
    excess = np.expm1(above[left : right + 1])
    highest = left + int(excess.argmax())
    width = np.count_nonzero(excess > excess.max() / 2) / PER_OCTAVE * math.log(2)
    octaves = (np.arange(above.size) - highest) / PER_OCTAVE
    height = math.log(excess.max()) + floor[highest] - np.log1p((2 * np.sinh(octaves * math.log(2)) / width) ** 2)
    return np.asarray(height > floor + math.log(HARMLESS))
