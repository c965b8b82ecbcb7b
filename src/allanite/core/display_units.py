"""Units in which results are shown."""

from collections.abc import Sequence
from functools import cache

from allanite.terms import TERMS

from .ranges import times
from .units import SIGNALS, Signal, signal_with, unit_of


def shown_unit(signal: Signal, power: float, wanted: Sequence[str] = ()) -> str:
    """The unit in which signal x time^power is shown: that of data sheets, or what the `wanted` units say."""
    # A wanted unit of this very quantity is taken as it is; one of the signal itself is carried over.
    for unit in wanted:
        if signal_with(unit_of(unit).dimension, power, values=True) is signal:
            return unit
    for unit in wanted:
        if unit_of(unit).dimension == signal.dimension and unit_of(unit) != unit_of(signal.sheet[0]):
            return f"{unit}/sqrt(Hz)" if power == 0.5 else times(unit, power)  # white noise as a density
    return signal.sheet[power]


def showing(unit: str) -> list[Signal]:
    """The signals of which a coefficient has this unit."""
    dimension = unit_of(unit).dimension
    signals = (signal_with(dimension, power, values=True) for power in {row.power for row in TERMS.values()})
    return sorted(filter(None, signals), key=SIGNALS.index)


@cache
def readable_unit(unit: str) -> str:
    """The data-sheet unit for an SI unit; any other unit is unchanged."""
    sheets = (signal.sheet[row.power] for signal in SIGNALS for row in TERMS.values() if signal.si[row.power] == unit)
    return next(sheets, unit)
