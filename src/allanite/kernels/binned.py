"""What is done to samples before their transform, and to its coefficients after it, in one pass each."""

import numpy as np
from numpy.typing import NDArray

from .compiling import swift, swift_part

BLOCK = 1024
"""Coefficients that are summed before they are added to the rest of their bin: rounding grows with neither."""


SIZE = np.int64(0x7FFF_FFFF_FFFF_FFFF)
"""The bits of a number without its sign: as integers they are ordered as the sizes are, and compared side by side."""


@swift_part
def _block(c):  # type: ignore[no-untyped-def]
    """Sum of squares, sums of the first, third .. and of the second, fourth .. of some coefficients."""
    squares = first = second = 0.0
    for i in range(c.size // 2):
        a, b = c[2 * i], c[2 * i + 1]
        first += a
        second += b
        squares += a * a + b * b
    if c.size % 2:
        a = c[-1]
        first += a
        squares += a * a
    return squares, first, second


@swift_part
def _largest(bits):  # type: ignore[no-untyped-def]
    """Bits of the largest of some numbers, without its sign."""
    found = np.int64(0)
    for i in range(bits.size):
        found = max(found, bits[i] & SIZE)
    return found


@swift
def _binned(c, bits, edges):  # type: ignore[no-untyped-def]
    """See `binned`; `bits` are those of c as integers."""
    result = np.zeros((5, edges.size - 1))
    for j in range(edges.size - 1):
        at, most = edges[j], np.int64(0)
        for start in range(edges[j], edges[j + 1], BLOCK):
            stop = min(start + BLOCK, edges[j + 1])
            squares, first, second = _block(c[start:stop])
            result[0, j] += squares
            result[3 + start % 2, j] += first
            result[4 - start % 2, j] += second
            largest = _largest(bits[start:stop])
            if largest > most:
                most, at = largest, start
        while (bits[at] & SIZE) < most:
            at += 1
        result[0, j] /= edges[j + 1] - edges[j]
        result[1, j] = c[at] * c[at]
        result[2, j] = at
    return result


def binned(c: NDArray[np.float64], edges: NDArray[np.int64]) -> NDArray[np.float64]:
    """Mean and largest square of c[a:b] between neighbouring edges, its index, sums of even and of odd indices.

    Shapes (edges - 1,), the indices as floats; no bin is empty.
    """
    return np.asarray(_binned(c, c.view(np.int64), edges))


@swift
def less_constant(values, constant):  # type: ignore[no-untyped-def]
    """Values less a constant, float64, and their sum, which is finite if all of them are."""
    y = np.empty(values.size)
    total = 0.0
    for i in range(values.size):
        y[i] = values[i] - constant
        total += y[i]
    return y, total


@swift
def less_ramp(y, slope):  # type: ignore[no-untyped-def]
    """Take a ramp that is zero in the middle out of y, in its place."""
    middle = (y.size - 1) / 2
    for i in range(y.size):
        y[i] -= slope * (i - middle)
