"""Text and CSV: columns of numbers with any delimiter, with or without a header."""

from pathlib import Path

from allanite.errors import DataError
from allanite.record import Recording

from . import csv_file, layout, parse
from .column import Column, headed
from .options import Options
from .table import Table

TITLE = "text or CSV: columns of numbers, with a header or without"

_UTF16 = (b"\xff\xfe", b"\xfe\xff")
_WIDEST = 1000


def sniff(head: bytes, suffix: str) -> bool:
    """Whether the first bytes are those of a text."""
    if head.startswith(_UTF16):
        return True
    control = sum(head.count(bytes([code])) for code in range(32) if code not in b"\t\n\v\f\r\x1a")
    return control == 0 and bool(head.strip())


def read(path: str, options: Options) -> Recording:
    """The channels of a text file.

    Raises
    ------
    DataError
        The file holds no rows of numbers, or something else among them; the line is named.
    UsageError
        What the file does not say is not given either.
    """
    data = _plain(Path(path).read_bytes())
    found = layout.find(data)
    if found.width > _WIDEST:
        raise DataError(
            f"line {found.line} holds {found.width} numbers; one row for each sample is expected, each on its own line"
        )
    values, notes = parse.columns(data, found)
    columns = (_column(v, i, found) for i, v in enumerate(values) if v is not None)
    table = csv_file.with_description(Table(tuple(columns), notes=(*found.notes, *notes)), data)
    return table.recording(options)


def _plain(data: bytes) -> bytes:
    """UTF-8 or Latin-1 without a byte order mark, with line ends that contain a newline."""
    if data.startswith(_UTF16):
        try:
            data = data.decode("utf-16").encode()
        except UnicodeDecodeError as error:
            raise DataError(f"the file begins like UTF-16 text but is damaged: {error}") from None
    data = data.removeprefix(b"\xef\xbb\xbf").removesuffix(b"\x1a")
    if b"\x00" in data:
        raise DataError(f"a zero byte stands at byte {data.index(0)} of the text: the file is damaged or binary")
    return data if b"\n" in data[: layout.HEAD] else data.replace(b"\r", b"\n")


def _column(values: parse.Values | str, place: int, found: layout.Layout) -> Column:
    import numpy as np

    name, unit = found.names[place], found.units[place]
    if isinstance(values, str):
        return headed(np.empty(0), place + 1, name, text=values)
    if values.dtype.kind == "M":
        return headed(values.astype(np.int64), place + 1, name or "time", unit="ns")
    return headed(values, place + 1, name, unit=unit)
