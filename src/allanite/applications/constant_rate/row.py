"""What an estimator is given of a record, what its weights follow from, and a row of the table of estimators."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from allanite.applications.choices import EstimatorChoices

from allanite.extending import (  # isort: skip
    POSITIVE, DataError, Finding, FloatArray, Model, Record, Term, UsageError, Value, demand_name, described, say,
    say_count, spelled, windowing)  # fmt: skip


@described
@dataclass(frozen=True, repr=False)
class EstimatorSettings(EstimatorChoices, Value):
    """Choices for individual estimators.

    Attributes
    ----------
    window : str
        For "hamming": any window that `scipy.signal.get_window` knows, taken symmetric.
    lines : int, optional
        For "conditional": number of regression lines, each starting one sample later; a 160th of the samples if left
        out, the 300 of 48000 of the paper.
    allowed : float, optional
        For "conditional": a line whose slope is farther from the median of slopes is dropped, SI; twice the robust
        standard deviation of the slopes if omitted (the paper gives no value).
    quantum : float, optional
        For "staircase": size of a step of the angle, in the record's unit (for a rate: times s); counts need none.
    descent : int, optional
        For "staircase": most steps of the descent of Enin and Saneev, from the interval's own count, which replaces
        the search.
    """

    allowed: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.descent is not None and self.certified:
            raise UsageError("a descent proves no optimum: omit certified")


@dataclass(frozen=True, eq=False)
class Task:
    """What the weights of an estimator follow from: everything but the data."""

    size: int  # number of sample intervals
    rate: float  # sampling rate, Hz
    model: Model | None = None  # the noise
    target: str = "mean"  # a name in `TARGETS`: what is estimated where the rate itself drifts
    dither: tuple[float, ...] = ()  # frequencies of sinusoids to be removed, Hz
    options: EstimatorSettings = field(default_factory=EstimatorSettings)
    pulse: float = float("nan")  # quantum of the angle, SI; NaN where there is none

    def __post_init__(self) -> None:
        if self.size < 3:
            raise UsageError(f"a rate needs at least 3 samples, not {self.size}")
        demand_name("target", self.target, TARGETS)
        if self.target == "constant" and self.wandering:
            walks = ", ".join(t.symbol for t in self.wandering)
            raise UsageError(f"a constant rate cannot be separated from {walks}, whose drift is unbounded; "
                             "use target='mean', 'centre' or 'start': the rate including the drift, over or at that "
                             "time")  # fmt: skip
        for frequency in self.dither:
            POSITIVE.demand(frequency, "a dither frequency, Hz,")
            alias = abs(frequency - self.rate * round(frequency / self.rate))
            if alias * self.size < 2 * self.rate:
                raise UsageError(f"dither at {frequency:g} Hz, sampled at {self.rate:g} Hz, appears at {alias:.3g} "
                                 f"Hz: less than two periods in {self.size / self.rate:g} s cannot be separated from a "
                                 "rate")  # fmt: skip

    @property
    def duration(self) -> float:
        """Measuring time, s."""
        return self.size / self.rate

    @cached_property
    def wandering(self) -> tuple[Term, ...]:
        """Terms whose rate has no mean that more data would give: flicker, random walk, ramp."""
        return tuple(t for t in self.model or () if t.row.slope >= 0 and t.value != 0)

    @cached_property
    def settled(self) -> tuple[Term, ...]:
        """The other terms."""
        return tuple(t for t in self.model or () if not t.row.slope >= 0 and t.value != 0)

    @cached_property
    def aim(self) -> FloatArray:
        """The estimand as weights on the rate without settled noise, shape (size,)."""
        return TARGETS[self.target](self.size)

    @cached_property
    def sinusoids(self) -> FloatArray:
        """Cosine and sine of each dither frequency at the samples, shape (size, 2 k)."""
        t = (np.arange(self.size) - (self.size - 1) / 2) / self.rate
        waves = [wave(2 * np.pi * f * t) for f in self.dither for wave in (np.cos, np.sin)]
        return np.column_stack(waves) if waves else np.empty((self.size, 0))


TARGETS: dict[str, Callable[[int], FloatArray]] = {
    "mean": lambda n: np.full(n, 1 / n), "constant": lambda n: np.full(n, 1 / n),
    "centre": lambda n: np.bincount([(n - 1) // 2, n // 2], minlength=n) / 2, "start": lambda n: np.eye(1, n)[0],
}  # fmt: skip
"""What is estimated: the mean of the drifting rate over the interval, the constant of one that does not drift, its
value in the middle sample, in the first. Without B, K and R in the model all four are the same."""


@dataclass(frozen=True, eq=False)
class Interval:
    """The data of one measurement."""

    steps: FloatArray  # shape (n,); samples per sample interval, `offset` subtracted, dither sinusoids removed
    offset: float  # in samples
    size: float  # rate of one sample, SI
    pulse: float  # quantum of the angle in samples; NaN where there is none


class RateMeasurement(NamedTuple):
    """What an estimator found: in samples beyond the offset, what else there is to say, limits that are certain."""

    value: float
    details: Mapping[str, float]
    bounds: tuple[float, float] | None = None


@dataclass(frozen=True)
class RateEstimator:
    """A row of `RATE_ESTIMATORS`."""

    # name, title, formula, reference: what it is called, as text, LaTeX, source
    name: str
    title: str
    formula: str
    reference: str
    assumes: str  # when it is the best there is
    # shape (n,); the weights of the rates, their sum is 1; of a method that is not linear, those to which it tends
    weights: Callable[[Task], FloatArray]
    measure: Callable[[Interval, FloatArray, Task], RateMeasurement]
    # variance beyond that of the weights, SI; NaN where it is not known
    excess: Callable[[Task], float] = lambda task: 0.0
    needs_model: bool = False
    needs_quantum: bool = False
    # color of its line in figures, ``#RRGGBB``
    color: str = "#6B6B6B"

    def lacks(self, task: Task) -> str:
        """What the method needs and a task does not have; empty if it can be used."""
        if self.needs_quantum and not math.isfinite(task.pulse):
            option = spelled("--quantum", "quantum=...")
            return say("it needs counts, or the quantum of the angle ({option})", option=option)
        return say("it needs a noise model") if self.needs_model and task.model is None else ""


def linear(interval: Interval, weights: FloatArray, _: Task) -> RateMeasurement:
    """The weighted mean."""
    return RateMeasurement(float(weights @ interval.steps), {})


JUMP = 20.0  # median absolute deviations from the median beyond which a sample is called a pulse slip
REPEATED = 0.999  # share of equal samples above which a record of counts is called saturated


def pulse_of(record: Record, options: EstimatorSettings) -> float:
    """Quantum of the angle in samples (of a rate: samples times the sample interval); NaN where there is none."""
    if options.quantum is not None:
        readings = options.quantum / (1.0 if record.scale is None else record.scale)
        return readings if record.integrated else readings * record.rate
    counted = record.kind == "count" or (record.kind == "increment" and record.scale is not None)
    return 1.0 if counted and not np.any(record.values % 1 > 0) else math.nan  # counts with gaps are increments


def reading_size(record: Record) -> float:
    """Rate of one sample, SI."""
    return record.factor * record.rate if record.integrated else record.factor


def demand_whole(record: Record) -> None:
    """Refuse samples that are not finite."""
    bad = ~np.isfinite(record.values)
    if bad.any():
        raise DataError(say("{bad} of {all} samples of {name!r} are not finite, the first at sample {first}; measure "
                            "between the gaps ({split}), or select a window without them ({window})",
                            bad=int(bad.sum()), all=bad.size, name=record.name, first=int(bad.argmax()),
                            split=spelled("--split-gaps", "gaps=split"), window=windowing()))  # fmt: skip


def readings_of(record: Record, options: EstimatorSettings) -> Interval:
    """The samples of each sample interval, a constant subtracted."""
    if record.kind == "angle":
        steps, offset = np.diff(record.values).astype(np.float64), 0.0
    else:
        offset = float(record.constant)
        steps = np.asarray(record.values - record.constant, dtype=np.float64)
    return Interval(steps, offset, reading_size(record), pulse_of(record, options))


def interval_of(readings: Interval, task: Task, start: int = 0) -> Interval:
    """Those of a measurement that begins with one of them, the dither's sinusoids subtracted."""
    return replace(readings, steps=without_dither(readings.steps[start : start + task.size], task))


