"""View: a record as used by the checks of its quality; quantities needed several times are computed once."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import BoolArray, FloatArray, complete
from allanite.core.record import Record

from .outliers import Outliers, outliers
from .rounding import fast_noise


@dataclass(frozen=True, eq=False)
class View:
    """The remaining samples of a record, joined over its gaps, in its own unit."""

    record: Record

    @cached_property
    def steps(self) -> NDArray[Any]:
        """The output of the sensor in each interval: samples, or steps of an angle, without missing ones."""
        steps = self.record.steps
        return steps if self.left is None else steps[self.left]

    @cached_property
    def left(self) -> NDArray[np.intp] | None:
        """Indices of the remaining intervals of the record; None if all remain."""
        steps = self.record.steps
        if complete(steps):
            return None
        return np.flatnonzero(np.isfinite(steps))

    @cached_property
    def joints(self) -> NDArray[np.intp]:
        """Index of the first step after each gap."""
        return np.empty(0, np.intp) if self.left is None else np.flatnonzero(np.diff(self.left) > 1) + 1

    @cached_property
    def outliers(self) -> Outliers:
        """Steps far from their neighbours."""
        return outliers(self.record)

    @property
    def rate(self) -> float:
        """Sampling rate, Hz."""
        return self.record.rate

    @cached_property
    def span(self) -> int:
        """Number of samples per block: one second, at least 32, and at least 16 blocks in a record."""
        return max(1, min(max(32, round(self.rate)), self.steps.size // 16))

    @cached_property
    def blocks(self) -> NDArray[Any]:
        """Samples in blocks, shape (blocks, span)."""
        count = self.steps.size // self.span
        return np.asarray(self.steps[: count * self.span].reshape(count, self.span))

    @cached_property
    def bends(self) -> FloatArray:
        """Second differences of successive samples: fast noise, independent of the bias and its drift; 0 over a gap."""
        y = self.steps
        bends: FloatArray = np.subtract(y[2:], y[:-2], dtype=np.float64)
        bends -= 2.0 * (y[1:-1] - y[:-2])
        bends[self.over] = 0.0
        return bends

    @property
    def over(self) -> NDArray[np.intp]:
        """Second differences that extend over a gap."""
        both = np.concatenate((self.joints - 2, self.joints - 1))
        return both[(both >= 0) & (both < self.steps.size - 2)]

    @cached_property
    def fast(self) -> float:
        """Standard deviation of the fast noise, robust; exact for white noise."""
        whole = np.delete(self.bends, self.over) if self.joints.size else self.bends
        # if no three samples are together, over the gaps
        return fast_noise(whole if whole.size else np.diff(self.steps.astype(np.float64), 2))

    @property
    def pulses(self) -> float:
        """The angle of a pulse, 1, where samples count single ones: the noise is less. Otherwise 0."""
        return float(self.record.kind == "count" and self.fast < 1)

    @property
    def ends(self) -> tuple[float, float]:
        """Beginning and end of the record, s after the first sample of the recording."""
        return self.seconds(0), self.seconds(self.steps.size)

    def seconds(self, index: float) -> float:
        """Time of a remaining sample, s after the first sample of the recording."""
        if self.left is None:
            return self.record.cut + index / self.rate
        whole = min(int(index), self.left.size - 1)
        return self.record.cut + (float(self.left[whole]) + index - whole) / self.rate


def stretches(mask: BoolArray) -> NDArray[np.intp]:
    """First index and index after the last of every run of True, shape (runs, 2)."""
    padded = np.concatenate(([False], mask, [False]))
    return np.flatnonzero(padded[1:] != padded[:-1]).reshape(-1, 2)
