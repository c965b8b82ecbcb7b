"""Text and CSV: columns of numbers with any delimiter, with or without a header."""

import re
from pathlib import Path
from typing import Any, NamedTuple, TypeGuard

import numpy as np

from allanite.core.errors import DataError
from allanite.core.record import Recording
from allanite.phrases.phrase import say
from allanite.readers.columns import dates, encoding, layout, parse, sensors, shapes
from allanite.readers.columns.column import Column, headed
from allanite.readers.columns.table import KEY, Table, described, restored, with_units
from allanite.readers.options import Options

TITLE = "text or CSV: columns of numbers, with or without a header"

_COMMENT = re.compile(rb'# (\{"%s": .*\})\r?\n' % KEY.encode())


def sniff(head: bytes, suffix: str) -> bool:
    """Whether the first bytes are those of a text."""
    if head.startswith(encoding.UTF16):
        return True
    control = sum(head.count(bytes([code])) for code in range(32) if code not in b"\t\n\v\f\r\x1a")
    return control == 0 and bool(head.strip())


class Parsed(NamedTuple):
    """The columns of a text, those of few words by position, the assumptions, and the rate that its lines state."""

    columns: list[Column]
    tags: dict[int, parse.Tags]
    notes: tuple[str, ...]
    nominal: tuple[float | None, str] = (None, "")


def read(path: str, options: Options) -> Recording:
    """The channels of a text file."""
    data, notes = _opened(path)
    comment = _COMMENT.match(data)
    return restored(arranged(columns_of(data, notes), options), comment[1] if comment else "").recording(options)


def arranged(found: Parsed, options: Options) -> Table:
    """The table of columns, those of several sensors separated."""
    columns, by = found.columns, sensors.turns(found.columns, found.tags)
    if by is None:
        columns, told = sensors.between(columns)
    else:
        groups, told = sensors.apart(columns, by)
        columns = sensors.wanted(groups, options.channels)
    return Table(tuple(columns), notes=(*found.notes, *told), nominal=found.nominal)


def write(recording: Recording, path: str) -> None:
    """A CSV file with a column for each channel; other programs skip the first line as a comment."""
    import pyarrow as pa
    from pyarrow import csv

    table = pa.table([pa.array(r.values) for r in recording], names=[str(i) for i in range(len(recording))])
    headers = with_units([_word(r.name) for r in recording], recording)
    with Path(path).open("wb") as file:
        file.write(f"# {described(recording, headers)}\n{','.join(headers)}\n".encode())
        csv.write_csv(table, file, csv.WriteOptions(include_header=False, quoting_style="none"))


def sheet_of(path: str) -> tuple[list[Column], tuple[str, ...]]:
    """The columns of a text file, of any kind, and the assumptions; errors are those of `read`."""
    found = columns_of(*_opened(path))
    return found.columns, found.notes


def columns_of(data: bytes, notes: tuple[str, ...] = ()) -> Parsed:
    """The columns of a text in UTF-8, after these notes."""
    found = layout.find(data)
    if found.width > shapes.WIDEST:
        raise DataError(
            f"line {found.line} contains {found.width} numbers; expected one row per sample, each on its own line"
        )
    values, passed = parse.columns(data, found)
    columns, tags, said = of_parsed(values, found.names, found.units)
    return Parsed(columns, tags, (*notes, *found.notes, *passed, *said), found.nominal)


def _opened(path: str) -> tuple[bytes, tuple[str, ...]]:
    """The text of a file in UTF-8, one line per sample, and the assumptions."""
    data, assumed = encoding.in_utf8(Path(path).read_bytes())
    data, turned = shapes.straightened(_plain(data))
    return data, (*assumed, *turned)


def _plain(data: bytes) -> bytes:
    """The text without a byte order mark, with line ends that contain a newline."""
    data = data.removeprefix(b"\xef\xbb\xbf").removesuffix(b"\x1a")
    if b"\x00" in data:
        raise DataError(f"there is a zero byte at byte {data.index(0)} of the text: the file is damaged or binary")
    return data if b"\n" in data[: layout.HEAD] else data.replace(b"\r", b"\n")


def of_parsed(
    values: list[parse.Parsed], headers: tuple[str, ...], units: tuple[str, ...]
) -> tuple[list[Column], dict[int, parse.Tags], tuple[str, ...]]:
    """The columns, those of few words by position, and notes about joined dates and times."""
    values, names, notes = _dated(values, list(headers))
    columns: list[Column] = []
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
            return (
                values,
                names,
                (
                    say(
                        "columns {first} and {second} are used as date and time of day",
                        first=first + 1,
                        second=second + 1,
                    ),
                ),
            )
    return values, names, ()


def _is(values: parse.Parsed, dtype: str) -> TypeGuard[parse.Values]:
    return isinstance(values, np.ndarray) and values.dtype == dtype


def _column(values: Any, place: int, name: str, unit: str) -> Column:
    if isinstance(values, (str, parse.Tags)):
        return headed(np.empty(0), place + 1, name, text=values if isinstance(values, str) else values.words[0])
    if values.dtype == "datetime64[D]":
        return headed(np.empty(0), place + 1, name, text=str(values[0]))
    if values.dtype.kind in "mM":
        stamps = dates.past_midnight(values) if values.dtype.kind == "m" else values.astype(np.int64)
        missing = np.isnat(values)
        if missing.any():
            stamps = np.where(missing, np.nan, stamps)
        usual = "time of day" if values.dtype.kind == "m" else "date and time"
        return Column(stamps, place + 1, name or usual, "ns", header=name)
    return headed(values, place + 1, name, unit=unit)


def _word(name: str) -> str:
    """A name that CSV readers do not split."""
    return re.sub(r"[^\w.+-]+", "_", name) or "column"
