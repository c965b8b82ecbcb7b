"""A rate measured by one of the estimators; the experiment: a record in short intervals, each with every method."""

import math
from dataclasses import dataclass, field, replace
from typing import Unpack

import numpy as np

from allanite.applications.choices import IntervalChoices

from allanite.extending import (  # isort: skip
    KINDS, BoolArray, DataError, FloatArray, IntArray, ModelLike, Record, Samples, Sampling, Signal, UnitError,
    UsageError, Value, as_record, described, given, join, public, say, say_count, usable_model)  # fmt: skip

from .estimates import RateEstimate
from .experiments import Experiment
from .linear import recognized, regression_lines
from .predict import RATE_ESTIMATORS, estimator_named, ranking, standard_error

from .row import (  # isort: skip
    EstimatorSettings, Interval, RateMeasurement, Task, demand_whole, findings_of, interval_of, pulse_of, reading_size,
    readings_of)  # fmt: skip


@public
def estimate(
    record: Samples, method: str = "optimal", *, model: ModelLike | None = None, target: str = "mean",
    dither: tuple[float, ...] = (), options: EstimatorSettings | None = None, **sampling: Unpack[Sampling],
) -> RateEstimate:  # fmt: skip
    """Measure the constant rate of a record.

    Parameters
    ----------
    record : Record or array, shape (n,)
        Counts with their scale, increments, an angle or a rate; every sample finite.
    method : str
        A name in `RATE_ESTIMATORS`.
    model : Model, Term or Fit, optional
        The noise; required by "optimal", and by all methods for a standard error. A fit that does not explain its
        record is refused; `measure_rates` then looks for one that explains means over blocks of samples.
    target : {"mean", "centre", "start", "constant"}
        What is estimated if the model contains drift terms (B, K, R).
    dither : tuple of float
        Frequencies of the residual dither, Hz, also above half the sampling rate; sinusoids are removed by least
        squares.
    options : EstimatorSettings, optional
        Choices for individual methods.
    **sampling
        `rate`, `unit`, `kind`, `scale` and `name` of a `Record`, for an array or a column of a table.

    Returns
    -------
    RateEstimate

    Raises
    ------
    DataError
        A sample is not finite.
    UsageError
        The method or target is unknown, a model or quantum is missing, or there are more lines than fit into the
        record.

    Examples
    --------
    >>> from allanite import N, Q
    >>> record = Record([3, 4, 4, 5, 3, 4], rate=1.0, unit="arcsec", kind="count", scale=0.5)
    >>> found = estimate(record, "optimal", model=N(0.001, "deg/sqrt(h)") + Q(0.2, "arcsec"))
    >>> found.words("deg/h")
    '1.961 (1.872 .. 2.050) deg/h'
    """
    record = as_record(record, "constant_rate.estimate", sampling)
    demand_whole(record)
    row, task = estimator_named(method), task_of(record, model, target, dither=dither, options=options)
    if lacking := row.lacks(task):
        raise UsageError(f"{method}: {lacking}")
    weights, interval = row.weights(task), interval_of(readings_of(record, task.options), task)
    measurement = in_si(row.measure(interval, weights, task), interval)
    return RateEstimate(value=measurement.value, standard_error=math.nan if task.model is None
                        else standard_error(row, weights, task), method=row.name, assumes=row.assumes,
                        signal=record.signal, target=task.target, duration=task.duration, limits=measurement.bounds,
                        details=dict(measurement.details), findings=findings_of(record), name=record.name)  # fmt: skip


def in_si(measurement: RateMeasurement, interval: Interval) -> RateMeasurement:
    """A measurement with its offset, in SI."""

    def rate(value: float) -> float:
        return (value + interval.offset) * interval.size

    bounds = None if measurement.bounds is None else (rate(measurement.bounds[0]), rate(measurement.bounds[1]))
    return RateMeasurement(rate(measurement.value), measurement.details, bounds)


def task_of(
    record: Record, model: ModelLike | None, target: str, *, dither: tuple[float, ...] = (),
    options: EstimatorSettings | None = None,
) -> Task:  # fmt: skip
    """What the weights follow from, for a record."""
    whole = None if model is None else usable_model(model)
    if whole is not None and whole.signal is not record.signal:
        raise UnitError(f"the model is that of a {whole.signal.name}, but the record is that of a {record.signal.name}")
    options = options or EstimatorSettings()
    pulse = pulse_of(record, options) * reading_size(record) / record.rate
    return Task(record.size, record.rate, whole, target, tuple(dither), options, pulse)


MAX_INTERVALS = 120
"""Intervals of one measuring time, where times are compared: their scatter is known to 6.5 %; all seconds of 2 min."""


