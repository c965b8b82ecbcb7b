"""Numbers of ROS messages, decoded many at a time; used by `bag_contents`.

A definition becomes steps, which are walked once for all messages of one length: where their texts are equally long
too, each number is at the same place in all of them. Nothing of a definition is executed.

ROS 1 writes fields one after the other. ROS 2 aligns numbers to their sizes; source: OMG, Common Object Request Broker
Architecture 3.3, part 2, section 9.3 (CDR transfer syntax).
"""

import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, NoReturn

import numpy as np
from rosbags.interfaces import Nodetype

UNITS = {
    ("sensor_msgs/msg/Imu", "angular_velocity"): "rad/s",
    ("sensor_msgs/msg/Imu", "linear_acceleration"): "m/s^2",
    ("sensor_msgs/msg/Temperature", "temperature"): "degC",
    ("sensor_msgs/msg/FluidPressure", "fluid_pressure"): "Pa",
}
"""Units of fields, and of the numbers in them, that the definition of a message type fixes in its comments."""

UNUSED = re.compile("orientation|magnetic_field|covariance|variance")
"""Names of fields that are neither measured by an inertial sensor nor a clock."""

STAMPS = ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")

INTEGERS = ("int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64")
NUMBERS = {name: np.dtype(name) for name in (*INTEGERS, "float32", "float64")}
NUMBERS |= dict.fromkeys(("bool", "byte", "char"), np.dtype("uint8"))

_ZSTD = b"\x28\xb5\x2f\xfd"

MOST_STEPS, MOST_COLUMNS, LONGEST_ARRAY = 10_000, 500, 64
"""Maximum number of fields and columns of a definition, and of elements of an array that become columns."""


class Numbers(NamedTuple):
    """Numbers of one type, and their names; none if they are skipped."""

    dtype: Any
    size: int
    names: tuple[str, ...] = ()


class Stamp(NamedTuple):
    """Seconds and nanoseconds; skipped if the name is empty."""

    name: str
    seconds: str


class Text(NamedTuple):
    """A text with its length before it."""


class Many(NamedTuple):
    """A number of elements, each of some steps, with their number before them; they are skipped."""

    element: tuple[Any, ...]


class Definition:
    """The steps of a message type, and its `columns` (name: type of number, unit); the fields `left` are no columns."""

    # `types` are the definitions of `rosbags.typesys` by name; `aligned` is true for ROS 2. Definitions that contain
    # themselves, or what is not known here, raise ValueError.
    def __init__(self, types: Mapping[str, Any], name: str, *, aligned: bool) -> None:
        self.types, self.aligned, self.budget = types, aligned, MOST_STEPS
        self.columns: dict[str, tuple[str, str]] = {}
        self.left: list[str] = []
        self.steps = tuple(self._message(name, "", "", taken=True))
        if len(self.columns) > MOST_COLUMNS:
            raise ValueError(f"{len(self.columns)} numbers in a message")

    def _message(self, name: str, path: str, unit: str, *, taken: bool) -> list[Any]:
        steps = []
        for field, about in self.types[name][1]:
            where = f"{path}.{field}".lstrip(".")
            fits = taken and not UNUSED.search(field.lower())
            if taken and not fits:
                self.left.append(where)
            steps += self._field(about, where, UNITS.get((name, field), unit), taken=fits)
        return steps

    def _field(self, about: Any, where: str, unit: str, *, taken: bool) -> list[Any]:
        self.budget -= 1
        if self.budget < 0 or where.count(".") > 20:
            raise ValueError("its definition is too large")
        what, inner = about
        if what == Nodetype.BASE:
            return [Text()] if inner[0] == "string" else [self._numbers(inner[0], where, unit, taken=taken)]
        if what == Nodetype.NAME:
            if inner in STAMPS:
                return [self._stamp(where, taken=taken)]
            return self._message(inner, where, unit, taken=taken)
        element, size = inner
        if what == Nodetype.SEQUENCE or size > LONGEST_ARRAY:
            self.left += [where] if taken else []
            taken = False
        if what == Nodetype.SEQUENCE:
            return [Many(tuple(self._field(element, where, "", taken=False)))]
        if element[0] == Nodetype.BASE and element[1][0] != "string":
            return [self._numbers(element[1][0], where, unit, size, taken=taken)]
        return [step for i in range(size) for step in self._field(element, f"{where}[{i}]", unit, taken=taken)]

    def _numbers(self, kind: str, where: str, unit: str, size: int | None = None, *, taken: bool) -> Numbers:
        if kind not in NUMBERS:
            raise ValueError(f"{where} is of type {kind}, which is not supported")
        if not taken:
            return Numbers(NUMBERS[kind], 1 if size is None else size)
        names = (where,) if size is None else tuple(f"{where}[{i}]" for i in range(size))
        self.columns |= dict.fromkeys(names, (NUMBERS[kind].str, unit))
        return Numbers(NUMBERS[kind], len(names), names)

    def _stamp(self, where: str, *, taken: bool) -> Stamp:
        if taken:
            self.columns[where] = ("<i8", "ns")
        # the seconds of ROS 1 end in 2106
        return Stamp(where if taken else "", "i4" if self.aligned else "u4")

    def decode(self, messages: Sequence[bytes], out: Any) -> None:
        """Put the numbers of messages into a structured array with a field for each column."""
        lengths = np.fromiter(map(len, messages), np.int64, len(messages))
        groups = _groups(np.arange(len(messages)), lengths)
        while groups:
            rows = groups.pop()
            every = len(rows) == len(messages)
            data = b"".join(messages if every else [messages[i] for i in rows])
            matrix = np.frombuffer(data, np.uint8).reshape(len(rows), int(lengths[rows[0]]))
            try:
                walk = Walk(matrix, aligned=self.aligned)
                walk.through(self.steps)
                walk.end()
            except Uneven as found:
                groups += _groups(rows, found.lengths)
            else:
                walk.fill(out, slice(None) if every else rows)


