"""What the user says about a file, checked once at the door."""

import math
from dataclasses import dataclass
from typing import Any

from allanite.errors import UsageError
from allanite.record import KINDS, explain_kinds
from allanite.units import unit_of


@dataclass(frozen=True)
class Options:
    """What the user says about a file; None leaves the question to the file.

    Parameters
    ----------
    rate : float, optional
        Sampling rate, Hz.
    unit : str, optional
        Unit of the readings (of `scale` where one is given).
    kind : str, optional
        What a reading is: a key of `record.KINDS`.
    scale : float, optional
        Worth of one step of the readings in `unit`.
    channels : sequence of str, optional
        Names of columns, or their places counted from 1.
    time : str, optional
        The time column, as ``"stamp"``, ``"1"`` or ``"stamp[us]"``; ``"none"``: use none.

    Raises
    ------
    UsageError
        A value is impossible.
    """

    rate: float | None = None
    unit: str | None = None
    kind: str | None = None
    scale: float | None = None
    channels: tuple[str, ...] | None = None
    time: str | None = None

    def __post_init__(self) -> None:
        _demand_positive(self.rate, "the sampling rate", "Hz", "rate=100 (--rate 100)")
        _demand_positive(self.scale, "the scale", "the unit of the readings", "scale=0.1 (--scale 0.1)")
        if self.kind is not None and self.kind not in KINDS:
            raise UsageError(f"unknown kind {self.kind!r}; {explain_kinds()}")
        if self.unit is not None:
            object.__setattr__(self, "unit", _demand_text(self.unit, "unit", "'deg/s'").strip())
            unit_of(self.unit)
        if self.time is not None:
            _demand_text(self.time, "time", "'stamp[us]', '1' or 'none'")


def _demand_positive(value: Any, what: str, unit: str, example: str) -> None:
    if value is None:
        return
    try:
        fine = not isinstance(value, (bool, str)) and math.isfinite(value) and value > 0
    except (TypeError, OverflowError):
        fine = False
    if not fine:
        raise UsageError(f"{what} must be a positive number of {unit}, not {value!r}; for example {example}")


def _demand_text(value: Any, option: str, example: str) -> str:
    if not isinstance(value, str) or not value.strip():
        raise UsageError(f"{option} must be a text such as {example}, not {value!r}")
    return value


def channel_names(channels: Any) -> tuple[str, ...] | None:
    """The chosen channels; a lone text is read as the command line writes it, with commas."""
    if channels is None:
        return None
    if isinstance(channels, str):
        channels = channels.split(",")
    try:
        names = tuple(str(name).strip() for name in channels)
    except TypeError:
        raise UsageError(f"channels must be names or column numbers, not {channels!r}") from None
    if not names or not all(names):
        raise UsageError(
            "no channel is chosen; give names or column numbers, for example channels=['gx', '2'], or leave it out"
        )
    if len(set(names)) < len(names):
        raise UsageError(f"a channel is chosen twice: {', '.join(names)}")
    return names
