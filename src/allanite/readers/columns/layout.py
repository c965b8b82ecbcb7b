"""The layout of a text file: delimiter, decimal sign, comments, names, and the first row of numbers."""

import csv
import math
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import accumulate, chain, pairwise, takewhile, zip_longest
from typing import NamedTuple

from allanite.core.errors import DataError
from allanite.phrases.phrase import say, say_count

from . import headers, preamble

MISSING = frozenset(("", "nan", "null", "na", "n/a", "#n/a", "-nan", "none", "1.#qnan", "-1.#ind", "1.#ind"))

_NUMBERS = {
    sign: re.compile(rf"[-+]?(?:(?:\d+(?:{signs}\d*)?|{signs}\d+)(?:e[-+]?\d+)?|nan|inf|infinity)", re.IGNORECASE)
    for sign, signs in ((".", r"\."), (",", "[.,]"))
}
"""Numbers by their decimal sign; some have a point beside a comma."""


class Row(NamedTuple):
    """A line of the file: its number from 1, its offset, its cells, and whether one of them is a number."""

    line: int
    offset: int
    cells: list[str]
    has_number: bool


def is_number(cell: str, decimal: str = ".") -> bool:
    """Whether a cell is a number."""
    return bool(_NUMBERS[decimal].fullmatch(cell))


def cells(line: str, delimiter: str) -> list[str]:
    """The cells of a line, without quotes and surrounding blanks."""
    return cells_of((line,), delimiter)[0]


def cells_of(lines: Iterable[str], delimiter: str) -> list[list[str]]:
    """The cells of each line."""
    if delimiter == " ":
        return [line.split() for line in lines]
    split = [_unquoted(line, delimiter) if '"' in line else line.split(delimiter) for line in lines]
    return [list(map(str.strip, row)) for row in split]


def _unquoted(line: str, delimiter: str) -> list[str]:
    try:
        return next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
    except csv.Error:  # a stray quotation mark: split at the delimiters
        return line.split(delimiter)


def decoded(raw: bytes) -> str:
    """Text of a header: UTF-8, otherwise Latin-1, in which older loggers write the degree sign."""
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


HEAD = 1 << 17  # bytes at the beginning of a file from which its layout is determined
LONGEST_HEAD = 1 << 22  # bytes of it at most, where the lines are longer
JUDGED_ROWS = 200  # rows by which the columns are judged
LINES = 2 * JUDGED_ROWS  # lines from which the layout is determined: the first ones, and some of the middle

HEADING = 3  # lines of words above the numbers, at most: groups, names and units

MARKS = ("#", "%", "//", ";")
"""Prefixes of comment lines; a semicolon is not one if it is the delimiter."""

# delimiter and decimal sign, the more likely first, which decides if a file can be read in two ways
_STYLES = ((",", "."), (";", "."), ("\t", "."), (" ", "."), (";", ","), ("\t", ","), (" ", ","))

_LETTER = re.compile(r"[^\W\d_eE]")  # a letter, or one of the few signs that are neither letters nor decimal digits

_BLANK_HEADER = re.compile(r"\S{1,99}?(?: ?\[[^\]]{0,99}\]| ?\([^)]{0,99}\))|\S+")


@dataclass(frozen=True)
class Layout:
    """The layout of a text file."""

    delimiter: str
    decimal: str
    names: tuple[str, ...]  # names and units have one entry per column, empty if the file has none
    units: tuple[str, ...]
    text: frozenset[int]  # positions of columns of words
    offset: int  # of the first row of numbers, as is its line from 1
    line: int
    notes: tuple[str, ...] = ()  # what was skipped
    nominal: tuple[float | None, str] = (None, "")  # sampling rate, Hz, that the lines above state, with its place
    empties: bool = False  # whether an empty line is an empty cell, as of a single column, unless all rows are apart

    @property
    def width(self) -> int:
        """Number of columns."""
        return len(self.names)


