"""Units in which results are shown."""

from collections.abc import Sequence

from .units import SIGNALS, Signal, signal_with, unit_of


def shown_unit(signal: Signal, power: float, wanted: Sequence[str] = ()) -> str:
    """The unit in which signal x time^power is shown: that of data sheets, or what the `wanted` units say.

    A wanted unit of this very quantity is taken as it is; one of the signal itself is carried over.

    Examples
    --------
    >>> from .units import signal_named
    >>> gyro = signal_named("gyro")
    >>> shown_unit(gyro, 0.5), shown_unit(gyro, 0.5, ["deg/s"]), shown_unit(gyro, 0.5, ["rad/sqrt(s)"])
    ('deg/sqrt(h)', 'deg/s/sqrt(Hz)', 'rad/sqrt(s)')
    """
    for unit in wanted:
        if signal_with(unit_of(unit).dimension, power, values=True) is signal:
            return unit
    for unit in wanted:
        if unit_of(unit).dimension == signal.dimension and unit != signal.sheet[0]:
            return _carried(unit, power)
    return signal.sheet[power]


def _carried(unit: str, power: float) -> str:
    """The unit of a signal times time to a power, as it is written: deg/s becomes deg/s^2."""
    if unit.endswith("/s") and power in (1, -1):
        return unit.removesuffix("/s") + ("" if power == 1 else "/s^2")
    return unit + {1: "*s", 0.5: "/sqrt(Hz)", 0: "", -0.5: "/sqrt(s)", -1: "/s"}[power]


def readable_unit(unit: str) -> str:
    """The data-sheet unit for an SI unit; any other unit is unchanged.

    Examples
    --------
    >>> readable_unit("rad/s"), readable_unit("m/s^2"), readable_unit("deg/s")
    ('deg/h', 'ug', 'deg/s')
    """
    sheets = (signal.sheet[power] for signal in SIGNALS for power, si in signal.si.items() if si == unit)
    return next(sheets, unit)