@described
@dataclass(frozen=True, repr=False)
class ExperimentSettings(IntervalChoices, Value):
    """Choices of an experiment.

    Attributes
    ----------
    interval : float
        Length of an interval, s; the whole record if it is shorter.
    methods : tuple of str
        Names in `RATE_ESTIMATORS`.
    options
        As for `estimate`.
    reference, bias : float
        The true rate, and a known bias, subtracted from every rate, SI.
    gaps : {"error", "split"}
        Whether to split the record at gaps, so that intervals contain no missing samples.
    """

    methods: tuple[str, ...] = tuple(RATE_ESTIMATORS)
    options: EstimatorSettings = field(default_factory=EstimatorSettings)
    reference: float | None = None
    bias: float = 0.0
    gaps: str = "error"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.gaps not in ("error", "split"):
            raise UsageError(f"gaps must be 'error' or 'split', not {given(self.gaps)}")
        for method in self.methods:
            estimator_named(method)


@public
def experiment(
    record: Record, model: ModelLike | None = None, settings: ExperimentSettings | None = None
) -> Experiment:
    """Measure the rate in every interval of a record by every method.

    Parameters
    ----------
    record : Record
    model : Model, Term or Fit, optional
        The noise, ``identify(record)``; "optimal" and predictions need it.
    settings : ExperimentSettings, optional
        By default intervals of two minutes and all methods.

    Returns
    -------
    Experiment

    Raises
    ------
    DataError
        A sample is not finite and gaps are not split, or no interval fits between the gaps.
    UsageError
        No method can be used; a choice is impossible.

    Examples
    --------
    >>> from allanite import GL1, simulate_ring_laser
    >>> record = simulate_ring_laser(GL1, 12.4392, 60_000, 400.0, rng=np.random.default_rng(1))
    >>> found = experiment(record, GL1.model, ExperimentSettings(interval=10.0, methods=("mean", "regression")))
    >>> found.rates.shape, found.notes
    ((2, 15), ())
    """
    settings = settings or ExperimentSettings()
    size = min(max(3, round(settings.interval * record.rate)), record.size)
    starts, notes = _starts(record, size, settings)
    first = piece(record, int(starts[0]), size)
    task = task_of(first, model, settings.target, dither=settings.dither, options=settings.options)
    left_out = {method: why for method in settings.methods if (why := RATE_ESTIMATORS[method].lacks(task))}
    rows = {method: RATE_ESTIMATORS[method] for method in settings.methods if method not in left_out}
    if not rows:
        raise UsageError("; ".join(f"{method}: {why}" for method, why in left_out.items()))
    weights = {method: row.weights(task) for method, row in rows.items()}
    rates, readings = np.empty((len(rows), starts.size)), readings_of(record, settings.options)
    for i, start in enumerate(starts):
        interval = interval_of(readings, task, int(start))
        for j, (method, row) in enumerate(rows.items()):
            rates[j, i] = in_si(row.measure(interval, weights[method], task), interval).value
    rates = rates - settings.bias
    known = task.model is not None
    return Experiment(name=record.name, signal=record.signal, methods=tuple(rows), start=starts / record.rate,
                      duration=size / record.rate, rate=record.rate, rates=rates, reference=float(rates[-1].mean())
                      if settings.reference is None else settings.reference, known=settings.reference is not None,
                      predicted=np.array([standard_error(row, weights[m], task) if known else math.nan
                                          for m, row in rows.items()]),
                      ranking=None if task.model is None else ranking(task, task.model), left_out=left_out, notes=notes,
                      findings=() if settings.gaps == "split" else findings_of(record))  # fmt: skip


def _starts(record: Record, size: int, settings: ExperimentSettings) -> tuple[IntArray, tuple[str, ...]]:
    """First samples of the intervals that are measured, which hold no missing sample, and what that omits."""
    if settings.gaps == "error":
        demand_whole(record)
    extra = KINDS[record.kind][1]
    lost = np.flatnonzero(~np.isfinite(record.values))
    edges = np.concatenate(([-1], lost, [len(record.values)]))
    starts = np.array([start for omitted, right in zip(edges[:-1] + 1, edges[1:], strict=True)
                       for start in range(int(omitted), int(right) - extra - size + 1, size)])  # fmt: skip
    if not starts.size:
        raise DataError(say("no interval of {interval:g} s fits between the {missing} missing samples of {name!r}",
                            interval=size / record.rate, missing=lost.size, name=record.name))  # fmt: skip
    notes = []
    if rest := record.size - starts.size * size:
        omitted = say("{rest:.6g} s of {length:.6g} s do not fill an interval and are omitted",
                   rest=rest / record.rate, length=record.duration)  # fmt: skip
        missing = say_count(int(lost.size), "{count} sample missing", "{count} samples missing")
        notes.append(join("; ", (omitted, missing)) if lost.size else omitted)
    if settings.most is not None and starts.size > settings.most:
        starts = starts[np.linspace(0, starts.size - 1, settings.most).astype(np.int64)]
        notes.append(say_count(settings.most, "{count} interval, spread over the record, was measured",
                               "{count} intervals, spread over the record, were measured"))  # fmt: skip
    return starts, tuple(notes)


