"""Readings: values read off the Allan deviation without a noise model."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from allanite.phrases.phrase import Phrase, say
from allanite.terms import TERMS

from .display_units import shown_unit
from .encoding import finite, plain
from .limits import demand_level, quantile
from .plain import Value
from .titles import title_of
from .units import Signal, convert

WHITE = 0.1
"""Largest difference of the slope from -1/2 at which the deviation at 1 s is read as an angle random walk."""

FLICKER = 1 / math.sqrt(TERMS["B"].level)
"""Bias instability over the Allan deviation of flicker noise: 1 / 0.66428."""


@dataclass(frozen=True, eq=False, repr=False)
class Reading(Value):
    """One point of a curve: averaging time `tau` in s, `deviation` in SI, and its `limits` (level -> (low, high))."""

    tau: float
    deviation: float
    limits: Callable[[float], tuple[float, float]]

    def interval(self, level: float = 0.95) -> tuple[float, float]:
        """Two-sided confidence limits of the deviation."""
        demand_level(level)
        return self.limits(level)

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, with the limits as numbers."""
        low, high = map(finite, self.interval(level))
        return super().to_dict(level) | {"low": low, "high": high, "level": level}


@dataclass(frozen=True, repr=False)
class Slope(Value):
    """Log-log slope of the curve between two averaging times, s: -1/2 for white rate noise, 0 for flicker."""

    start: float
    end: float
    value: float
    standard_error: float

    def interval(self, level: float = 0.95) -> tuple[float, float]:
        """Two-sided confidence interval."""
        demand_level(level)
        half = self.standard_error * quantile((1 + level) / 2)
        return self.value - half, self.value + half


@dataclass(frozen=True, repr=False)
class Means(Value):
    """N-second stability: standard deviation `value`, SI, of `count` successive means over `seconds`."""

    seconds: float
    value: float
    count: int


class Quantity(NamedTuple):
    """One line of a table of readings: `value`, `low` and `high` in SI units of the signal times time to the `power`.

    `power` is None for a slope, which has no unit. `quoted`: whether data sheets have it.
    """

    title: str
    tau: float
    value: float
    low: float
    high: float
    power: float | None
    remark: str = ""
    quoted: bool = False


MINIMUM = "minimum"
"""Stands for the minimum of the Allan deviation where a coefficient has its symbol."""


def minimum_title(signal: Signal) -> str:
    """What the minimum of the Allan deviation is called: data sheets of inertial sensors have a name for it."""
    return say("minimum (in-run bias stability)") if signal.inertial else say("minimum of the Allan deviation")


@dataclass(frozen=True, eq=False, repr=False)
class Readings(Value):
    """Values conventionally read off the overlapping Allan deviation, without a noise model.

    The intervals assume the power law identified at each averaging time.
    """

    _also = ("unit", "random_walk", "bias_instability")

    signal: Signal
    usual: Reading  # deviation at 1 s, or at the nearest averaging time of the record
    around: Slope | None  # slope from a third of that time to three times it; None at the end of the curve
    # the minimum of the Allan deviation (in-run bias stability), among averaging times with at least eight windows
    minimum: Reading | None
    inside: bool  # whether the curve rises again after the minimum; if not, the last point is an upper limit
    slopes: tuple[Slope, ...]  # slopes by decades of averaging time
    means: tuple[Means, ...]  # n-second stability for 10 and 100 s
    # units in which all is shown, if not in those of data sheets; see `units.shown_unit`
    wanted: tuple[str, ...] = ()

    @property
    def unit(self) -> str:
        """SI unit of the deviations."""
        return self.signal.si[0]

    def shown_unit(self, power: float) -> str:
        """The unit in which signal x time^power is shown."""
        return shown_unit(self.signal, power, self.wanted)

    @property
    def white(self) -> bool:
        """Whether the slope is that of white rate noise where the angle random walk is read."""
        return self.around is not None and abs(self.around.value + 0.5) <= WHITE

    @property
    def random_walk(self) -> float:
        """The angle random walk, SI, if the noise at `usual` is white: deviation times sqrt(tau)."""
        return self.usual.deviation * math.sqrt(self.usual.tau)

    @property
    def bias_instability(self) -> float | None:
        """The minimum divided by 0.664: the bias instability, SI, if all of it were flicker."""
        return None if self.minimum is None else self.minimum.deviation * FLICKER

    def quantities(self, level: float = 0.95) -> list[Quantity]:
        """All values as the lines of a table."""
        walk = title_of("N", self.signal)
        tau, root = self.usual.tau, math.sqrt(self.usual.tau)
        found = [
            _quantity(say("deviation at {tau:.4g} s", tau=tau), self.usual, level),
            _quantity(say("as {walk}", walk=walk), self.usual, level, root, self._slope_there())._replace(power=0.5),
        ]
        if self.minimum is not None:
            tau = self.minimum.tau
            inside, last = (
                say("at {tau:.4g} s", tau=tau),
                say("at {tau:.4g} s, the last point: an upper limit", tau=tau),
            )
            found.append(
                _quantity(
                    minimum_title(self.signal), self.minimum, level, 1.0, inside if self.inside else last
                )._replace(quoted=True)
            )
            most = say("{term} at most", term=title_of("B", self.signal))
            found.append(_quantity(say("minimum / 0.664"), self.minimum, level, FLICKER, most))
        found += [
            Quantity(
                stability_over(m.seconds),
                m.seconds,
                m.value,
                math.nan,
                math.nan,
                0,
                say("of {count} means", count=m.count),
                quoted=True,
            )
            for m in self.means
        ]
        return found + [
            Quantity(
                say("slope, {start:.4g} to {end:.4g} s", start=s.start, end=s.end), s.start, s.value,
                *s.interval(level), None,
            )
            for s in self.slopes
        ]  # fmt: skip

    def _slope_there(self) -> Phrase:
        """The slope where the angle random walk is read."""
        if self.around is None:
            return say("slope unknown there, not -0.5: not valid")
        if self.white:
            return say("slope {slope:.2f} there", slope=self.around.value)
        return say("slope {slope:.2f} there, not -0.5: not valid", slope=self.around.value)

    def rows(self, level: float = 0.95) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows, data sheet and SI side by side."""
        headings = ["reading", "tau", "value", "low", "high", "unit", "SI value", "SI unit", "remark"]
        rows: list[list[Any]] = []
        for q in self.quantities(level):
            sheet, si = ("", "") if q.power is None else (self.shown_unit(q.power), self.signal.si[q.power])
            factor = convert(1.0, si, sheet) if sheet else 1.0
            size = (q.value * factor, q.low * factor, q.high * factor)
            rows.append([q.title, q.tau, *size, sheet, q.value, si, q.remark])
        return headings, rows

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, SI, with the data-sheet form under "shown"."""
        headings, rows = self.rows(level)
        shown = [dict(zip(headings[:6], map(plain, row[:6]), strict=True)) for row in rows]
        return super().to_dict(level) | {"shown": shown, "level": level}

    def _summary(self) -> str:
        unit = self.shown_unit(0)
        return f"{convert(self.usual.deviation, self.unit, unit):.4g} {unit} at {self.usual.tau:.4g} s"


def stability_over(seconds: float) -> Phrase:
    """The name of N-second stability."""
    return say("{seconds:.4g} s stability", seconds=seconds)


def _quantity(title: str, point: Reading, level: float, factor: float = 1.0, remark: str = "") -> Quantity:
    low, high = point.interval(level)
    return Quantity(title, point.tau, point.deviation * factor, low * factor, high * factor, 0, remark)
