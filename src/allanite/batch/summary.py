"""Mean, spread and worst of a coefficient over units."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from allanite.core.plain import Value
from allanite.core.readings import MINIMUM
from allanite.core.units import Signal, convert
from allanite.study.results import Channel
from allanite.terms import TERMS


@dataclass(frozen=True, repr=False)
class Coefficient(Value):
    """The coefficient of a channel: what everything that is found of it over several units has in common."""

    channel: str
    symbol: str
    signal: Signal

    @property
    def sheet_unit(self) -> str:
        """Unit of data sheets."""
        return self.signal.sheet[power_of(self.symbol)]

    @property
    def factor(self) -> float:
        """SI units in one unit of data sheets."""
        return convert(1.0, self.sheet_unit, self.signal.si[power_of(self.symbol)])


@dataclass(frozen=True, repr=False)
class Across(Coefficient):
    """One coefficient of one channel over all units, SI.

    Attributes
    ----------
    channel, symbol, signal
        Whose it is; "minimum" is the minimum of the Allan deviation.
    units : int
        Units with a valid result for it, identified or not.
    identified : int
        Units with a value; the numbers that follow are theirs.
    mean, deviation : float
        Mean of the values, and their standard deviation from unit to unit; NaN of a single one. It contains the
        statistical error of each value.
    worst : float
        The value of the largest size.
    file : str
        The unit it belongs to.
    below : float or None
        The largest upper limit of the units in which the term was not identified.
    """

    units: int
    identified: int
    mean: float
    deviation: float
    worst: float
    file: str
    below: float | None = None

    def row(self) -> list[Any]:
        """Channel, term, numbers of units, mean, spread, worst and its file, upper limit, unit: of data sheets."""
        shown = [v / self.factor for v in (self.mean, self.deviation, self.worst)]
        below = math.nan if self.below is None else self.below / self.factor
        return [self.channel, self.symbol, self.units, self.identified, *shown, self.file, below, self.sheet_unit]

    def _summary(self) -> str:
        return f"{self.channel!r}: {self.symbol}, {self.identified} of {self.units} units"


def power_of(symbol: str) -> float:
    """The power of time in the unit of a coefficient, or of the minimum of the deviation."""
    return 0 if symbol == MINIMUM else TERMS[symbol].power


class Known(NamedTuple):
    """What is known of a coefficient of one unit: its value, or its upper limit."""

    file: str
    value: float | None
    upper: float | None


def gathered(
    channels: Iterable[tuple[str, Channel]], level: float, *, valued: bool = False
) -> list[tuple[tuple[str, str, Signal], list[Known]]]:
    """Channel, symbol and signal of every coefficient, with what is known of it over units."""
    results: dict[tuple[str, str, str], tuple[tuple[str, str, Signal], list[Known]]] = {}
    for file, channel in channels:
        name, signal = channel.record.name, channel.record.signal
        known: list[tuple[str, float | None, float | None]] = [
            (e.symbol, e.value, None) if e.valued else (e.symbol, None, e.upper)
            for e in channel.fit or ()
            if e.valued or e.status == "absent"
        ]
        minimum = None if channel.readings is None else channel.readings.minimum
        if channel.readings is not None and minimum is not None:
            inside, most = channel.readings.inside, minimum.interval(level)[1]
            known.append((MINIMUM, minimum.deviation, None) if inside else (MINIMUM, None, most))
        for symbol, value, upper in known:
            if value is not None or not valued:
                _, units = results.setdefault((name, signal.name, symbol), ((name, symbol, signal), []))
                units.append(Known(file, value, upper))
    return list(results.values())


def across(channels: Iterable[tuple[str, Channel]], level: float) -> tuple[Across, ...]:
    """Every coefficient of every channel over units; see `gathered`."""
    results = []
    for of, units in gathered(channels, level):
        values = np.array([unit.value for unit in units if unit.value is not None], dtype=np.float64)
        mean, spread, worst, file = math.nan, math.nan, math.nan, ""
        if values.size:
            at = int(np.argmax(np.abs(values)))
            mean, worst = float(values.mean()), float(values[at])
            spread = float(values.std(ddof=1)) if values.size > 1 else math.nan
            file = [unit.file for unit in units if unit.value is not None][at]
        below = max((unit.upper for unit in units if unit.value is None and unit.upper is not None), default=None)
        results.append(Across(*of, len(units), values.size, mean, spread, worst, file, below))
    return tuple(results)