def piece(record: Record, start: int, size: int) -> Record:
    """So many sample intervals of a record, from one on."""
    return replace(record, values=record.values[start : start + size + KINDS[record.kind][1]])


@public
def by_duration(
    record: Record, durations: tuple[float, ...], model: ModelLike | None = None,
    settings: ExperimentSettings | None = None,
) -> tuple[Experiment, ...]:  # fmt: skip
    """The experiment for several measuring times, s: the accuracy against the time it takes.

    Times that do not fit into the record are omitted. At most `settings.most` intervals of each, or `MOST`, spread over
    the record, are measured.
    """
    settings = settings or ExperimentSettings()
    most = settings.most or MAX_INTERVALS
    fitting = [d for d in durations if fits(record, d)]
    return tuple(experiment(record, model, replace(settings, interval=d, most=most)) for d in fitting)


def fits(record: Record, duration: float) -> bool:
    """Whether a measuring time, s, has three samples, and fits into a record."""
    return 3 <= duration * record.rate <= record.size


@dataclass(frozen=True, eq=False, repr=False)
class Closeup(Value):
    """What the estimators of lines and stairs see in one interval.

    Attributes
    ----------
    name : str
        Channel.
    signal : Signal
    start, duration, rate : float
        Of the interval, s after the record's first sample; sampling rate, Hz.
    slopes : array, shape (lines,)
        Slope of each regression line, SI; each begins one sample after the one before.
    kept : array, shape (lines,)
        Whether the conditional estimator keeps it.
    counts : array, shape (n + 1,)
        The angle in quanta at every sample, from 0; empty without a quantum.
    line : array, shape (n + 1,)
        The straight line whose floor is the staircase nearest to the counts; empty without a quantum.
    descent : array, shape (steps + 1,)
        The rates at which a descent begins and after each of its steps, SI; empty if none was chosen.
    """

    name: str
    signal: Signal
    start: float
    duration: float
    rate: float
    slopes: FloatArray
    kept: BoolArray
    counts: FloatArray
    line: FloatArray
    descent: FloatArray

    @property
    def misfit(self) -> FloatArray:
        """Counts less the staircase, quanta."""
        return np.asarray(self.counts - np.floor(self.line))


@public
def closeup(record: Record, settings: ExperimentSettings | None = None, *, start: float = 0.0) -> Closeup:
    """Look at one interval of a record.

    Parameters
    ----------
    record : Record
    settings : ExperimentSettings, optional
        Its length, the dither to remove, the choices of the estimators.
    start : float
        Start of the interval, s after the record's first sample.

    Raises
    ------
    DataError
        A sample of the interval is not finite.
    UsageError
        The interval does not fit into the record.

    Examples
    --------
    >>> from allanite import GL1, simulate_ring_laser
    >>> record = simulate_ring_laser(GL1, 12.4392, 48_000, 400.0, rng=np.random.default_rng(1))
    >>> found = closeup(record)
    >>> found.slopes.size, bool(abs(found.misfit).mean() < 1)
    (300, True)
    """
    settings = settings or ExperimentSettings()
    size = min(max(3, round(settings.interval * record.rate)), record.size)
    first = round(start * record.rate) if np.isfinite(start) else -1
    if not 0 <= first <= record.size - size:
        raise UsageError(f"an interval of {size / record.rate:g} s from {start:g} s does not fit into "
                         f"{record.duration:g} s")  # fmt: skip
    part = piece(record, first, size)
    demand_whole(part)
    task = task_of(part, None, settings.target, dither=settings.dither, options=settings.options)
    interval = interval_of(readings_of(part, task.options), task)
    slopes, kept = regression_lines(interval, task)
    counts = line = descent = np.empty(0)
    if math.isfinite(interval.pulse):
        counts, line, descent = recognized(interval, settings.options)
    rates, descent = ((each + interval.offset) * interval.size - settings.bias for each in (slopes, descent))
    span = first / record.rate, size / record.rate
    return Closeup(record.name, record.signal, *span, record.rate, rates, kept, counts, line, descent)
