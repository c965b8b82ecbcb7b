"""Parses the rows of numbers of a text file to columns with pyarrow; locates what is not a number."""

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, NoReturn

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError
from allanite.parallel.processors import spare
from allanite.phrases.phrase import say, say_count
from allanite.readers.arrow import csv, pa, pc

from . import dates
from .column import of_arrow
from .layout import MISSING, Layout, cells, decoded, is_number, marks_of

_NULLS = [*MISSING, "NaN", "NAN", "NULL", "None", "NA", "N/A", "#N/A", "-NaN", "1.#QNAN", "-1.#IND"]

LONGEST_ROW = 1 << 20  # bytes of a row that pyarrow reads, whose blocks have as many
FEW_WORDS = 16  # maximum number of different words in a column that may distinguish rows
JUDGED_BYTES = 1 << 20  # bytes of the rows that show whether it has more

Values = NDArray[Any]


class Tags(NamedTuple):
    """A column of few words: the words, and the index of the word in each row."""

    words: tuple[str, ...]
    codes: Values


Parsed = Values | Tags | str | None


@dataclass
class Forms:
    """What the first rows show of the columns of words, by position, so that later rows are read alike."""

    types: dict[int, Any] = field(default_factory=dict)  # those of pyarrow
    patterns: dict[int, str] = field(default_factory=dict)  # of dates, empty for other words
    american: set[int] = field(default_factory=set)  # the dates whose month and day are in the other order
    rows: int = 0  # so far


def columns(
    data: bytes, layout: Layout, forms: Forms | None = None, *, last: bool = True
) -> tuple[list[Parsed], tuple[str, ...]]:
    """The columns of the rows from ``layout.offset`` on, and notes on what was skipped."""
    # With `forms` of the rows above, the text is a part of one, perhaps the `last`.
    # A column is float64 or int64 of shape (n,), NaN where a cell is empty; ``datetime64[ns]`` for dates with time,
    # ``datetime64[D]`` for dates, ``timedelta64[ns]`` for times of day; `Tags` for a few words, the first entry for
    # many; None if it is empty. Anything else is refused, with its line.
    held = signs(data, layout.offset)
    body, comments, notes = clean_rows(data, layout, held, last=last)
    notes = notes if forms else (*commented(comments), *notes)
    result, rows = _of_pieces(body, layout) if not forms and len(body) > 2 * PIECE else ([], 0)
    if not result:
        result, rows = _parsed(body, layout, forms, {} if forms else _of_many_words(body, layout))
    if '"' in held and data.count(b'"', layout.offset) % 2 and rows != count(body):
        _blame_quotation(body, layout)
    if any(values is NotImplemented for values in result):
        _blame(body, layout, say("a column of numbers contains something else"))
    if forms:
        forms.rows += rows
    return result, notes


def _parsed(
    body: bytes | memoryview, layout: Layout, forms: Forms | None, many: Mapping[int, str]
) -> tuple[list[Any], int]:
    """The columns of clean rows, and the number of rows; `many` are the first words of columns of many."""
    table = _table(body, layout, forms, many)
    rows, parsed = table.num_rows, dict(zip(map(int, table.column_names), table.columns, strict=True))
    del table  # each column is given back when it is converted
    return [many.get(i) or _values(parsed.pop(i), layout, i, forms) for i in range(layout.width)], rows


PIECE = 1 << 26  # bytes of a large text that are parsed at a time, which take three times as much memory meanwhile


