"""Squared differences of sums of the angle, from running sums that are local: of segments, less the line through them.

A running sum of the whole record would lose (record / window)^1.5 to ^2.5 digits to the rounding of its large values.
"""

import numpy as np

from .compiling import inner, kernel, swift_part
from .squared import add_overlapped

REACH = 36
"""Averaging factors that share a segment differ by less than this factor: four running sums for 5 million samples."""

SHORT, LONG = 512, 128
"""Length of a segment: at least, and over its smallest averaging factor; twelve digits are left of a random walk."""


@inner
def running_sum(x, S):  # type: ignore[no-untyped-def]
    """S[0] = 0, S[k+1] = S[k] + x[k] less the line through the first and the last point, k < x.size.

    Four quarters run side by side: each waits for its own last addition only.
    """
    slope = (x[-1] - x[0]) / max(x.size - 1, 1)
    q = x.size // 4
    a, b, c, d = x[:q], x[q : 2 * q], x[2 * q : 3 * q], x[3 * q : 4 * q]
    A, B, C, D = S[1 : q + 1], S[q + 1 : 2 * q + 1], S[2 * q + 1 : 3 * q + 1], S[3 * q + 1 : 4 * q + 1]
    a0 = x[0]
    b0, c0, d0 = a0 + slope * q, a0 + slope * (2 * q), a0 + slope * (3 * q)
    sa = sb = sc = sd = 0.0
    S[0] = 0.0
    for i in range(q):
        line = slope * i
        sa += (a[i] - a0) - line
        sb += (b[i] - b0) - line
        sc += (c[i] - c0) - line
        sd += (d[i] - d0) - line
        A[i], B[i], C[i], D[i] = sa, sb, sc, sd
    sb += sa
    sc += sb
    for i in range(q):
        B[i] += sa
        C[i] += sb
        D[i] += sc
    total = sc + sd
    for i in range(4 * q, x.size):
        total += (x[i] - a0) - slope * i
        S[i + 1] = total


@inner
def group_end(m, first):  # type: ignore[no-untyped-def]
    """Index after the last averaging factor that shares segments with m[first]."""
    stop = first
    while stop < m.size and m[stop] < REACH * m[first]:
        stop += 1
    return stop


@kernel
def modified(x, m):  # type: ignore[no-untyped-def]
    """Sum over i of (sum over k < m of x[i+2m+k] - 2 x[i+m+k] + x[i+k])^2 for every m, ascending, shape of m."""
    sums, space = np.zeros(m.size), np.empty(x.size + 1)
    first = 0
    while first < m.size:
        after = group_end(m, first)
        most = 3 * m[after - 1]
        length = max(SHORT, LONG * m[first])
        S = space[: min(length + most, x.size) + 1]
        for start in range(0, x.size + 1 - 3 * m[first], length):
            part = x[start : min(start + length + most - 1, x.size)]
            running_sum(part, S)
            add_overlapped(sums[first:after], S[: part.size + 1], m[first:after], 3, min(length, part.size + 1))
        first = after
    return sums


@swift_part
def _parabolic_squares(S, U, m, count):  # type: ignore[no-untyped-def]
    half = (m - 1) / 2
    s0, s2 = S[:count], S[2 * m : 2 * m + count]
    u0, u1, v1, u2 = U[1 : 1 + count], U[m : m + count], U[m + 1 : m + 1 + count], U[2 * m : 2 * m + count]
    total = 0.0
    for i in range(count):
        value = half * (s2[i] - s0[i]) + ((u1[i] - u0[i]) - (u2[i] - v1[i]))
        total += value * value
    return total


@kernel
def parabolic(x, m):  # type: ignore[no-untyped-def]
    """Sum over i < x.size - 2m of (sum over k < m of ((m-1)/2 - k) (x[i+k] - x[i+m+k]))^2 for every m > 1."""
    sums = np.zeros(m.size)
    for j in range(m.size):
        k = m[j]
        length = max(256, 16 * k)
        S, U = np.empty(length + 2 * k + 1), np.empty(length + 2 * k + 2)
        for start in range(0, x.size - 2 * k, length):
            z = x[start : min(start + length + 2 * k, x.size)]
            running_sum(z, S)
            total = 0.0
            for i in range(z.size + 1):
                U[i] = total
                total += S[i]
            sums[j] += _parabolic_squares(S, U, k, min(length, x.size - 2 * k - start))
    return sums
