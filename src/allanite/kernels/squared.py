"""Sums of squared differences: at every point for many averaging factors, and of the cells of a level of a stream.

Four differences that lie m apart in a row share their points: six loads for four second differences instead of twelve.
Where m is too short for rows, four averaging factors share the first point. The record is processed in tiles that the
second-level cache holds; averaging factors whose rows reach beyond a tile read it from further away.
"""

import numpy as np
from numpy.typing import NDArray

from .allan import squares
from .compiling import inner, once, part, swift_part, swift_shared
from .ladder import BAND, FIRST, HOP, OCTAVE, UPPER

ROWS = 256
"""Averaging factors from which rows are long enough."""

BLOCK = 1024
"""Samples for which the first-level cache holds the points of several averaging factors; longest part of a row."""

TILE = 1 << 17
"""Samples that are processed for one averaging factor after the other."""

NEAR_TILE = TILE // 4
"""Averaging factors from which rows reach beyond a tile."""


@once
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


@swift_part
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


@once
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


@once
def _add_short(sums, x, m, order, span):  # type: ignore[no-untyped-def]
    """Add the squared differences at i = span[0] .. span[1] - 1 for m below `ROWS`, ascending."""
    # Where a group ends short its last factor stands in for the rest, and the end of a record is taken singly whatever
    # the group: the sum of a factor has the same bits beside any others.
    start, end = span
    if order == 2 and end <= x.size - 2 * ROWS:
        last = m.size - 1
        for j in range(0, m.size, 4):
            k, r, n = min(j + 1, last), min(j + 2, last), min(j + 3, last)
            found = _four_factors(x, (m[j], m[k], m[r], m[n]), start, end - start)
            for i in range(min(4, m.size - j)):
                sums[j + i] += found[i]
        return
    for j in range(m.size):
        stop = min(end, x.size - order * m[j])
        if stop > start:
            sums[j] += squares(x, m[j], order, start, stop)


