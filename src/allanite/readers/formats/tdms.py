"""TDMS files of LabVIEW and DIAdem: channels of a group that have one length and time step."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from allanite.core.record import Recording
from allanite.phrases.phrase import say
from allanite.readers.columns.column import column
from allanite.readers.columns.containers import Stream, any_inertial, stream_recording
from allanite.readers.columns.table import FileTable
from allanite.readers.options import Options
from allanite.readers.sandbox.process import Process, demand_size, worded

TITLE = "LabVIEW TDMS (needs npTDMS)"

Item = Mapping[str, Any]


def read(path: str, options: Options) -> Recording:
    """The channels of a group, with units and time step from the properties of the channels."""
    with Process("tdms", path, options.progress) as process:
        with worded():
            # the channels of a group with one length and time step; if there are several, each has a number
            groups: dict[tuple[str, int, float], list[Item]] = {}
            for item in process.contents["datasets"]:
                length = int(item["shape"][0])
                if np.dtype(str(item["fields"][0][1])).kind in "iufM" and length > 1:
                    groups.setdefault((str(item["group"]), length, float(item["step"])), []).append(item)
            names, streams = [group for group, _, _ in groups], list[Stream]()
            for (group, length, step), own in groups.items():
                number = sum(stream.name.startswith(f"{group}/") for stream in streams) + 1
                name = f"{group}/{number}" if names.count(group) > 1 else group
                load = partial(_table, own, process, length, step)
                columns = tuple(str(item["name"]) for item in own)
                fits = any_inertial(columns, (str(item["unit"]) for item in own))
                streams.append(Stream(name, length, columns, load, 1 / step if step > 0 else None, fits))
        return stream_recording(streams, options)


def _table(items: Sequence[Item], process: Process, length: int, step: float) -> FileTable:
    """The channels of a stream, which are loaded when they are wanted."""
    columns = []
    for place, item in enumerate(items, 1):
        dtype = np.dtype(str(item["fields"][0][1]))
        demand_size(length * dtype.itemsize, process.path, f"channel {item['name']!r}")
        values = process.load(str(item["path"]), (length,), dtype)
        columns.append(column(str(item["name"]), values, place, unit=str(item["unit"])))
    rate = 1 / step if step > 0 else None
    start = float(items[0]["start"]) if rate else None
    return FileTable(tuple(columns), rate, str(say("the property wf_increment of the channels")), (), start)
