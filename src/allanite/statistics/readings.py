"""Values read off the Allan deviation of a record: N-second stability, deviation at 1 s, minimum, slopes."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from allanite.core.aliases import public
from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.curve import Curve
from allanite.core.display_units import readable_unit
from allanite.core.errors import DataError, UsageError
from allanite.core.limits import Remembered
from allanite.core.model import ModelLike, model_of
from allanite.core.readings import FLICKER, Means, Reading, Readings, Slope
from allanite.core.record import Record
from allanite.core.threads import one_thread
from allanite.core.units import convert
from allanite.phrases.phrase import say
from allanite.statistics import deviation
from allanite.statistics.differences import OADEV
from allanite.statistics.estimator import AngleRecord, estimated, integrated
from allanite.statistics.grids import factors_of

MIN_COMPLETE_MEANS = 2  # minimum number of complete means
MIN_EDF = 10.0  # minimum degrees of freedom of a point for the minimum


class Stability(NamedTuple):
    """Standard deviation `value` of N-second means, SI, and its exact expectation under a model (`expected`)."""

    # There are `blocks` means over `seconds`; `duration` is that of the record, s: except for white noise the value
    # grows with it.
    value: float
    seconds: float
    blocks: int
    duration: float
    unit: str
    expected: float | None


class Minimum(NamedTuple):
    """The minimum of a curve, and the bias instability if all of it were flicker, which is an upper limit."""

    # `value` is ``deviation / 0.66428``, in `unit`, that of the curve. `inside` says whether the curve rises again
    # beyond `tau`; otherwise the minimum is the last point and only an upper limit.
    value: float
    deviation: float
    tau: float
    inside: bool
    unit: str

    def __repr__(self) -> str:
        shown = readable_unit(self.unit)
        value, least = (f"{convert(number, self.unit, shown):.4g} {shown}" for number in self[:2])
        where = "rises beyond" if self.inside else "its last point"
        return f"<Minimum {value} = {self.value:.4g} {self.unit}, from {least} at {self.tau:.4g} s ({where})>"


@public
def averaging_stability(record: Record, seconds: float = 10.0, *, model: ModelLike | None = None) -> Stability:
    """N-second stability: the standard deviation of the means over `seconds`, without overlap.

    ``s^2 = sum (Y_j - mean Y)^2 / (K - 1)``. Under a model its expectation is ``1/(K (K-1)) sum_l (K - l) (2 D(tau) + 2
    D(l tau) - D((l+1) tau) - D((l-1) tau)) / tau^2``. Means that overlap a gap are omitted.

    Raises
    ------
    UsageError
        `seconds` is not a multiple of the sample interval.
    DataError
        There are fewer than 2 means.

    Examples
    --------
    >>> record = Record([1.0, 3, 2, 2, 5, 3], rate=1.0, unit="rad/s", kind="rate")
    >>> round(averaging_stability(record, 2.0).value, 4)
    1.1547
    """
    m = round(seconds * record.rate) if math.isfinite(seconds * record.rate) else 0
    if m < 1 or abs(m - seconds * record.rate) > 1e-6 * m:
        raise UsageError(f"{seconds:g} s is not a multiple of the sample interval {record.interval:g} s")
    means, whole = means_of(record, m)
    blocks = int(whole.sum())
    if blocks < MIN_COMPLETE_MEANS:
        names: dict[str, Any] = {"channel": record.name, "blocks": blocks, "seconds": seconds}
        if blocks < whole.size:
            raise DataError(say("{channel!r} has {blocks} complete means over {seconds:g} s, but 2 are needed, and a "
                                "mean that touches a gap is not complete; choose a shorter time", **names))  # fmt: skip
        raise DataError(
            say(
                "{channel!r} has {blocks} complete means over {seconds:g} s, but 2 are needed; the longest "
                "possible time is {longest:g} s",
                **names, longest=record.duration / 2,
            )
        )  # fmt: skip
    value = scatter(means[whole])
    expected = None
    if model is not None:  # of successive means that are whole
        size, lag, D = 2 * whole.size, np.arange(1.0, whole.size), model_of(model).structure
        pairs = np.rint(np.fft.irfft(np.abs(np.fft.rfft(whole, size)) ** 2, size)[1 : whole.size])
        squares = 2 * D(np.full_like(lag, seconds)) + 2 * D(lag * seconds)
        squares = squares - D((lag + 1) * seconds) - D((lag - 1) * seconds)
        expected = math.sqrt(float(pairs @ squares / (blocks * (blocks - 1)) / seconds**2))
    return Stability(value, seconds, blocks, record.duration, record.signal.si[0.0], expected)


def means_of(record: Record, m: int) -> tuple[FloatArray, BoolArray]:
    """Means of m successive rates, without overlap, and which of them are complete."""
    steps = record.steps
    means = np.asarray(steps[: steps.size // m * m].reshape(-1, m).mean(axis=1) * record.rate_factor)
    return means, np.isfinite(means)


def scatter(means: FloatArray) -> float:
    """Standard deviation of at least two means."""
    return float(np.std(means, ddof=1))


@public
def minimum(curve: Curve) -> Minimum:
    """The minimum of a curve as an upper limit of the bias instability.

    Only points with at least 10 degrees of freedom are used, if these are known: the lowest of scattered points is
    biased low. With N and K alone, and no flicker at all, the minimum is sqrt(2 N K / 1.732).

    Examples
    --------
    >>> from allanite import deviation
    >>> import numpy as np
    >>> record = Record(np.random.default_rng(1).standard_normal(5000), rate=1.0, unit="rad/s", kind="rate")
    >>> minimum(deviation(record)).inside
    False
    """
    known = curve.edf >= MIN_EDF if curve.law is not None else np.ones(curve.tau.size, dtype=bool)
    if not known.any():
        raise DataError(say("no point of the curve has {least:g} degrees of freedom; record longer", least=MIN_EDF))
    lowest = int(np.where(known, curve.deviation, np.inf).argmin())
    last = int(np.flatnonzero(known)[-1])
    value = float(curve.deviation[lowest])
    return Minimum(value * FLICKER, value, float(curve.tau[lowest]), lowest < last, curve.unit)


USUAL_TIME = 1.0  # averaging time, s, at which the angle random walk is read
MEAN_TIMES = (10.0, 100.0)  # averaging times, s, of the N-second stability of data sheets
MIN_STABILITY_MEANS = 10  # minimum number of means for which their standard deviation is given
MIN_SUCCESSIVE = 8  # minimum number of successive windows at an averaging time
MIN_RANGE = 2.0  # ratio of averaging times below which a range is too narrow for a slope


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
    angle = _begun(record) if curve is None else None
    wide = deviation(record, "oadev", taus="log", noise=None) if curve is None else curve
    known = wide.count >= MIN_SUCCESSIVE * wide.m
    factors = wide.m[known].tolist()
    lowest = int(wide.deviation[known].argmin()) if factors else 0
    usual = min(max(round(USUAL_TIME * record.rate), 1), max(factors, default=1))
    around = max(round(usual / 3), 1), min(3 * usual, int(wide.m.max()))
    marks: list[int] = []
    if factors:  # that bound the ranges of slopes: the first, those of 10^k seconds, the last that is known
        start, end = factors[0], factors[-1]
        powers = range(math.floor(math.log10(start / record.rate)), math.ceil(math.log10(end / record.rate)) + 1)
        tens = (round(10.0**k * record.rate) for k in powers)
        marks = [start, *(m for m in tens if MIN_RANGE * start <= m <= end / MIN_RANGE), end]
    least = factors[lowest : lowest + 1]
    points = _Points(deviation(record, "oadev", m=sorted({usual, *around, *marks, *least}), omit=True, angle=angle))
    slopes = (points.slope(first, last) for first, last in pairwise(marks))
    return Readings(
        signal=record.signal, usual=points.reading(usual if usual in points.place else max(points.place)),
        around=points.slope(*around), minimum=points.reading(least[0]) if least and least[0] in points.place else None,
        inside=lowest < len(factors) - 1, slopes=tuple(slope for slope in slopes if slope is not None),
        means=tuple(_means(record)),
    )  # fmt: skip


def _begun(record: Record) -> AngleRecord:
    """The angle, of which the deviations are taken that an analysis asks for one after another."""
    grids = [factors_of(name, OADEV, record.size, record.rate) for name in ("octave", "log")]
    tens = 10.0 ** np.arange(math.floor(math.log10(record.interval)), math.log10(record.duration))
    marks = np.rint(record.rate * np.array([USUAL_TIME / 3, USUAL_TIME, 3 * USUAL_TIME, *tens])).astype(np.int64)
    marks = marks[(marks >= 1) & (marks <= grids[1].max(initial=0))]
    with one_thread():
        angle = integrated(record, OADEV.order)
        estimated(record, OADEV, np.unique(np.concatenate((*grids, marks))), angle=angle)
    return angle


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
        if last < MIN_RANGE * first or not variance.all():
            return None
        ratio = math.log(tau[1] / tau[0])
        # as if the two were independent: correlation can only reduce the scatter of their ratio
        error = math.sqrt(float((2 / edf).sum())) / 2 / ratio
        return Slope(float(tau[0]), float(tau[1]), math.log(variance[1] / variance[0]) / 2 / ratio, error)


def _means(record: Record) -> Iterator[Means]:
    """N-second stability, where the record has ten means of which two are complete."""
    for seconds in MEAN_TIMES:
        m = round(seconds * record.rate)
        if m < 1 or MIN_STABILITY_MEANS * m > record.size:
            continue
        means, whole = means_of(record, m)
        if whole.sum() >= MIN_COMPLETE_MEANS:
            yield Means(m / record.rate, scatter(means[whole]), int(whole.sum()))
