"""Samples far off the median of those around them."""

import numpy as np

from .compiling import kernel, part

HALF = 15
"""Neighbours on either side."""

BLOCK = 1024
"""Samples whose bends are taken at a time."""

EARLY = 24
"""Neighbours that are counted first: those that follow rarely matter."""


@kernel
def off(y, limit, part):  # type: ignore[no-untyped-def]
    """Indices of samples more than ``limit[i // part]`` off the median of the 31 around them; y has 31 or more.

    Only where y bends by as much. More than half of 31 values lie below a bound exactly if their median does: nothing
    is sorted.
    """
    n = y.size
    found = np.empty(n, np.int64)
    bends = np.empty(BLOCK)
    count = 0
    for begin in range(0, n, part):
        most, end = limit[begin // part], min(begin + part, n)
        for first in range(begin, end, BLOCK):
            size = min(BLOCK, end - first)
            _bends(y, first, bends[:size])
            for i in range(size):
                if bends[i] > most:
                    found[count] = first + i
                    count += _beyond(y, first + i, most)
    return found[:count].copy()


@part
def _bends(y, first, bends):  # type: ignore[no-untyped-def]
    """How far samples from the first on are off both neighbours together; at an end the one counts twice."""
    n, size = y.size, bends.size
    a, b = max(first, 1), min(first + size, n - 1)
    before, middle, after = y[a - 1 : b - 1], y[a:b], y[a + 1 : b + 1]
    inner = bends[a - first :]
    for i in range(middle.size):
        inner[i] = abs((middle[i] - before[i]) + (middle[i] - after[i]))
    if first == 0:
        bends[0] = abs((y[0] - y[1]) + (y[0] - y[1]))
    if first + size == n:
        bends[size - 1] = abs((y[n - 1] - y[n - 2]) + (y[n - 1] - y[n - 2]))


@part
def _beyond(y, i, most):  # type: ignore[no-untyped-def]
    """Whether a sample is more than that off the median of the 31 around it."""
    width = 2 * HALF + 1
    start = min(max(i - HALF, 0), y.size - width)
    near = y[start : start + width]
    low, high = y[i] - most, y[i] + most
    below = 0
    above = 0
    for j in range(EARLY):
        below += near[j] < low
        above += near[j] > high
    if max(below, above) + width - EARLY <= HALF:
        return False
    for j in range(EARLY, width):
        below += near[j] < low
        above += near[j] > high
    return below > HALF or above > HALF
