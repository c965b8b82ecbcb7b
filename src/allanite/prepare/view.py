"""View: a record as the checks of its quality look at it; what several of them need is computed once."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.record import Record

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class View:
    """A record without gaps, in its own unit."""

    record: Record

    @cached_property
    def steps(self) -> NDArray[Any]:
        """What the sensor said in each interval: readings, or steps of an angle."""
        values = self.record.values
        return np.diff(values) if self.record.kind == "angle" else values

    @property
    def rate(self) -> float:
        """Sampling rate, Hz."""
        return self.record.rate

    @cached_property
    def span(self) -> int:
        """Readings in a block: one second, at least 32, and at least 16 blocks in a record."""
        return max(1, min(max(32, round(self.rate)), self.steps.size // 16))

    @cached_property
    def blocks(self) -> NDArray[Any]:
        """Readings in blocks, shape (blocks, span)."""
        count = self.steps.size // self.span
        return np.asarray(self.steps[: count * self.span].reshape(count, self.span))

    @cached_property
    def bends(self) -> FloatArray:
        """Second differences of neighbouring readings: fast noise, whatever the bias and its drift."""
        y = self.steps
        bends: FloatArray = np.subtract(y[2:], y[:-2], dtype=np.float64)
        bends -= 2.0 * (y[1:-1] - y[:-2])
        return bends

    @cached_property
    def fast(self) -> float:
        """Standard deviation of the fast noise, robust; of white noise its standard deviation."""
        sample = np.abs(self.bends[:: max(1, self.bends.size // 100_000)])
        scale = float(np.median(sample)) / 0.6745 or float(sample.std())
        # of coarse readings the median is coarse too: the spread of what is no outlier is not
        kept = sample[sample < 6 * scale]
        return float(np.sqrt(np.square(kept).mean() / 6)) if kept.size else scale / math.sqrt(6)

    def seconds(self, index: float) -> float:
        """Time of a reading after the first one, s."""
        return index / self.rate


def stretches(mask: NDArray[np.bool_]) -> NDArray[np.intp]:
    """First index and index behind the last of every run of True, shape (runs, 2)."""
    padded = np.concatenate(([False], mask, [False]))
    return np.flatnonzero(padded[1:] != padded[:-1]).reshape(-1, 2)
