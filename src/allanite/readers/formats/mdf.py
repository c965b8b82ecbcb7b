"""MDF files of ASAM, versions 3 and 4: the channels that have common time stamps."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from allanite.core.record import Recording
from allanite.phrases.phrase import say
from allanite.readers.columns.arrays import column
from allanite.readers.columns.column import some
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
                streams.append(_Group(tuple(own), process).stream(name))
            names = [str(name) for name in process.contents["left"]]
        omitted = say("left out, no numbers, or numbers converted by a formula: {names}", names=some(names))
        notes = [omitted] if names else []
        return stream_recording(streams, options, notes)


@dataclass(frozen=True, eq=False)
class _Group:
    """Channels with common time stamps."""

    items: tuple[Item, ...]
    process: Process

    @property
    def length(self) -> int:
        """Number of samples."""
        return int(self.items[0]["length"])

    def stream(self, name: str) -> Stream:
        """The stream that loads them."""
        rate = mean_rate(self.length, float(self.items[0]["span"]))
        names = tuple(str(item["name"]) for item in self.items)
        fits = any_inertial(names, (str(item["unit"]) for item in self.items))
        return Stream(name, self.length, names, self.table, rate, fits)

    def table(self) -> FileTable:
        """Time stamps and samples."""
        demand_size(8 * self.length * (1 + len(self.items)), self.process.path, "the group")
        kind, shape = np.dtype(np.float64), (self.length,)
        columns = []
        if self.items[0]["clock"]:
            times = self.process.load(str(self.items[0]["group"]), shape, kind)
            columns.append(column("time", times, 1, unit="s"))
        for place, item in enumerate(self.items, 2):
            values = self.process.load(str(item["path"]), shape, kind)
            columns.append(column(str(item["name"]), values, place, unit=str(item["unit"])))
        return FileTable(tuple(columns))
