"""How the values of a coefficient scatter over the units of a lot: distribution, trend, outlying units."""

import math
from dataclasses import dataclass

import numpy as np

from allanite.core.arrays import FloatArray

from .sources import DATE
from .summary import Coefficient

DAY = 86400.0
FALSE_ALARM = 0.05
"""Probability that a coefficient of a uniform lot has an outlying unit, or shows a trend."""
FEWEST = 4
"""Values from which on there are quantiles and outlying units; of three one would have to be 47 deviations away."""


@dataclass(frozen=True, eq=False, repr=False)
class Distribution(Coefficient):
    """The `values` of a coefficient, SI, of the units that have one, with their 10 %, 50 % and 90 % quantiles."""

    values: FloatArray
    low: float
    median: float
    high: float

    @property
    def tested(self) -> bool:
        """Whether units were tested for being outlying, by the logarithms of their values."""
        return self.values.size >= FEWEST and bool(self.values.all())


@dataclass(frozen=True, eq=False, repr=False)
class Trend(Coefficient):
    """A straight line through the values of a coefficient."""

    along: str  # One of "temperature", "date"
    # at, values: temperature in degrees Celsius, or time in seconds since 1970, and value in SI of the units that
    # have both
    at: FloatArray
    values: FloatArray
    # slope, low, high: change in SI for each kelvin or second, with its 95 % interval, from the scatter of the values
    # about the line
    slope: float
    low: float
    high: float

    @property
    def shown(self) -> bool:
        """Whether the interval excludes zero."""
        return self.low > 0 or self.high < 0

    @property
    def step(self) -> float:
        """The step of temperature or time that slopes are shown for, in kelvin or seconds."""
        return DAY if self.along == DATE else 1.0


@dataclass(frozen=True, repr=False)
class Outlying(Coefficient):
    """A unit whose value differs from the others more than chance explains; `median` is that of all, SI."""

    file: str
    value: float
    median: float


def slope_of(at: FloatArray, value: FloatArray) -> tuple[float, float, float]:
    """Slope of a straight line, with the interval in which it is by the scatter about the line."""
    from scipy import stats

    scale = float(np.std(at))
    fit = stats.linregress((at - at.mean()) / scale, value)
    half = float(stats.t.ppf(1 - FALSE_ALARM / 2, at.size - 2)) * fit.stderr
    return fit.slope / scale, (fit.slope - half) / scale, (fit.slope + half) / scale


def detectable(count: int) -> float:
    """Distance of one of several values from the mean of the others, in their standard deviations, of an outlier.

    Examples
    --------
    >>> [round(detectable(count)) for count in (4, 6, 10)]
    [10, 5, 4]
    """
    from scipy import stats

    return float(stats.t.isf(FALSE_ALARM / (2 * count), count - 2)) * math.sqrt(count / (count - 1))


def outliers(values: FloatArray) -> list[int]:
    """Places of the values that are outliers of a normal sample, by Rosner's generalized extreme studentized deviate.

    One is looked for in fewer than 15 values, for which the test is exact, and at most a fifth of them in more. With a
    probability of `FALSE_ALARM` one is found where there is none.

    Examples
    --------
    >>> outliers(np.array([0.1, -0.2, 0.3, 0.0, -0.1, 0.2, 9.0]))
    [6]
    """
    from scipy import stats

    n, left, found, removed = values.size, np.arange(values.size), 0, list[int]()
    for i in range(1, (1 if n < 15 else n // 5) + 1):
        rest = values[left]
        spread = float(rest.std(ddof=1))
        if not spread > 0:
            break
        at = int(np.argmax(np.abs(rest - rest.mean())))
        size = abs(float(rest[at] - rest.mean())) / spread
        t = float(stats.t.isf(FALSE_ALARM / (2 * (n - i + 1)), n - i - 1))
        removed.append(int(left[at]))
        left = np.delete(left, at)
        if size > t * (n - i) / math.sqrt((n - i - 1 + t * t) * (n - i + 1)):
            found = i
    return removed[:found]
