"""The contents of a ROS bag, read with rosbags; started by `worker`.

Of rosbags, only what reads containers and definitions is used: its own decoders are programs made from the definitions.
"""

import os
import re
import runpy
import struct
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from rosbags.interfaces import MessageDefinitionFormat
from rosbags.rosbag1 import Reader as Reader1
from rosbags.rosbag2 import Reader as Reader2
from rosbags.typesys import get_types_from_idl, get_types_from_msg

Definition = runpy.run_path(os.path.join(os.path.dirname(__file__), "bag_messages.py"))["Definition"]

MOST_TOPICS, LONGEST_DEFINITION = 1000, 1 << 20
BATCH, BYTES = 4096, 8 << 20  # messages, and their bytes, that are decoded together

RECEIVED = "receive time"

COST = 20  # bytes of a dataset that count like a byte of the file: its messages are unpacked too

_NAME = re.compile(r"([A-Za-z]\w*)(?:/msg)?/([A-Za-z]\w*)")
_SEPARATOR = "=" * 80 + "\n"

_NUMBER, _STAMP = struct.Struct("<I").unpack_from, struct.Struct("<II").unpack_from
_CONNECTION, _TIME, _MESSAGE = b"\x09\0\0\0conn=", b"\x0d\0\0\0time=", b"\x04\0\0\0op=\x02"
"""Numbers and fields of the records in a chunk of ROS 1; see Bags/Format/2.0 of the ROS wiki."""


def opened(path: str, most: int, names: dict[str, Any]) -> tuple[dict[str, Any], Callable[..., Any]]:
    """The topics of a bag with types, counts, columns and seconds that it spans, and a function that sends a topic."""
    with _worded():
        if os.path.isdir(path):
            reader: Any = Reader2(path)
        else:
            with open(path, "rb") as file:
                head = file.read(8)
            if head.startswith(b"#ROSBAG"):
                reader = Chunks(path)
            elif head.startswith(b"SQLite"):
                reader = Reader2.STORAGE_PLUGINS[".db3"](Path(quote(path)))  # opened as a URI
            else:
                reader = Reader2.STORAGE_PLUGINS[".mcap"](Path(path))
        reader.open()
        groups: dict[tuple[str, str], list[Any]] = {}
        for connection in reader.connections:
            groups.setdefault((connection.topic, connection.msgtype), []).append(connection)
        if len(groups) > MOST_TOPICS:
            how = "copy those of the sensor to a bag of their own with rosbag filter, ros2 bag convert or mcap filter"
            sys.exit(f"too many topics: {len(groups)}, and at most {MOST_TOPICS} are read; {how}")
        topics = [Topic(reader, group, path) for group in groups.values()]
    named = {f"{topic.contents['topic']} ({topic.contents['type']})": topic for topic in topics}

    def load(where: str, fields: list[str]) -> tuple[int, Iterator[Any]]:
        return COST * int(sys.argv[5]), named[where].blocks()

    return {"topics": [topic.contents for topic in topics]}, load


@contextmanager
def _worded() -> Iterator[None]:
    """Any error of rosbags as the message of an exit; an assertion of it has none."""
    try:
        yield
    except MemoryError:
        raise
    except Exception as error:
        reason = " ".join(str(error).split()) or "its records contradict each other"
        sys.exit(reason[:200])


class Topic:
    """A topic of a bag: its `contents` without the numbers, and these."""

    def __init__(self, reader: Any, connections: list[Any], path: str) -> None:
        self.reader, self.connections = reader, connections
        first, self.count = connections[0], sum(connection.msgcount for connection in connections)
        self.contents = {"topic": first.topic, "type": first.msgtype.replace("/msg/", "/"), "count": self.count}
        span = float(getattr(reader, "metadata", reader).duration)
        self.contents |= {"span": span * 1e-9, "columns": [], "left": [], "why": ""}
        types = Types(path)
        try:
            types.update(_parsed(first.msgdef.format, first.msgdef.data, first.msgtype))
            self.definition = Definition(types, first.msgtype, aligned=not isinstance(reader, Chunks))
        except Exception as error:  # the parser and what it is given may fail in any way; other topics remain
            self.contents["why"] = str(error)[:200] or type(error).__name__
            return
        columns = {RECEIVED: ("<i8", "ns")} | self.definition.columns
        self.dtype = np.dtype([(name, kind) for name, (kind, _) in columns.items()])
        self.contents["columns"] = [(name, *about) for name, about in columns.items()]
        self.contents["left"], self.contents["beside"] = self.definition.left[:20], types.beside

    def blocks(self) -> Iterator[Any]:
        """The bytes of rows with the columns."""
        batch, times, size, missing = list[bytes](), list[int](), 0, self.count
        with _worded():
            for _, time, data in self.reader.messages(self.connections):
                batch.append(data)
                times.append(time)
                size, missing = size + len(data), missing - 1
                if missing < 0:
                    break
                if len(batch) == BATCH or size > BYTES:
                    yield self._rows(batch, times)
                    batch, times, size = [], [], 0
            if missing:
                count = "more" if missing < 0 else self.count - missing
                raise ValueError(f"{self.count} messages are announced, but {count} are there")
            if batch:
                yield self._rows(batch, times)

    def _rows(self, batch: list[bytes], times: list[int]) -> Any:
        rows = np.zeros(len(batch), self.dtype)
        rows[RECEIVED] = times
        self.definition.decode(batch, rows)
        return rows.view(np.uint8).data


