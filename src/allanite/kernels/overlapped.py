"""Squared differences at every point for many averaging factors, with fewer loads than differences have points.

Four differences that lie m apart in a row share their points: six loads for four second differences instead of twelve.
Where m is too short for rows, four averaging factors share the first point. The record is processed in tiles that the
second-level cache holds; averaging factors whose rows reach beyond a tile read it from further away.
"""

import numpy as np
from numpy.typing import NDArray

from .allan import squares
from .compiling import part, shared, swift_part

ROWS = 256
"""Averaging factors from which rows are long enough."""

BLOCK = 1024
"""Samples for which the first-level cache holds the points of several averaging factors; longest part of a row."""

TILE = 1 << 17
"""Samples that are processed for one averaging factor after the other."""

NEAR = TILE // 4
"""Averaging factors from which rows reach beyond a tile."""


@swift_part
def _four_rows(x, m, order, at, count):  # type: ignore[no-untyped-def]
    """Sum of the squared differences of order 2 or 3 at i, i + m, i + 2m and i + 3m for i = at .. at + count - 1."""
    a, b, c = x[at : at + count], x[at + m : at + m + count], x[at + 2 * m : at + 2 * m + count]
    d, e = x[at + 3 * m : at + 3 * m + count], x[at + 4 * m : at + 4 * m + count]
    f = x[at + 5 * m : at + 5 * m + count]
    one = two = 0.0
    if order == 2:
        for i in range(count):
            p, q = (a[i] - 2.0 * b[i]) + c[i], (b[i] - 2.0 * c[i]) + d[i]
            r, s = (c[i] - 2.0 * d[i]) + e[i], (d[i] - 2.0 * e[i]) + f[i]
            one += p * p + q * q
            two += r * r + s * s
        return one + two
    g = x[at + 6 * m : at + 6 * m + count]
    for i in range(count):
        p, q = (d[i] - a[i]) - 3.0 * (c[i] - b[i]), (e[i] - b[i]) - 3.0 * (d[i] - c[i])
        r, s = (f[i] - c[i]) - 3.0 * (e[i] - d[i]), (g[i] - d[i]) - 3.0 * (f[i] - e[i])
        one += p * p + q * q
        two += r * r + s * s
    return one + two


@part
def rows(x, m, order, start, stop):  # type: ignore[no-untyped-def]
    """Sum over i = start .. stop - 1 of the squared differences at m, a part of the columns of all rows at a time."""
    total = 0.0
    for column in range(start, min(start + m, stop), BLOCK):
        count, at = min(BLOCK, start + m - column), column
        while at + 3 * m + count <= stop:
            total += _four_rows(x, m, order, at, count)
            at += 4 * m
        while at < stop:
            total += squares(x, m, order, at, min(at + count, stop))
            at += m
    return total


@swift_part
def _four_factors(x, m, start, count):  # type: ignore[no-untyped-def]
    """Sums of the squared second differences at four m for i = start .. start + count - 1."""
    j, k, r, n = m
    x = x[start:]
    a, b, c, d, e = x[:count], x[j : j + count], x[2 * j : 2 * j + count], x[k : k + count], x[2 * k : 2 * k + count]
    f, g, h, o = x[r : r + count], x[2 * r : 2 * r + count], x[n : n + count], x[2 * n : 2 * n + count]
    one = two = three = four = 0.0
    for i in range(count):
        p, q = (a[i] - 2.0 * b[i]) + c[i], (a[i] - 2.0 * d[i]) + e[i]
        r, s = (a[i] - 2.0 * f[i]) + g[i], (a[i] - 2.0 * h[i]) + o[i]
        one += p * p
        two += q * q
        three += r * r
        four += s * s
    return one, two, three, four


@part
def _add_short(sums, x, m, order, span):  # type: ignore[no-untyped-def]
    """Add the squared differences at i = span[0] .. span[1] - 1 for short m, ascending."""
    (start, end), j = span, 0
    while j < m.size:
        if order == 2 and j + 4 <= m.size and end <= x.size - 2 * m[j + 3]:
            one, two, three, four = _four_factors(x, (m[j], m[j + 1], m[j + 2], m[j + 3]), start, end - start)
            sums[j] += one
            sums[j + 1] += two
            sums[j + 2] += three
            sums[j + 3] += four
            j += 4
        else:
            stop = min(end, x.size - order * m[j])
            if stop > start:
                sums[j] += squares(x, m[j], order, start, stop)
            j += 1


@shared
def add_overlapped(sums, x, m, order, size):  # type: ignore[no-untyped-def]
    """Add the squared differences of order 1 to 3 at every i < size for every m[j], ascending, as far as x reaches.

    Rows are taken four at a time; what is left of them when a tile ends goes with the next one.
    """
    done = np.zeros(m.size, np.int64)
    short = near = 0
    for j in range(m.size):
        short += m[j] < ROWS
        near += m[j] < NEAR
    short = m.size if order == 1 else min(m.size, (short + 3) // 4 * 4)
    for tile in range(0, size, TILE):
        end = min(tile + TILE, size)
        for start in range(tile, end, BLOCK):
            _add_short(sums[:short], x, m[:short], order, (start, min(start + BLOCK, end)))
        for j in range(short, near):
            four = 4 * m[j]
            stop = done[j] + max(min(end, x.size - order * m[j]) - done[j], 0) // four * four
            sums[j] += rows(x, m[j], order, done[j], stop)
            done[j] = stop
    for j in range(short, m.size):
        sums[j] += rows(x, m[j], order, done[j], min(size, x.size - order * m[j]))


def overlapped(x: NDArray[np.float64], m: NDArray[np.int64], order: int) -> NDArray[np.float64]:
    """Sum of the squared differences of order 1 to 3 at every i for every m[j], ascending, shape of m."""
    sums = np.zeros(m.size)
    add_overlapped(sums, x, m, order, x.size)
    return sums
