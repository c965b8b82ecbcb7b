"""Samples far off the median of those around them."""

import numpy as np
from numba import njit

HALF = 15
"""Neighbours on either side."""


@njit(cache=True, nogil=True)
def off(y, limit, part):  # type: ignore[no-untyped-def]
    """Indices of samples more than ``limit[i // part]`` off the median of the 31 around them; y has 31 or more.

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
