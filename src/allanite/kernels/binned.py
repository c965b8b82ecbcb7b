"""What is done to samples before their transform, and to its coefficients after it, in one pass each."""

import numpy as np
from numba import njit

FAST = {"reassoc", "nsz", "contract", "nnan"}

swift = njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)

BLOCK = 1024
"""Coefficients that are summed before they are added to the rest of their bin: rounding grows with neither."""


@swift
def _block(c):  # type: ignore[no-untyped-def]
    """Sum of squares, largest square, sums of the first, third .. and of the second, fourth .. of some coefficients."""
    squares = peak = first = second = 0.0
    for i in range(c.size // 2):
        a, b = c[2 * i], c[2 * i + 1]
        first += a
        second += b
        squares += a * a + b * b
        peak = max(peak, a * a, b * b)
    if c.size % 2:
        a = c[-1]
        first += a
        squares += a * a
        peak = max(peak, a * a)
    return squares, peak, first, second


@swift
def binned(c, edges):  # type: ignore[no-untyped-def]
    """Mean and largest square of c[a:b] between neighbouring edges, its index, sums of even and of odd indices.

    Shapes (edges - 1,), the indices as floats; no bin is empty.
    """
    result = np.zeros((5, edges.size - 1))
    for j in range(edges.size - 1):
        at = edges[j]
        for start in range(edges[j], edges[j + 1], BLOCK):
            squares, peak, first, second = _block(c[start : min(start + BLOCK, edges[j + 1])])
            result[0, j] += squares
            result[3 + start % 2, j] += first
            result[4 - start % 2, j] += second
            if peak > result[1, j]:
                result[1, j], at = peak, start
        while c[at] * c[at] < result[1, j]:
            at += 1
        result[0, j] /= edges[j + 1] - edges[j]
        result[2, j] = at
    return result


@swift
def less_ramp(y, slope):  # type: ignore[no-untyped-def]
    """Take a ramp that is zero in the middle out of y, in its place."""
    middle = (y.size - 1) / 2
    for i in range(y.size):
        y[i] -= slope * (i - middle)
