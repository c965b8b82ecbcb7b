"""Columns of a file and how a user refers to them; arrays and structures as columns."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError, UsageError
from allanite.core.names import nearest
from allanite.phrases.phrase import Phrase, join, say
from allanite.readers.arrow import pa

from . import headers


@dataclass(frozen=True, eq=False)
class FileColumn:
    """One column of a file."""

    values: NDArray[Any]  # float64 or int64 of shape (n,), empty for text
    position: int  # in the file, counted from 1
    # what the file states, empty or None if it does not
    name: str = ""
    unit: str = ""
    kind: str = ""
    scale: float | None = None
    header: str = ""  # unchanged
    text: str = ""  # the first entry of a column of text, empty for numbers
    history: tuple[str, ...] = ()  # processing of the samples before they were written

    @property
    def label(self) -> str:
        """The name of the column in messages, as in its file."""
        return say("column {header!r}", header=self.header) if self.header else self.name

    def demand_numbers(self) -> None:
        """Refuse a column of text."""
        if self.text:
            raise DataError(say("{column} holds text ({text!r}) instead of numbers; select another column",
                                column=self.label, text=self.text))  # fmt: skip


def headed(values: NDArray[Any], position: int, header: str, *, unit: str = "", text: str = "") -> FileColumn:
    """A column with the name, and unless given the unit, from its header."""
    name, stated = headers.split(header)
    if unit:
        unit = unit.strip("[](){} ")
        name, stated, header = header.strip(), unit.strip(), f"{header.strip()} [{unit}]".strip()
    return FileColumn(values, position, name or f"column {position}", stated, header=header.strip(), text=text)


def unique(columns: tuple[FileColumn, ...]) -> tuple[FileColumn, ...]:
    """The columns with unique names: the second ``gx`` becomes ``gx 2``."""
    named = dict[str, FileColumn]()
    for column in columns:
        name, again = column.name, 2
        while name in named:
            name, again = f"{column.name} {again}", again + 1
        named[name] = replace(column, name=name)
    return tuple(named.values())


def lookup(columns: tuple[FileColumn, ...], key: str, choice: str = "channels") -> FileColumn:
    """The column called `key` by a choice: by name or header, ignoring case, or by its position counted from 1."""
    wanted = key.strip()
    exact = [column for column in columns if wanted in (column.name, column.header)]
    alike = [column for column in columns if wanted.lower() in (column.name.lower(), column.header.lower())]
    placed = [column for column in columns if wanted == str(column.position)]
    bare = [c for c in columns if wanted.lower() == headers.without_number(c.name).lower()]
    for column in (*exact, *alike, *placed, *bare[: len(bare) == 1]):
        return column
    names = [f"{column.position}: {column.header or column.name}" for column in columns]
    meant = nearest(wanted, [column.name for column in columns])
    known = f"did you mean {meant}? Columns" if meant else "columns"
    cure = (wanted, meant) if meant else ("", "")
    raise UsageError(f"no column {key!r}; {known}: {some(names, 30)}", choice=choice, cure=cure)


def some(names: Sequence[str], most: int = 20) -> Phrase:
    """The names as text, at most `most` of them."""
    shown = join(", ", names[:most])
    if len(names) <= most:
        return shown
    return say("{names} and {count} more", names=shown, count=len(names) - most)


RATE_NAMES = (
    "rate", "fs", "sample_rate", "samplerate", "sampling_rate", "rate_hz", "fs_hz", "sampling_frequency", "freq",
    "frequency", "imu_rate", "samplingrate",
)  # fmt: skip
"""Names under which containers store the sampling rate in Hz."""


def split(name: str, array: NDArray[Any], names: tuple[str, ...] = ()) -> Iterator[tuple[str, NDArray[Any]]]:
    """Headers and one-dimensional arrays; time runs along the longer side of a matrix."""
    if array.dtype.names:
        for field in array.dtype.names:
            yield from split(field, array[field])
    elif array.ndim == 1:
        yield name, array
    elif array.ndim == 2:
        upright = array.T if turned(array) else array
        # the number of a column stands before the unit
        at = max(name.rfind("["), name.rfind("("))
        has_unit = name[-1:] in ("]", ")") and at >= 0 and not set("])") & set(name[at:-1])
        stem = name[:at].rstrip() if has_unit else name
        numbered = [f"{stem} {i}{name[len(stem) :]}" if name else "" for i in range(1, upright.shape[1] + 1)]
        yield from zip(names if len(names) == upright.shape[1] else numbered, upright.T, strict=True)
    elif array.ndim > 2:
        what = say("array {name!r} has the shape {shape}; expected one column per channel",
                   name=name, shape=array.shape)  # fmt: skip
        raise DataError(what)


def turned(array: NDArray[Any]) -> bool:
    """Whether the channels of a matrix are its rows."""
    return array.ndim == 2 and not array.dtype.names and array.shape[0] < array.shape[1]


def turned_note(name: str, array: NDArray[Any]) -> str:
    """The assumption about such a matrix."""
    rows, count = array.shape[:2]
    if not name:
        return say("the {rows} rows of {size} values are used as channels", rows=rows, size=count)
    return say("the {rows} rows of {size} values in {name!r} are used as channels", rows=rows, size=count, name=name)


def column(header: str, values: NDArray[Any], position: int, *, unit: str = "") -> FileColumn:
    """A column of any array type; time stamps of NumPy become nanoseconds, text and booleans a text."""
    if values.dtype.kind in "Mm":
        stamps = values.astype(f"{values.dtype.kind}8[ns]").astype(np.int64)
        return headed(stamps, position, header or "time", unit="ns")
    if values.dtype.kind in "USb?":
        return headed(np.empty(0), position, header, text=str(values[0]) if len(values) else "text")
    return headed(numbers(values, header or say("column {position}", position=position)), position, header, unit=unit)


def numbers(values: NDArray[Any], header: str) -> NDArray[Any]:
    """Samples of any real type as native float64 or int64."""
    copy = values.base is not None  # a part of a matrix, which it would keep in memory, or of a file, which may change
    if values.dtype.kind in "iu":
        fits = values.dtype != np.uint64 or not len(values) or values.max() <= np.iinfo(np.int64).max
        return values.astype(np.int64 if fits else np.float64, copy=copy)
    if values.dtype.kind == "f":
        with np.errstate(over="ignore", invalid="ignore"):  # the latter for signaling NaN
            return values.astype(np.float64, copy=copy)
    what = say("{header!r} holds values of type {dtype}; expected real numbers", header=header, dtype=values.dtype)
    raise DataError(what)


def of_arrow(chunks: Any) -> NDArray[Any]:
    """Numbers or time stamps of a column of pyarrow, NaN or NaT where one is missing."""
    kind = chunks.type
    if pa.types.is_decimal(kind) or pa.types.is_null(kind):
        chunks = chunks.cast(pa.float64())
    elif pa.types.is_date(kind):
        chunks = chunks.cast(pa.timestamp("ns"))
    elif pa.types.is_time(kind):  # time of day
        chunks = chunks.cast(pa.time64("ns")).cast(pa.int64()).cast(pa.duration("ns"))
    kind = chunks.type
    if not (pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_temporal(kind)):
        return np.asarray(chunks.to_numpy())
    parts = list[NDArray[Any]]()
    # by their buffers, since pyarrow's own conversion imports pandas where it is installed
    for chunk in chunks.chunks:
        dtype = np.dtype(chunk.type.to_pandas_dtype())
        known, held = chunk.buffers()
        stored = np.frombuffer(held or b"", dtype, len(chunk), chunk.offset * dtype.itemsize if held else 0)
        if chunk.null_count:
            bits = np.unpackbits(np.frombuffer(known, np.uint8), bitorder="little")[chunk.offset :][: len(chunk)]
            stored = np.where(bits.view(bool), stored, np.array("NaT", dtype) if dtype.kind in "mM" else np.nan)
        parts.append(stored)
    return parts[0] if len(parts) == 1 else np.concatenate(parts or [np.empty(0)])


def is_number(kind: Any) -> bool:
    """Whether a type of pyarrow holds numbers or times."""
    t = pa.types
    tests = (t.is_integer, t.is_floating, t.is_decimal, t.is_null, t.is_temporal)
    return any(test(kind) for test in tests) and not t.is_interval(kind)
