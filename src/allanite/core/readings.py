"""Readings: values read off the Allan deviation without a noise model. Data sheet: what data sheets quote."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

from allanite.phrases.phrase import Phrase, averaging, join, say
from allanite.terms import TERMS, WHITE

from .digits import Digits, digits
from .display_units import shown_unit
from .encoding import finite, plain
from .estimate import Estimate
from .fit import Fit
from .kinds import title_of
from .limits import demand_level, quantile
from .plain import Value
from .units import Signal, convert

WHITE_WITHIN = 0.1
"""Largest difference of the slope from -1/2 at which the deviation at 1 s is read as an angle random walk."""

FLICKER = 1 / math.sqrt(TERMS["B"].level)  # bias instability over the Allan deviation of flicker noise: 1 / 0.66428


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
    """One line of a table of readings: `value`, `low`, `high` in SI units of the signal times time to the `power`."""

    # `power` is None for a slope, which has no unit.
    title: str
    tau: float
    value: float
    low: float
    high: float
    power: float | None
    remark: str = ""


MINIMUM = "minimum"  # the symbol of the minimum of the Allan deviation, beside those of coefficients

IN_RUN = say("in-run bias stability")  # what data sheets of inertial sensors call it

FALLING, FALLING_SIGN = say("still falling"), "↓"
"""Stand beside a minimum that is the last point of its curve: a longer record may have a lower one."""


def minimum_title(signal: Signal) -> str:
    """What the minimum of the Allan deviation is called: data sheets of inertial sensors have a name for it."""
    return say("minimum ({name})", name=IN_RUN) if signal.inertial else say("minimum of the Allan deviation")


@dataclass(frozen=True, eq=False, repr=False)
class Readings(Value):
    """Values conventionally read off the overlapping Allan deviation, without a noise model."""

    # The intervals assume the power law identified at each averaging time.
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

    def lowest(self, level: float = 0.95) -> Digits | None:
        """The minimum, rounded with its interval, in the unit that is shown; None where there is none."""
        if self.minimum is None:
            return None
        factor = convert(1.0, self.unit, self.shown_unit(0))
        return digits(self.minimum.deviation * factor, *(limit * factor for limit in self.minimum.interval(level)))

    def lowest_words(self, level: float = 0.95, *, pretty: bool = False) -> str:
        """The same as text: ``1.23 (0.87 .. 2.10) deg/h at 5.7 min, still falling``."""
        lowest = self.lowest(level)
        if lowest is None or self.minimum is None:
            return ""
        size = f"{lowest.pretty() if pretty else lowest.words()} {self.shown_unit(0)}"
        text = say("{value} at {tau}", value=size, tau=averaging(self.minimum.tau))
        return text if self.inside else join(", ", (text, FALLING))

    @property
    def white(self) -> bool:
        """Whether the slope is that of white rate noise where the angle random walk is read."""
        return self.around is not None and abs(self.around.value + 0.5) <= WHITE_WITHIN

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
        quantities = [_quantity(say("deviation at {tau:.4g} s", tau=tau), self.usual, level),
                      _quantity(say("as {walk}", walk=walk), self.usual, level, root,
                                self._slope_there())._replace(power=0.5)]  # fmt: skip
        if self.minimum is not None:
            where = say("at {tau:.4g} s", tau=self.minimum.tau)
            remark = where if self.inside else join(", ", (where, FALLING))
            quantities.append(_quantity(minimum_title(self.signal), self.minimum, level, 1.0, remark))
            most = say("{term} at most", term=title_of("B", self.signal))
            quantities.append(_quantity(say("minimum / 0.664"), self.minimum, level, FLICKER, most))
        return quantities + [Quantity(say("slope, {start:.4g} to {end:.4g} s", start=s.start, end=s.end), s.start,
                                      s.value, *s.interval(level), None) for s in self.slopes]  # fmt: skip

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


def _quantity(title: str, point: Reading, level: float, factor: float = 1.0, remark: str = "") -> Quantity:
    low, high = point.interval(level)
    return Quantity(title, point.tau, point.deviation * factor, low * factor, high * factor, 0, remark)


ONE_SIDED = math.sqrt(2)  # one-sided over two-sided amplitude spectral density
MOSTLY = 0.8  # part of an N-second stability that a ramp alone makes, from which it is named

BANDWIDTH = say("bandwidth (-3 dB)")


class DataSheetRow(NamedTuple):
    """One line of a data sheet."""

    # `value`, `low` and `high` are in `unit`; of a term that was not found only `high` is known, a one-sided 95 % upper
    # limit. `tau` is the averaging time in s, where the quantity has one. `coefficient`: whether it is a coefficient of
    # the model in its usual unit, as tables of coefficients have it, too.
    quantity: str
    value: float | None
    low: float | None
    high: float | None
    unit: str
    tau: float | None = None
    remark: str = ""
    coefficient: bool = False


def data_sheet(fit: Fit | None, readings: Readings | None, rate: float, level: float = 0.95) -> list[DataSheetRow]:
    """The quantities of a data sheet, each with its limits."""
    estimates = () if fit is None else fit.estimates
    white = [e for e in estimates if TERMS[e.symbol].slope == WHITE]
    entries = list[DataSheetRow]()
    densities = ((say("noise density, two-sided"), 1.0, ""), (say("noise density, one-sided"), ONE_SIDED, "sqrt(2) "))
    for e in white:
        for unit in dict.fromkeys((e.sheet_unit, e.signal.sheet[TERMS[e.symbol].power])):
            entries.append(_entry(e, _name(e), unit, level)._replace(coefficient=unit == e.sheet_unit))
        for (quantity, factor, before), unit in product(densities, e.signal.density):
            row = _entry(e, quantity, unit, level, factor)
            entries.append(row if row.remark else row._replace(remark=f"{before}{e.symbol}"))
    entries += _minimum(readings, level)
    for e in (e for e in estimates if e not in white):
        entries.append(_entry(e, _name(e), e.sheet_unit, level)._replace(coefficient=True))
        if TERMS[e.symbol].slope == 0:
            floor = math.sqrt(TERMS[e.symbol].level)
            entries.append(_entry(e, say("flicker floor, {floor:.3f} B", floor=floor), e.sheet_unit, level, floor))
    if readings is not None:
        unit = readings.shown_unit(0)
        per = convert(1.0, readings.unit, unit)
        for means in readings.means:
            name, value = say("{seconds:.4g} s stability", seconds=means.seconds), means.value * per
            remark = say("{count} means", count=means.count)
            if any(_spread_of(e, means) > MOSTLY * means.value for e in estimates):
                remark = say("{means}; mostly the ramp R", means=remark)
            entries.append(DataSheetRow(name, value, None, None, unit, means.seconds, remark))
    return entries if fit is None else [*entries, _bandwidth(fit, rate)]


def _spread_of(e: Estimate, means: Means) -> float:
    """Standard deviation of means that a ramp alone makes, SI: R n s / sqrt(12); 0 of any other term."""
    if TERMS[e.symbol].waveform is None or TERMS[e.symbol].slope != 1 or e.value is None:
        return 0.0
    return abs(e.value) * means.count * means.seconds / math.sqrt(12)


def _name(e: Estimate) -> Phrase:
    return say("{term} {symbol}", term=title_of(e.symbol, e.signal), symbol=e.symbol)


def _entry(e: Estimate, quantity: str, unit: str, level: float, factor: float = 1.0) -> DataSheetRow:
    scale = factor * convert(1.0, e.unit, unit)
    remark = {"identified": "", "absent": say("not identified")}.get(e.status, e.row.name)
    if e.status == "not valid" or e.value is None:
        most = None if e.upper is None or e.status == "not valid" else e.upper * scale
        return DataSheetRow(quantity, None, None, most, unit, None, remark)
    low, high = (None if math.isnan(v) else v * scale for v in e.interval(level))
    return DataSheetRow(quantity, e.value * scale, low, high, unit, None, remark)


def _minimum(readings: Readings | None, level: float) -> Iterator[DataSheetRow]:
    if readings is None or readings.minimum is None:
        return
    point, unit = readings.minimum, readings.shown_unit(0)
    factor = convert(1.0, readings.unit, unit)
    value, low, high = (size * factor for size in (point.deviation, *point.interval(level)))
    lowest, inertial = say("minimum of the Allan deviation"), readings.signal.inertial
    remark = FALLING if not readings.inside else lowest if inertial else ""
    yield DataSheetRow(IN_RUN if inertial else lowest, value, low, high, unit, point.tau, remark)


def _bandwidth(fit: Fit, rate: float) -> DataSheetRow:
    behind = fit.scope.filter if fit.scope else None
    if behind is not None:
        return DataSheetRow(BANDWIDTH, behind.cutoff, behind.low, behind.high, "Hz", None, behind.title)
    flat = fit.scope is not None and fit.scope.whole
    remark = say("no roll-off up to {frequency:.6g} Hz", frequency=rate / 2) if flat else say("not determined")
    return DataSheetRow(BANDWIDTH, None, None, None, "", None, remark)
