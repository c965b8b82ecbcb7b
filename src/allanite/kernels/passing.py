"""One look at what a file has: samples far off their neighbours, missing samples, messages of a log."""

import numpy as np

from .compiling import inner, kernel, part

HALF = 15
"""Neighbours on either side."""

BEND_BLOCK = 1024
"""Samples whose bends are taken at a time."""

EARLY = 24
"""Neighbours that are counted first: those that follow rarely matter."""


@kernel
def off(y, limit, part):  # type: ignore[no-untyped-def]
    """Indices of samples more than ``limit[i // part]`` off the median of the 31 around them; y has 31 or more.

    Only where y bends by as much. More than half of 31 values lie below a bound exactly if their median does: nothing
    is sorted.
    """
    n = y.size
    found = np.empty(n, np.int64)
    bends = np.empty(BEND_BLOCK)
    count = 0
    for begin in range(0, n, part):
        most, end = limit[begin // part], min(begin + part, n)
        for first in range(begin, end, BEND_BLOCK):
            size = min(BEND_BLOCK, end - first)
            _bends(y, first, bends[:size])
            for i in range(size):
                if bends[i] > most:
                    found[count] = first + i
                    count += _beyond(y, first + i, most)
    return found[:count].copy()


@part
def _bends(y, first, bends):  # type: ignore[no-untyped-def]
    """How far samples from the first on are off both neighbours together; at an end the one counts twice."""
    n, size = y.size, bends.size
    a, b = max(first, 1), min(first + size, n - 1)
    before, middle, after = y[a - 1 : b - 1], y[a:b], y[a + 1 : b + 1]
    inner = bends[a - first :]
    for i in range(middle.size):
        inner[i] = abs((middle[i] - before[i]) + (middle[i] - after[i]))
    if first == 0:
        bends[0] = abs((y[0] - y[1]) + (y[0] - y[1]))
    if first + size == n:
        bends[size - 1] = abs((y[n - 1] - y[n - 2]) + (y[n - 1] - y[n - 2]))


@part
def _beyond(y, i, most):  # type: ignore[no-untyped-def]
    """Whether a sample is more than that off the median of the 31 around it."""
    width = 2 * HALF + 1
    start = min(max(i - HALF, 0), y.size - width)
    near = y[start : start + width]
    low, high = y[i] - most, y[i] + most
    below = 0
    above = 0
    for j in range(EARLY):
        below += near[j] < low
        above += near[j] > high
    if max(below, above) + width - EARLY <= HALF:
        return False
    for j in range(EARLY, width):
        below += near[j] < low
        above += near[j] > high
    return below > HALF or above > HALF


GAIN = 0.1
"""Share of a stamp's departure by which the level follows: jitter is averaged over 20 stamps, drift is followed."""


@kernel
def followed(stamps, rows, ahead, slack):  # type: ignore[no-untyped-def]
    """Whole intervals by which each stamp is ahead of its row, and what is left of its departure.

    `stamps` are in nominal intervals, shape (n,), `rows` the numbers of their rows. A departure of more than `slack`
    counts if the next `ahead` stamps keep it: a late stamp is followed by stamps in time, a missing sample is not.
    """
    shift = np.empty(stamps.size, np.int64)
    left = np.empty(stamps.size)
    level = stamps[0] - rows[0]
    spread = 0.0
    lost = 0
    for k in range(stamps.size):
        off = stamps[k] - rows[k] - lost - level
        if abs(off) > slack:
            kept = off
            for j in range(k + 1, min(k + ahead, stamps.size)):
                then = stamps[j] - rows[j] - lost - level
                kept = min(kept, then) if off > 0.0 else max(kept, then)
                if kept * off <= 0.0:
                    break
            # the last stamps have too few behind them to tell a late one from a loss
            limit = slack if k + 3 < stamps.size else max(slack, 4.0 * spread)
            if abs(kept) > limit and kept * off > 0.0:
                jump = int(np.rint(kept))
                lost += jump
                off -= jump
        if abs(off) <= slack:
            level += GAIN * off
            spread += GAIN * (abs(off) - spread)
        shift[k] = lost
        left[k] = off
    return shift, left


DEFINITION = 128
"""Type of the messages that define types: the type and its length are their first two bytes."""


@inner
def message_at(data, at, lengths):  # type: ignore[no-untyped-def]
    """Length of the message at a position; 0 if there is none, or if what follows it is not one either.

    `data`, uint8, shape (n,); `lengths` of the types, shape (256,), receives those that the message defines.
    """
    if at + 3 > data.size or data[at] != 0xA3 or data[at + 1] != 0x95:
        return 0
    kind = data[at + 2]
    length = lengths[kind]
    end = at + length
    if length < 3 or end > data.size:
        return 0
    # the next message may be cut off, but not missing: a message that lost bytes must not be read
    if end < data.size and (data[end] != 0xA3 or (end + 1 < data.size and data[end + 1] != 0x95)):
        return 0
    if kind == 128 and lengths[data[at + 3]] == 0:
        lengths[data[at + 3]] = data[at + 4]
    return length


@kernel
def counted(data, lengths):  # type: ignore[no-untyped-def]
    """Number of messages of each type, shape (256,), and number of bytes that belong to none."""
    counts = np.zeros(256, np.int64)
    at = lost = 0
    while at < data.size:
        length = message_at(data, at, lengths)
        if length:
            counts[data[at + 2]] += 1
            at += length
        else:
            lost += 1
            at += 1
    return counts, lost


@kernel
def taken(data, lengths, kind, rows):  # type: ignore[no-untyped-def]
    """Copy the contents of all messages of a type to `rows`, uint8, shape (count, length - 3)."""
    at = row = 0
    while at < data.size and row < rows.shape[0]:
        length = message_at(data, at, lengths)
        if length and data[at + 2] == kind:
            for k in range(rows.shape[1]):
                rows[row, k] = data[at + 3 + k]
            row += 1
        at += length if length else 1
