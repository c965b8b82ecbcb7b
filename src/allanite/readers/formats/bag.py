"""ROS bags: ROS 1 .bag, ROS 2 sqlite3 .db3 and MCAP .mcap, or the folder that ROS 2 records.

One topic is read. Its columns are the numbers in its messages, with the units that the message type prescribes; the
stamp of a header and the time at which the bag received a message are candidates for the clock.
"""

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError, UsageError
from allanite.core.language import say
from allanite.core.record import Recording
from allanite.core.wording import spelled
from allanite.readers.columns import headers
from allanite.readers.columns.arrays import numbers
from allanite.readers.columns.column import Column, some
from allanite.readers.columns.table import Table
from allanite.readers.options import Options
from allanite.readers.sandbox.guard import demand_size, worded
from allanite.readers.sandbox.process import Process
from allanite.readers.sandbox.source import head_of

TITLE = "ROS bags .bag, .db3 and .mcap (pip install 'allanite[ros]')"

_MAGIC = (b"#ROSBAG V", b"\x89MCAP0\r\n", b"SQLite format 3\0")
_PACKED = b"\x28\xb5\x2f\xfd"

_AXIS = re.compile(r"(?:.*\.)?(angular_velocity|linear_acceleration)\.([xyz])")
_LETTERS = {"angular_velocity": "g", "linear_acceleration": "a"}


def sniff(head: bytes, suffix: str) -> bool:
    """Whether the first bytes, or the name, are those of a bag."""
    return head.startswith((*_MAGIC, _PACKED)) or suffix in (".bag", ".db3", ".mcap")


@dataclass(frozen=True)
class Topic:
    """A topic: type, number of messages, approximate rate in Hz, and the name, type and unit of its columns.

    `why` says why there are none; `left` are the fields that are not read, `beside` the files of definitions used.
    """

    topic: str
    type: str
    count: int
    rate: float
    columns: tuple[tuple[str, str, str], ...]
    left: tuple[str, ...]
    why: str
    beside: tuple[str, ...]

    @property
    def dtype(self) -> np.dtype[Any]:
        """The type of a row."""
        return np.dtype([(name, kind) for name, kind, _ in self.columns])

    @property
    def likeness(self) -> int:
        """2 if some numbers have the unit of an inertial sensor, 1 if some have its name, otherwise 0."""
        if any(headers.inertial(unit) for _, _, unit in self.columns):
            return 2
        return int(any(headers.sensor_by_name(name.rpartition(".")[2]) for name, _, _ in self.columns))

    def __str__(self) -> str:
        rate = f", {self.rate:.4g} Hz" if self.rate else ""
        return f"{self.topic} ({self.type}, {self.count} messages{rate})"


def read(path: str, options: Options) -> Recording:
    """The channels of one topic of a bag; `options.channels` may name the topic."""
    _demand_bag(path)
    with Process("bag", path, {}) as process:
        with worded():
            topics = [_topic(item) for item in process.said["topics"]]
        topic, options = _chosen(topics, options)
        with worded():
            dtype = topic.dtype
        demand_size(topic.count * dtype.itemsize, process.path, f"topic {topic.topic!r}")
        rows = process.load(f"{topic.topic} ({topic.type})", (topic.count,), dtype)
    received = rows[topic.columns[0][0]]
    if np.any(received[1:] < received[:-1]):
        rows = rows[np.argsort(received, kind="stable")]
    return Table(tuple(_columns(topic, rows)), notes=tuple(_notes(topic, topics))).recording(options)


def _demand_bag(path: str) -> None:
    head = head_of(path)[:16]
    if head.startswith(_PACKED) and not os.path.isdir(path):
        raise DataError(
            "the file is compressed with zstd; of a ROS 2 bag, give the folder that holds it and its metadata.yaml; "
            "unpack any other file with zstd -d"
        )
    if not head.startswith((*_MAGIC, _PACKED)):
        raise DataError(
            f"the file does not begin like a ROS bag (it begins with {head[:8]!r}); check that it is complete"
        )


def _topic(said: dict[str, Any]) -> Topic:
    columns = tuple((str(name), str(kind), str(unit)) for name, kind, unit in said["columns"])
    about = (str(said["topic"]), str(said["type"]), max(0, int(said["count"])), float(said["rate"]))
    return Topic(*about, columns, tuple(said["left"]), str(said["why"]), tuple(said.get("beside", ())))


