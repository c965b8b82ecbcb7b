"""Sums of squared differences, and powers of short cosine transforms, of samples that come in chunks.

A cell of level k is the sum of 2^k samples; a pair of cells makes one of the next level. At level k the differences
over m = 8 .. 15 times 2^k are taken at every cell (at level 0 over m = 1 .. 15), and segments of 16 cells,
one every 8, are transformed for the octave of their frequencies that no other level reads (at level 0 for the upper
two). What differences need of the past
are the last cells of each level; what another part needs that ends where this one begins are the first. Every angle
is summed from its own level's last cells: no sum grows with the length of the stream.

The second channel of a cell, for differences of the running sum of the angle, is the sum of the angle over its samples
from where the cell begins, by which the sum of the angle grows beside 2^k times the angle there.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .allan import squares

FAST = {"reassoc", "nsz", "contract"}

LEVELS = 32
"""Averaging factors reach to 15 * 2^31."""

HOP = 8
"""Cells from one segment to the next; a segment is twice as long."""

OCTAVE = 8
"""Averaging factors of a level: q = 8 .. 15."""

FIRST = 15
"""Averaging factors of level 0: 1 .. 15."""

UPPER, BAND = 6, 2
"""Coefficients of a segment, at level 0 and above."""

MANY = 128
"""Segments that are transformed at a time."""

NEAR = 4096
"""Cells whose differences are taken at a time, so that the cache has them for all averaging factors."""


class State(NamedTuple):
    """What is kept: sums, first and last cells, and what pairs are waiting for.

    Attributes
    ----------
    sums, counts : arrays, shape (15 + 8 * 31,)
        Of the squared differences, level by level.
    powers : array, shape (6 + 2 * 31,)
        Sums of the squared coefficients.
    segments : array, shape (levels,)
    head, tail : arrays, shape (levels, channels, cells)
        First cells of the first run, last cells of the last one, of `filled`, shape (levels, 2), of them.
    odd, even : arrays, shape (levels, channels)
        A first cell whose partner would be before it, and a last one whose partner is to come; `has`, shape (levels,
        2), says whether there are.
    at : array, shape (levels,)
        Place of the next cell.
    runs : array, shape (1,)
        1 while no sample is missing, then 2.
    """

    sums: NDArray[np.float64]
    counts: NDArray[np.int64]
    powers: NDArray[np.float64]
    segments: NDArray[np.int64]
    head: NDArray[np.float64]
    tail: NDArray[np.float64]
    filled: NDArray[np.int64]
    odd: NDArray[np.float64]
    even: NDArray[np.float64]
    has: NDArray[np.bool_]
    at: NDArray[np.int64]
    runs: NDArray[np.int64]


@njit(cache=True, nogil=True)
def push(state, values, constant, shape):  # type: ignore[no-untyped-def]
    """Add finite samples that follow the last one; `shape` is (order of the differences, rows of the transform).

    Returns whether the sum of the samples is finite; if not, nothing is added.
    """
    have = state.filled[0, 1]
    row = np.empty((state.head.shape[1], have + values.size))
    if not np.isfinite(_less(values, constant, row[0, have:])):
        return False
    if row.shape[0] == 2:
        row[1, have:] = row[0, have:]
    for k in range(LEVELS):
        have = state.filled[k, 1]
        row[:, :have] = state.tail[k, :, :have]
        cells, place = row[:, have:], state.at[k]
        _read(state, k, row, (have, row.shape[1], place - have), shape)
        first = state.filled[k, 0] == 0
        if state.runs[0] == 1:
            _extend(state, k, cells)
        _keep(state, k, row)
        state.at[k] = place + cells.shape[1]
        row = _paired(state, k, cells, (place, state.filled[min(k + 1, LEVELS - 1), 1]), first)
        if row.shape[1] == 0:
            return True
    return True


@njit(cache=True, nogil=True, fastmath=FAST)
def _less(values, constant, result):  # type: ignore[no-untyped-def]
    """Samples less a constant, and their sum."""
    total = 0.0
    for i in range(values.size):
        result[i] = values[i] - constant
        total += values[i]
    return total


@njit(cache=True, nogil=True)
def _joined(before, after):  # type: ignore[no-untyped-def]
    row = np.empty((before.shape[0], before.shape[1] + after.shape[1]))
    row[:, : before.shape[1]] = before
    row[:, before.shape[1] :] = after
    return row


@njit(cache=True, nogil=True)
def _extend(state, k, cells):  # type: ignore[no-untyped-def]
    """Add cells to the first ones of a level, as long as there is room."""
    have = state.filled[k, 0]
    more = min(state.head.shape[2] - have, cells.shape[1])
    if more > 0:
        state.head[k, :, have : have + more] = cells[:, :more]
        state.filled[k, 0] = have + more


@njit(cache=True, nogil=True)
def _keep(state, k, row):  # type: ignore[no-untyped-def]
    """Keep the last cells of a row."""
    size = min(state.tail.shape[2], row.shape[1])
    state.tail[k, :, :size] = row[:, row.shape[1] - size :]
    state.filled[k, 1] = size


@njit(cache=True, nogil=True)
def _paired(state, k, cells, where, first):  # type: ignore[no-untyped-def]
    """The cells of the next level, behind room for where[1] others; empty without any. What has no partner waits.

    where[0] is the place of the first cell; `first` says whether it is the first of its level.
    """
    n, channels, (place, room) = cells.shape[1], cells.shape[0], where
    waiting, skip = state.has[k, 1], place % 2
    made = 1 if skip and waiting else 0
    if k + 1 < LEVELS:
        state.at[k + 1] = (place + skip) // 2 - made
    if n == 0:
        return np.empty((channels, 0))
    size = (n - skip) // 2
    if k + 1 == LEVELS or made + size == 0:
        room = made = size = 0
    pairs = np.empty((channels, room + made + size))
    if made:
        pairs[0, room] = state.even[k, 0] + cells[0, 0]
        if channels == 2:
            pairs[1, room] = state.even[k, 1] + cells[1, 0] + 2.0**k * state.even[k, 0]
    elif skip and not waiting and first and state.runs[0] == 1:
        state.odd[k] = cells[:, 0]
        state.has[k, 0] = True
    _halved(cells[0, skip:], pairs[0, room + made :])
    if channels == 2:
        for i in range(size):
            a = skip + 2 * i
            pairs[1, room + made + i] = cells[1, a] + cells[1, a + 1] + 2.0**k * cells[0, a]
    state.has[k, 1] = (n - skip) % 2 == 1
    if state.has[k, 1]:
        state.even[k] = cells[:, n - 1]
    return pairs


@njit(cache=True, nogil=True)
def _halved(cells, pairs):  # type: ignore[no-untyped-def]
    for i in range(pairs.size):
        pairs[i] = cells[2 * i] + cells[2 * i + 1]


@njit(cache=True, nogil=True)
def _read(state, k, row, span, shape):  # type: ignore[no-untyped-def]
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


@njit(cache=True, nogil=True, fastmath=FAST)
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


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True, fastmath=FAST)
def _fold(cells, window, many, folded):  # type: ignore[no-untyped-def]
    """Segments (a, b, c, d) in quarters, times the window, as (-c' - d, a - b') and the sum of the segment."""
    a, b, c, d = window[0], window[1], window[2], window[3]
    e, f, g, h = window[4], window[5], window[6], window[7]
    for s in range(many):
        x = cells[s * HOP : (s + 2) * HOP]
        folded[0, s], folded[1, s] = -(e * x[11] + d * x[12]), -(f * x[10] + c * x[13])
        folded[2, s], folded[3, s] = -(g * x[9] + b * x[14]), -(h * x[8] + a * x[15])
        folded[4, s], folded[5, s] = a * x[0] - h * x[7], b * x[1] - g * x[6]
        folded[6, s], folded[7, s] = c * x[2] - f * x[5], d * x[3] - e * x[4]
        total = 0.0
        for i in range(2 * HOP):
            total += x[i]
        folded[8, s] = total


@njit(cache=True, nogil=True, fastmath=FAST)
def _squared(folded, weights):  # type: ignore[no-untyped-def]
    """Sum of the squares of weights' folded."""
    a, b, c, d, e = weights[0], weights[1], weights[2], weights[3], weights[4]
    f, g, h, i = weights[5], weights[6], weights[7], weights[8]
    r, s, t, u, v = folded[0], folded[1], folded[2], folded[3], folded[4]
    w, x, y, z = folded[5], folded[6], folded[7], folded[8]
    total = 0.0
    for n in range(r.size):
        one = ((a * r[n] + b * s[n]) + (c * t[n] + d * u[n])) + ((e * v[n] + f * w[n]) + (g * x[n] + h * y[n]))
        one += i * z[n]
        total += one * one
    return total


