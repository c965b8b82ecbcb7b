"""The layout of a text file: delimiter, decimal sign, comments, names, sampling rate, the first row of numbers."""

import csv
import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, chain, islice
from typing import NamedTuple

from allanite.core.errors import DataError
from allanite.core.units import unit_of
from allanite.phrases.phrase import Phrase, join, say, say_count

from . import headers

_RATE = (
    r"sampl(?:e|ing)[ _-]?(?:rate|freq(?:uency|\.)?)|(?:output|imu)[ _]data[ _]rate|odr"
    r"|update[ _](?:rate|freq(?:uency)?)|частота\s+(?:дискретизации|опроса|выборки|регистрации|измерений|съ[её]ма)"
    "|采样(?:频率|速率|率)|更新(?:率|频率)|输出频率"
)
_INTERVAL = (
    r"sampl(?:e|ing)[ _-]?(?:interval|period|time)|time[ _]?step"
    r"|(?:период|интервал|шаг)\s+(?:дискретизации|опроса|выборки)"
    "|采样(?:间隔|周期|时间)"
)
_STATED = re.compile(
    rf"(?:^|[^\w])(?:(?P<rate>{_RATE}|(?-i:[Ff]s))|(?P<interval>{_INTERVAL}))\s*(?:[\[(（,]\s*(?P<before>[^\W\d]+)\s*[\])）]?)?"
    r"[\s\"':=：,;]+(?P<number>\d+(?P<fraction>[.,]\d+)?(?:e[-+]?\d+)?)[\s\"',;]*(?P<after>[^\W\d]+(?:/[^\W\d]+)?)?(?![\w.,%]*\d|[/-])",
    re.IGNORECASE,
)
_HERTZ = {"hz": 1.0, "гц": 1.0, "赫兹": 1.0, "赫": 1.0, "khz": 1e3, "кгц": 1e3, "sps": 1.0, "samples/s": 1.0}
_FASTEST = 1e7


class StatedRate(NamedTuple):
    """A rate in Hz, and the line that states it."""

    rate: float
    line: int
    text: str


def statement(line: int, text: str, decimal: str = ".") -> StatedRate | None:
    """The sampling rate that a line states; None if it states none."""
    stated = _STATED.search(text) if len(text) <= headers.LONGEST_HEADER else None
    if stated is None or (stated["fraction"] or "").startswith(",") > (decimal == ","):
        return None
    number, unit = float(stated["number"].replace(",", ".")), stated["after"] or stated["before"] or ""
    if stated["rate"]:
        value = number * _HERTZ.get(unit.lower(), 0.0 if unit else 1.0)
    else:  # a number without unit may be seconds or milliseconds
        value = 1 / (number * unit_of(unit).factor) if headers.is_time(unit) and number else 0.0
    return StatedRate(value, line, text.lstrip("#%/; ").strip()[:60]) if 0 < value <= _FASTEST else None


def nominal(lines: Iterable[tuple[int, str]], decimal: str) -> tuple[float | None, Phrase]:
    """The rate that the lines above the numbers state, with its place; no rate if they contradict each other."""
    statements = [stated for line, text in lines if (stated := statement(line, text, decimal))]
    places = join(" ", ())
    if statements:
        places = join(
            ", ", (say("line {line} ({text!r})", line=stated.line, text=stated.text) for stated in statements)
        )
    rates = [stated.rate for stated in statements]
    if not rates or max(rates) > 1.001 * min(rates):
        return None, places
    return rates[0], places


MISSING = frozenset(("", "nan", "null", "na", "n/a", "#n/a", "-nan", "none", "1.#qnan", "-1.#ind", "1.#ind"))

_NUMBER = re.compile(r"[-+]?(?:(?:\d+(?:\.\d*)?|\.\d+)(?:e[-+]?\d+)?|nan|inf|infinity)", re.IGNORECASE)


@dataclass
class Row:
    """A line of the file: its number from 1, its offset, its text, delimiter and decimal sign."""

    line: int
    offset: int
    text: str
    style: tuple[str, str]

    @cached_property
    def cells(self) -> list[str]:
        """Its cells."""
        return cells(self.text, self.style[0])

    @cached_property
    def has_number(self) -> bool:
        """Whether a cell is a number."""
        return any(is_number(cell, self.style[1]) for cell in self.cells)


def is_number(cell: str, decimal: str = ".") -> bool:
    """Whether a cell is a number."""
    return bool(_NUMBER.fullmatch(cell if decimal == "." else cell.replace(decimal, ".", 1)))


def cells(line: str, delimiter: str) -> list[str]:
    """The cells of a line, without quotes and surrounding blanks."""
    if delimiter == " ":
        return line.split()
    if '"' in line:
        try:
            return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]
        except csv.Error:
            pass  # a stray quotation mark: split at the delimiters
    return [cell.strip() for cell in line.split(delimiter)]