def _chosen(topics: Sequence[Topic], options: Options) -> tuple[Topic, Options]:
    """The topic named by the user, otherwise the only one that looks like a sensor's, and the options within it."""
    keys = options.channels or ()
    named = [topic for topic in topics if any(_within(topic, key) is not None for key in keys)]
    for key in keys:
        if key.startswith("/") and all(_within(topic, key) is None for topic in topics):
            raise UsageError(f"no topic {key!r} in the bag, which has {_listed(topics)}")
    if named:
        topic = _only(named, topics, "are named")
        columns = tuple(key if (inner := _within(topic, key)) is None else inner for key in keys)
        options = replace(options, channels=tuple(filter(None, columns)) or None)
    else:
        best = max((topic.likeness for topic in topics), default=0)
        if not best:
            raise UsageError(_none(topics))
        topic = _only([topic for topic in topics if topic.likeness == best], topics, "may be those of a sensor")
    if topic.why:
        raise UsageError(f"the messages of {topic} cannot be decoded: {topic.why}")
    return topic, options


def _none(topics: Sequence[Topic]) -> str:
    """That no topic is recognized, and what the one with most messages lacks, if it cannot be decoded."""
    first = max(topics, key=lambda topic: (bool(topic.why), topic.count), default=None)
    why = f" ({first.topic}: {first.why})" if first and first.why else ""
    return (
        f"no topic of the bag is recognized as that of an inertial sensor{why}; it has {_listed(topics)}; name the "
        f"topic with {_how(first)}"
    )


def _within(topic: Topic, key: str) -> str | None:
    """The column that a key names in a topic, empty for the topic as a whole; None if it names neither."""
    name, wanted = topic.topic.strip("/"), key.strip("/")
    if wanted == name:
        return ""
    return wanted.removeprefix(f"{name}/") if wanted.startswith(f"{name}/") else None


def _only(found: Sequence[Topic], topics: Sequence[Topic], what: str) -> Topic:
    if len(found) > 1:
        raise UsageError(
            f"{len(found)} topics of the bag {what}, but each has its own clock: {_listed(found)}; name one with "
            f"{_how(found[0])}"
        )
    return found[0]


def _listed(topics: Sequence[Topic]) -> str:
    return some([str(topic) for topic in topics], 30) or "no topics"


def _how(topic: Topic | None = None) -> str:
    name = topic.topic if topic else "/imu/data"
    return spelled(f"--channels {name}", f"channels={name!r}")


def _columns(topic: Topic, rows: NDArray[Any]) -> list[Column]:
    """The columns; the angular rate and specific force of a single sensor are called gx to az."""
    called = {name: _LETTERS[match[1]] + match[2] for name, _, _ in topic.columns if (match := _AXIS.fullmatch(name))}
    if len(set(called.values())) < len(called):
        called = {}
    called |= {name: "seq" for name, _, _ in topic.columns if name.endswith("header.seq")}
    columns = []
    # the receive time comes last: of two clocks that are equally steady, the stamp of the header is the better one
    for i, (name, _, unit) in enumerate((*topic.columns[1:], topic.columns[0]), 1):
        kind = "rate" if headers.inertial(unit) else ""
        columns.append(Column(numbers(rows[name], name), i, called.get(name, name), unit, kind, header=name))
    return columns


def _both(units: Sequence[str]) -> str:
    return say("{first} and {last}", first=units[0], last=units[1]) if len(units) == 2 else ", ".join(units)


def _notes(topic: Topic, topics: Sequence[Topic]) -> list[str]:
    units = sorted({unit for _, _, unit in topic.columns if headers.inertial(unit)}, reverse=True)
    others = [str(other) for other in topics if other is not topic]
    said = (
        say("topic {topic}", topic=str(topic)),
        say("{units} by the definition of the message", units=_both(units)) if units else "",
        say("other topics: {others}", others=some(others, 10)) if others else "",
        say("defined by {files} beside the bag", files=", ".join(topic.beside)) if topic.beside else "",
        say("left out, no signal or of no fixed number: {left}", left=", ".join(topic.left)) if topic.left else "",
    )
    return [note for note in said if note]
