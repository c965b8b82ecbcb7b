"""Sums of squared differences in windows that slide along the angle."""

import numpy as np

from .allan import squares
from .compiling import kernel


@kernel
def sliding(blocks, f):  # type: ignore[no-untyped-def]
    """Sums of every f neighbours, shape (blocks.size - f + 1,), by additions only (van Herk, Gil and Werman).

    Within groups of f the blocks are added up from the left and from the right; a window is the right part of one group
    and the left part of the next. Nothing is subtracted: what has left the window leaves no rounding error behind.
    """
    left, right = blocks.copy(), blocks.copy()
    for i in range(1, blocks.size):
        if i % f:
            left[i] += left[i - 1]
    for i in range(blocks.size - 2, -1, -1):
        if (i + 1) % f:
            right[i] += right[i + 1]
    sums = left[f - 1 :].copy()
    for i in range(sums.size):
        if i % f:
            sums[i] += right[i]
    return sums


@kernel
def windowed(x, m, count, order, step):  # type: ignore[no-untyped-def]
    """Sum of the squared differences that start at w step ... w step + count[j] - 1, shape (windows, m.size).

    Every difference is taken once: its square goes into the sum of a block of `step` of them, of which the first
    ``count mod step`` are added up apart, as the end of a window.
    """
    windows = (x.size - order * m[0] - count[0]) // step + 1
    result = np.empty((windows, m.size))
    for j in range(m.size):
        f, rest = count[j] // step, count[j] % step
        heads, blocks = np.empty(windows + f), np.zeros(windows + f)
        for b in range(windows + f):
            heads[b] = squares(x, m[j], order, b * step, b * step + rest)
            # the last block only ends a window: what follows its head may lie beyond the record
            if b + 1 < windows + f:
                blocks[b] = heads[b] + squares(x, m[j], order, b * step + rest, (b + 1) * step)
        for w in range(windows):
            result[w, j] = heads[f + w]
        if f:
            sums = sliding(blocks[: windows + f - 1], f)
            for w in range(windows):
                result[w, j] += sums[w]
    return result
