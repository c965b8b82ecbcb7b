"""What makes the axes of a sensor drift, and which of them is the worst at a time."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.errors import UsageError
from allanite.core.model import Term
from allanite.core.plain import Value
from allanite.phrases.phrase import say
from allanite.planning.drift import Response, drift_variance

from .drift_settings import DriftPath, DriftSettings

TURN_ON, SCALE = say("turn-on bias"), say("scale factor")
"""What causes drift beside the noise."""


@dataclass(frozen=True, eq=False, repr=False)
class DriftCause(Value):
    """What makes one axis drift: a noise term, or a constant error."""

    name: str  # symbol of the term, "turn-on bias" or "scale factor"
    term: Term | None = None  # with its coefficient; of one that was not identified, its upper limit (`limit`)
    # bias, step: constant error of the rate, and of its integral from the start on, SI
    bias: float = 0.0
    step: float = 0.0
    # low, high: limits of the coefficient as shares of it; NaN if there are none
    low: float = math.nan
    high: float = math.nan
    limit: bool = False

    def variance(self, response: Response, times: FloatArray, calibration: float, rate: float | None) -> FloatArray:
        """What it adds to the variance of a quantity, SI."""
        if self.term is not None:
            return drift_variance(self.term, response, times, calibration=calibration, rate=rate)
        return np.asarray((self.bias * response.bias(times) + self.step * response.step(times)) ** 2)


@dataclass(frozen=True, eq=False, repr=False)
class DriftAxis(Value):
    """The causes of one axis."""

    sensor: str
    channel: str
    causes: tuple[DriftCause, ...]
    rate: float | None = None  # sampling rate, Hz
    # longest averaging time of its curve, s: beyond it the drift is what the terms predict
    longest: float | None = None
    correlation: FloatArray | None = None  # of the estimates of its terms, in the order of the causes

    def __post_init__(self) -> None:
        terms = sum(cause.term is not None and not cause.limit for cause in self.causes)
        if self.correlation is not None and self.correlation.shape != (terms, terms):
            raise UsageError(f"{terms} terms have a correlation of {terms} rows and columns: the data were changed")


@dataclass(frozen=True, eq=False)
class DriftShare:
    """Variance of a quantity from one cause at each time, SI, with its limits; NaN if there are none.

    `channels` are the axes whose it is, one for each time; `cause` is that of the last time.
    """

    sensor: str
    channels: tuple[str, ...]
    cause: DriftCause
    variance: FloatArray
    low: FloatArray
    high: FloatArray


@dataclass(frozen=True, eq=False)
class _AxisDrift:
    """Variances of one axis, shape (causes, times)."""

    axis: DriftAxis
    causes: Sequence[DriftCause]
    variance: FloatArray

    @cached_property
    def found(self) -> FloatArray:
        """Whether a cause is no upper limit, shape (causes, 1)."""
        return np.array([[not cause.limit] for cause in self.causes], dtype=np.float64)

    def squares(self, end: str) -> FloatArray:
        """Square of how far a limit of the variance is from it: of the limits of its terms, with their correlation.

        The method of variance estimates recovery (G. Y. Zou and A. Donner, Statistics in Medicine 27 (2008) 1693).
        """
        terms = [i for i, cause in enumerate(self.causes) if cause.term is not None and not cause.limit]
        size = np.array([[getattr(self.causes[i], end) ** 2 - 1] for i in terms]).reshape(-1, 1)
        off = np.nan_to_num(size) * self.variance[terms]
        together = np.eye(len(terms)) if self.axis.correlation is None else self.axis.correlation
        return np.asarray(np.maximum(np.einsum("it,ij,jt->t", off, together, off), 0))


@dataclass(frozen=True, eq=False)
class WorstAxis:
    """Of each time the axis of a sensor that drifts most.

    `below` and `above` are the squares of the distances of the limits of the variance from it; `most` is the largest
    upper limit of any axis, with the terms that were not identified at theirs.
    """

    shares: tuple[DriftShare, ...]
    below: FloatArray
    above: FloatArray
    most: FloatArray


def worst_axis(axes: Sequence[DriftAxis], path: DriftPath, settings: DriftSettings, times: FloatArray) -> WorstAxis:
    """The worst axis at each time: by the causes that were found, or by upper limits if nothing was."""
    each = []
    for axis in axes:
        # a turn about the vertical does not tilt
        causes = [cause for cause in axis.causes if not (path.coupled and cause.name == SCALE)]
        of = [cause.variance(settings.response(path), times, settings.averaged, axis.rate) for cause in causes]
        each.append(_AxisDrift(axis, causes, np.array(of).reshape(len(causes), times.size)))
    known = np.array([(one.variance * one.found).sum(axis=0) for one in each])
    every = np.array([one.variance.sum(axis=0) for one in each])
    which = (known if known.any() else every).argmax(axis=0)
    below, above = (np.array([one.squares(end) for one in each]) for end in ("low", "high"))
    most = known + np.sqrt(above + (every - known) ** 2)
    chosen = which, np.arange(times.size)
    shares: dict[tuple[str, tuple[float, ...], bool], DriftShare] = {}
    names = tuple(each[i].axis.channel for i in which)
    for i in dict.fromkeys(which.tolist()):
        for cause, variance in zip(each[i].causes, each[i].variance * (which == i), strict=True):
            key = cause.name, cause.term.shape if cause.term and len(each) == 1 else (), cause.limit
            own = np.array([variance, variance * cause.low**2, variance * cause.high**2])
            if key in shares:
                own += [shares[key].variance, shares[key].low, shares[key].high]
            shares[key] = DriftShare(path.sensor, names, cause, *own)
    return WorstAxis(tuple(shares.values()), below[chosen], above[chosen], most.max(axis=0))
