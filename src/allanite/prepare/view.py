"""View: a record as used by the checks of its quality; quantities needed several times are computed once."""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import FloatArray
from allanite.core.record import Record

from .outliers import Outliers, outliers
from .rounding import FEWEST_NOISE, Rounding, fast_noise, rounding

PART, EIGHT = 1 << 15, 8  # samples that are looked at together, while the cache holds them; smallest block
LEVEL_PARTS = 8  # number of parts of a record whose noise levels are compared
MINUTE = 1e-9  # difference over the fast noise up to which samples are equal
NONE = np.empty(0, np.intp)


class Sweep(NamedTuple):
    """What the differences of neighbours tell."""

    eights: FloatArray  # sums of the squares of eight second differences
    step: float  # the least difference that is not MINUTE
    repeated: int  # how many differences are below half of it, and second differences below that or MINUTE, at most:
    midway: int  # counted with the least difference up to there


@dataclass(frozen=True, eq=False)
class View:
    """The remaining samples of a record, joined over its gaps, in its own unit."""

    record: Record

    @cached_property
    def steps(self) -> NDArray[Any]:
        """The output of the sensor in each interval: samples, or steps of an angle, without missing ones."""
        return self._whole if self.left is None else self._whole[self.left]

    @cached_property
    def _whole(self) -> NDArray[Any]:
        return self.record.steps

    @cached_property
    def left(self) -> NDArray[np.intp] | None:
        """Indices of the remaining intervals of the record; None if all remain."""
        return None if self.record.complete else np.flatnonzero(np.isfinite(self._whole))

    @cached_property
    def extremes(self) -> tuple[Any, Any]:
        """The smallest and the largest step."""
        return self.record.bounds if self.steps is self.record.values else (self.steps.min(), self.steps.max())

    @cached_property
    def limited(self) -> list[int]:
        """How many steps are equal to each of these."""
        return [int(np.count_nonzero(self.steps == edge)) for edge in self.extremes]

    @cached_property
    def joints(self) -> NDArray[np.intp]:
        """Index of the first step after each gap."""
        return NONE if self.left is None else np.flatnonzero(np.diff(self.left) > 1) + 1

    @cached_property
    def outliers(self) -> Outliers:
        """Steps far from their neighbours."""
        return outliers(self.record)

    @cached_property
    def outlying(self) -> NDArray[np.intp]:
        """Their places among the remaining steps."""
        return self.outliers.at if self.left is None else np.searchsorted(self.left, self.outliers.at)

    @property
    def rate(self) -> float:
        """Sampling rate, Hz."""
        return self.record.rate

    @cached_property
    def span(self) -> int:
        """Number of samples per block: one second, at least 32, and at least 16 blocks in a record."""
        return max(1, min(max(32, round(self.rate)), self.steps.size // 16))

    @cached_property
    def blocks(self) -> tuple[FloatArray, FloatArray]:
        """Mean and standard deviation in each block."""
        count = self.steps.size // self.span
        rows, equal = self.steps[: count * self.span].reshape(count, self.span), np.full(self.span, 1 / self.span)
        means, own = np.empty((2, count))
        for some in map(slice, range(0, count, many := -(-PART // self.span)), range(many, count + many, many)):
            means[some] = rows[some] @ equal
            off = rows[some] - means[some, None]
            own[some] = np.sqrt(np.square(off, out=off) @ equal)
        return means, own

    @cached_property
    def levels(self) -> FloatArray:
        """Mean squares of the second differences in eight parts, without those that contain an outlier."""
        size, without = self.bent // LEVEL_PARTS, containing(self.outlying)
        power, edges = np.empty(LEVEL_PARTS), [i * size for i in range(LEVEL_PARTS + 1)]
        for i, (a, b) in enumerate(pairwise(edges)):
            first = min(-(-a // EIGHT) * EIGHT, b)
            last = max(b - b % EIGHT, first)
            ends = np.concatenate((self.bends(a, first, without), self.bends(last, b, without)))
            power[i] = ends @ ends + self.sweep.eights[first // EIGHT : last // EIGHT].sum()
        return np.asarray(power / np.maximum(size - np.diff(np.searchsorted(without, edges)), 1))

    @cached_property
    def sweep(self) -> Sweep:
        """All differences of neighbours taken once, squares without those that contain an outlier."""
        return self.swept(containing(self.outlying))

    def swept(self, without: NDArray[np.intp]) -> Sweep:
        """The same with the squares at some ascending places taken as 0."""
        eights, least, step = np.empty(self.bent // EIGHT), MINUTE * self.fast, math.inf
        repeated = midway = 0
        for start in range(0, self.bent, PART):
            some = self.steps[start : start + PART + 2]
            apart = np.abs(np.subtract(some[1:-1], some[:-2], dtype=np.float64))
            bends = np.abs(self.bends(start, start + apart.size))
            near = float(apart.min())
            step = min(step, near if near > least else float(np.min(apart, where=apart > least, initial=np.inf)))
            repeated += int(np.count_nonzero(apart < step / 2)) if near <= least else 0
            midway += int(np.count_nonzero(bends < max(step / 2, least)))
            low, high = np.searchsorted(without, (start, start + bends.size))
            bends[without[low:high] - start] = 0.0
            sums = np.square(bends, out=bends)[: bends.size // EIGHT * EIGHT].reshape(-1, EIGHT) @ np.ones(EIGHT)
            eights[start // EIGHT :][: sums.size] = sums
        return Sweep(eights, step, repeated, midway)

    @property
    def bent(self) -> int:
        """Number of second differences."""
        return max(self.steps.size - 2, 0)

    def bends(self, first: int, end: int, without: NDArray[np.intp] = NONE) -> FloatArray:
        """Second differences of successive samples: fast noise, independent of the bias and its drift.

        They are 0 over a gap, and at the ascending places `without`.
        """
        bends = second_differences(self.steps[first : end + 2])
        for zeros in (self.over, without):
            low, high = np.searchsorted(zeros, (first, end))
            bends[zeros[low:high] - first] = 0.0
        return bends

    @cached_property
    def over(self) -> NDArray[np.intp]:
        """Second differences that extend over a gap."""
        both = np.concatenate((self.joints - 2, self.joints - 1))
        return np.unique(both[(both >= 0) & (both < self.bent)])

    @cached_property
    def fast(self) -> float:
        """Standard deviation of the fast noise, robust; exact for white noise."""
        if not self.joints.size:
            return fast_noise(second_differences(self.steps, max(1, self.bent // FEWEST_NOISE)))
        whole = np.delete(self.bends(0, self.bent), self.over)
        # if no three samples are together, over the gaps
        return fast_noise(whole if whole.size else np.diff(self.steps.astype(np.float64), 2))

    @cached_property
    def rounding(self) -> Rounding:
        """How the steps are rounded."""
        return rounding(self.steps, self.fast)

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


def second_differences(y: NDArray[Any], every: int = 1) -> FloatArray:
    """Second differences of samples, all or some."""
    bends: FloatArray = np.subtract(y[2::every], y[1:-1:every], dtype=np.float64)
    bends -= y[1:-1:every] - y[:-2:every]
    return bends


def containing(at: NDArray[np.intp]) -> NDArray[np.intp]:
    """Places of the second differences that contain one of these samples."""
    return np.unique(np.subtract.outer(at, np.arange(3)))
