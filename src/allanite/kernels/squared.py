"""Sums of squared differences, and of powers of segments, of the cells of one level of a stream; see `ladder`."""

import numpy as np

from .allan import squares
from .compiling import inner, part, swift_part
from .ladder import BAND, FIRST, HOP, OCTAVE, UPPER

MANY = 128
"""Segments that are transformed at a time."""

NEAR = 4096
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
        for near in range(first, last, NEAR):
            found = _four(points, q, order, near, min(near + NEAR, last))
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
