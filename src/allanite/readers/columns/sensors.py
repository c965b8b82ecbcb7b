"""Several sensors in one file, and time stamps in two columns."""

import re
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from allanite.phrases.phrase import Phrase, join, say
from allanite.readers.options import Options

from . import headers
from .column import FileColumn
from .parse import Tags

MOST_SENSORS = 8  # maximum number of sensors with alternating rows

_ID = re.compile(r"(^|[^a-z])(sensor|type|id|source|name|tag|device)([^a-z]|$)|sensor_?(id|type|name)")
_AXES = ("x", "y", "z")


class Turns(NamedTuple):
    """A column that identifies the sensor of each row: its position, the ids, and the index of the id in each row."""

    place: int
    ids: tuple[str, ...]
    codes: NDArray[Any]


def turns(columns: list[FileColumn], tags: dict[int, Tags]) -> Turns | None:
    """The column that distinguishes the rows of several sensors; None if all rows belong to one."""
    # A column of a few words is one if they change often; a column of numbers if its header says so, or if they repeat
    # in the same order, which samples do not.
    for place, column in enumerate(columns if len(columns) > 1 else ()):
        named = bool(_ID.search(column.header.lower()))
        if place in tags:
            ids, codes = tags[place]
        elif column.text or column.values.dtype.kind != "i":
            continue
        else:
            numbers = np.unique(column.values[:1000])
            if not 2 <= numbers.size <= MOST_SENSORS or np.any(~np.isin(column.values, numbers)):
                continue
            ids, codes = tuple(map(str, numbers)), np.searchsorted(numbers, column.values)
            around = codes.size > 4 * len(ids) and np.array_equal(codes[len(ids) :], codes[: -len(ids)])
            if not named and not (column.header == "" and around):
                continue
        if 2 <= len(ids) <= MOST_SENSORS and codes.min() >= 0 and (np.diff(codes) != 0).mean() > 0.1:
            return Turns(place, ids, codes)
    return None


def apart(columns: list[FileColumn], by: Turns) -> tuple[list[list[FileColumn]], tuple[str, ...]]:
    """The columns of each sensor, named after it, and a note."""
    groups, position = [], len(columns)
    for code, name in enumerate(by.ids):
        rows = by.codes == code
        group = []
        for place, column in enumerate(columns):
            if place == by.place or column.text:
                continue
            position += 1
            values = column.values[rows]
            if values.dtype.kind == "f" and np.all(np.isnan(values)):
                continue
            header = f"{name} {column.header or column.name}"
            group.append(replace(column, values=values, name=f"{name} {column.name}", header=header, position=position))
        groups.append(group)
    counted = zip(by.ids, np.bincount(by.codes, minlength=len(by.ids)).tolist(), strict=True)
    sizes = join(", ", (say("{name} ({count} rows)", name=name, count=count) for name, count in counted))
    return groups, (say(
        "the rows belong to {count} sensors according to {column}: {sizes}",
        count=len(by.ids), column=columns[by.place].label, sizes=sizes,
    ),)  # fmt: skip


def between(columns: list[FileColumn]) -> tuple[list[FileColumn], tuple[str, ...]]:
    """Columns without header, named after the ids that precede them: ``3, ax, ay, az, 4, gx, gy, gz``."""
    # An id is an integer that never changes; there are at least two, all different, each followed by the same number of
    # columns.
    ids = [i for i, column in enumerate(columns) if _constant(column)]
    if len(ids) < 2 or any(column.header for column in columns):
        return columns, ()
    numbers = [int(columns[i].values[0]) for i in ids]
    width = ids[1] - ids[0]
    regular = len(set(numbers)) == len(ids) and set(np.diff(ids)) == {width} and 2 <= width <= 4
    if not regular or len(columns) < ids[-1] + width:
        return columns, ()
    known = list(zip(ids, numbers, strict=True))
    names = {i + k: f"sensor {number} {_AXES[k - 1]}" for i, number in known for k in range(1, width)}
    result = [replace(c, name=names.get(i, c.name)) for i, c in enumerate(columns) if i not in ids]
    always = (say("{position} (always {number})", position=columns[i].position, number=number) for i, number in known)
    return result, (say(
        "columns {columns} are used as ids of sensors, and the columns after each are named after it",
        columns=join(", ", always),
    ),)  # fmt: skip


def _constant(column: FileColumn) -> bool:
    values = column.values
    return not column.text and values.dtype.kind == "i" and len(values) > 1 and bool(np.all(values == values[0]))


