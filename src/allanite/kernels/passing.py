"""What one look at a part of a record shows: its extremes, and runs of one value."""

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def looked(y):  # type: ignore[no-untyped-def]
    """Smallest and largest value, how often the more frequent of them occurs, and the longest run of equal neighbours.

    Values that are not finite are passed over.
    """
    low, high = np.inf, -np.inf
    lows = highs = 0
    longest = run = 0
    before = y[0]
    for i in range(y.size):
        value = y[i]
        if value <= low:
            lows = lows + 1 if value == low else 1
            low = value
        if value >= high:
            highs = highs + 1 if value == high else 1
            high = value
        run = run + 1 if i > 0 and value == before else 0
        longest = max(longest, run)
        before = value
    return low, high, max(lows, highs), longest