def decoded(raw: bytes) -> str:
    """Text of a header: UTF-8, otherwise Latin-1, in which older loggers write the degree sign."""
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


HEAD = 1 << 17  # bytes at the beginning of a file from which its layout is determined
JUDGED_ROWS, FEW_ROWS = 200, 600  # rows by which the columns are judged, and rows of which all are looked at for them

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

    @property
    def width(self) -> int:
        """Number of columns."""
        return len(self.names)


def find(data: bytes) -> Layout:
    """The layout of a text; refused if there are no rows of numbers near the beginning, or more names than columns."""
    lines = numbered_lines(data)
    if not lines:
        raise DataError(say(
            "the first line is longer than {size} bytes; expected one row per sample, each on its own line",
            size=HEAD,
        ))  # fmt: skip
    delimiter, decimal = _style_of([text for _, _, text in lines if text])
    marks = marks_of(delimiter)
    # a line with a word is not one of numbers
    worded = ((n, text) for n, _, text in lines if any(map(str.isalpha, _LETTER.findall(text))))
    rated = [line for line in worded if statement(*line, decimal)]
    stating = {number for number, _ in rated}
    lines = [line for line in lines if line[0] not in stating]
    comments = [(number, text) for number, _, text in lines if text.startswith(marks)]
    rows = [Row(*line, (delimiter, decimal)) for line in lines if line[2] and not line[2].startswith(marks)]
    first, text = _first_row(rows, decimal)
    names, units, notes = _named(rows[: first + 1], comments, delimiter, decimal)
    if not any(names) and _numbered(rows[first], rows[first + 1 :]):
        names, first = tuple(rows[first].cells), first + 1
        notes = (
            say(
                "line {line} with the numbers {names}.. is used as column names",
                line=rows[first - 1].line, names=", ".join(names[:3]),
            ),
        )  # fmt: skip
    if decimal == ",":
        notes = (*notes, say("the decimal sign is a comma"))
    rate, places = nominal((line for line in rated if line[0] < rows[first].line), decimal)
    if rate is None and places:
        notes = (*notes, say("rates that contradict each other are not used: {places}", places=places))
    return Layout(
        delimiter, decimal, names, units, text, rows[first].offset, rows[first].line, notes, (rate, places)
    )  # fmt: skip


def _style_of(texts: list[str]) -> tuple[str, str]:
    """Delimiter and decimal sign of all but comments, among which lines of cells between semicolons may be."""
    plain = [text for text in texts if not text.startswith(MARKS)]
    return style([*plain[:1], *plain[-JUDGED_ROWS:]] or [text for text in texts if not text.startswith(MARKS[:3])])


def marks_of(delimiter: str) -> tuple[str, ...]:
    """The prefixes of comment lines beside a delimiter."""
    return MARKS[:3] if delimiter == ";" else MARKS


def numbered_lines(data: bytes) -> list[tuple[int, int, str]]:
    """Number, offset and text of the whole lines at the beginning."""
    head = data[:HEAD]
    raw = head.splitlines(keepends=True)
    if len(data) > HEAD:
        raw = raw[:-1]
    starts = accumulate((len(line) for line in raw), initial=0)
    # a tab at either end is an empty cell, unless all lines have it
    texts = (line.strip(" \r\n") for line in _decoded_lines(raw))
    return [(i, at, text if text.strip() else "") for i, (at, text) in enumerate(zip(starts, texts, strict=False), 1)]


def _decoded_lines(lines: list[bytes]) -> list[str]:
    try:
        return [line.decode("utf-8") for line in lines]
    except UnicodeDecodeError:
        return list(map(decoded, lines))


def style(lines: list[str]) -> tuple[str, str]:
    """Delimiter and decimal sign: those that make the largest share of the cells numbers, and then the most numbers."""

    def score(style: tuple[str, str]) -> tuple[float, int]:
        numbers = [is_number(cell, style[1]) for line in lines for cell in cells(line, style[0]) if cell]
        return (sum(numbers) / max(1, len(numbers)), sum(numbers))

    best = max(_STYLES, key=score)
    # mixed tabs and blanks: if blanks give as many cells in every line, header included, no cell is empty or contains
    # one
    widths = {len(cells(line, " ")) for line in lines} if best[0] == "\t" else set()
    return (" ", best[1]) if len(widths) == 1 and all(len(cells(line, "\t")) in widths for line in lines[-1:]) else best


