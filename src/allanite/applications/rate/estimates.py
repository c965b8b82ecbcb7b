"""RateEstimate: a constant rate, its uncertainty and the assumptions."""

import math
from dataclasses import dataclass, field
from typing import Any

from allanite.extending import Finding, Signal, UnitError, Value, demand_level, finite, say, unit_of


def rate_factor(unit: str, signal: Signal) -> float:
    """Size of `unit`, a unit of the signal itself, in SI."""
    found = unit_of(unit)
    if found.dimension != signal.dimension:
        raise UnitError(
            f"{unit!r} is not a unit of the {signal.name}'s signal; usual units: {signal.sheet[0]}, {signal.unit}"
        )
    return found.factor


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
            return say(
                "{value:.8g} {unit} (no standard error: give a noise model)", value=self.value / factor, unit=unit
            )
        half = (high - low) / 2
        digits = max(0, 1 - math.floor(math.log10(half))) if half > 0 else 9
        return f"{self.value / factor:.{digits}f} ({low:.{digits}f} .. {high:.{digits}f}) {unit}"

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, SI, with the limits at `level` and the data-sheet form under "shown"."""
        low, high = self.interval(level)
        unit = self.signal.sheet[0]
        numbers = {"value": self.value, "low": low, "high": high, "standard_error": self.standard_error}
        factor = rate_factor(unit, self.signal)
        shown = {**{key: finite(number / factor) for key, number in numbers.items()}, "unit": unit}
        limits = {"low": finite(low), "high": finite(high), "level": level, "unit": self.unit}
        return super().to_dict(level) | limits | {"certain": self.limits is not None, "shown": shown}

    def _summary(self) -> str:
        return f"{self.method}: {self.words()}"
