"""Time stamps in two columns, seconds and the nanoseconds after them, joined to one column of nanoseconds."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.phrases.phrase import Phrase, say
from allanite.readers.options import Options

from .column import FileColumn

_SECONDS = re.compile(r"(?:tv_)?(s|secs?|seconds?)$")
_PARTS = re.compile(r"(?:tv_)?(n|u|nano|micro)(?:s|secs?|seconds?)$")
_PER_SECOND = {"n": 10**9, "u": 10**6, "nano": 10**9, "micro": 10**6}


def joined(columns: tuple[FileColumn, ...], options: Options) -> tuple[tuple[FileColumn, ...], tuple[Phrase, ...]]:
    """The columns with each pair of seconds and fractions as one clock, and notes; those named by the user stay apart.

    Both are whole numbers, such as ``header.stamp.sec`` and ``header.stamp.nanosec`` of ROS, and are added as such:
    a float64 has no room for the nanoseconds of an epoch.
    """
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
        said = {"seconds": seconds.label, "fraction": column.label}
        if not stamps.size:
            notes.append(say("{seconds} and {fraction} are not joined: the latter is not a part of a second", **said))
            continue
        stem = seconds.name[: len(stem)].strip() or "time"
        clock = replace(seconds, values=stamps, name=stem, unit="ns", header=f"{seconds.header} + {column.header}")
        columns = tuple(clock if c is seconds else c for c in columns if c is not column)
        notes.append(say("{seconds} and {fraction} are joined to one clock in ns", **said))
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
    found = units.search(name)
    if found is None:
        return "", ""
    end = found.start()
    while end and not (name[end - 1].isascii() and name[end - 1].isalnum()):
        end -= 1
    return name[:end], found[1]


def _whole(values: NDArray[Any]) -> NDArray[np.int64] | None:
    """Whole numbers as integers; None if they are not, or too large to be exact."""
    if values.dtype.kind == "i":
        return np.asarray(values, np.int64)
    if values.dtype.kind != "f" or not np.all(np.abs(values) < 2**53) or np.any(values != np.floor(values)):
        return None
    return values.astype(np.int64)