def _first_row(rows: list[Row], decimal: str) -> tuple[int, frozenset[int]]:
    """Index of the first row of numbers, and the positions of the columns of words."""
    width, text = _columns(_judged(rows), decimal)

    def fits(row: Row) -> bool:
        checked = (cell for i, cell in enumerate(row.cells) if i not in text and cell.lower() not in MISSING)
        return all(is_number(cell, decimal) for cell in checked)

    def wide(row: Row) -> bool:
        return row.has_number and len(row.cells) == width

    wide_rows = (i for i, row in enumerate(rows) if wide(row))
    first = next(wide_rows)
    first = next((i for i in chain((first,), wide_rows) if fits(rows[i])), first)
    # a row with numbers directly above, without a header between, is damaged, not a preamble: refused by name later
    while first and wide(rows[first - 1]):
        first -= 1
    return first, text


def _judged(rows: list[Row]) -> list[Row]:
    """The rows by which the columns are judged, from the middle of those with numbers; refused if there are none."""
    first = next((i for i, row in enumerate(rows) if row.has_number), None)
    if first is None:
        shown = say("it contains only comments or blank lines")
        shown = say("its first line is {text!r}", text=rows[0].cells[0][:40]) if rows else shown
        raise DataError(say("no rows of numbers were found ({seen}); a text file needs one row per sample", seen=shown))
    # below the first row with numbers nearly all have some: few are looked at
    middle = first + (len(rows) - first) // 2
    numeric = list(islice((row for row in rows[middle:] if row.has_number), JUDGED_ROWS))
    if len(rows) > FEW_ROWS and len(numeric) == JUDGED_ROWS:
        return numeric
    numeric = [row for row in rows if row.has_number]
    return numeric[len(numeric) // 2 :][:JUDGED_ROWS]


def _columns(rows: list[Row], decimal: str) -> tuple[int, frozenset[int]]:
    """The number of columns of most rows, and the positions of those that have words and no numbers."""
    width = Counter(len(row.cells) for row in rows).most_common(1)[0][0]
    cells_of = zip(*(row.cells for row in rows if len(row.cells) == width), strict=True)
    filled = [[cell for cell in column if cell.lower() not in MISSING] for column in cells_of]
    return width, frozenset(
        i for i, column in enumerate(filled) if column and not any(is_number(cell, decimal) for cell in column)
    )


def _numbered(row: Row, following: list[Row]) -> bool:
    """Whether a row is the header 0, 1, 2.. that pandas writes for columns without names."""
    names = row.cells[1:] if row.cells[0] == "" else row.cells
    fractions = following and any(not re.fullmatch(r"[-+]?\d*", cell) for cell in following[0].cells)
    return len(names) > 1 and names == [str(i) for i in range(len(names))] and bool(fractions)


def _named(
    rows: list[Row], comments: list[tuple[int, str]], delimiter: str, decimal: str
) -> tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
    """Names, units and notes from the lines above the first row of numbers, which is the last of `rows`."""
    above, width = rows[:-1], len(rows[-1].cells)
    worded = [row for row in above[-2:] if not row.has_number]
    blank = ("",) * width
    units = blank
    # the second of two lines of words may be one of units
    last = worded[-1].cells if len(worded) == 2 and above[-1] is worded[-1] else []
    marked = [cell.strip("[](){} ") for cell in last if cell.strip("[](){} -")]
    if sum(headers.known(cell.strip()) is not None for cell in marked) > len(marked) / 2:
        units = tuple((worded.pop().cells + list(blank))[:width])
    named = _names(worded[-1].cells, width, delimiter) if worded and worded[-1] is above[-1 - any(units)] else None
    if named is not None:
        passed = len(above) - 1 - any(units)
        filled = sum(map(bool, named))
        unnamed = (
            (say("the header names {filled} of {width} columns", filled=filled, width=width),) if filled < width else ()
        )
        return named, units, _passed(passed, above[0]) + unnamed
    commented = [(number, text) for number, text in comments if number < rows[-1].line][-1:]
    for number, text in commented:
        header = _commented(text, width, delimiter, decimal)
        if header is not None:
            return (
                header,
                blank,
                (*_passed(len(above), rows[0]), say("column names from the comment on line {number}", number=number)),
            )
    return blank, blank, _passed(len(above), rows[0])


def _names(row: list[str], width: int, delimiter: str) -> tuple[str, ...] | None:
    """The cells of a header as one name per column; None if the line is not a header."""
    if delimiter == " ":
        row = row if len(row) == width else _BLANK_HEADER.findall(" ".join(row))
        return tuple(row) if len(row) == width else None
    while len(row) > width and not row[-1]:
        row = row[:-1]
    if len(row) > width:
        raise DataError(say(
            "the header names {count} columns ({names}..) but the rows below have {width}",
            count=len(row), names=", ".join(row[:8]), width=width,
        ))  # fmt: skip
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
    skipped = say_count(
        count,
        "skipped {count} line above the numbers, the first {text!r}",
        "skipped {count} lines above the numbers, the first {text!r}",
        text=row.cells[0][:40],
    )
    return (skipped,)