def _groups(rows: Any, keys: Any) -> list[Any]:
    """The rows with equal keys."""
    order = np.argsort(keys, kind="stable")
    return list(np.split(rows[order], np.flatnonzero(np.diff(keys[order])) + 1))


class Uneven(Exception):  # noqa: N818  not an error: the messages are divided
    """Messages with something of different `lengths` at the same place."""

    def __init__(self, lengths: Any) -> None:
        self.lengths = lengths


class Walk:
    """A walk through messages of one length, `rows` of bytes: where their numbers are."""

    def __init__(self, rows: Any, *, aligned: bool) -> None:
        self.rows, self.aligned, self.order, self.at = rows, aligned, "<", 0
        self.places: dict[str, tuple[Any, int]] = {}
        if aligned:
            self._demand(4)
            if rows[0, :4].tobytes() == _ZSTD:
                raise ValueError("its messages are compressed one by one; give the folder that holds its metadata.yaml")
            # 0 0 big-endian, 0 1 little-endian, and two bytes that mean nothing
            self.order, self.at = "><"[self._common(rows[:, :2].astype(np.int64) @ [256, 1], 1)], 4

    def through(self, steps: tuple[Any, ...], *, taken: bool = True) -> None:
        """Go on by some steps."""
        for step in steps:
            if isinstance(step, Numbers):
                self._numbers(step, taken=taken)
            elif isinstance(step, Stamp):
                self._stamp(step, taken=taken)
            elif isinstance(step, Text):
                size = self._length()
                self._demand(size)
                self.at += size
            else:
                count = self._length()
                if count > self.rows.shape[1] - self.at:
                    _refuse("shorter")
                first = step.element[0] if len(step.element) == 1 else None
                if isinstance(first, Numbers):
                    self._numbers(Numbers(first.dtype, count * first.size), taken=False)
                else:
                    for _ in range(count):
                        self.through(step.element, taken=False)

    def end(self) -> None:
        """Refuse messages that are longer than their definition; those of ROS 2 may be padded."""
        if self.rows.shape[1] - self.at > (7 if self.aligned else 0):
            _refuse("longer")

    def fill(self, out: Any, where: Any) -> None:
        """Put the numbers into some rows of a structured array."""
        if not self.places:
            return
        formats, offsets = zip(*self.places.values(), strict=True)
        about: Any = {
            "names": list(self.places), "formats": formats, "offsets": offsets, "itemsize": self.rows.shape[1],
        }  # fmt: skip
        numbers = self.rows.reshape(-1).view(np.dtype(about))
        for name in self.places:
            values = numbers[name]
            if values.dtype.names:
                values = values["s"].astype(np.int64) * 1_000_000_000 + values["ns"]
            out[name][where] = values

    def _numbers(self, step: Numbers, *, taken: bool) -> None:
        size = step.dtype.itemsize
        self._align(size if step.size else 1)
        self._demand(step.size * size)
        for i, name in enumerate(step.names if taken else ()):
            self.places[name] = (step.dtype.newbyteorder(self.order), self.at + i * size)
        self.at += step.size * size

    def _stamp(self, step: Stamp, *, taken: bool) -> None:
        self._align(4)
        self._demand(8)
        if step.name and taken:
            about: Any = [("s", self.order + step.seconds), ("ns", f"{self.order}u4")]
            self.places[step.name] = (np.dtype(about), self.at)
        self.at += 8

    def _length(self) -> int:
        self._align(4)
        self._demand(4)
        values = self.rows[:, self.at : self.at + 4].copy().view(f"{self.order}u4")[:, 0]
        self.at += 4
        return self._common(values.astype(np.int64), self.rows.shape[1])

    def _common(self, values: Any, most: int) -> int:
        if values[0] > most:
            _refuse("shorter")
        if np.any(values != values[0]):
            raise Uneven(values)
        return int(values[0])

    def _align(self, size: int) -> None:
        if self.aligned:
            self.at += -(self.at - 4) % size

    def _demand(self, size: int) -> None:
        if self.at + size > self.rows.shape[1]:
            _refuse("shorter")


def _refuse(how: str) -> NoReturn:
    raise ValueError(f"a message is {how} than its definition")
