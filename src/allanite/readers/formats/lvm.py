"""LabVIEW measurement files .lvm: text with a header, and one or several segments of rows.

Source of the format: NI, Specification for the LabVIEW Measurement File (.lvm), revision 2.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise, takewhile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError
from allanite.core.record import Recording
from allanite.phrases.phrase import Phrase, say
from allanite.readers.columns import parse
from allanite.readers.columns.column import FileColumn, column
from allanite.readers.columns.layout import Layout, decoded
from allanite.readers.columns.table import FileTable
from allanite.readers.options import Options
from allanite.readers.sandbox.process import worded

TITLE = "LabVIEW measurement text .lvm"

_END = "***End_of_Header***"
_SEPARATORS = {"tab": "\t", "comma": ","}

Header = dict[str, list[str]]


@dataclass(frozen=True)
class _Style:
    """How rows are written: separator, decimal sign, and columns of time: ``no``, ``one`` or ``multi``."""

    mark: str
    decimal: str
    times: str

    def number(self, header: Header, key: str) -> float:
        """The first number of an entry; 0 if there is none."""
        cells = [cell for cell in header.get(key, []) if cell]
        return float(cells[0].replace(self.decimal, ".")) if cells else 0.0


@dataclass(frozen=True)
class _Segment:
    """The header of some rows, the line of their names, the rows, and the number of the first line."""

    about: Header
    names: list[str]
    rows: list[str]
    line: int


def read(path: str, options: Options) -> Recording:
    """The channels of all segments, with units, times and time step from the headers."""
    with worded():
        lines = decoded(Path(path).read_bytes().removeprefix(b"\xef\xbb\xbf")).splitlines()
        ends = [i for i, line in enumerate(lines) if line.startswith(_END)]
        if len(ends) < 2:
            raise DataError(say("the end of a header, {end}, is missing: the file is incomplete", end=_END))
        mark = next((m for line in lines[: ends[0]] if line.startswith("Separator") for m in "\t," if m in line), "\t")
        general = _entries(lines[: ends[0]], mark)
        mark = _SEPARATORS.get(general.get("Separator", ["Tab"])[0].lower(), mark)
        decimal, times = (
            general.get(key, [usual])[0] for key, usual in (("Decimal_Separator", "."), ("X_Columns", "One"))
        )
        style = _Style(mark, decimal or ".", times.lower())
        segments = list(_segments(lines, ends, style))
        first = segments[0]
        kept = [segment for segment in segments if segment.names == first.names and segment.rows]
        if not kept:
            raise DataError(say("the file contains no rows of numbers; check that the recording was saved"))
        other = len(segments) - len(kept)
        omitted = say("{number} segments without rows or with other channels are left out", number=other)
        table = _joined(kept, style, (omitted,) if other else ())
    return table.recording(options)


def _joined(segments: list[_Segment], style: _Style, notes: tuple[Phrase, ...]) -> FileTable:
    """The channels of segments, one after the other; their times are those of the headers and rows."""
    values = [_values(segment, style) for segment in segments]
    about, names = segments[0].about, segments[0].names
    units, step = about.get("Y_Unit_Label", []), style.number(about, "Delta_X")
    signals = (np.concatenate([part[1][i] for part in values]) for i in range(len(names)))
    columns = [
        column(name, joined, place, unit=units[place - 2] if place - 2 < len(units) else "")
        for place, (name, joined) in enumerate(zip(names, signals, strict=True), 2)
    ]
    if len(segments) == 1 and style.times == "no":
        source = str(say("Delta_X in the header"))
        return FileTable(tuple(columns), 1 / step if step > 0 else None, source, notes, style.number(about, "X0"))
    clock = np.concatenate([part[0] for part in values])
    return FileTable((FileColumn(clock, 1, "X_Value", "ns", header="X_Value"), *columns), notes=notes)


def _entries(lines: list[str], mark: str) -> Header:
    """Keys and values of the lines of a header."""
    cells = ([cell.strip() for cell in line.split(mark)] for line in lines)
    return {row[0]: row[1:] for row in cells if row[0] and len(row) > 1}


def _segments(lines: list[str], ends: list[int], style: _Style) -> Iterator[_Segment]:
    """The segments after the header of the file; each begins with a header of its own."""
    start = ends[0] + 1
    for end, following in pairwise((*ends[1:], len(lines))):
        about = _entries(lines[start:end], style.mark)
        count = int(about["Channels"][0])
        cells = [cell.strip() for cell in lines[end + 1].split(style.mark)] if end + 1 < len(lines) else []
        names = cells[1 : 2 * count : 2] if style.times == "multi" else cells[1 : 1 + count]
        if len(names) != count:
            raise DataError(say("line {line} should name {count} channels", line=end + 2, count=count))
        rows = list(takewhile(lambda line: line.strip() and line[:8] != "Channels", lines[end + 2 : following]))
        start = end + 2 + len(rows)
        yield _Segment(about, names, rows, end + 3)


def _values(segment: _Segment, style: _Style) -> tuple[NDArray[np.int64], list[NDArray[np.float64]]]:
    """The times of the rows of a segment in ns, and the samples of each channel."""
    count = len(segment.names)
    width, first = (2 * count, 2) if style.times == "multi" else (1 + count, 1)
    names = tuple(f"column {i + 1}" for i in range(width))
    # a comment may follow the numbers in some rows
    body = "\n".join(style.mark.join(row.split(style.mark)[:width]) for row in segment.rows) + "\n"
    layout = Layout(style.mark, style.decimal, names, ("",) * width, frozenset(), 0, segment.line)
    columns = [np.asarray(values, np.float64) for values in parse.columns(body.encode(), layout)[0]]
    x = columns[0]
    if style.times == "no" or not np.all(np.isfinite(x)):
        steps = np.arange(x.size, dtype=np.float64)
        x = np.add(style.number(segment.about, "X0"), style.number(segment.about, "Delta_X") * steps)
    day, time = (segment.about.get(key, [""])[0].replace(",", ".") for key in ("Date", "Time"))
    try:
        start = int(np.datetime64(f"{day.replace('/', '-')}T{time[:18]}", "ns").astype(np.int64))
    except ValueError:  # the header has no time
        start = 0
    return start + np.rint(x.clip(-1e9, 1e9) * 1e9).astype(np.int64), columns[1::first]
