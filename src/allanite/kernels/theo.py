"""Theo1 by its definition."""

import numpy as np
from numba import njit

from .allan import FAST

_BLOCK = 2048


@njit(cache=True, nogil=True, fastmath=FAST)
def _pair_squares(ends, near, far):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(ends.size):
        difference = ends[i] - (near[i] + far[i])
        total += difference * difference
    return total


@njit(cache=True, nogil=True)
def theo1(x, m):  # type: ignore[no-untyped-def]
    """Sum over i < x.size - m and v = 1 .. m/2 of (x[i] - x[i+v] + x[i+m] - x[i+m-v])^2 / v for every even m."""
    sums = np.zeros(m.size)
    for j in range(m.size):
        sums[j] = _one(x, m[j])
    return sums


@njit(cache=True, nogil=True)
def _one(x, m):  # type: ignore[no-untyped-def]
    z, ends = np.empty(_BLOCK + m), np.empty(_BLOCK)
    total = 0.0
    for start in range(0, x.size - m, _BLOCK):
        count = min(_BLOCK, x.size - m - start)
        piece = x[start : start + count + m]
        slope = (piece[-1] - piece[0]) / (piece.size - 1)
        for i in range(piece.size):
            z[i] = (piece[i] - piece[0]) - slope * i
        for i in range(count):
            ends[i] = z[i] + z[m + i]
        for v in range(1, m // 2 + 1):
            total += _pair_squares(ends[:count], z[v : v + count], z[m - v : m - v + count]) / v
    return total


@njit(cache=True, nogil=True, fastmath=FAST)
def triangles(e, leaf, out):  # type: ignore[no-untyped-def]
    """out[v] += sum of e[p] e[p + 2 (out.size - 1 - v)] over p < v in the block of `leaf` places that holds v."""
    for start in range(0, out.size, leaf):
        for v in range(start + 1, start + leaf):
            lag = 2 * (out.size - 1 - v)
            a, b = e[start:v], e[start + lag : v + lag]
            total = 0.0
            for p in range(a.size):
                total += a[p] * b[p]
            out[v] += total
