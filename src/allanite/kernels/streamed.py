"""Samples that come in chunks, and parts of a stream that are joined; see `ladder` for what is kept of them."""

import numpy as np

from .compiling import inner, kernel, swift_part
from .ladder import LEVELS
from .squared import read


@kernel
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
        read(state, k, row, (have, row.shape[1], place - have), shape)
        first = state.filled[k, 0] == 0
        if state.runs[0] == 1:
            _extend(state, k, cells)
        _keep(state, k, row)
        state.at[k] = place + cells.shape[1]
        row = _paired(state, k, cells, (place, state.filled[min(k + 1, LEVELS - 1), 1]), first)
        if row.shape[1] == 0:
            return True
    return True


@swift_part
def _less(values, constant, result):  # type: ignore[no-untyped-def]
    """Samples less a constant, and their sum."""
    total = 0.0
    for i in range(values.size):
        result[i] = values[i] - constant
        total += values[i]
    return total


@inner
def _joined(before, after):  # type: ignore[no-untyped-def]
    row = np.empty((before.shape[0], before.shape[1] + after.shape[1]))
    row[:, : before.shape[1]] = before
    row[:, before.shape[1] :] = after
    return row


@inner
def _extend(state, k, cells):  # type: ignore[no-untyped-def]
    """Add cells to the first ones of a level, as long as there is room."""
    have = state.filled[k, 0]
    more = min(state.head.shape[2] - have, cells.shape[1])
    if more > 0:
        state.head[k, :, have : have + more] = cells[:, :more]
        state.filled[k, 0] = have + more


@inner
def _keep(state, k, row):  # type: ignore[no-untyped-def]
    """Keep the last cells of a row."""
    size = min(state.tail.shape[2], row.shape[1])
    state.tail[k, :, :size] = row[:, row.shape[1] - size :]
    state.filled[k, 1] = size


@inner
def _paired(state, k, cells, where, first):  # type: ignore[no-untyped-def]
    """The cells of the next level, behind room for where[1] others; empty without any. What has no partner waits.

    where[0] is the place of the first cell; `first` says whether it is the first of its level.
    """
    n, channels, (place, room) = cells.shape[1], cells.shape[0], where
    waiting, skip = state.has[k, 1], place % 2
    made = skip * waiting
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


@inner
def _halved(cells, pairs):  # type: ignore[no-untyped-def]
    for i in range(pairs.size):
        pairs[i] = cells[2 * i] + cells[2 * i + 1]


@kernel
def broken(state, place):  # type: ignore[no-untyped-def]
    """Go on at sample `place`, with missing ones before it: nothing that came is still awaited."""
    state.runs[0] = 2
    state.filled[:, 1] = 0
    state.has[:, 1] = False
    state.at[0] = place


@kernel
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
            read(state, k, row, (have, have + joint.shape[1], place - have), shape)
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


@kernel
def apart(state, other):  # type: ignore[no-untyped-def]
    """Add a part of a stream that begins later than where this one ends, with missing samples between them."""
    state.tail[:] = other.tail
    state.filled[:, 1] = other.filled[:, 1]
    state.even[:] = other.even
    state.has[:, 1] = other.has[:, 1]
    state.at[:] = other.at
    state.runs[0] = 2
    _add(state, other)


@inner
def _add(state, other):  # type: ignore[no-untyped-def]
    state.sums[:] += other.sums
    state.counts[:] += other.counts
    state.powers[:] += other.powers
    state.segments[:] += other.segments


@swift_part
def _sum_less(values, constant):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(values.size):
        total += values[i] - constant
    return total


@kernel
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
