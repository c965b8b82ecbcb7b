"""The contents of a TDMS file, read with npTDMS; started by `worker`."""

import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from nptdms import TdmsFile

MOST_CHANNELS = 10_000  # maximum number of channels that are listed
BLOCK = 1 << 20
UNITS = ("unit_string", "NI_UnitDescription", "unit", "units", "Unit")


def opened(path: str, most: int, names: dict[str, Any]) -> tuple[dict[str, Any], Callable[..., Any]]:
    """The channels with their units and time steps, and a function that sends one; see `worker.main`."""
    file = TdmsFile.open(open(path, "rb"))  # noqa: SIM115  by name it would also open an index beside the file
    channels = [channel for group in file.groups() for channel in group.channels()][:MOST_CHANNELS]
    made = {f"{i}": channel for i, channel in enumerate(channels)}
    datasets = []
    for where, channel in made.items():
        about = channel.properties
        unit = next((about[name] for name in UNITS if isinstance(about.get(name), str) and about[name]), "")
        stated = map(about.get, ("wf_increment", "wf_start_offset"))
        step, start = (float(n) if isinstance(n, (int, float, np.number)) and np.isfinite(n) else 0.0 for n in stated)
        fields = [["", np.dtype(channel.dtype).str, ()]]
        item = {"path": where, "group": channel.group_name, "name": channel.name, "shape": [len(channel)]}
        datasets.append(item | {"unit": unit, "fields": fields, "step": step, "start": start})
    return {"datasets": datasets}, lambda where, fields: (
        len(made[where]) * made[where].dtype.itemsize,
        _blocks(made[where]),
    )


def _blocks(channel: Any) -> Iterator[Any]:
    for start in range(0, len(channel), BLOCK):
        values = np.ascontiguousarray(channel.read_data(start, min(BLOCK, len(channel) - start)))
        if len(values) != min(BLOCK, len(channel) - start) or values.dtype != channel.dtype:
            sys.exit(f"channel {channel.name!r} claims {len(channel)} samples, but has {start + len(values)}")
        yield values.view(np.uint8).data