def _of_pieces(body: bytes | memoryview, layout: Layout) -> tuple[list[Any], int]:
    """The columns of a large text, parsed a piece at a time, and the number of rows; none where not all are numbers."""
    pieces, at, rows = list[list[Any]](), 0, 0
    while at < len(body) and not layout.text:
        end = len(body)
        if end - at > PIECE:
            end = at + PIECE - _IN_CACHE + bytes(body[at + PIECE - _IN_CACHE : at + PIECE]).rfind(b"\n") + 1
        try:
            piece, count = _parsed(body[at:end], layout, None, {})
        except DataError:  # which the whole text names by its line
            return [], 0
        if any(not isinstance(values, np.ndarray) or values.dtype.kind not in "if" for values in piece):
            return [], 0
        pieces.append(piece)
        at, rows = end, rows + count
    columns = [[piece[i] for piece in pieces] for i in range(layout.width)] if pieces else []
    pieces.clear()
    pa.default_memory_pool().release_unused()
    for parts in columns:  # those that are joined are given back
        parts[:] = [np.concatenate(parts)]
    return [values for (values,) in columns], rows


def forms_of(data: bytes, layout: Layout, *, last: bool) -> Forms:
    """What rows show of the columns of words; see `Forms`."""
    forms = Forms()
    body = clean_rows(data, layout, signs(data, layout.offset), last=last)[0] if layout.text else b""
    table: Any = _table(body, layout, None) if layout.text else None
    for place in layout.text:
        kind = table.column(place).type
        if pa.types.is_timestamp(kind):
            forms.types[place] = kind
        else:
            forms.types[place] = pa.string()
            forms.patterns[place] = dates.pattern_of(_first_word(table.column(place).cast(pa.string())))
    return forms


def see_order(body: bytes | memoryview, layout: Layout, forms: Forms) -> None:
    """Look whether the dates of clean rows show that their month and day are in the other order."""
    dated = {i: form for i, form in forms.patterns.items() if "<m>" in form and i not in forms.american}
    table: Any = _table(body, layout, forms) if dated else None
    forms.american |= {i for i, form in dated.items() if dates.is_american(table.column(i), form)}


def count(body: bytes | memoryview) -> int:
    """The number of rows of a text without comments."""
    text = bytes(body)
    empty = len(re.findall(rb"^\r?\n", text, re.MULTILINE)) if b"\n\n" in text or b"\n\r\n" in text else 0
    return text.count(b"\n") + (text[-1:] not in (b"", b"\n")) - max(empty, text.startswith((b"\n", b"\r\n")))


SIGNS = '#%/;" '
"""Signs that mean something else than a number."""

_IN_CACHE = 1 << 18  # bytes that are searched for all signs before the next ones


def signs(data: bytes, start: int) -> frozenset[str]:
    """The `SIGNS` that occur in a text from a place on."""
    held, rest = set[str](), {sign: sign.encode() for sign in SIGNS}
    for at in range(start, len(data), _IN_CACHE):
        for sign in [s for s, byte in rest.items() if data.find(byte, at, at + _IN_CACHE) >= 0]:
            held.add(sign)
            del rest[sign]
    return frozenset(held)


def clean_rows(
    data: bytes, layout: Layout, held: frozenset[str], *, last: bool = True
) -> tuple[bytes | memoryview, int, tuple[str, ...]]:
    """The rows as they are parsed, the number of comments, and notes on what was left out at the end of the `last`."""
    # They have no comments, and single blanks between cells; line numbers are preserved. Most texts `held` no signs of
    # what is left out.
    body: bytes | memoryview = memoryview(data)[layout.offset :]
    begin, blank = layout.offset, (b"\n\n", b"\n\r\n", b"\n\t", b"\n ")
    if layout.empties and (data[begin : begin + 1].isspace() or any(data.find(mark, begin) >= 0 for mark in blank)):
        body = _with_empties(bytes(body), layout, last=last)
    comments, marks = 0, [mark for mark in marks_of(layout.delimiter) if held.issuperset(mark)]
    if marks:
        pattern = rb"(?m)^[ \t]*(?:" + b"|".join(re.escape(mark.encode()) for mark in marks) + rb")[^\r\n]*"
        body, comments = re.subn(pattern, b"", bytes(body))
    if layout.delimiter == " ":
        text = bytes(body).translate(bytes.maketrans(b"\t\v\f", b"   ")).replace(b"\r\n", b"\n")
        while b"  " in text:  # halves the runs each time
            text = text.replace(b"  ", b" ")
        body = text.replace(b"\n ", b"\n").replace(b" \n", b"\n").strip(b" ")
    elif " " in held and any(data.find(end, layout.offset) >= 0 for end in (b" \n", b" \r\n")):
        # a line of blanks is an empty line, not a row with one cell
        body = re.sub(rb"^ +(?=\r?$)", b"", bytes(body), flags=re.MULTILINE)
    if not last:
        return body, comments, ()
    # an incomplete last line, as after a power failure of the logger, or a closing remark
    tail = bytes(body[-65536:]).rstrip(b" \r\n")
    start = max(tail.rfind(b"\n"), tail.rfind(b"\r")) + 1
    end = decoded(tail[start:])
    count = len(cells(end, layout.delimiter))
    if start == 0 or count >= layout.width:
        return body, comments, ()
    note = say("the last line ({text!r}) has {count} of {width} columns and was left out",
               text=end[:40], count=count, width=layout.width)  # fmt: skip
    return body[: len(body) - min(len(body), 65536) + start], comments, (note,)


