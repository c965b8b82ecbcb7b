"""Counting the samples that a clock has seen and a file has not."""

import numpy as np

from .compiling import kernel

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