def find(data: bytes) -> Layout:
    """The layout of a text; refused if there are no rows of numbers near the beginning, or more names than columns."""
    if not data.strip():
        raise DataError(say("the file is empty, or has blank lines only; a text file needs one row per sample"))
    # of all lines where it is further down
    begin = _begin_of(numbered_lines(data, LINES), LINES // 4) or _begin_of(numbered_lines(data))
    if begin is None:
        shown = say("it contains only comments or blank lines")
        if words := next((text for _, _, text in numbered_lines(data) if text and not text.startswith(MARKS)), ""):
            shown = say("its first line is {text!r}", text=words[:40])
        raise DataError(say("no rows of numbers were found ({seen}); a text file needs one row per sample", seen=shown))
    delimiter, decimal, rows, first, text, comments, rated = begin
    names, units, notes = _named(rows[: first + 1], comments, delimiter, decimal)
    if not any(names) and _numbered(rows[first], rows[first + 1 :], decimal):
        names, first = tuple(rows[first].cells), first + 1
        above = {"line": rows[first - 1].line, "names": ", ".join(names[:3])}
        notes = (say("line {line} with the numbers {names}.. is used as column names", **above),)
    if decimal == ",":
        notes = (*notes, say("the decimal sign is a comma"))
    rate, places = preamble.nominal((line for line in rated if line[0] < rows[first].line), decimal)
    if rate is None and places:
        notes = (*notes, say("rates that contradict each other are not used: {places}", places=places))
    at = rows[first]
    empties = len(names) == 1 and any(b.line == a.line + 1 for a, b in pairwise(rows[first:]))
    return Layout(delimiter, decimal, names, units, text, at.offset, at.line, notes, (rate, places), empties)


class _Begin(NamedTuple):
    """The first row of numbers among the lines of a text, and what is above it."""

    delimiter: str
    decimal: str
    rows: list[Row]
    first: int  # index of the row
    text: frozenset[int]  # positions of columns of words
    comments: list[tuple[int, str]]
    rated: list[tuple[int, str]]  # lines that state a rate


def _begin_of(lines: list[tuple[int, int, str]], within: int = HEAD) -> _Begin | None:
    """Where the numbers begin; None if none of the first lines, `within` so many, is a row of them."""
    if not lines:
        raise DataError(say("the first line is longer than {size} bytes; expected one row per sample, each on its own "
                            "line", size=LONGEST_HEAD))  # fmt: skip
    delimiter, decimal = _style_of([text for _, _, text in lines if text])
    marks, number = marks_of(delimiter), _NUMBERS[decimal].fullmatch
    # a line with a word is not one of numbers
    worded = [(n, text) for n, _, text in lines if any(map(str.isalpha, _LETTER.findall(text)))]
    rated = [line for line in worded if preamble.statement(*line, decimal)]
    stating = {number for number, _ in rated}
    lines = [line for line in lines if line[0] not in stating]
    comments = [(n, text) for n, _, text in lines if text.startswith(marks)]
    lines = [line for line in lines if line[2] and not line[2].startswith(marks)]
    split = cells_of([text for _, _, text in lines], delimiter)
    rows = [Row(n, at, row, any(map(number, row))) for (n, at, _), row in zip(lines, split, strict=True)]
    numeric = [row for row in rows if row.has_number]
    if not numeric:
        return None
    width, text = _columns(numeric[len(numeric) // 2 :][:JUDGED_ROWS], decimal)
    first = _first_row(rows, width, text, decimal, within)
    return None if first is None else _Begin(delimiter, decimal, rows, first, text, comments, rated)


def _style_of(texts: list[str]) -> tuple[str, str]:
    """Delimiter and decimal sign of all but comments, among which lines of cells between semicolons may be."""
    plain = [text for text in texts if not text.startswith(MARKS)]
    edged = [text for text in plain[1:4] if text.startswith("\t")]  # a cell that is empty, unless all lines begin so
    judged = [*plain[:1], *edged, *plain[-JUDGED_ROWS:]]
    return style(judged or [text for text in texts if not text.startswith(MARKS[:3])])


def marks_of(delimiter: str) -> tuple[str, ...]:
    """The prefixes of comment lines beside a delimiter."""
    return MARKS[:3] if delimiter == ";" else MARKS


def numbered_lines(data: bytes, most: int = HEAD) -> list[tuple[int, int, str]]:
    """Number, offset and text of the whole lines of the head; of more than `most`, of the first and of the middle."""
    size = HEAD
    while size < min(len(data), LONGEST_HEAD) and data.count(b"\n", 0, size) < HEADING + 2:
        size *= 2
    head = data[:size]
    raw = head.splitlines(keepends=True)
    if len(data) > len(head):
        raw = raw[:-1]
    lines = list(zip(range(1, len(raw) + 1), accumulate(map(len, raw), initial=0), raw, strict=False))
    if len(lines) > most:
        half, middle = most // 2, len(lines) // 2
        lines = [*lines[:half], *lines[middle : middle + half]]
    # a tab at either end is an empty cell, unless all lines have it
    texts = [line.strip(" \r\n") for line in _decoded_lines([line for _, _, line in lines])]
    return [(n, at, text if text.strip() else "") for (n, at, _), text in zip(lines, texts, strict=True)]


def _decoded_lines(lines: list[bytes]) -> list[str]:
    try:
        return [line.decode("utf-8") for line in lines]
    except UnicodeDecodeError:
        return list(map(decoded, lines))


def style(lines: list[str]) -> tuple[str, str]:
    """Delimiter and decimal sign: those that make the largest share of the cells numbers, and then the most numbers."""

    def score(style: tuple[str, str]) -> tuple[float, int]:
        filled = [cell for row in cells_of(lines, style[0]) for cell in row if cell]
        numbers = sum(map(bool, map(_NUMBERS[style[1]].fullmatch, filled)))
        return numbers / max(1, len(filled)), numbers

    # delimiters and commas that do not occur make no difference
    text, distinct = "\n".join(lines), dict[tuple[str, bool], tuple[str, str]]()
    for delimiter, decimal in _STYLES:
        known = delimiter if delimiter == " " or delimiter in text else ""
        distinct.setdefault((known, decimal == "," and "," in text), (delimiter, decimal))
    best = max(distinct.values(), key=score)
    # mixed tabs and blanks: if blanks give as many cells in every line, header included, no cell is empty or contains
    # one
    widths = set(map(len, cells_of(lines, " "))) if best[0] == "\t" else set()
    return (" ", best[1]) if len(widths) == 1 and all(len(cells(line, "\t")) in widths for line in lines[-1:]) else best


def _first_row(rows: list[Row], width: int, text: frozenset[int], decimal: str, within: int) -> int | None:
    """Index of the first row of so many numbers and words; None if it is not `within` so many lines."""

    def fits(row: Row) -> bool:
        checked = (cell for i, cell in enumerate(row.cells) if i not in text and cell.lower() not in MISSING)
        return all(is_number(cell, decimal) for cell in checked)

    def wide(row: Row) -> bool:
        return row.has_number and len(row.cells) == width

    wide_rows = (i for i, row in enumerate(rows) if wide(row))
    first = next(wide_rows)
    first = next((i for i in chain((first,), wide_rows) if fits(rows[i])), first)
    if rows[first].line > within:
        return None
    # a row with numbers directly above, without a header between, is damaged, not a preamble: refused by name later
    while first and wide(rows[first - 1]):
        first -= 1
    return first


def _columns(rows: list[Row], decimal: str) -> tuple[int, frozenset[int]]:
    """The number of columns of most rows, and the positions of those that have words and no numbers."""
    width = Counter([len(row.cells) for row in rows]).most_common(1)[0][0]
    columns = zip(*[row.cells for row in rows if len(row.cells) == width], strict=True)
    filled = [[cell for cell in column if cell.lower() not in MISSING] for column in columns]
    of_words = (bool(column) and not any(is_number(cell, decimal) for cell in column) for column in filled)
    return width, frozenset(i for i, words in enumerate(of_words) if words)


def _numbered(row: Row, following: list[Row], decimal: str) -> bool:
    """Whether a row is the header 0, 1, 2.. that pandas writes for columns without names, above fractions only."""
    at = int(row.cells[0] == "")  # below it pandas writes the numbers of the rows
    names = row.cells[at:]
    cells = [cell for other in following[:JUDGED_ROWS] for cell in other.cells[at:] if cell]
    fractions = [cell for cell in cells if not re.fullmatch(r"[-+]?\d*", cell)]
    if len(names) < 2 or names != [str(i) for i in range(len(names))] or not 0 < len(cells) == len(fractions):
        return False
    begin = [other.cells[at].replace(decimal, ".") for other in following[:2]]
    # a clock goes on evenly from the zero
    return not (all(map(is_number, begin)) and math.isclose(2 * float(begin[0]), float(begin[-1]), rel_tol=1e-3))


def _named(
    rows: list[Row], comments: list[tuple[int, str]], delimiter: str, decimal: str
) -> tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
    """Names, units and notes from the lines above the first row of numbers, which is the last of `rows`."""
    above, width = rows[:-1], len(rows[-1].cells)
    blank = ("",) * width
    heading = list(takewhile(lambda row: not row.has_number, reversed(above[-HEADING:])))
    united = next((row for row in heading if len(heading) > 1 and _of_units(row.cells)), None)
    named = [row.cells for row in heading if row is not united]
    units = blank if united is None else tuple((united.cells + list(blank))[:width])
    names = _names(named[0], width, delimiter) if named else None
    if names is not None:
        groups = [cells for cells in named[1:] if _groups(cells, names)]
        if groups or united is not heading[0]:  # a merged cell of units ends with its group
            units = tuple(_merged(units, names, groups[0] if groups else ()))
        for group in groups:
            names, units = _grouped(_merged(group, names), names, units)
        passed = len(above) - 1 - (united is not None)
        filled, notes = sum(map(bool, names)), _passed(passed - len(groups), above[0])
        if filled < width:
            notes = (*notes, say("the header names {filled} of {width} columns", filled=filled, width=width))
        return names, units, notes
    commented = [(number, text) for number, text in comments if number < rows[-1].line][-1:]
    for number, text in commented:
        header = _commented(text, width, delimiter, decimal)
        if header is not None:
            source = say("column names from the comment on line {number}", number=number)
            return header, blank, (*_passed(len(above), rows[0]), source)
    return blank, blank, _passed(len(above), rows[0])


def _of_units(row: list[str]) -> bool:
    """Whether most cells of a line of words are units."""
    marked = [cell.strip("[](){} ") for cell in row if cell.strip("[](){} -")]
    return sum(headers.known(cell) is not None for cell in marked) > len(marked) / 2


def _groups(row: list[str], names: tuple[str, ...]) -> bool:
    """Whether a line names groups of columns whose own names do not suffice."""
    again = len({name for name in names if name}) < sum(map(bool, names))
    return 1 < len(row) <= len(names) and (again or ("" in names and len(row) == len(names)))


def _merged(row: Sequence[str], names: tuple[str, ...], groups: Sequence[str] = ()) -> list[str]:
    """The cells of a line over names, of which a merged one stands in the first of its columns only."""
    filled, last = list[str](), ""
    for cell, name, group in zip_longest(row, names, groups, fillvalue=""):
        last = cell or ("" if group else last)
        filled.append(last if name else cell)
    return filled


def _grouped(groups: list[str], names: tuple[str, ...], units: tuple[str, ...]) -> tuple[tuple[str, ...], ...]:
    """Names and units of columns, each after its group, in which the unit may stand."""
    pairs = list[tuple[str, str]]()
    for group, name, unit in zip(groups, names, units, strict=True):
        stem, its = headers.split(group)
        stem, its = (stem, its) if headers.known(its) else (group, "")
        pairs.append((f"{stem} {name}".strip(), unit or ("" if headers.split(name)[1] else its)))
    return tuple(name for name, _ in pairs), tuple(unit for _, unit in pairs)


def _names(row: list[str], width: int, delimiter: str) -> tuple[str, ...] | None:
    """The cells of a header as one name per column; None if the line is not a header."""
    if delimiter == " ":
        row = row if len(row) == width else _BLANK_HEADER.findall(" ".join(row))
        return tuple(row) if len(row) == width else None
    if "Start" in row and "Increment" in row:  # over the rate that Rigol states beside the names
        row = row[: row.index("Start")]
    while len(row) > width and not row[-1]:
        row = row[:-1]
    if len(row) > width:
        raise DataError(say("the header names {count} columns ({names}..) but the rows below have {width}",
                            count=len(row), names=", ".join(row[:8]), width=width))  # fmt: skip
    return tuple(row + [""] * (width - len(row))) if len(row) > 1 or width == 1 else None


def _commented(text: str, width: int, delimiter: str, decimal: str) -> tuple[str, ...] | None:
    """Names from a comment such as ``#timestamp [ns],w_x [rad s^-1]``; None if it is an ordinary comment."""
    row = cells(text.lstrip("#%;/ \t"), delimiter)
    if delimiter == " " and len(row) != width:
        row = _BLANK_HEADER.findall(" ".join(row))
    wordy = all(re.search(r"[^\W\d]", cell) and not is_number(cell, decimal) for cell in row)
    prose = width == 1 and len(_BLANK_HEADER.findall(" ".join(row))) > 1
    return tuple(row) if len(row) == width and wordy and not prose else None


def _passed(count: int, row: Row) -> tuple[str, ...]:
    if count <= 0:
        return ()
    skipped = say_count(count,
                        "skipped {count} line above the numbers, the first {text!r}",
                        "skipped {count} lines above the numbers, the first {text!r}",
                        text=row.cells[0][:40])  # fmt: skip
    return (skipped,)