def _with_empties(body: bytes, layout: Layout, *, last: bool) -> bytes:
    """The rows of a single column with a missing sample in each empty line, but around comments and at the end."""
    marks = b"|".join(re.escape(mark.encode()) for mark in marks_of(layout.delimiter))
    end = len(body.rstrip()) if last else len(body)
    empty = re.compile(rb"(?m)(?:^[ \t]*(?:(?:%s)[^\n]*)?\r?\n)+" % marks)
    return empty.sub(lambda run: run[0] if run[0].strip() else b"nan\n" * run[0].count(b"\n"), body[:end]) + body[end:]


def commented(count: int) -> tuple[str, ...]:
    """The note on so many comments."""
    if not count:
        return ()
    return (say_count(count, "skipped {count} comment among the rows of numbers",
                      "skipped {count} comments among the rows of numbers"),)  # fmt: skip


def _of_many_words(body: bytes | memoryview, layout: Layout) -> dict[int, str]:
    """The first words of the columns of many words by position: of these, nothing else is kept."""
    if not layout.text or len(body) < JUDGED_BYTES:
        return {}
    head = bytes(body[:JUDGED_BYTES])
    rows: Any = _table(head[: head.rfind(b"\n") + 1] or body, layout, None)
    words = {i: rows.column(i) for i in layout.text if str(rows.column(i).type) == "string"}
    return {i: _first_word(column) for i, column in words.items() if _has_many(column)}


def _table(body: bytes | memoryview, layout: Layout, forms: Forms | None, without: Collection[int] = ()) -> Any:
    read = csv.ReadOptions(use_threads=spare(), column_names=[str(i) for i in range(layout.width)])
    parse = csv.ParseOptions(delimiter=layout.delimiter)
    types = {str(place): kind for place, kind in forms.types.items()} if forms else {}
    convert = csv.ConvertOptions(null_values=_NULLS, decimal_point=layout.decimal, column_types=types)
    convert.include_columns = [str(i) for i in range(layout.width) if i not in without]
    try:
        source = pa.BufferReader(pa.py_buffer(body))
        return csv.read_csv(source, read_options=read, parse_options=parse, convert_options=convert)
    except pa.ArrowCancelled:  # by a signal that does not end the program, as in a watch
        return _table(body, layout, forms, without)
    except pa.ArrowException as error:
        _blame(body, layout, str(error))


