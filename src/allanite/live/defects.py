"""Defects of a live stream that are looked for block by block: single outliers, and steps of the mean."""

from collections import deque
from collections.abc import Callable, Sequence

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.record import Record
from allanite.prepare.outliers import FEWEST, MOST, outliers

SMALLEST = 64
"""Samples below which nothing is called an outlier."""

LIMIT = 8.0
"""Size of a step, in standard deviations of what means of blocks differ by."""

AFTER, BEFORE = 4, 16
"""Blocks after a step and before it that must have come."""


def spikes(blocks: FloatArray, recent: Sequence[FloatArray], made: Callable[[list[FloatArray]], Record]) -> BoolArray:
    """Which samples of blocks, shape (blocks, samples), are outliers, as `prepare` has it for a record.

    They are compared with the `recent` blocks, `made` to a record. Blocks in which more than 2 % of the samples are
    outliers, and more than one, have none: they move.
    """
    found = np.zeros(blocks.shape, dtype=np.bool_)
    whole = np.isfinite(blocks).all(axis=1)
    typical = [float(np.std(part)) for part in (*recent, *blocks[whole])]
    if not whole.any() or blocks.size + sum(part.size for part in recent) < SMALLEST:
        return found
    centre = np.median(blocks[whole], axis=1, keepdims=True)
    # of most blocks this is enough to say that they have none
    if not (np.abs(blocks[whole] - centre) > 0.8 * FEWEST * float(np.median(typical))).any():
        return found
    before = sum(part.size for part in recent)
    at = outliers(made([*recent, *blocks])).at - before
    found.reshape(-1)[at[at >= 0]] = True
    found[found.sum(axis=1) > max(1, MOST * blocks.shape[1])] = False
    return found


class Steps:
    """Looks for steps in the means of successive blocks.

    The differences between the mean after a block and the one before it are compared with their median size. A step is
    one that is more than eight times their standard deviation, larger than those beside it, and still there four
    blocks later.
    """

    def __init__(self, most: int) -> None:
        self.means: deque[tuple[int, float]] = deque(maxlen=most)

    def push(self, place: int, mean: float) -> tuple[int, float] | None:
        """Add the mean of the block at a place; the place and size of a step in the block four before, if there is one.

        Examples
        --------
        >>> noise = np.random.default_rng(1).normal(size=40)
        >>> noise[25:] += 20.0
        >>> steps = Steps(64)
        >>> [place for place, size in filter(None, (steps.push(i, mean) for i, mean in enumerate(noise)))]
        [25]
        """
        self.means.append((place, mean))
        at = len(self.means) - 1 - AFTER
        if at < BEFORE:
            return None
        m = np.array([mean for _, mean in self.means])
        across = np.abs(m[2:] - m[:-2])  # across[i - 1] is over block i
        size, beside = across[at - 1], (across[at - 2], across[at])
        scale = 1.4826 * float(np.median(across))
        if not (scale > 0 and size > LIMIT * scale and size > beside[0] and size >= beside[1]):
            return None
        step = float(np.median(m[at + 1 :]) - np.median(m[at - AFTER : at]))
        return (self.means[at][0], step) if abs(step) > size / 2 else None
