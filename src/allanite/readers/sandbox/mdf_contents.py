"""The contents of an MDF file (versions 3 and 4), read with asammdf; started by `worker`.

Samples are read as they are stored, and only linear conversions are applied: others are tables and formulas of the
file, and a formula would be evaluated as a program.
"""

import hashlib
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
from asammdf import MDF

MOST_CHANNELS = 5000  # maximum number of channels


def opened(path: str, most: int, names: dict[str, Any]) -> tuple[dict[str, Any], Callable[..., Any]]:
    """The channels of numbers with a hash of their times, and a function that sends one; see `worker.main`."""
    file: Any = MDF(path)
    if sum(len(group.channels) for group in file.groups) > MOST_CHANNELS:
        sys.exit(f"too many channels: more than {MOST_CHANNELS}; export those of the sensor as CSV")
    contents: dict[str, Any] = {"datasets": [], "left": []}
    for number, group in enumerate(file.groups):
        master = file.masters_db.get(number)
        if group.channel_group.cycles_nr < 2:
            continue
        if master is not None and _linear(file, group.channels[master]) is None:
            contents["left"].append(f"group {number}")
            continue
        title = getattr(group.channel_group, "acq_name", None) or ""
        about = {"group": number, "title": title, "clock": "", "span": 0.0}
        if master is not None:  # groups with common times are found by a hash of these
            times, claimed = _times(file, number), int(group.channel_group.cycles_nr)
            if times.size != claimed:
                sys.exit(f"group {number} claims {claimed} samples, but has {times.size}")
            span = float(times[-1] - times[0])
            about |= {"clock": hashlib.sha256(times.data).hexdigest(), "span": span if np.isfinite(span) else 0.0}
        for place, channel in enumerate(group.channels):
            if place != master:
                _list(contents, file, (number, place, channel), about)

    def load(where: str, fields: list[str]) -> tuple[int, list[Any]]:
        number, _, place = where.partition("/")
        values = _values(file, int(number), int(place)) if place else _times(file, int(number))
        return values.nbytes, [values.data]

    return contents, load


def _list(contents: dict[str, Any], file: Any, at: tuple[int, int, Any], about: dict[str, Any]) -> None:
    """Add a channel to the contents."""
    number, place, channel = at
    first = file.get(group=number, index=place, raw=True, samples_only=True, record_count=1)[0]
    if first.dtype.kind not in "iuf" or first.ndim != 1 or _linear(file, channel) is None:
        contents["left"].append(channel.name)
        return
    unit = file.get_channel_unit(group=number, index=place) or ""
    length = int(file.groups[number].channel_group.cycles_nr)
    own = {"path": f"{number}/{place}", "name": channel.name, "unit": unit, "length": length}
    contents["datasets"].append(about | own)


def _linear(file: Any, channel: Any) -> tuple[float, float] | None:
    """Factor and offset of the conversion of a channel; None if it is another one."""
    conversion = channel.conversion
    none, linear = (0, 1) if file.version >= "4.00" else (65535, 0)
    if conversion is None or conversion.conversion_type == none:
        return 1.0, 0.0
    return (float(conversion.a), float(conversion.b)) if conversion.conversion_type == linear else None


def _times(file: Any, number: int) -> Any:
    return np.ascontiguousarray(file.get_master(number), dtype=np.float64)


def _values(file: Any, number: int, place: int) -> Any:
    """The samples of a channel, NaN where they are marked as invalid."""
    raw, invalid = file.get(group=number, index=place, raw=True, samples_only=True)
    factor, offset = _linear(file, file.groups[number].channels[place]) or (1.0, 0.0)
    if raw.size != (claimed := int(file.groups[number].channel_group.cycles_nr)):
        sys.exit(f"a channel of group {number} claims {claimed} samples, but has {raw.size}")
    with np.errstate(all="ignore"):
        values = np.ascontiguousarray(raw.astype(np.float64) * factor + offset)
    if invalid is not None:
        values[np.asarray(invalid, dtype=bool)] = np.nan
    return values