@njit(cache=True, nogil=True)
def broken(state, place):  # type: ignore[no-untyped-def]
    """Go on at sample `place`, with missing ones before it: nothing that came is still awaited."""
    state.runs[0] = 2
    state.filled[:, 1] = 0
    state.has[:, 1] = False
    state.at[0] = place


@njit(cache=True, nogil=True)
def join(state, other, shape):  # type: ignore[no-untyped-def]
    """Add the part of a stream that begins where this one ends, with its own sums."""
    joint = np.empty((state.head.shape[1], 0))
    for k in range(LEVELS):
        whole = other.runs[0] == 1
        have, begins = state.filled[k, 1], other.filled[k, 0] > 0
        head = other.head[k][:, : other.filled[k, 0]]
        after = _joined(joint, head)
        row = _joined(state.tail[k][:, :have], after)
        place = state.at[k]
        if row.shape[1]:
            _read(state, k, row, (have, have + joint.shape[1], place - have), shape)
        first = state.filled[k, 0] == 0
        if state.runs[0] == 1:
            _extend(state, k, after)
        # the last cells are those of the other part, unless it is too short to have all of them
        if whole and other.filled[k, 1] < state.tail.shape[2]:
            _keep(state, k, _joined(_joined(state.tail[k][:, :have], joint), other.tail[k][:, : other.filled[k, 1]]))
        else:
            _keep(state, k, other.tail[k][:, : other.filled[k, 1]])
        # what waits on both sides of the joint
        candidates = joint
        if begins and other.has[k, 0]:
            candidates = _joined(joint, np.ascontiguousarray(other.odd[k]).reshape(-1, 1))
        joint = _paired(state, k, candidates, (place, 0), first)
        state.at[k] = place + candidates.shape[1]
        if begins or not whole:
            state.even[k], state.has[k, 1], state.at[k] = other.even[k], other.has[k, 1], other.at[k]
    state.runs[0] = max(state.runs[0], other.runs[0])
    _add(state, other)


