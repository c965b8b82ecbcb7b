"""What one look at a part of a record shows: its extremes, and runs of one value."""

import numpy as np

from .compiling import inner, kernel, swift_part

BLOCK = 2048
"""Samples that are looked at together, while the cache has them."""


@kernel
def looked(y):  # type: ignore[no-untyped-def]
    """Number of finite values, the extremes, how often the more frequent one occurs, the longest run of neighbours.

    A run is one of equal values, and its length that of their steps. Values are looked at one by one only in blocks
    with new extremes, equal neighbours, or missing values.
    """
    low, high = np.inf, -np.inf
    lows = highs = left = longest = run = 0
    before = np.nan
    for begin in range(0, y.size, BLOCK):
        part = y[begin : begin + BLOCK]
        finite = np.isfinite(_sum(part))
        left += part.size if finite else _finite(part)
        if not finite or _extreme(part, low, high) > 0:
            low, lows = _lowest(part, 1.0, low, lows)
            negative, highs = _lowest(part, -1.0, -high, highs)
            high = -negative
        if part[0] == before or _equal(part[1:], part[:-1]) > 0:
            run, longest = _runs(part, before, run, longest)
        else:
            run = 0
        before = part[-1]
    return left, low, high, max(lows, highs), longest


@swift_part
def _sum(y):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(y.size):
        total += y[i]
    return total


@inner
def _extreme(y, low, high):  # type: ignore[no-untyped-def]
    """How many values do not lie between the limits."""
    count = 0
    for i in range(y.size):
        count += (y[i] <= low) | (y[i] >= high)
    return count


@inner
def _equal(a, b):  # type: ignore[no-untyped-def]
    count = 0
    for i in range(b.size):
        count += a[i] == b[i]
    return count


@inner
def _finite(y):  # type: ignore[no-untyped-def]
    count = 0
    for i in range(y.size):
        count += np.isfinite(y[i])
    return count


@inner
def _lowest(y, sign, low, count):  # type: ignore[no-untyped-def]
    """The smallest finite value times the sign so far, and how often it occurred."""
    for i in range(y.size):
        value = sign * y[i]
        if value <= low and np.isfinite(value):
            count = count + 1 if value == low else 1
            low = value
    return low, count


@inner
def _runs(y, before, run, longest):  # type: ignore[no-untyped-def]
    """Length of the last run of neighbours equal to the one before, and of the longest."""
    for i in range(y.size):
        run = run + 1 if y[i] == before else 0
        longest = max(longest, run)
        before = y[i]
    return run, longest
