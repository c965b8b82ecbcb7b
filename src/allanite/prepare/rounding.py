"""Rounding of samples: the step, and whether the noise is sufficient to make rounding errors a noise."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import FloatArray
from allanite.core.record import Record
from allanite.phrases.phrase import say

COARSE = 0.5  # quantization step over the standard deviation of the fast noise above which the step affects the results

NO_DITHER = 0.3
"""Fast noise over the step below which rounding errors are not white noise. After rounding it appears as one or two
codes: noise of 0.3 steps already gives three within a few hundred samples.
"""

NEARBY = 256  # number of successive samples in which codes are counted
FEWEST_NOISE = 100_000  # second differences, of as many or more, that tell the fast noise
MIDDLE = 200_000  # samples in the middle of a record of which the fast noise is taken
FEW_CODES = 16  # number of distinct values up to which they are counted


@dataclass(frozen=True)
class Rounding:
    """How a series is rounded: `codes` distinct values (in a sample of a long one), which are multiples of `step`."""

    codes: int
    step: float  # 0 if there is no grid
    nearby: float  # typical number of values among 256 neighbours, infinite if there is no grid
    noise: float  # standard deviation of the fast noise, in steps, infinite if there is no step

    @property
    def coarse(self) -> bool:
        """Whether the step affects the results."""
        return self.step > 0 and (self.noise < 1 / COARSE or self.codes <= FEW_CODES)

    @property
    def undithered(self) -> bool:
        """Whether rounding errors are not white noise, because there is too little noise before the rounding."""
        return self.coarse and (self.noise < NO_DITHER or self.nearby <= 2)

    @property
    def sparse(self) -> bool:
        """The same for steps of a rounded angle."""
        # White noise of sigma steps before the rounding leaves errors with a lag-one correlation of exp(-2 pi^2
        # sigma^2); above 0.2 steps (0.45) there are more than three codes among 256 samples.
        return self.undithered or (self.coarse and self.nearby <= 3)

    @property
    def counted(self) -> str:
        """``3 distinct values`` if there are few."""
        return say("{count} distinct values", count=self.codes) if self.codes <= FEW_CODES else ""


def rounding(y: NDArray[Any], fast: float) -> Rounding:
    """The rounding of a series whose fast noise has the standard deviation `fast`.

    >>> found = rounding(np.rint(np.random.default_rng(1).standard_normal(1000) * 0.1 + 2.0), 0.1)
    >>> found.step, found.undithered
    (0.0, False)
    >>> found = rounding(np.rint(np.arange(1000) % 7 / 7.0), 0.1)
    >>> found.codes, found.step, found.undithered
    (2, 1.0, True)
    """
    codes, step = grid(y)
    if not step:
        return Rounding(codes, 0.0, float("inf"), float("inf"))
    starts = np.linspace(0, max(y.size - NEARBY, 0), 50).astype(int)
    nearby = float(np.median([np.unique(y[start : start + NEARBY]).size for start in starts]))
    return Rounding(codes, step, nearby, fast / step)


def rounding_of(record: Record) -> Rounding:
    """The rounding of the samples of a record, of an angle that of its steps."""
    steps = finite(record.steps, record)
    middle = max(0, (steps.size - MIDDLE) // 2)
    part = np.asarray(steps[middle : middle + MIDDLE], dtype=np.float64)
    return rounding(steps, fast_noise(np.diff(part, 2)))


def step_of(record: Record) -> float:
    """The step of the samples of a record; 0 if there is no grid."""
    return grid(finite(record.values, record))[1]


def finite(values: NDArray[Any], record: Record) -> NDArray[Any]:
    """The values that are finite of some of a record."""
    return values if record.complete else values[np.isfinite(values)]


def grid(y: NDArray[Any]) -> tuple[int, float]:
    """Number of distinct values in a sample, and their step; 0 if there is no grid."""
    starts = np.linspace(0, max(y.size - 20_000, 0), 10).astype(int)
    part = y if y.size <= 200_000 else np.concatenate([y[start : start + 20_000] for start in starts])
    codes = np.unique(part)
    if codes.size > 0.2 * part.size or codes.size < 2:
        return codes.size, 0.0
    gaps = np.diff(codes.astype(np.float64))
    # values printed with rounding differ by multiples of the step to within a part of it
    step = float(np.median(gaps[gaps < 1.5 * gaps.min()]))
    multiples = gaps / step
    even = np.abs(multiples - np.rint(multiples)) < 0.1
    return codes.size, step if even.mean() > 0.95 else 0.0


def fast_noise(bends: FloatArray) -> float:
    """Standard deviation of the fast noise from second differences, robust; exact for white noise."""
    sample = np.abs(bends[:: max(1, bends.size // FEWEST_NOISE)])
    scale = float(np.median(sample)) / 0.6745 or float(sample.std())
    # for coarse samples the median is coarse, too; the spread without outliers is not
    kept = sample[sample < 6 * scale]
    return float(np.sqrt(np.square(kept).mean() / 6)) if kept.size else scale / float(np.sqrt(6))
