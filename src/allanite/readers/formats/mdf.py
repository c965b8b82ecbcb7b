"""MDF files of ASAM, versions 3 and 4: the channels that have common time stamps."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from allanite.core.record import Recording
from allanite.phrases.phrase import say
from allanite.readers.columns.column import column, some
from allanite.readers.columns.containers import Stream, any_inertial, mean_rate, stream_recording
from allanite.readers.columns.table import FileTable
from allanite.readers.options import Options
from allanite.readers.sandbox.process import Process, demand_size, worded

TITLE = "ASAM MDF 3 and 4 .mf4 (needs asammdf)"

Item = Mapping[str, Any]


def read(path: str, options: Options) -> Recording:
    """The channels of a group, or of several with the same time stamps; formulas of the file are not evaluated."""
    with Process("mdf", path, options.progress) as process:
        with worded():
            # the channels with common time stamps, named after the first group that has them
            groups: dict[str, list[Item]] = {}
            for item in process.contents["datasets"]:
                groups.setdefault(str(item["clock"]) or f"group {item['group']}", []).append(item)
            titles = [str(own[0]["title"]) for own in groups.values()]
            streams = []
            for title, own in zip(titles, groups.values(), strict=True):
                name = title if title and titles.count(title) == 1 else f"group {own[0]['group']}"
                streams.append(_stream(name, own, process))
            names = [str(name) for name in process.contents["left"]]
        omitted = say("left out, no numbers, or numbers converted by a formula: {names}", names=some(names))
        notes = [omitted] if names else []
        return stream_recording(streams, options, notes)


def _stream(name: str, items: Sequence[Item], process: Process) -> Stream:
    """The stream of channels with common time stamps."""
    length, names = int(items[0]["length"]), tuple(str(item["name"]) for item in items)
    likely = any_inertial(names, (str(item["unit"]) for item in items))
    rate = mean_rate(length, float(items[0]["span"]))
    return Stream(name, length, names, partial(_table, items, length, process), rate, likely)


def _table(items: Sequence[Item], length: int, process: Process) -> FileTable:
    """Time stamps and samples."""
    demand_size(8 * length * (1 + len(items)), process.path, "the group")
    kind, shape = np.dtype(np.float64), (length,)
    columns = []
    if items[0]["clock"]:
        columns.append(column("time", process.load(str(items[0]["group"]), shape, kind), 1, unit="s"))
    for place, item in enumerate(items, 2):
        values = process.load(str(item["path"]), shape, kind)
        columns.append(column(str(item["name"]), values, place, unit=str(item["unit"])))
    return FileTable(tuple(columns))
