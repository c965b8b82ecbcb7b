"""Dates and times of day as text, converted to nanoseconds."""

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError
from allanite.phrases.phrase import say
from allanite.readers.arrow import pa, pc

DATES = (
    r"(?P<y>\d{4})[-/.](?P<m>\d{1,2})[-/.](?P<d>\d{1,2})",
    r"(?P<d>\d{1,2})[-/.](?P<m>\d{1,2})[-/.](?P<y>\d{4}|\d{2})",
)
TIME = (
    r"(?P<H>\d{1,2}):(?P<M>\d{2})(?::(?P<S>\d{2})(?:[.,:](?P<f>\d{1,9})\d*)?)?\s*(?P<p>[AaPp]?)[Mm]?"
    r"(?:\s*(?:Z|UTC|[-+]\d{2}:?\d{2}))?"
)
PATTERNS = (*(rf"{date}[T_ ]+{TIME}" for date in DATES), *DATES, TIME)
"""Regular expressions for both Python and pyarrow; groups are year, month, day, hour, minute, second, fraction."""

DAY = 86_400 * 10**9

LONGEST_DATE = 100  # maximum number of characters of a date; over long runs of blanks the patterns take quadratic time

Values = NDArray[Any]


def pattern_of(word: str) -> str:
    """The pattern that a word matches; empty if it is not a date or time."""
    word = word.strip()
    return next((p for p in PATTERNS if re.fullmatch(p, word)), "") if len(word) <= LONGEST_DATE else ""


def parsed(words: Any, pattern: str, label: str, first: int = 0, american: bool | None = None) -> Values:
    """A column of words that match one pattern, from row `first` of the data on; NaT where a cell is empty."""
    # ``datetime64[ns]`` for dates with time, ``datetime64[D]`` for dates, ``timedelta64[ns]`` for times of day. Whether
    # the month and the day are in the other order than in the pattern is seen in the words, unless it is given.
    text = pc.utf8_trim_whitespace(words)
    fields = pc.extract_regex(pc.if_else(pc.equal(text, ""), None, text), rf"^(?:{pattern})$")
    wrong = pc.and_(pc.and_(pc.is_valid(text), pc.not_equal(text, "")), pc.is_null(fields))
    if pc.any(wrong).as_py():
        row = pc.index(wrong, True).as_py()
        raise DataError(say("row {row} of the data, {column}: {text!r} is not a date or time of the same format as "
                            "the others", row=first + row + 1, column=label, text=text[row].as_py()[:40]))  # fmt: skip

    def part(name: str) -> Values:
        if f"<{name}>" not in pattern:
            return np.zeros(len(words), dtype=np.int64)
        field = pc.struct_field(fields, name)
        if name == "f":
            field = pc.utf8_rpad(field, 9, "0")
        return np.asarray(pc.fill_null(pc.if_else(pc.equal(field, ""), "0", field), "0").cast(pa.int64()))

    empty = np.asarray(pc.is_null(fields))
    if american is None:
        american = "<y>" in pattern and is_american(words, pattern)
    days = _days(part("y"), part("m"), part("d"), label, american) if "<y>" in pattern else None
    if "<H>" not in pattern:
        assert days is not None  # noqa: S101 - a pattern has a date, a time, or both
        return np.where(empty, np.datetime64("NaT", "D"), days)
    hours = part("H")
    if "<p>" in pattern:  # of the twelve-hour clock
        letter = pc.fill_null(pc.utf8_lower(pc.struct_field(fields, "p")), "")
        after, before = (np.asarray(pc.equal(letter, which)) for which in "pa")
        hours = np.asarray(np.where(after | before, hours % 12 + 12 * after, hours))
    time = (((hours * 60 + part("M")) * 60 + part("S")) * 10**9 + part("f")).astype("timedelta64[ns]")
    if days is None:
        return np.where(empty, np.timedelta64("NaT", "ns"), time)
    return np.where(empty, np.datetime64("NaT", "ns"), days.astype("datetime64[ns]") + time)


def is_american(words: Any, pattern: str) -> bool:
    """Whether words show that the month and the day are in the other order than in their pattern."""
    # The month is never above 12, and within a record it changes only together with the day: if the date does not
    # change, the order does not matter.
    fields = pc.extract_regex(pc.utf8_trim_whitespace(words), rf"^(?:{pattern})$")
    days, months = (pc.min_max(pc.struct_field(fields, name).cast(pa.int64())).as_py() for name in "dm")
    largest = months["max"] or 0
    return largest > 12 or (days["max"] == days["min"] and months["max"] != months["min"])


def _days(year: Values, month: Values, day: Values, label: str, american: bool) -> Values:
    year = np.where((year < 100) & (year > 0), year + 2000, year)
    if american:
        month, day = day, month
    if month.max(initial=1) > 12 or day.max(initial=1) > 31:
        raise DataError(say("{column} holds dates with a month {month} or a day {day}",
                            column=label, month=month.max(), day=day.max()))  # fmt: skip
    months = (year - 1970) * 12 + np.maximum(month, 1) - 1
    days = (np.maximum(day, 1) - 1).astype("timedelta64[D]")
    return np.asarray(months.astype("datetime64[M]").astype("datetime64[D]") + days)


def continued(stamps: Values, last: Values) -> Values:
    """Nanoseconds since the first midnight that continue others, as if `past_midnight` had seen all of them at once."""
    if not last.size or np.isnan(last[-1]):
        return stamps
    days, time = divmod(int(last[-1]), DAY)
    return stamps + DAY * (days + int(stamps[0] - time < -DAY // 2))


def past_midnight(time: Values) -> Values:
    """Nanoseconds since the first midnight from times of day that restart at midnight."""
    stamps = time.astype(np.int64)
    return np.asarray(stamps + DAY * np.cumsum(np.diff(stamps, prepend=stamps[:1]) < -DAY // 2))