def _values(column: Any, layout: Layout, place: int, forms: Forms | None) -> Any:
    """One column as numbers or as its first word; NotImplemented if words occur among its numbers."""
    kind = column.type
    if pa.types.is_null(kind):
        return np.full(len(column), np.nan) if layout.names[place] or forms else None
    if pa.types.is_integer(kind) or pa.types.is_floating(kind):
        return of_arrow(column)
    if pa.types.is_timestamp(kind) and (forms is None or place in forms.types):
        try:
            return of_arrow(column.cast(pa.timestamp("ns")))
        except pa.ArrowInvalid:
            pass  # a year outside the range of 64-bit nanoseconds: words
    if place in layout.text:
        return _words(column, layout, place, forms)
    # numbers that pyarrow does not accept as they are: with a plus sign, or blanks for an empty cell
    try:
        text = pc.utf8_trim_whitespace(column.cast(pa.string()))
        text = pc.if_else(pc.is_in(pc.utf8_lower(text), pa.array(sorted(MISSING))), None, text)
        text = pc.replace_substring_regex(text, r"^\+", "")
        text = pc.replace_substring(text, layout.decimal, ".")
        return of_arrow(text.cast(pa.float64()))
    except pa.ArrowException:
        return NotImplemented


def _words(column: Any, layout: Layout, place: int, forms: Forms | None) -> Parsed:
    try:
        words = column.cast(pa.string())
    except pa.ArrowInvalid:
        return "text"  # of an unknown encoding
    name = layout.names[place]
    label = say("column {name!r}", name=name) if name else say("column {position}", position=place + 1)
    if forms is None:
        return words_of(words, label)
    pattern = forms.patterns.get(place)
    return dates.parsed(words, pattern, label, forms.rows, place in forms.american) if pattern else "text"


def words_of(column: Any, label: str) -> Parsed:
    """A column of words of pyarrow: dates and times, a few repeated words as codes, otherwise the first word."""
    first = _first_word(column)
    pattern = dates.pattern_of(first)
    if pattern:
        return dates.parsed(column, pattern, label)
    if _has_many(column):
        return first
    codes = column.combine_chunks().dictionary_encode()
    words = tuple(str(word) for word in codes.dictionary.to_pylist())
    return Tags(words, np.asarray(codes.indices.fill_null(-1))) if len(words) <= FEW_WORDS else first


def _has_many(column: Any) -> bool:
    """Whether a column of words has too many to distinguish rows, and they are no dates."""
    return not dates.pattern_of(_first_word(column)) and len(pc.unique(column[: FEW_WORDS * 100])) > FEW_WORDS


def _first_word(column: Any) -> str:
    return str(next((entry for entry in column[:100].to_pylist() if entry), "text"))


def _blame(body: bytes | memoryview, layout: Layout, otherwise: str) -> NoReturn:
    """Name the line and column of what is not a number; slow, but used only for a refusal."""
    for i, raw in enumerate(bytes(body).splitlines()):
        line = decoded(raw).strip(" ") if layout.delimiter == " " else decoded(raw)
        row = cells(line, layout.delimiter)
        if not line.strip():
            continue
        where = say("line {line}", line=layout.line + i)
        if len(raw) > LONGEST_ROW:
            raise DataError(say("{where} has {size} bytes; expected one row per sample, each on its own line",
                                where=where, size=len(raw)))  # fmt: skip
        if len(row) != layout.width:
            raise DataError(say("{where} has {count} columns instead of {width}: {line!r}",
                                where=where, count=len(row), width=layout.width, line=line[:60]))  # fmt: skip
        for place, cell in enumerate(row):
            if place not in layout.text and not is_number(cell, layout.decimal) and cell.lower() not in MISSING:
                name = layout.names[place] or say("column {position}", position=place + 1)
                raise DataError(say("{where}, column {name!r}: {cell!r} is not a number; correct or remove the line",
                                    where=where, name=name, cell=cell[:40]))  # fmt: skip
    raise DataError(say("the rows of numbers cannot be read: {reason}", reason=otherwise.splitlines()[0][:200]))


def _blame_quotation(body: bytes | memoryview, layout: Layout) -> NoReturn:
    """Name the first line with a quotation mark that is not closed in it."""
    i, raw = next((i, raw) for i, raw in enumerate(bytes(body).splitlines()) if raw.count(b'"') % 2)
    where = say("line {line}", line=layout.line + i)
    raise DataError(say("{where}: a quotation mark is not closed: {line!r}", where=where, line=decoded(raw)[:60]))
