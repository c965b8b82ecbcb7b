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
    named = {
        key.partition("[")[0].strip().lower()
        for key in (options.time or "", *(options.channels or ()), *(options.along or ()))
    }
    wanted = [c for c in columns if not c.kind and not named & {c.name.lower(), c.header.lower(), str(c.position)}]
    fractions = {stem: (column, size) for column in wanted for stem, size in _fraction(column)}
    notes = list[Phrase]()
    for seconds in wanted:
        stem, unit = _ending(seconds, _SECONDS)
        partner = fractions.get(stem) if unit else None
        if partner is None:
            continue
        column, size = partner
        whole, rest = _whole(seconds.values), _whole(column.values)
        if whole is None or rest is None or len(whole) != len(rest) or not len(rest):
            continue
        said = {"seconds": seconds.label, "fraction": column.label}
        if rest.min() < 0 or rest.max() >= size or np.abs(whole).max() >= 2**62 // 10**9:
            notes.append(say("{seconds} and {fraction} are not joined: the latter is not a part of a second", **said))
            continue
        stamps = whole * 10**9 + rest * (10**9 // size)
        stem = seconds.name[: len(stem)].strip() or "time"
        clock = replace(seconds, values=stamps, name=stem, unit="ns", header=f"{seconds.header} + {column.header}")
        columns = tuple(clock if c is seconds else c for c in columns if c is not column)
        notes.append(say("{seconds} and {fraction} are joined to one clock in ns", **said))
    return columns, tuple(notes)


def _fraction(column: FileColumn) -> list[tuple[str, int]]:
    """The name of a clock and the parts of a second, if a column holds such parts by its name."""
    clock, unit = _ending(column, _PARTS)
    return [(clock, _PER_SECOND[unit])] if unit and not column.text else []


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