@swift_shared
def add_overlapped(sums, x, m, order, size):  # type: ignore[no-untyped-def]
    """Add the squared differences of order 1 to 3 at every i < size for every m[j], ascending, as far as x reaches.

    Rows are taken four at a time; what is left of them when a tile ends goes with the next one.
    """
    short = near = 0
    for j in range(m.size):
        short += m[j] < ROWS
        near += m[j] < NEAR_TILE
    short = m.size if order == 1 else short
    for tile in range(0, size, TILE):
        end = min(tile + TILE, size)
        for start in range(tile, end, BLOCK):
            _add_short(sums[:short], x, m[:short], order, (start, min(start + BLOCK, end)))
        for j in range(short, near if end < size else m.size):
            four, last = 4 * m[j], min(max(x.size - order * m[j], 0), size)
            begin = min(tile, last) // four * four if j < near else 0
            sums[j] += rows(x, m[j], order, begin, min(end, last) // four * four if end < size else last)


def overlapped(x: NDArray[np.float64], m: NDArray[np.int64], order: int) -> NDArray[np.float64]:
    """Sum of the squared differences of order 1 to 3 at every i for every m[j], ascending, shape of m."""
    sums = np.zeros(m.size)
    add_overlapped(sums, x, m, order, x.size)
    return sums


MANY = 128
"""Segments that are transformed at a time."""

STRETCH = 4096
"""Cells whose differences are taken at a time, so that the cache has them for all averaging factors."""


@part
def read(state, k, row, span, shape):  # type: ignore[no-untyped-def]
    """Differences and segments of a row of cells that begin before cell span[1] and end after the span[0]-th.

    span[2] is the place of the row's first cell.
    """
    order, transform = shape
    points = _points(row, k)
    base = 0 if k == 0 else FIRST + OCTAVE * (k - 1)
    least = 1 if k == 0 else OCTAVE
    after, before = span[0], span[1]
    for q in range(least - least % 4, 2 * OCTAVE, 4):
        first, last = max(after + 1 - order * q, 0), min(before, points.size - order * (q + 3))
        for j in range(max(q, least), q + 4):
            start, stop = max(after + 1 - order * j, 0), min(before, points.size - order * j)
            if stop > start:
                state.counts[base + j - least] += stop - start
                if last <= first:
                    state.sums[base + j - least] += squares(points, j, order, start, stop)
                else:
                    state.sums[base + j - least] += squares(points, j, order, start, first)
                    state.sums[base + j - least] += squares(points, j, order, last, stop)
        for near in range(first, last, STRETCH):
            found = _four(points, q, order, near, min(near + STRETCH, last))
            for j in range(max(q, least), q + 4):
                state.sums[base + j - least] += found[j - q]
    first = max(after + 1 - 2 * HOP, 0)
    first += -(span[2] + first) % HOP
    last = min(before, row.shape[1] - 2 * HOP + 1)
    if last > first:
        _transform(state, k, row[0, first:], (last - first + HOP - 1) // HOP, transform)


@swift_part
def _four(x, m, order, start, stop):  # type: ignore[no-untyped-def]
    """Sums of the squared differences for m, m + 1, m + 2, m + 3, at once: each point is loaded less often."""
    a, n = x[start:stop], stop - start
    p, q, r, s = 0.0, 0.0, 0.0, 0.0
    b0, b1, b2, b3 = x[start + m :], x[start + m + 1 :], x[start + m + 2 :], x[start + m + 3 :]
    c0, c1, c2, c3 = x[start + 2 * m :], x[start + 2 * m + 2 :], x[start + 2 * m + 4 :], x[start + 2 * m + 6 :]
    if order == 2:
        for i in range(n):
            e, f = (c0[i] - b0[i]) - (b0[i] - a[i]), (c1[i] - b1[i]) - (b1[i] - a[i])
            g, h = (c2[i] - b2[i]) - (b2[i] - a[i]), (c3[i] - b3[i]) - (b3[i] - a[i])
            p, q, r, s = p + e * e, q + f * f, r + g * g, s + h * h
        return p, q, r, s
    d0, d1, d2, d3 = x[start + 3 * m :], x[start + 3 * m + 3 :], x[start + 3 * m + 6 :], x[start + 3 * m + 9 :]
    for i in range(n):
        e, f = (d0[i] - a[i]) - 3.0 * (c0[i] - b0[i]), (d1[i] - a[i]) - 3.0 * (c1[i] - b1[i])
        g, h = (d2[i] - a[i]) - 3.0 * (c2[i] - b2[i]), (d3[i] - a[i]) - 3.0 * (c3[i] - b3[i])
        p, q, r, s = p + e * e, q + f * f, r + g * g, s + h * h
    return p, q, r, s


@inner
def _points(row, k):  # type: ignore[no-untyped-def]
    """The angle, or its running sum, between the cells of a row, less what differences take away."""
    n = row.shape[1]
    x = np.empty(n + 1)
    x[0] = mean = 0.0
    step = max(n // 64, 1)
    for i in range(0, n, step):
        mean += row[0, i]
    mean /= max((n + step - 1) // step, 1)
    if row.shape[0] == 1:
        _summed(row[0], mean, x)
        return x
    width = 2.0**k
    level = mean * (width + 1.0) / 2.0
    angle = total = 0.0
    for i in range(n):
        total += width * angle + (row[1, i] - level)
        angle += row[0, i] - mean
        x[i + 1] = total
    return x


@inner
def _summed(cells, mean, x):  # type: ignore[no-untyped-def]
    """Running sums of the cells less their mean: four at a time, so that one addition waits for another once."""
    total, whole = 0.0, cells.size - cells.size % 4
    for i in range(0, whole, 4):
        a = cells[i] - mean
        b = a + (cells[i + 1] - mean)
        c = b + (cells[i + 2] - mean)
        d = b + ((cells[i + 2] - mean) + (cells[i + 3] - mean))
        x[i + 1], x[i + 2], x[i + 3] = total + a, total + b, total + c
        total += d
        x[i + 4] = total
    for i in range(whole, cells.size):
        total += cells[i] - mean
        x[i + 1] = total


@part
def _transform(state, k, cells, segments, rows):  # type: ignore[no-untyped-def]
    """Squares of the coefficients of successive segments; `rows` are the window, and weights of what is folded."""
    base, size = (UPPER + BAND * (k - 1), BAND) if k else (0, UPPER)
    folded = np.zeros((HOP + 1, MANY))
    for start in range(0, segments, MANY):
        many = min(MANY, segments - start)
        if many < MANY:
            folded[:] = 0.0
        _fold(cells[start * HOP :], rows[0], many, folded)
        for j in range(size):
            state.powers[base + j] += _squared(folded, rows[j + 1])
    state.segments[k] += segments


@swift_part
def _fold(cells, window, many, folded):  # type: ignore[no-untyped-def]
    """Segments (a, b, c, d) in quarters, times the window, as (-c' - d, a - b') and the sum of the segment."""
    half, before = HOP // 2, 0.0
    for i in range(HOP):
        before += cells[i]
    for s in range(many):
        x, total = cells[s * HOP : (s + 2) * HOP], 0.0
        for i in range(half):
            c, d = x[3 * half - 1 - i], x[3 * half + i]
            folded[i, s] = -(window[half + i] * c + window[half - 1 - i] * d)
            folded[half + i, s] = window[i] * x[i] - window[HOP - 1 - i] * x[HOP - 1 - i]
            total += c + d
        folded[HOP, s] = before + total
        before = total


@swift_part
def _squared(folded, weights):  # type: ignore[no-untyped-def]
    """Sum of the squares of weights' folded."""
    total = 0.0
    for n in range(MANY):
        one = 0.0
        for i in range(HOP + 1):
            one += weights[i] * folded[i, n]
        total += one * one
    return total
