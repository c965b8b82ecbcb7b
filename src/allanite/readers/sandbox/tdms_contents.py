"""The contents of a TDMS file, read with npTDMS; started by `worker`."""

import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from nptdms import TdmsFile

MOST = 10_000
"""Maximum number of channels that are listed."""
BLOCK = 1 << 20
UNITS = ("unit_string", "NI_UnitDescription", "unit", "units", "Unit")


def opened(path: str, most: int, names: dict[str, Any]) -> tuple[dict[str, Any], Callable[..., Any]]:
    """The channels with their units and time steps, and a function that sends one; see `worker.main`."""
    file = TdmsFile.open(open(path, "rb"))  # noqa: SIM115  by name it would also open an index beside the file
    channels = [channel for group in file.groups() for channel in group.channels()][:MOST]
    made = {f"{i}": channel for i, channel in enumerate(channels)}
    said = {"datasets": [_said(where, channel) for where, channel in made.items()]}
    return said, lambda where, fields: (len(made[where]) * made[where].dtype.itemsize, _blocks(made[where]))


def _said(where: str, channel: Any) -> dict[str, Any]:
    """Place, group, name, length, type, and from its properties unit, time step and offset of a channel."""
    about = channel.properties
    unit = next((about[name] for name in UNITS if isinstance(about.get(name), str) and about[name]), "")
    step, start = (_number(about.get(name)) for name in ("wf_increment", "wf_start_offset"))
    said = {"path": where, "group": channel.group_name, "name": channel.name, "shape": [len(channel)], "unit": unit}
    return said | {"fields": [["", np.dtype(channel.dtype).str, ()]], "step": step, "start": start}


def _number(value: Any) -> float:
    return float(value) if isinstance(value, (int, float, np.number)) and np.isfinite(value) else 0.0


def _blocks(channel: Any) -> Iterator[Any]:
    for start in range(0, len(channel), BLOCK):
        values = np.ascontiguousarray(channel.read_data(start, min(BLOCK, len(channel) - start)))
        if len(values) != min(BLOCK, len(channel) - start) or values.dtype != channel.dtype:
            sys.exit(f"channel {channel.name!r} claims {len(channel)} samples, but has {start + len(values)}")
        yield values.view(np.uint8).data