def wanted(groups: list[list[FileColumn]], keys: tuple[str, ...] | None) -> list[FileColumn]:
    """The columns of the sensors selected by the user; of all sensors if they have the same number of rows."""
    # By default, if the sensors have different numbers of rows, those with inertial names are kept if their numbers
    # agree; otherwise all, which the table then refuses.
    if keys is not None:
        asked = {key.strip().lower() for key in keys}
        chosen = [g for g in groups if any(asked & {c.name.lower(), c.header.lower(), str(c.position)} for c in g)]
        return [column for group in chosen or groups for column in group]
    inertial = [group for group in groups if any(headers.sensor_by_name(column.name) for column in group)]
    kept = inertial if len({len(group[0].values) for group in groups if group}) > 1 and inertial else groups
    return [column for group in kept for column in group]


_SECONDS = re.compile(r"(?:tv_)?(s|secs?|seconds?)$")
_PARTS = re.compile(r"(?:tv_)?(n|u|nano|micro)(?:s|secs?|seconds?)$")
_PER_SECOND = {"n": 10**9, "u": 10**6, "nano": 10**9, "micro": 10**6}


def joined(columns: tuple[FileColumn, ...], options: Options) -> tuple[tuple[FileColumn, ...], tuple[Phrase, ...]]:
    """The columns with each pair of seconds and fractions as one clock, and notes; those that are named stay apart."""
    # Both are whole numbers, such as header.stamp.sec and header.stamp.nanosec of ROS, and are added as such: a float64
    # has no room for the nanoseconds of an epoch.
    named = _named(options)
    wanted = [c for c in columns if not c.kind and not named & {c.name.lower(), c.header.lower(), str(c.position)}]
    endings = ((column, *_ending(column, _PARTS)) for column in wanted if not column.text)
    fractions = {stem: (column, _PER_SECOND[unit]) for column, stem, unit in endings if unit}
    notes = list[Phrase]()
    for seconds in wanted:
        stem, unit = _ending(seconds, _SECONDS)
        partner = fractions.get(stem) if unit else None
        if partner is None:
            continue
        column, size = partner
        stamps = _added(seconds.values, column.values, size)
        if stamps is None:
            continue
        labels = {"seconds": seconds.label, "fraction": column.label}
        if not stamps.size:
            notes.append(say("{seconds} and {fraction} are not joined: the latter is not a part of a second", **labels))
            continue
        stem = seconds.name[: len(stem)].strip() or "time"
        clock = replace(seconds, values=stamps, name=stem, unit="ns", header=f"{seconds.header} + {column.header}")
        columns = tuple(clock if c is seconds else c for c in columns if c is not column)
        notes.append(say("{seconds} and {fraction} are joined to one clock in ns", **labels))
    return columns, tuple(notes)


def _named(options: Options) -> set[str]:
    """The columns that the user names."""
    keys = (options.time or "", *(options.channels or ()), *(options.along or ()))
    return {key.partition("[")[0].strip().lower() for key in keys}


def _added(seconds: NDArray[Any], parts: NDArray[Any], size: int) -> NDArray[np.int64] | None:
    """Nanoseconds of both, with `size` parts a second; empty if they are no such parts, None if no whole numbers."""
    whole, rest = _whole(seconds), _whole(parts)
    if whole is None or rest is None or len(whole) != len(rest) or not len(rest):
        return None
    if rest.min() < 0 or rest.max() >= size or np.abs(whole).max() >= 2**62 // 10**9:
        return np.empty(0, np.int64)
    return np.asarray(whole * 10**9 + rest * (10**9 // size))


def _ending(column: FileColumn, units: re.Pattern[str]) -> tuple[str, str]:
    """A name without the unit at its end and the signs between, and the unit; both are empty if there is none."""
    name = column.name.strip().lower()
    ending = units.search(name)
    if ending is None:
        return "", ""
    end = ending.start()
    while end and not (name[end - 1].isascii() and name[end - 1].isalnum()):
        end -= 1
    return name[:end], ending[1]


def _whole(values: NDArray[Any]) -> NDArray[np.int64] | None:
    """Whole numbers as integers; None if they are not, or too large to be exact."""
    if values.dtype.kind == "i":
        return np.asarray(values, np.int64)
    if values.dtype.kind != "f" or not np.all(np.abs(values) < 2**53) or np.any(values != np.floor(values)):
        return None
    return values.astype(np.int64)
