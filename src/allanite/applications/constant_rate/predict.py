"""The table of estimators, the variance of their weights under a model, and the best one."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from allanite.extending import (  # isort: skip
    Covariance, FloatArray, Model, ModelLike, Signal, Value, public, read_key, row_of, say, size_and_rate, unit_of,
    usable_model,
)  # fmt: skip

from .linear import CONDITIONAL, HAMMING, MEAN, OPTIMAL, REGRESSION, STAIRCASE
from .row import EstimatorSettings, RateEstimator, Task, without_dither

RATE_ESTIMATORS: dict[str, RateEstimator] = {row.name: row for row in (MEAN, HAMMING, REGRESSION, CONDITIONAL,
                                                                       STAIRCASE, OPTIMAL)}  # fmt: skip

MAX_LOSS = 0.02  # loss of accuracy that is not worth another method


def estimator_named(name: str) -> RateEstimator:
    """The row of `RATE_ESTIMATORS`; an unknown name is an error that lists the known ones."""
    return row_of("rate estimator", name, RATE_ESTIMATORS)


def variance(weights: FloatArray, task: Task) -> float:
    """Mean square error of a linear estimator, SI squared."""
    # With w the weights and g the estimand: w'C_s w of the settled noise, (w - g)'C (w - g) of the drifting one, and
    # the square of what a ramp adds, (w - g)'R.
    total = 0.0
    noise = tuple(t for t in task.wandering if t.row.waveform is None)
    if task.settled:
        total += Covariance(task.settled, task.size, task.rate).variance(weights)
    if noise:
        total += Covariance(noise, task.size, task.rate).variance(weights - task.aim)
    for t in task.wandering:
        wave = t.sampled(task.rate).waveform
        if wave is not None:
            total += float((weights - task.aim) @ (t.value * task.rate**t.row.power * wave(task.size))) ** 2
    return max(total, 0.0)


def standard_error(row: RateEstimator, weights: FloatArray, task: Task) -> float:
    """Standard error of an estimator with these weights, SI; NaN if it cannot be predicted."""
    return math.sqrt(variance(without_dither(weights, task, weights=True), task) + row.excess(task))


@public
def predicted_standard_error(
    method: str, model: ModelLike, *, size: int | None = None, rate: float | None = None,
    duration: float | str | None = None, target: str = "mean", dither: tuple[float, ...] = (),
    options: EstimatorSettings | None = None,
) -> float:  # fmt: skip
    """The standard error of a method under a model, without data.

    Parameters
    ----------
    method : str
        A name in `RATE_ESTIMATORS`.
    model : Model, Term or Fit
    size : int
        Number of samples; or `duration`, s.
    rate : float
        Sampling rate, Hz.
    target, dither, options
        As for `estimate`; "staircase" needs ``EstimatorSettings(quantum=...)``, here in SI (rad).

    Returns
    -------
    float
        SI; exact for the linear methods. NaN for "staircase" where the angle's noise is below 0.3 quanta.

    Examples
    --------
    >>> from allanite import N
    >>> white = N(0.003, "deg/sqrt(h)")
    >>> errors = [predicted_standard_error(m, white, size=48000, rate=400.0) for m in ("mean", "regression")]
    >>> round(errors[1] / errors[0], 4)
    1.0954
    """
    task = _expected(model, size_and_rate(size, rate, duration), target=target, dither=tuple(dither), options=options)
    row = estimator_named(method)
    return standard_error(row, row.weights(task), task)


@dataclass(frozen=True, repr=False)
class Ranking(Value):
    """Predicted standard errors of all methods, the best first.

    Attributes
    ----------
    signal : Signal
    duration : float
        Measuring time, s.
    model : Model
    errors : dict
        Method -> standard error, SI; NaN where it cannot be predicted.
    """

    _also: ClassVar[tuple[str, ...]] = ("unit", "verdict")
    _checks: ClassVar = {"errors": lambda errors: read_key(errors, "optimal", float)}

    signal: Signal
    duration: float
    model: Model
    errors: dict[str, float]

    @property
    def unit(self) -> str:
        """SI unit."""
        return self.signal.unit

    @property
    def best(self) -> float:
        """The bound: the least standard error any unbiased linear method has, SI."""
        return self.errors["optimal"]

    def ratio(self, method: str) -> float:
        """Standard error of a method over the bound."""
        return self.errors[method] / self.best if self.best > 0 else math.nan

    @property
    def chosen(self) -> str:
        """The simplest method within `MAX_LOSS` of the bound; empty where nothing is to choose."""
        if not self.best > 0:
            return ""
        return next((m for m in self.errors if self.ratio(m) <= 1 + MAX_LOSS and m != "optimal"), "optimal")

    @property
    def verdict(self) -> str:
        """Which method to use, in a sentence."""
        use = self.chosen
        if not use:
            return say("under this model the rate is measured without error")
        if use == "mean":
            percent = max(100 * (self.ratio("mean") - 1), 0.1)
            return say("for this gyro averaging is already within {percent:.2g} % of the optimum", percent=percent)
        gain = self.errors["mean"] / self.errors[use]
        if use == "optimal" and self.ratio("regression") < self.ratio("mean"):
            return say("use {method}: {gain:.3g} times better than averaging, and {percent:.2g} % better than "
                       "regression", method=use, gain=gain, percent=100 * (self.ratio("regression") - 1))  # fmt: skip
        return say("use {method}: {gain:.3g} times better than averaging", method=use, gain=gain)

    def rows(self, unit: str | None = None) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows: method, standard error in `unit`, its ratio to the bound."""
        unit = unit or self.signal.sheet[0]
        factor = unit_of(unit).factor
        ordered = sorted(self.errors, key=lambda m: math.inf if math.isnan(self.errors[m]) else self.errors[m])
        rows: list[list[Any]] = [[m, self.errors[m] / factor, self.ratio(m)] for m in ordered]
        return ["method", f"standard error, {unit}", "over the bound"], rows


def ranking(task: Task, model: Model) -> Ranking:
    """Predicted standard errors of all methods under a task with a model."""
    errors = {name: standard_error(row, row.weights(task), task) for name, row in RATE_ESTIMATORS.items()}
    return Ranking(model.signal, task.duration, model, errors)


@public
def rank(
    model: ModelLike, *, size: int | None = None, rate: float | None = None, duration: float | str | None = None,
    target: str = "mean", options: EstimatorSettings | None = None,
) -> Ranking:  # fmt: skip
    """The best method for a gyro, and its advantage; parameters as for `predicted_standard_error`.

    Examples
    --------
    >>> from allanite import N, Q
    >>> rank(N(0.003, "deg/sqrt(h)"), size=48000, rate=400.0).verdict
    'for this gyro averaging is already within 0.1 % of the optimum'
    """
    model = usable_model(model)
    return ranking(_expected(model, size_and_rate(size, rate, duration), target=target, options=options), model)


def _expected(
    model: ModelLike, sampling: tuple[int, float], *, target: str, dither: tuple[float, ...] = (),
    options: EstimatorSettings | None,
) -> Task:  # fmt: skip
    """The task of samples that nobody has recorded yet."""
    options = options or EstimatorSettings()
    pulse = math.nan if options.quantum is None else options.quantum
    return Task(*sampling, usable_model(model), target, dither, options, pulse)
