"""ROS bags: ROS 1 .bag, ROS 2 sqlite3 .db3 and MCAP .mcap, or the folder that ROS 2 records.

One topic is read. Its columns are the numbers in its messages, with the units that the message type prescribes; the
stamp of a header and the time at which the bag received a message are candidates for the clock.
"""

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError
from allanite.core.record import Recording
from allanite.phrases.phrase import say, spelled
from allanite.readers.columns import headers
from allanite.readers.columns.column import FileColumn, numbers, some
from allanite.readers.columns.containers import Stream, any_inertial, arranged_stream, mean_rate, stream_recording
from allanite.readers.columns.lines import HEAD_ROWS, Parts
from allanite.readers.columns.table import FileTable
from allanite.readers.options import Options
from allanite.readers.sandbox.process import Process, demand_size, worded
from allanite.readers.sandbox.source import head_of

from .registry import ZSTD

TITLE = "ROS bags .bag, .db3 and .mcap (needs rosbags)"

_AXIS = re.compile(r"(?:.*\.)?(angular_velocity|linear_acceleration)\.([xyz])")
_LETTERS = {"angular_velocity": "g", "linear_acceleration": "a"}


def read(path: str, options: Options) -> Recording:
    """The channels of one topic of a bag; `options.channels` may name the topic."""
    _demand_bag(path)
    with Process("bag", path, options.progress) as process:
        with worded():
            topics = [_topic(item) for item in process.contents["topics"]]
            streams = [_stream(topic, [other.name for other in topics], path, process) for topic in topics]
        return stream_recording(streams, options)


def parts(path: str, options: Options) -> Parts:
    """The messages of one topic, which are decoded one part after the other."""
    _demand_bag(path)
    with Process("bag", path) as process, worded():
        topics = [_topic(item) for item in process.contents["topics"]]
    names = [topic.name for topic in topics]
    streams = {stream.name: (stream, topic) for topic in topics for stream in (_stream(topic, names, path),)}
    stream, table, options = arranged_stream([stream for stream, _ in streams.values()], options)
    topic = streams[stream.name][1]
    order = [*list(topic.units)[1:], next(iter(topic.units))]

    def blocks(wanted: Sequence[int], rows: int) -> Iterator[list[NDArray[Any]]]:
        for values in _blocks(topic, path, rows):
            yield [values[order[i]] for i in wanted]

    return Parts(table, topic.count, blocks, options)


def _blocks(topic: "_Topic", path: str, rows: int) -> Iterator[dict[str, NDArray[Any]]]:
    """The numbers of so many messages at a time, in the order in which they were received."""
    demand_size(topic.count * topic.dtype.itemsize, path, f"topic {topic.name!r}")
    first, last = next(iter(topic.units)), None
    with Process("bag", path) as process:
        for part in process.parts(f"{topic.name} ({topic.type})", (topic.count,), topic.dtype, rows):
            values = _ordered({name: part[name] for name in topic.units})
            if last is not None and values[first][0] < last:
                raise DataError(say("messages of {topic} are stored before earlier ones, over more than a part of the "
                                    "bag; sort it (rosbag, ros2 bag convert, mcap sort), or read it as a whole with "
                                    "{option}", topic=topic.name, option=spelled("--memory", "memory=")))  # fmt: skip
            last = values[first][-1]
            yield values


def _demand_bag(path: str) -> None:
    if head_of(path).startswith(ZSTD) and not os.path.isdir(path):
        raise DataError(say("the file is compressed with zstd; of a ROS 2 bag, give the folder that holds it and its "
                            "metadata.yaml; unpack any other file with zstd -d"))  # fmt: skip


@dataclass(frozen=True)
class _Topic:
    """A topic: type, number of messages, seconds between the first and the last, and names and units of its columns."""

    name: str
    type: str
    count: int
    span: float
    dtype: np.dtype[Any]  # of a row
    units: dict[str, str]
    unread: tuple[str, ...]  # fields
    beside: tuple[str, ...]  # files of definitions used
    why: str  # there are no columns

    @property
    def fits(self) -> int:
        """2 if some numbers have the unit of an inertial sensor, 1 if some have its name, otherwise 0."""
        if any(map(headers.inertial, self.units.values())):
            return 2
        return int(any_inertial(name.rpartition(".")[2] for name in self.units))

    @property
    def called(self) -> dict[str, str]:
        """Other names of columns; the angular rate and specific force of a single sensor are called gx to az."""
        axes = {name: _LETTERS[match[1]] + match[2] for name in self.units if (match := _AXIS.fullmatch(name))}
        axes = axes if len(set(axes.values())) == len(axes) else {}
        return axes | {name: "seq" for name in self.units if name.endswith("header.seq")}


def _topic(item: Mapping[str, Any]) -> _Topic:
    columns = [(str(name), str(kind), str(unit)) for name, kind, unit in item["columns"]]
    dtype = np.dtype([(name, kind) for name, kind, _ in columns])
    about = (str(item["topic"]), str(item["type"]), max(0, int(item["count"])), float(item["span"]))
    units = {name: unit for name, _, unit in columns}
    return _Topic(*about, dtype, units, tuple(item["left"]), tuple(item.get("beside", ())), str(item["why"]))


def _stream(topic: _Topic, names: Sequence[str], path: str, process: Process | None = None) -> Stream:
    """The stream of a topic, with its type in the name if messages of several types have the same topic."""
    # Without a process its table is that of the first messages.

    def load() -> FileTable:
        if process is None:
            return _table(topic, next(_blocks(topic, path, HEAD_ROWS)))
        demand_size(topic.count * topic.dtype.itemsize, process.path, f"topic {topic.name!r}")
        return _table(topic, _ordered(process.fields(f"{topic.name} ({topic.type})", topic.count, topic.dtype)))

    return Stream(
        topic.name if names.count(topic.name) == 1 else f"{topic.name}/{topic.type}",
        topic.count, (*topic.units, *topic.called.values()), load, mean_rate(topic.count, topic.span), topic.fits,
        topic.type, topic.why,
    )  # fmt: skip


def _ordered(values: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """The numbers of messages in the order in which they were received, the time of which is the first column."""
    received = next(iter(values.values()))
    if np.any(received[1:] < received[:-1]):
        order = np.argsort(received, kind="stable")
        values = {name: column[order] for name, column in values.items()}
    return values


def _table(topic: _Topic, values: dict[str, NDArray[Any]]) -> FileTable:
    """The numbers of messages."""
    first, *others = topic.units
    columns = []
    # the receive time comes last: of two clocks that are equally steady, the stamp of the header is the better one
    for i, name in enumerate((*others, first), 1):
        unit = topic.units[name]
        kind = "rate" if headers.inertial(unit) else ""
        called, samples = topic.called.get(name, name), numbers(values.pop(name), name)
        columns.append(FileColumn(samples, i, called, unit, kind, header=name))
    units = ", ".join(sorted(set(filter(headers.inertial, topic.units.values())), reverse=True))
    notes = (
        (units, say("{units} by the definition of the message", units=units)),
        (topic.beside, say("defined by {files} beside the bag", files=", ".join(topic.beside))),
        (topic.unread, say("left out, no signal or of no fixed number: {left}", left=some(topic.unread))),
    )
    return FileTable(tuple(columns), notes=tuple(note for names, note in notes if names))
