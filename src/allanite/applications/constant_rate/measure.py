"""A rate measured by one of the estimators."""

import math
from typing import Unpack

from allanite.extending import ModelLike, Record, Samples, Sampling, UnitError, as_record, public, usable_model

from .estimates import RateEstimate
from .estimators import estimator_named
from .inputs import demand_whole, findings_of, interval_of, pulse_of, reading_size
from .predict import standard_error
from .row import Interval, RateMeasurement
from .setting import EstimatorSettings, Task


@public
def estimate(
    record: Samples,
    method: str = "optimal",
    *,
    model: ModelLike | None = None,
    target: str = "mean",
    dither: tuple[float, ...] = (),
    options: EstimatorSettings | None = None,
    **sampling: Unpack[Sampling],
) -> RateEstimate:
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
    weights, interval = row.weights(task), interval_of(record, task)
    found = in_si(row.measure(interval, weights, task), interval)
    return RateEstimate(
        value=found.value,
        standard_error=math.nan if task.model is None else standard_error(row, weights, task),
        method=row.name,
        assumes=row.assumes,
        signal=record.signal,
        target=task.target,
        duration=task.duration,
        limits=found.bounds,
        details=dict(found.details),
        findings=findings_of(record),
        name=record.name,
    )


def in_si(found: RateMeasurement, interval: Interval) -> RateMeasurement:
    """A measurement with its offset, in SI."""

    def rate(value: float) -> float:
        return (value + interval.offset) * interval.size

    bounds = None if found.bounds is None else (rate(found.bounds[0]), rate(found.bounds[1]))
    return RateMeasurement(rate(found.value), found.details, bounds)


def task_of(
    record: Record,
    model: ModelLike | None,
    target: str,
    *,
    dither: tuple[float, ...] = (),
    options: EstimatorSettings | None = None,
) -> Task:
    """What the weights follow from, for a record."""
    whole = None if model is None else usable_model(model)
    if whole is not None and whole.signal is not record.signal:
        raise UnitError(f"the model is that of a {whole.signal.name}, but the record is that of a {record.signal.name}")
    options = options or EstimatorSettings()
    pulse = pulse_of(record, options) * reading_size(record) / record.rate
    return Task(record.size, record.rate, whole, target, tuple(dither), options, pulse)