class Types(dict[str, Any]):
    """Definitions of message types; a missing one is looked for in a .msg file beside the bag, or is a standard one."""

    def __init__(self, path: str) -> None:
        super().__init__()
        self.folder = Path(path) if os.path.isdir(path) else Path(path).parent
        self.beside: list[str] = []

    def __missing__(self, name: str) -> Any:
        match = _NAME.fullmatch(name)
        places = (f"{match[2]}.msg", f"{match[1]}/msg/{match[2]}.msg") if match else ()
        for file in (self.folder / place for place in places):
            if file.is_file() and file.stat().st_size < LONGEST_DEFINITION:
                self.update({**get_types_from_msg(file.read_text(encoding="utf-8"), name), **self})
                self.beside.append(file.name)
                return self[name]
        if name not in _standard():
            where = f": put it beside the bag as {places[0]}" if places else ""
            raise ValueError(f"the definition of {name.replace('/msg/', '/')} is missing{where}")
        return _standard()[name]


@cache
def _parsed(form: Any, text: str, name: str) -> dict[str, Any]:
    """The definitions in a text."""
    if len(text) > LONGEST_DEFINITION:
        raise ValueError("its definition is too long")
    if form == MessageDefinitionFormat.MSG:
        return get_types_from_msg(text, name)
    if form == MessageDefinitionFormat.NONE:
        return {}
    parts = text.split(_SEPARATOR)[1:] if text.startswith(f"{_SEPARATOR}IDL: ") else [f"\n{text}"]
    return {name: about for part in parts for name, about in get_types_from_idl(part.partition("\n")[2]).items()}


@cache
def _standard() -> dict[str, Any]:
    from rosbags.typesys.stores.ros2_humble import FIELDDEFS

    return dict(FIELDDEFS)


class Chunks(Reader1):
    """A bag that is read without its index of single messages, which is larger in memory than what they hold."""

    def open(self) -> None:
        """Open it, and count the messages of each connection."""
        super().open()
        counts = [chunk.connection_counts for chunk in self.chunk_infos]
        totals = [sum(count.get(connection.id, 0) for count in counts) for connection in self.connections]
        self.connections = [c._replace(msgcount=total) for c, total in zip(self.connections, totals, strict=True)]

    def read_index_data(self, pos: int, indexes: Any) -> None:
        """Nothing."""

    def messages(self, connections: Any = (), start: Any = None, stop: Any = None) -> Any:
        """Connections, times in ns and bytes of the messages, in the order in which they were written."""
        wanted = {connection.id: connection for connection in connections}
        bio: Any = self.bio
        for chunk in sorted(self.chunk_infos, key=lambda one: (one.start_time, one.pos)):
            if wanted.keys().isdisjoint(chunk.connection_counts):
                continue
            where = self.chunks[chunk.pos]
            bio.seek(where.datapos)
            data, at = where.decompressor(bio.read(where.datasize)), 0
            while at < len(data):
                begin = at + 4
                at = begin + _NUMBER(data, at)[0]
                header = data[begin:at]
                begin = at + 4
                at = begin + _NUMBER(data, at)[0]
                if at > len(data):
                    raise ValueError("a chunk ends within a record")
                if _MESSAGE not in header:
                    continue
                connection = wanted.get(_NUMBER(header, header.index(_CONNECTION) + len(_CONNECTION))[0])
                if connection is not None:
                    seconds, nanoseconds = _STAMP(header, header.index(_TIME) + len(_TIME))
                    yield connection, seconds * 1_000_000_000 + nanoseconds, data[begin:at]
