"""Text and CSV: columns of numbers with any delimiter, with or without a header; columns requested by name."""

import math
import os
import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, TypeGuard

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError
from allanite.core.record import Recording
from allanite.phrases.phrase import say
from allanite.readers.arrow import csv, pa
from allanite.readers.columns import dates, encoding, layout, lines, parse, sensors, shapes
from allanite.readers.columns.column import FileColumn, headed
from allanite.readers.columns.lines import Parts
from allanite.readers.columns.table import KEY, FileTable, described, restored, with_units
from allanite.readers.options import Options

TITLE = "text or CSV: columns of numbers, with or without a header"

DENSITY = 0.5  # samples in a byte, at most: a digit and a delimiter

_CONTROLS = bytes(code for code in range(32) if code not in b"\t\n\v\f\r\x1a")

_COMMENT = re.compile(rb'# (\{"%s": .*\})\r?\n' % KEY.encode())


def sniff(head: bytes, suffix: str) -> bool:
    """Whether the first bytes are those of a text."""
    if head.startswith(encoding.UTF16):
        return True
    return head.translate(None, _CONTROLS) == head and bool(head.strip())


class Parsed(NamedTuple):
    """The columns of a text, those of few words by position, the assumptions, and the rate that its lines state."""

    columns: list[FileColumn]
    tags: dict[int, parse.Tags]
    notes: tuple[str, ...]
    nominal: tuple[float | None, str] = (None, "")


def read(path: str, options: Options) -> Recording:
    """The channels of a text file."""
    data, notes = _opened(path)
    comment = _COMMENT.match(data)
    return restored(arranged(columns_of(data, notes), options), comment[1] if comment else "").recording(options)


def shape_of(path: str) -> tuple[int, int]:
    """About how many rows and columns a text has, by its head; none if that is no text in UTF-8 of them."""
    with Path(path).open("rb") as file:
        head = file.read(layout.HEAD)
    with suppress(DataError):
        form = layout.find(head)
        rows = head.count(b"\n", form.offset)
        return math.ceil(os.path.getsize(path) * rows / (len(head) - form.offset)), form.width
    return 0, 0


def parts(path: str, options: Options) -> Parts | None:
    """The rows of a text file, a block of lines at a time; see `streamed`."""
    return streamed(lines.chunks_of(path), options)


def streamed(chunks: lines.Chunks, options: Options, *, grows: bool = False) -> Parts | None:
    """The rows of a text whose bytes are read like this; None if its lines are not the rows of one sensor."""
    # It is read once to count the rows, to see its encoding and the order of its dates. Of one that `grows` the blocks
    # are each time those of the lines that the chunks have then.
    text = lines.TextLines(chunks, *encoding.encoding_of(chunks))
    first, whole = next(text.blocks(), (b"", True))
    if shapes.straightened(first)[1]:
        return None
    form, comment = _layout(first), _COMMENT.match(first)
    forms = parse.forms_of(first, form, last=whole)
    rows, comments, passed = 0, 0, tuple[str, ...]()
    for block, part, last in text.rows(form):
        body, count, passed = parse.clean_rows(block, part, parse.signs(block, part.offset), last=last)
        comments += count
        rows += parse.count(body)
        parse.see_order(body, part, forms)
    values = parse.columns(first, form, last=whole)[0]
    columns, tags, joined = of_parsed(values, form.names, form.units)
    if sensors.turns(columns, tags) is not None:
        return None
    notes = (*encoding.noted(text.codec, text.name), *form.notes, *parse.commented(comments), *passed, *joined)
    head = restored(arranged(Parsed(columns, tags, notes, form.nominal), options), comment[1] if comment else "")
    begun = form, replace(forms), dict[int, NDArray[Any]]()

    def blocks(wanted: Sequence[int], at_once: int) -> Iterator[list[NDArray[Any]]]:
        nonlocal begun
        at, known, before = begun if grows else (form, replace(forms), dict[int, NDArray[Any]]())

        def past_midnight(time: NDArray[Any], position: int) -> NDArray[Any]:
            before[position] = dates.continued(_stamps(time), before.get(position, np.empty(0)))
            return before[position]

        for block, part, last in text.rows(at):
            values = _dated(parse.columns(block, part, known, last=last)[0], list(part.names))[0]
            made = list[NDArray[Any]]()
            for column in (head.columns[i] for i in wanted):
                entry: Any = values[column.position - 1]
                if entry.dtype.kind in "mM":
                    entry = _stamps(entry) if entry.dtype.kind == "M" else past_midnight(entry, column.position)
                made.append(entry.astype(np.float64, copy=False) if column.values.dtype.kind == "f" else entry)
            count = max(1, math.ceil(len(made[0]) / at_once))
            yield from map(list, zip(*(np.array_split(each, count) for each in made), strict=True))
            begun = replace(part, line=part.line + block.count(b"\n")), known, before

    return Parts(head, rows, blocks, options)


