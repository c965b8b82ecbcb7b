"""Messages of a binary log that describes itself: each begins with two bytes, and its type determines its length."""

import numpy as np

from .compiling import inner, kernel

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