def without_dither(values: FloatArray, task: Task, *, weights: bool = False) -> FloatArray:
    """Samples less the sinusoids that fit them beside a constant; or, of weights on those, the ones on raw samples."""
    X = task.sinusoids
    if not X.shape[1]:
        return values
    centred = X - X.mean(axis=0)
    taken, fitted = (centred, X) if weights else (X, centred)
    return np.asarray(values - taken @ np.linalg.solve(centred.T @ centred, fitted.T @ values))


def findings_of(record: Record) -> tuple[Finding, ...]:
    """Findings that make a rate of this record doubtful: a dead or saturated output, slipped pulses."""
    values = np.diff(record.values) if record.kind == "angle" else record.values
    if not values.any():
        what = say("every sample is zero: the output is dead, or the axis does not turn")
        remedy = say("check that the sensor is connected")
        return (Finding("dead", what, say("a rate of zero is without evidence"), remedy),)
    typical = float(np.median(values))
    away = np.abs(values - typical)
    equal = float((away == 0).mean())
    if equal >= REPEATED:
        what = say("{percent:.4g} % of the samples are {value:g}", percent=100 * equal, value=typical)
        remedy = say("check the output's range")
        return (Finding("constant", what, say("a saturated or stuck output looks like this"), remedy),)
    spread = float(np.median(away)) or float(away.mean())
    # coarse counts have a spread of nothing: a slip is more than a few pulses in any case
    limit = JUMP * max(spread, 1.0 if record.kind == "count" else 0.0)
    worst = int(away.argmax())
    if away[worst] <= limit:
        return ()
    count = int((away > limit).sum())
    what = say_count(count, "{count} sample with a jump, the first at sample {first}, the largest by {jump:.6g} "
                     "at sample {worst}, where {typical:.3g} is typical", "{count} samples with a jump, the first at "
                     "sample {first}, the largest by {jump:.6g} at sample {worst}, where {typical:.3g} is typical",
                     first=int((away > limit).argmax()), jump=float(away[worst]), worst=worst,
                     typical=spread)  # fmt: skip
    consequence = say("missing or doubled pulses enter the rate in full")
    return (Finding("slip", what, consequence, say("choose a window without them")),)
