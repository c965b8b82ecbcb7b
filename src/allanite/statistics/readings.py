"""Values read off the Allan deviation of a record: the deviation at 1 s, the minimum, slopes."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from allanite.core.aliases import public
from allanite.core.curve import Curve
from allanite.core.limits import Remembered
from allanite.core.readings import Means, Reading, Readings, Slope
from allanite.core.record import Record
from allanite.statistics import deviation

from .stability import FEWEST, means_of, scatter

USUAL = 1.0
"""Averaging time, s, at which the angle random walk is read."""

MEANS = (10.0, 100.0)
"""Averaging times, s, of the N-second stability of data sheets."""

FEWEST_MEANS = 10
"""Minimum number of means for which their standard deviation is given."""

WINDOWS = 8
"""Minimum number of successive windows at an averaging time."""

WIDE = 2.0
"""Ratio of averaging times below which a range is too narrow for a slope."""


@dataclass(frozen=True, eq=False)
class _Limits:
    """Limits of one point of a curve: level -> (low, high)."""

    every: Callable[[float], Any]
    at: int

    def __call__(self, level: float) -> tuple[float, float]:
        low, high = self.every(level)
        return float(low[self.at]), float(high[self.at])


@public
def readings(record: Record, curve: Curve | None = None) -> Readings:
    """Read off the overlapping Allan deviation the values that data sheets and other programs give.

    Points with fewer than eight successive windows are omitted: the lowest of scattered points is biased low.

    Parameters
    ----------
    record : Record
    curve : Curve, optional
        The record's oadev on the grid "log", if it is already computed.

    Raises
    ------
    DataError
        The record has no complete window.

    Examples
    --------
    >>> import numpy as np
    >>> record = Record(np.random.default_rng(1).standard_normal(5000), rate=10.0, unit="deg/h")
    >>> found = readings(record)
    >>> found.usual.tau, round(found.around.value, 2), found.inside
    (1.0, -0.5, False)
    """
    wide = deviation(record, "oadev", taus="log", noise=None) if curve is None else curve
    known = wide.count >= WINDOWS * wide.m
    factors = wide.m[known].tolist()
    lowest = int(wide.deviation[known].argmin()) if factors else 0
    usual = min(max(round(USUAL * record.rate), 1), max(factors, default=1))
    around = max(round(usual / 3), 1), min(3 * usual, int(wide.m.max()))
    marks: list[int] = []
    if factors:  # that bound the ranges of slopes: the first, those of 10^k seconds, the last that is known
        start, end = factors[0], factors[-1]
        powers = range(math.floor(math.log10(start / record.rate)), math.ceil(math.log10(end / record.rate)) + 1)
        tens = (round(10.0**k * record.rate) for k in powers)
        marks = [start, *(m for m in tens if WIDE * start <= m <= end / WIDE), end]
    least = factors[lowest : lowest + 1]
    points = _Points(deviation(record, "oadev", m=sorted({usual, *around, *marks, *least}), omit=True))
    slopes = (points.slope(first, last) for first, last in pairwise(marks))
    return Readings(
        signal=record.signal,
        usual=points.reading(usual if usual in points.place else max(points.place)),
        around=points.slope(*around),
        minimum=points.reading(least[0]) if least and least[0] in points.place else None,
        inside=lowest < len(factors) - 1,
        slopes=tuple(slope for slope in slopes if slope is not None),
        means=tuple(_means(record)),
    )


class _Points:
    """Points of a curve by their averaging factor."""

    def __init__(self, curve: Curve) -> None:
        self.curve, self.place = curve, {int(m): i for i, m in enumerate(curve.m)}
        self.limits, self.edf = Remembered(curve.interval), curve.edf

    def reading(self, m: int) -> Reading:
        i = self.place[m]
        return Reading(float(self.curve.tau[i]), float(self.curve.deviation[i]), _Limits(self.limits, i))

    def slope(self, first: int, last: int) -> Slope | None:
        """From one point to the other; None where they are too close, one is missing, or a variance is zero."""
        if not {first, last} <= self.place.keys():
            return None
        at = [self.place[first], self.place[last]]
        tau, variance, edf = (values[at] for values in (self.curve.tau, self.curve.variance, self.edf))
        if last < WIDE * first or not variance.all():
            return None
        ratio = math.log(tau[1] / tau[0])
        # as if the two were independent: correlation can only reduce the scatter of their ratio
        error = math.sqrt(float((2 / edf).sum())) / 2 / ratio
        return Slope(float(tau[0]), float(tau[1]), math.log(variance[1] / variance[0]) / 2 / ratio, error)


def _means(record: Record) -> Iterator[Means]:
    """N-second stability, where the record has ten means of which two are complete."""
    for seconds in MEANS:
        m = round(seconds * record.rate)
        if m < 1 or FEWEST_MEANS * m > record.size:
            continue
        means, whole = means_of(record, m)
        if whole.sum() >= FEWEST:
            yield Means(m / record.rate, scatter(means[whole]), int(whole.sum()))
