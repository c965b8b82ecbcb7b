"""What the user states about a file, checked once."""

import math
import re
from dataclasses import dataclass
from typing import Any, Protocol

from allanite.core.errors import UsageError
from allanite.core.record import KINDS, explain_kinds
from allanite.core.units import unit_of
from allanite.core.wording import spelled

_WORTH = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S.*?)?\s*")
"""A number, optionally followed by a unit."""


class Frame(Protocol):
    """A table in memory: ``frame[name].to_numpy()`` is the column of each of the names in `columns`."""

    @property
    def columns(self) -> Any:
        """Names of the columns."""

    def __getitem__(self, name: Any, /) -> Any:
        """A column."""


@dataclass(frozen=True)
class Options:
    """What the user states about a file, as in `allanite.readers.read`; None takes it from the file.

    A `scale` such as ``"0.01deg/s"`` becomes a number and a unit.
    """

    rate: float | None = None
    unit: str | None = None
    kind: str | None = None
    scale: float | str | None = None
    channels: tuple[str, ...] | None = None
    along: tuple[str, ...] | None = None
    time: str | None = None
    dtype: str | None = None
    columns: int | None = None
    offset: int | None = None
    otherwise: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if isinstance(self.scale, str):
            worth, unit = _worth(self.scale, self.unit)
            object.__setattr__(self, "scale", worth)
            object.__setattr__(self, "unit", unit)
        _demand_positive(self.rate, "the sampling rate", "Hz", spelled("--rate 100", "rate=100"))
        _demand_positive(self.scale, "the scale", "the unit of the samples", spelled("--scale 0.1", "scale=0.1"))
        if self.kind is not None and self.kind not in KINDS:
            raise UsageError(f"unknown kind {self.kind!r}; {explain_kinds()}")
        if self.unit is not None:
            object.__setattr__(self, "unit", _demand_text(self.unit, "unit", "'deg/s'").strip())
            unit_of(self.unit)
        if self.time is not None:
            _demand_text(self.time, "time", "'stamp[us]', '1' or 'none'")
        if self.dtype is not None:
            object.__setattr__(self, "dtype", _demand_text(self.dtype, "dtype", "'i2', '>i2' or 'f4'").strip())
        _demand_whole(self.columns, 1, spelled("--columns 6", "columns=6") + " for rows of six numbers")
        _demand_whole(self.offset, 0, spelled("--offset 512", "offset=512") + " for a header of 512 bytes")
        if self.dtype is None and (self.columns, self.offset) != (None, None):
            raise UsageError(
                f"columns and offset describe raw binary; give the type of its numbers with "
                f"{spelled('--dtype i2', 'dtype=...')}"
            )

    @property
    def worth(self) -> float | None:
        """Scale factor per count, in `unit`."""
        return None if self.scale is None else float(self.scale)


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


def _demand_whole(value: Any, least: int, example: str) -> None:
    if value is not None and (isinstance(value, bool) or not isinstance(value, int) or value < least):
        raise UsageError(f"expected a whole number of at least {least}, not {value!r}; for example {example}")


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
