"""RateEstimate: a constant rate, its uncertainty and the assumptions; a bias subtracted or removed by turning."""

import math
from dataclasses import dataclass, field, replace
from typing import Annotated, Any

from allanite.extending import (  # isort: skip
    REAL, SIZE, Finding, Signal, UnitError, UsageError, Value, demand_level, finite, public, say, unit_of)  # fmt: skip


def rate_factor(unit: str, signal: Signal) -> float:
    """Size of `unit`, a unit of the signal itself, in SI."""
    size = unit_of(unit)
    if size.dimension != signal.dimension:
        raise UnitError(f"{unit!r} is not a unit of the {signal.name}'s signal; usual units: {signal.sheet[0]}, "
                        f"{signal.unit}")  # fmt: skip
    return size.factor


def sheet_unit(signal: Signal) -> tuple[str, float]:
    """The unit of data sheets of a signal, and its size in SI."""
    return signal.sheet[0], unit_of(signal.sheet[0]).factor


@dataclass(frozen=True, eq=False, repr=False)
class RateEstimate(Value):
    """A constant rate measured in a short time, SI.

    Attributes
    ----------
    value : float
    standard_error : float
        Standard error under the noise model; NaN if there is no model, or it cannot be predicted.
    method, assumes : str
        Name in `RATE_ESTIMATORS`; the noise for which that method is optimal.
    signal : Signal
    target : str
        What was estimated of a drifting rate: "mean" over the interval, "centre", "start", or a "constant".
    duration : float
        Measuring time, s.
    limits : (low, high) or None
        Limits that hold with certainty, for counts without noise.
    details : dict
        Details of the method: share of lines kept, misfit, phase.
    findings : tuple of Finding
        Findings to report with the rate.
    name : str
        Channel.
    history : tuple of str
        Processing of the rate: bias subtracted, reversal.
    """

    value: float
    standard_error: float
    method: str
    assumes: str
    signal: Signal
    target: str
    duration: float
    limits: tuple[float, float] | None = None
    details: dict[str, float] = field(default_factory=dict)
    findings: tuple[Finding, ...] = ()
    name: str = ""
    history: tuple[str, ...] = ()

    @property
    def unit(self) -> str:
        """SI unit."""
        return self.signal.unit

    def to(self, unit: str) -> float:
        """The value in `unit`."""
        return self.value / rate_factor(unit, self.signal)

    def interval(self, level: float = 0.95) -> tuple[float, float]:
        """Confidence limits (low, high), SI; certain ones where there are any; NaN without a standard error."""
        demand_level(level)
        if self.limits is not None:
            return self.limits
        from scipy.special import ndtri

        reach = float(ndtri((1 + level) / 2)) * self.standard_error
        return self.value - reach, self.value + reach

    def words(self, unit: str | None = None, level: float = 0.95) -> str:
        """The value and its limits: ``12.4331 (12.4298 .. 12.4364) deg/h``."""
        unit = unit or self.signal.sheet[0]
        factor = rate_factor(unit, self.signal)
        low, high = (v / factor for v in self.interval(level))
        if not math.isfinite(low):
            return say("{value:.8g} {unit} (no standard error: give a noise model)", value=self.to(unit), unit=unit)
        half = (high - low) / 2
        digits = max(0, 1 - math.floor(math.log10(half))) if half > 0 else 9
        return f"{self.value / factor:.{digits}f} ({low:.{digits}f} .. {high:.{digits}f}) {unit}"

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, SI, with the limits at `level` and the data-sheet form under "shown"."""
        (low, high), (unit, factor) = self.interval(level), sheet_unit(self.signal)
        numbers = {"value": self.value, "low": low, "high": high, "standard_error": self.standard_error}
        shown = {**{key: finite(number / factor) for key, number in numbers.items()}, "unit": unit}
        limits = {"low": finite(low), "high": finite(high), "level": level, "unit": self.unit}
        return super().to_dict(level) | limits | {"certain": self.limits is not None, "shown": shown}

    def _summary(self) -> str:
        return f"{self.method}: {self.words()}"


@public
def subtract_bias(estimate: RateEstimate, bias: Annotated[float, REAL], unit: str,
                  standard_error: Annotated[float, SIZE] = 0.0) -> RateEstimate:  # fmt: skip
    """The estimate less a bias known beforehand, for example from the gyro's passport.

    The reading is the true rate and the bias: a passport bias of -0.0948 deg/h raises the result by 0.0948 deg/h.

    Parameters
    ----------
    estimate : RateEstimate
    bias, unit, standard_error
        The bias and how well it is known, in `unit`.

    Examples
    --------
    >>> from allanite import N
    >>> gyro = N(0.001, "deg/sqrt(h)").signal
    >>> raw = RateEstimate(12.335042 * 4.84813681e-6, 0.0, "mean", "", gyro, "mean", 120.0)
    >>> round(subtract_bias(raw, -0.0948, "deg/h").to("deg/h"), 4)
    12.4298
    """
    factor = rate_factor(unit, estimate.signal)
    shift, limits = bias * factor, estimate.limits if standard_error == 0 else None
    history = (*estimate.history, say("bias of {bias:g} {unit} subtracted", bias=bias, unit=unit))
    return replace(estimate, value=estimate.value - shift, history=history,
                   standard_error=math.hypot(estimate.standard_error, standard_error * factor),
                   limits=None if limits is None else (limits[0] - shift, limits[1] - shift))  # fmt: skip


@public
def reversal(first: RateEstimate, second: RateEstimate) -> tuple[RateEstimate, RateEstimate]:
    """The rate and the bias from two measurements, the gyro's axis turned about between them.

    Half the difference is the rate along the axis of the first, half the sum the bias. What the bias does from one
    measurement to the next is not in the standard error: a model of one interval knows nothing of it.

    Returns
    -------
    (rate, bias)

    Examples
    --------
    >>> from allanite import N
    >>> gyro = N(0.001, "deg/sqrt(h)").signal
    >>> up, down = (RateEstimate(v, 0.3, "mean", "", gyro, "mean", 120.0) for v in (11.0, -9.0))
    >>> [e.value for e in reversal(up, down)]
    [10.0, 1.0]
    """
    if first.signal is not second.signal or first.target != second.target:
        raise UsageError("the two positions of a reversal must be measured by sensors of one kind, with one target")
    error = math.hypot(first.standard_error, second.standard_error) / 2
    both = replace(first, standard_error=error, limits=None, details={}, duration=first.duration + second.duration,
                   findings=(*first.findings, *second.findings))  # fmt: skip
    difference, total = first.value - second.value, first.value + second.value
    return (replace(both, value=difference / 2, history=(*first.history, say("half the difference of two positions"))),
            replace(both, value=total / 2, history=(*first.history, say("half the sum of two positions"))))  # fmt: skip