def arranged(found: Parsed, options: Options) -> FileTable:
    """The table of columns, those of several sensors separated."""
    columns, by = found.columns, sensors.turns(found.columns, found.tags)
    if by is None:
        columns, told = sensors.between(columns)
    else:
        groups, told = sensors.apart(columns, by)
        columns = sensors.wanted(groups, options.channels)
    return FileTable(tuple(columns), notes=(*found.notes, *told), nominal=found.nominal)


def write(recording: Recording, path: str) -> None:
    """A CSV file with a column for each channel; other programs skip the first line as a comment."""
    table = pa.table([pa.array(r.values) for r in recording], names=[str(i) for i in range(len(recording))])
    headers = with_units([(re.sub(r"[^\w.+-]+", "_", r.name) or "column") for r in recording], recording)
    with Path(path).open("wb") as file:
        file.write(f"# {described(recording, headers)}\n{','.join(headers)}\n".encode())
        csv.write_csv(table, file, csv.WriteOptions(include_header=False, quoting_style="none"))


def columns_of(data: bytes, notes: tuple[str, ...] = ()) -> Parsed:
    """The columns of a text in UTF-8, after these notes."""
    form = _layout(data)
    values, passed = parse.columns(data, form)
    columns, tags, joined = of_parsed(values, form.names, form.units)
    return Parsed(columns, tags, (*notes, *form.notes, *passed, *joined), form.nominal)


def _layout(data: bytes) -> layout.Layout:
    form = layout.find(data)
    if form.width > shapes.WIDEST_LINE and not any(form.names):
        raise DataError(
            f"line {form.line} contains {form.width} numbers; expected one row per sample, each on its own line"
        )
    return form


def _opened(path: str) -> tuple[bytes, tuple[str, ...]]:
    """The text of a file in UTF-8, one line per sample, and the assumptions."""
    data, assumed = encoding.in_utf8(Path(path).read_bytes())
    data = lines.plain(data).removesuffix(b"\x1a")
    data, turned = shapes.straightened(data if b"\n" in data[: layout.LONGEST_HEAD] else data.replace(b"\r", b"\n"))
    return data, (*assumed, *turned)


def of_parsed(
    values: list[parse.Parsed], headers: tuple[str, ...], units: tuple[str, ...]
) -> tuple[list[FileColumn], dict[int, parse.Tags], tuple[str, ...]]:
    """The columns, those of few words by position, and notes about joined dates and times."""
    values, names, notes = _dated(values, list(headers))
    columns: list[FileColumn] = []
    tags = {}
    for place, entry in enumerate(values):
        if entry is None:
            continue
        if isinstance(entry, parse.Tags):
            tags[len(columns)] = entry
        columns.append(_column(entry, place, names[place], units[place]))
    return columns, tags, notes


def _dated(values: list[parse.Parsed], names: list[str]) -> tuple[list[parse.Parsed], list[str], tuple[str, ...]]:
    """A column of dates next to one of times of day becomes one of time stamps; so does one of times alone."""
    for day, time in ((i, j) for i in range(len(values)) for j in (i + 1, i - 1) if 0 <= j < len(values)):
        date, clock = values[day], values[time]
        if _is(date, "datetime64[D]") and _is(clock, "timedelta64[ns]"):
            stamps = date.astype("datetime64[ns]") + clock
            first, second = sorted((day, time))
            label = " ".join(filter(None, (names[first], names[second])))
            values = [stamps if i == first else None if i == second else v for i, v in enumerate(values)]
            names = [label if i == first else name for i, name in enumerate(names)]
            return values, names, (say("columns {first} and {second} are used as date and time of day",
                                       first=first + 1, second=second + 1),)  # fmt: skip
    return values, names, ()


def _is(values: parse.Parsed, dtype: str) -> TypeGuard[parse.Values]:
    return isinstance(values, np.ndarray) and values.dtype == dtype


def _column(values: Any, place: int, name: str, unit: str) -> FileColumn:
    if isinstance(values, (str, parse.Tags)):
        return headed(np.empty(0), place + 1, name, text=values if isinstance(values, str) else values.words[0])
    if values.dtype == "datetime64[D]":
        return headed(np.empty(0), place + 1, name, text=str(values[0]))
    if values.dtype.kind in "mM":
        usual = "time of day" if values.dtype.kind == "m" else "date and time"
        return FileColumn(_stamps(values), place + 1, name or usual, "ns", header=name)
    return headed(values, place + 1, name, unit=unit)


def _stamps(values: parse.Values) -> parse.Values:
    """Nanoseconds of dates or times of day; NaN where there is none."""
    stamps = dates.past_midnight(values) if values.dtype.kind == "m" else values.astype(np.int64)
    missing = np.isnat(values)
    return np.where(missing, np.nan, stamps) if missing.any() else stamps
