"""The names and units of columns, from the lines above the first row of numbers."""

import re

from allanite.core.errors import DataError

from . import headers
from .cells import Row, cells, has_number, is_number

_BLANK_HEADER = re.compile(r"\S+?(?:\s*\[[^\]]*\]|\s*\([^)]*\))|\S+")


def header(
    rows: list[Row], comments: list[tuple[int, str]], delimiter: str, decimal: str
) -> tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
    """Names, units and notes from the lines above the first row of numbers, which is the last of `rows`."""
    above, width = rows[:-1], len(rows[-1].cells)
    worded = [row for row in above[-2:] if not has_number(row, decimal)]
    blank = ("",) * width
    units = blank
    if len(worded) == 2 and above[-1] is worded[-1] and _is_units(worded[-1].cells):
        units = tuple((worded.pop().cells + list(blank))[:width])
    named = _names(worded[-1].cells, width, delimiter) if worded and worded[-1] is above[-1 - any(units)] else None
    if named is not None:
        passed = len(above) - 1 - any(units)
        return named, units, _passed(passed, above[0]) + _unnamed(named)
    commented = [(number, text) for number, text in comments if number < rows[-1].line][-1:]
    for number, text in commented:
        said = _commented(text, width, delimiter, decimal)
        if said is not None:
            return said, blank, (*_passed(len(above), rows[0]), f"column names from the comment on line {number}")
    return blank, blank, _passed(len(above), rows[0])


def _is_units(row: list[str]) -> bool:
    filled = [cell.strip("[](){} ") for cell in row if cell.strip("[](){} -")]
    return bool(filled) and sum(headers.known(cell.strip()) is not None for cell in filled) > len(filled) / 2


def _names(row: list[str], width: int, delimiter: str) -> tuple[str, ...] | None:
    """The cells of a header as one name a column; None if the line is no header."""
    if delimiter == " ":
        row = row if len(row) == width else _BLANK_HEADER.findall(" ".join(row))
        return tuple(row) if len(row) == width else None
    while len(row) > width and not row[-1]:
        row = row[:-1]
    if len(row) > width:
        raise DataError(f"the header names {len(row)} columns ({', '.join(row[:8])}..) but the rows below have {width}")
    return tuple(row + [""] * (width - len(row))) if len(row) > 1 or width == 1 else None


def _commented(text: str, width: int, delimiter: str, decimal: str) -> tuple[str, ...] | None:
    """Names in a comment such as ``#timestamp [ns],w_x [rad s^-1]``; None if it is an ordinary comment."""
    row = cells(text.lstrip("#%;/ \t"), delimiter)
    if delimiter == " " and len(row) != width:
        row = _BLANK_HEADER.findall(" ".join(row))
    wordy = all(re.search(r"[^\W\d]", cell) and not is_number(cell, decimal) for cell in row)
    prose = width == 1 and len(_BLANK_HEADER.findall(" ".join(row))) > 1
    return tuple(row) if len(row) == width and wordy and not prose else None


def _passed(count: int, row: Row) -> tuple[str, ...]:
    if count <= 0:
        return ()
    return (f"{count} line{'s' * (count > 1)} above the numbers passed over, the first {row.cells[0][:40]!r}",)


def _unnamed(names: tuple[str, ...]) -> tuple[str, ...]:
    named = sum(bool(name) for name in names)
    return (f"the header names {named} of {len(names)} columns",) if named < len(names) else ()
