"""Integration, and squared second differences of the angle at every averaging factor."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# the sum may be reordered (SIMD); NaN and infinity keep their meaning
_FAST = {"reassoc", "nsz", "contract"}

BLOCK = 8192
"""Samples per block: what one averaging factor has loaded the next finds in the cache."""


@njit(cache=True, nogil=True)
def integrate(values, constant):  # type: ignore[no-untyped-def]
    """x[0] = 0, x[k+1] = x[k] + (values[k] - constant), shape (n + 1,), float64.

    Integers stay exact as long as the sum is below 2^53 steps.
    """
    x = np.empty(values.size + 1)
    x[0] = 0.0
    total = 0.0
    for k in range(values.size):
        total += values[k] - constant
        x[k + 1] = total
    return x


@njit(cache=True, nogil=True, fastmath=_FAST)
def overlapped(x, m):  # type: ignore[no-untyped-def]
    """Sum over i of (x[i+2m] - 2 x[i+m] + x[i])^2 for every m[j], shape of m; all in one pass over x."""
    sums = np.zeros(m.size)
    for start in range(0, x.size, BLOCK):
        for j in range(m.size):
            stop = min(start + BLOCK, x.size - 2 * m[j])
            if stop > start:
                first = x[start:stop]
                middle = x[start + m[j] : stop + m[j]]
                last = x[start + 2 * m[j] : stop + 2 * m[j]]
                part = 0.0
                for i in range(first.size):
                    difference = (last[i] - middle[i]) - (middle[i] - first[i])
                    part += difference * difference
                sums[j] += part
    return sums


@njit(cache=True, nogil=True)
def strided(x, m):  # type: ignore[no-untyped-def]
    """Sum over j of (x[(j+2)m] - 2 x[(j+1)m] + x[jm])^2 for every m, shape of m."""
    sums = np.zeros(m.size)
    for k in range(m.size):
        points = x[:: m[k]]
        for j in range(points.size - 2):
            difference = (points[j + 2] - points[j + 1]) - (points[j + 1] - points[j])
            sums[k] += difference * difference
    return sums
