"""The table of estimators, and a rate measured by one of them."""

import math

from allanite.errors import UnitError, UsageError
from allanite.model import Model, Term
from allanite.record import Record

from .estimate import RateEstimate
from .inputs import demand_whole, findings_of, interval_of, pulse_of, reading_size
from .linear import CONDITIONAL, HAMMING, MEAN, REGRESSION
from .optimal import OPTIMAL
from .predict import Ranking, through_dither, variance
from .row import FloatArray, Interval, Measurement, Options, RateEstimator, Setting
from .staircase import STAIRCASE

RATE_ESTIMATORS: dict[str, RateEstimator] = {
    "mean": MEAN,
    "hamming": HAMMING,
    "regression": REGRESSION,
    "conditional": CONDITIONAL,
    "staircase": STAIRCASE,
    "optimal": OPTIMAL,
}


def estimator_named(name: str) -> RateEstimator:
    """The row of `RATE_ESTIMATORS`; an unknown name is an error that lists the known ones."""
    if name not in RATE_ESTIMATORS:
        raise UsageError(f"unknown rate estimator {name!r}; known are {', '.join(RATE_ESTIMATORS)}")
    return RATE_ESTIMATORS[name]


def estimate(
    record: Record,
    method: str = "optimal",
    *,
    model: Model | Term | None = None,
    target: str = "mean",
    dither: tuple[float, ...] = (),
    options: Options | None = None,
) -> RateEstimate:
    """Measure the constant rate of a record.

    Parameters
    ----------
    record : Record
        Counts with their scale, increments, an angle or a rate; every reading finite.
    method : str
        A name in `RATE_ESTIMATORS`.
    model : Model, optional
        The noise; needed by "optimal", and by all for a standard error.
    target : {"mean", "centre", "start", "constant"}
        What is estimated, if the model holds terms whose rate wanders (B, K, R).
    dither : tuple of float
        Frequencies of the dither's residual, Hz, also above half the sampling rate; their sinusoids are taken out by
        least squares.
    options : Options, optional
        Choices that concern one method each.

    Returns
    -------
    RateEstimate

    Raises
    ------
    DataError
        A reading is not finite.
    UsageError
        An unknown method or target; a model or quantum is missing; more lines than fit into the record.

    Examples
    --------
    >>> from allanite.model import N, Q
    >>> record = Record([3, 4, 4, 5, 3, 4], rate=1.0, unit="arcsec", kind="count", scale=0.5)
    >>> found = estimate(record, "optimal", model=N(0.001, "deg/sqrt(h)") + Q(0.2, "arcsec"))
    >>> found.words("deg/h")
    '2.04 (1.91 .. 2.16) deg/h'
    """
    demand_whole(record)
    row, setting = estimator_named(method), setting_of(record, model, target, dither=dither, options=options)
    weights = row.weights(setting)
    found = in_si(row.measure(interval := interval_of(record, setting), weights, setting), interval)
    return RateEstimate(
        value=found.value,
        standard_error=math.nan if setting.model is None else standard_error(row, weights, setting),
        method=row.name,
        assumes=row.assumes,
        signal=record.signal,
        target=setting.target,
        duration=setting.duration,
        limits=found.bounds,
        details=found.details,
        findings=findings_of(record),
        name=record.name,
    )


def in_si(found: Measurement, interval: Interval) -> Measurement:
    """A measurement with its offset, in SI."""

    def rate(value: float) -> float:
        return (value + interval.offset) * interval.size

    bounds = None if found.bounds is None else (rate(found.bounds[0]), rate(found.bounds[1]))
    return Measurement(rate(found.value), found.details, bounds)


def setting_of(
    record: Record,
    model: Model | Term | None,
    target: str,
    *,
    dither: tuple[float, ...] = (),
    options: Options | None = None,
) -> Setting:
    """What the weights follow from, for a record."""
    model = Model((model,)) if isinstance(model, Term) else model
    if model is not None and model.signal is not record.signal:
        raise UnitError(f"the model is that of a {model.signal.name}, the record that of a {record.signal.name}")
    options = options or Options()
    pulse = pulse_of(record, options) * reading_size(record) / record.rate
    return Setting(record.size, record.rate, model, target, tuple(dither), options, pulse)


def standard_error(row: RateEstimator, weights: FloatArray, setting: Setting) -> float:
    """Of an estimator with these weights, SI; NaN where it cannot be predicted."""
    return math.sqrt(variance(through_dither(weights, setting), setting) + row.excess(setting))


def predicted_standard_error(
    method: str,
    model: Model | Term,
    *,
    n: int,
    rate: float,
    target: str = "mean",
    dither: tuple[float, ...] = (),
    options: Options | None = None,
) -> float:
    """The standard error that a method will have under a model, without any data.

    Parameters
    ----------
    method : str
        A name in `RATE_ESTIMATORS`.
    model : Model
    n : int
        Number of samples.
    rate : float
        Sampling rate, Hz.
    target, dither, options
        As of `estimate`; "staircase" needs ``Options(quantum=...)``, here in SI (rad).

    Returns
    -------
    float
        SI; exact for the linear methods. NaN for "staircase" where the angle's noise is below 0.3 quanta.

    Examples
    --------
    >>> from allanite.model import N
    >>> white = N(0.003, "deg/sqrt(h)")
    >>> errors = [predicted_standard_error(m, white, n=48000, rate=400.0) for m in ("mean", "regression")]
    >>> round(errors[1] / errors[0], 4)
    1.0954
    """
    options = options or Options()
    pulse = math.nan if options.quantum is None else options.quantum
    whole = Model((model,)) if isinstance(model, Term) else model
    setting = Setting(n, rate, whole, target, tuple(dither), options, pulse)
    row = estimator_named(method)
    return standard_error(row, row.weights(setting), setting)


def ranking(setting: Setting) -> Ranking:
    """Predicted standard errors of all methods under a setting with a model."""
    model = setting.needed_model
    errors = {name: standard_error(row, row.weights(setting), setting) for name, row in RATE_ESTIMATORS.items()}
    return Ranking(model.signal, setting.duration, model, errors)


def rank(
    model: Model | Term, *, n: int, rate: float, target: str = "mean", options: Options | None = None
) -> Ranking:
    """Which method is the best for a gyro, and by how much; parameters as of `predicted_standard_error`.

    Examples
    --------
    >>> from allanite.model import N, Q
    >>> rank(N(0.003, "deg/sqrt(h)"), n=48000, rate=400.0).verdict
    'for this gyro averaging is already within 0.1 % of the optimum'
    """
    options = options or Options()
    pulse = math.nan if options.quantum is None else options.quantum
    whole = Model((model,)) if isinstance(model, Term) else model
    return ranking(Setting(n, rate, whole, target, (), options, pulse))
