"""What the user states about a file, checked once."""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

from allanite.core.choices import INTEGER
from allanite.core.errors import UsageError
from allanite.core.kinds import KINDS
from allanite.core.names import demand_name
from allanite.core.ranges import Range
from allanite.core.units import latin, signal_with, unit_of
from allanite.phrases.phrase import spelled

_WORTH = re.compile(r"\s*([-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S.*?)?\s*")
"""A number, optionally followed by a unit."""


RAW = {"columns": Range(1, 1e6), "offset": Range(0, 2**63 - 1, "bytes")}
"""Of raw binary: numbers per row, and bytes before the first one."""

KINDS_OF_SENSORS = {
    "gyro": "gyro", "gyros": "gyro", "gyroscope": "gyro", "accel": "accelerometer", "acc": "accelerometer",
    "accelerometer": "accelerometer", "accelerometers": "accelerometer",
}  # fmt: skip
"""Words for all gyros or all accelerometers of a file."""


@runtime_checkable
class FrameLike(Protocol):
    """A table in memory: ``frame[name].to_numpy()`` is the column of each of the names in `columns`."""

    @property
    def columns(self) -> Any:
        """Names of the columns."""

    def __getitem__(self, name: Any, /) -> Any:
        """A column."""


@dataclass(frozen=True)
class Options:
    """What the user states about a file, as in `allanite.readers.read`; None takes it from the file."""

    rate: float | None = None
    unit: str | None = None
    kind: str | None = None
    scale: float | str | None = None  # such as "0.01deg/s" becomes a number and a unit
    channels: tuple[str, ...] | None = None
    along: tuple[str, ...] | None = None
    time: str | None = None
    dtype: str | None = None
    columns: int | None = None
    offset: int | None = None
    sincos: tuple[str, ...] | None = None
    otherwise: tuple[str, ...] = ()
    units: tuple[tuple[str, str], ...] = ()  # of "gyro=deg/s,accel=g", by the name of a sensor or the key of a column
    # called with the share, 0 to 1, of the file that has been read
    progress: Callable[[float], None] | None = field(default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        if self.unit is not None:
            stated = stated_unit(self.unit)
            object.__setattr__(self, "units", parts_of(stated))
            object.__setattr__(self, "unit", None if self.units else stated)
        if isinstance(self.scale, str):
            worth, unit = _worth(self.scale, self.unit)
            object.__setattr__(self, "scale", worth)
            object.__setattr__(self, "unit", unit)
        _demand_positive(self.rate, "the sampling rate", "Hz", spelled("--rate 100", "rate=100"))
        _demand_positive(self.scale, "the scale", "the unit of the samples", spelled("--scale 0.1", "scale=0.1"))
        if self.kind is not None:
            demand_name("kind", self.kind, KINDS)
        _demand_units(self)
        if self.time is not None:
            _demand_text(self.time, "time", "'stamp[us]', '1' or 'none'")
        if self.dtype is not None:
            object.__setattr__(self, "dtype", _demand_text(self.dtype, "dtype", "'i2', '>i2' or 'f4'").strip())
        for name, within in RAW.items():
            if (value := getattr(self, name)) is not None:
                within.demand(INTEGER.demand(name, value), name)
        if self.dtype is None and (self.columns, self.offset) != (None, None):
            raise UsageError("columns and offset describe raw binary; give the type of its numbers with "
                             f"{spelled('--dtype i2', 'dtype=...')}")  # fmt: skip

        if self.sincos is not None:
            self._demand_sincos(self.sincos)

    def _demand_sincos(self, names: tuple[str, ...]) -> None:
        """Take the columns of sines and cosines as the channels, which nothing else may describe."""
        option = spelled("--sincos", "sincos")
        if len(names) % 2:
            raise UsageError(f"{option} takes pairs of columns, the sine first, for example "
                             f"{spelled('--sincos sin,cos', 'sincos=[' + repr('sin') + ', ' + repr('cos') + ']')}, not "
                             f"{', '.join(names)}")  # fmt: skip
        for word, value in (("channels", self.channels), ("unit", self.unit), ("scale", self.scale)):
            if value is not None:
                raise UsageError(f"{option} gives an angle in rad, so that {spelled('--' + word, word)} has no meaning")
        if self.kind not in (None, "value", "angle"):
            raise UsageError(f"{option} gives an angle: its kind is 'value' if the angle itself is analyzed, or "
                             f"'angle' if its rate is, not {self.kind!r}")  # fmt: skip
        object.__setattr__(self, "channels", names)

    @property
    def worth(self) -> float | None:
        """Scale factor per count, in `unit`."""
        return None if self.scale is None else float(self.scale)


def stated_unit(unit: Any) -> str:
    """A unit, or several by sensor or channel, as one text; a mapping becomes ``"gyro=deg/s,accel=g"``."""
    if not isinstance(unit, Mapping):
        text = _demand_text(unit, "unit", "'deg/s' or 'gyro=deg/s,accel=g'").strip()
        return text if "=" in text else latin(text)
    for key, value in unit.items():
        _demand_text(value, f"the unit of {key!r}", "'deg/s'")
        if not isinstance(key, str) or not key.strip() or set(key) & set(",="):
            raise UsageError(f"units are given by 'gyro', 'accel', or the name or number of a column, not by {key!r}; "
                             "a column with a comma or = in its name is given by its number")  # fmt: skip
    if not unit:
        raise UsageError("no unit is given; for example unit={'gyro': 'deg/s', 'accel': 'g'}")
    return ",".join(f"{key.strip()}={value.strip()}" for key, value in unit.items())


def parts_of(unit: str) -> tuple[tuple[str, str], ...]:
    """The units by sensor or column; empty if there is one for all."""
    if "=" not in unit:
        return ()
    pairs = [tuple(word.strip() for word in part.partition("=")[::2]) for part in unit.split(",")]
    for key, value in pairs:
        if not key or not value:
            example = spelled("--unit gyro=deg/s,accel=g", "unit='gyro=deg/s,accel=g'")
            raise UsageError(f"{unit!r} does not give each sensor or column a unit; for example {example}")
    names = [KINDS_OF_SENSORS.get(key.lower(), key) for key, _ in pairs]
    again = next((name for i, name in enumerate(names) if name in names[:i]), None)
    if again is not None:
        raise UsageError(f"{unit!r} gives {again} two units; give it one")
    return tuple(zip(names, (latin(value) for _, value in pairs), strict=True))


def _demand_units(options: Options) -> None:
    """Refuse a unit that is unknown, or not one of its sensor, and a scale for several units."""
    for unit in (options.unit,) if options.unit else (value for _, value in options.units):
        unit_of(unit)
    for name, unit in options.units:
        size = unit_of(unit).dimension
        signal = signal_with(size) or signal_with(size, 1)
        if name in KINDS_OF_SENSORS.values() and (signal is None or signal.name != name):
            example = spelled("--unit gyro=deg/s,accel=g", "unit={'gyro': 'deg/s', 'accel': 'g'}")
            raise UsageError(f"{unit!r} is not a unit of a {name}; for example {example}")
    if options.unit and options.units:
        why = f"the scale is in {options.unit!r}, but units are given by sensor or channel"
        raise UsageError(f"{why}; give the scale as a number")
    if options.scale is not None and len({unit for _, unit in options.units}) > 1:
        option = spelled("--channels", "channels=...")
        raise UsageError(
            f"one scale cannot belong to several units; read the channels of each by themselves with {option}"
        )


def _worth(text: str, unit: str | None) -> tuple[float | str, str | None]:
    """Number and unit of a scale such as ``0.01deg/s``; anything else is refused later."""
    match = _WORTH.fullmatch(text)
    if match is None:
        return text, unit
    if match[2] and unit is not None and unit.strip() != match[2]:
        raise UsageError(
            f"the scale {text!r} contradicts {spelled(f'--unit {unit}', f'unit={unit!r}')}; give the unit once"
        )
    return float(match[1]), match[2] or unit


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
    """The selected channels; a single text is split at commas, as at the command line."""
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
            "no channel is selected; give names or column numbers, for example "
            + spelled("--channels gx,2", "channels=['gx', '2']")
            + ", or omit it"
        )
    if len(set(names)) < len(names):
        raise UsageError(f"a channel is selected twice: {', '.join(names)}")
    return names
