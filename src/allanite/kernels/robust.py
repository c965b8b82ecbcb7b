"""Readings far off the median of those around them."""

import numpy as np
from numba import njit

HALF = 15
"""Neighbours on either side."""


@njit(cache=True, nogil=True)
def residuals(y, at):  # type: ignore[no-untyped-def]
    """How far y is off the median of the 31 readings around the indices `at`; near an end, of the first or last 31."""
    width = min(2 * HALF + 1, y.size)
    out = np.empty(at.size)
    window = np.empty(width)
    for j in range(at.size):
        start = min(max(at[j] - HALF, 0), y.size - width)
        for i in range(width):
            value = y[start + i]
            place = i
            while place > 0 and window[place - 1] > value:
                window[place] = window[place - 1]
                place -= 1
            window[place] = value
        out[j] = y[at[j]] - 0.5 * (window[(width - 1) // 2] + window[width // 2])
    return out


@njit(cache=True, nogil=True)
def off(y, limit, part):  # type: ignore[no-untyped-def]
    """Indices of readings more than ``limit[i // part]`` off the median of the 31 around them; y has 31 or more.

    Only where y bends by as much. More than half of 31 values lie below a bound exactly if their median does: nothing
    is sorted.
    """
    n = y.size
    width = 2 * HALF + 1
    found = np.empty(n, np.int64)
    count = 0
    for begin in range(0, n, part):
        most = limit[begin // part]
        for i in range(begin, min(begin + part, n)):
            before = y[i - 1] if i > 0 else y[1]
            after = y[i + 1] if i < n - 1 else y[n - 2]
            if abs((y[i] - before) + (y[i] - after)) > most:
                start = min(max(i - HALF, 0), n - width)
                below = 0
                above = 0
                for j in range(start, start + width):
                    below += y[j] < y[i] - most
                    above += y[j] > y[i] + most
                found[count] = i
                count += below > HALF or above > HALF
    return found[:count].copy()