@njit(cache=True, nogil=True)
def apart(state, other):  # type: ignore[no-untyped-def]
    """Add a part of a stream that begins later than where this one ends, with missing samples between them."""
    state.tail[:] = other.tail
    state.filled[:, 1] = other.filled[:, 1]
    state.even[:] = other.even
    state.has[:, 1] = other.has[:, 1]
    state.at[:] = other.at
    state.runs[0] = 2
    _add(state, other)


@njit(cache=True, nogil=True)
def _add(state, other):  # type: ignore[no-untyped-def]
    state.sums[:] += other.sums
    state.counts[:] += other.counts
    state.powers[:] += other.powers
    state.segments[:] += other.segments


@njit(cache=True, nogil=True, fastmath=FAST)
def _sum_less(values, constant):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(values.size):
        total += values[i] - constant
    return total


@njit(cache=True, nogil=True)
def gathered(total, count, values, constant, place):  # type: ignore[no-untyped-def]
    """Add finite samples to cells, in place; `place` is (cell size, first sample) with cell 0 beginning at 0."""
    size, at = place
    i = 0
    while i < values.size:
        cell = (at + i) // size
        stop = min((cell + 1) * size - at, values.size)
        total[cell] += _sum_less(values[i:stop], constant)
        count[cell] += stop - i
        i = stop
