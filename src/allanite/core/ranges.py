"""Ranges of averaging times, frequencies and levels that a user may give, and units times a power of time."""

import math
import re
from collections.abc import Callable, Iterable, Mapping
from itertools import pairwise
from typing import Any, NamedTuple

from .errors import UsageError, given


class Range(NamedTuple):
    """Numbers from `low` to `high` in a unit; without `low` if they are `above` it, without `high` if `below`."""

    low: float
    high: float
    unit: str = ""
    above: bool = False
    below: bool = False
    what: str = ""  # what they are, where a message does not name their option

    def __repr__(self) -> str:
        return self.words()  # as signatures show the annotation of a parameter

    def holds(self, value: Any) -> bool:
        """Whether a number, or each of several, is one of them; words and what is missing always are."""
        value = value.tolist() if hasattr(value, "tolist") else value
        if value is None or isinstance(value, (str, bool)):
            return True
        if isinstance(value, Iterable):
            return all(map(self.holds, value.values() if isinstance(value, Mapping) else value))
        inner = value != self.low if self.above else True
        return bool(self.low <= value <= self.high and inner and not (self.below and value == self.high))

    def words(self, write: Callable[[float], str] = "{:g}".format, unit: str = "") -> str:
        """Which numbers they are: ``above 0 and at most 100 %``."""
        low, high = write(self.low), write(self.high)
        if self.above == self.below:
            words = f"between {low} and {high}"
        else:
            words = f"above {low} and at most {high}" if self.above else f"at least {low} and below {high}"
        return f"{words} {unit or self.unit}".rstrip()

    def demand(self, value: Any, name: str = "it", words: str = "", typed: Any = None) -> Any:
        """The value, which is refused if it holds another number; `name` is that of its parameter."""
        if self.holds(value):
            return value
        shown = given(typed or (value.tolist() if hasattr(value, "tolist") else value))
        refusal = f"{self.what or name} must be {words or self.words()}, not {shown}"
        percent = self.high <= 1 and isinstance(value, (int, float)) and self.high < value <= 100 * self.high
        meant = f"{value / 100:g}" if percent and not words and self.holds(value / 100) else ""
        refusal += f"; did you mean {meant}?" * bool(meant)
        raise UsageError(refusal, cure=(meant and f"{value:g}", meant))


RATE = Range(1e-9, 1e15, "Hz", what="the sampling rate")
"""Sampling rates: beyond them powers of averaging times are not numbers any more."""
TIME = Range(1 / RATE.high, 1e12, "s")
"""Times: from one sample of the highest rate to 30 000 years."""
INSTANT, STAMP = Range(0, TIME.high, "s"), Range(-TIME.high, TIME.high, "s")
"""Times that may be zero, such as that at which a window begins, or negative."""
FREQUENCY = Range(0, RATE.high, "Hz")
SAMPLES = Range(1, 2**53)
"""Numbers of samples: more are not told from each other in floating point."""
INTERVALS = Range(0, 1e15)
"""Time constants in sampling intervals: differences of functions of longer ones are lost in rounding."""
LEVEL = Range(0, 1, above=True, below=True, what="a confidence level")
SHARE = Range(0, 1)
PART = Range(0, 1, above=True)
SEED = Range(0, 2**63 - 1, what="a seed")
LATITUDE, ANGLE = Range(-90, 90, "deg"), Range(-360, 360, "deg")
POSITIVE = Range(1e-30, 1e30)
"""Sizes, of which eighth powers are numbers."""
SIZE, REAL = Range(0, POSITIVE.high), Range(-POSITIVE.high, POSITIVE.high)

AS = {"s": "100..160,300..310", "Hz": "0.4..2.1,19..20"}  # an example of pieces in each unit


def demand_ranges(ranges: object) -> dict[str, tuple[float, float]]:
    """Check ranges of averaging times by the symbol of a term: two times each, the lower one first, none in common."""
    if not isinstance(ranges, Mapping) or not ranges:
        raise UsageError(f"ranges are two averaging times in s for each term, as N=0.1:10, not {ranges!r}")
    times: dict[str, tuple[float, float]] = {}
    for symbol, pair in ranges.items():
        numbers = isinstance(pair, (tuple, list)) and len(pair) == 2 and all(isinstance(v, (int, float)) for v in pair)
        if not numbers or not 0 < pair[0] < pair[1]:
            raise UsageError(f"the range of {symbol} must be two averaging times in s, the lower one first, not {pair}")
        times[symbol] = (float(pair[0]), float(pair[1]))
    for (symbol, (low, high)), (other, (start, end)) in pairwise(sorted(times.items(), key=lambda item: item[1])):
        if start < high:
            raise UsageError(f"the ranges of {symbol} ({low:g} to {high:g} s) and {other} ({start:g} to {end:g} s) "
                             "overlap; one term at most makes a part of the curve")  # fmt: skip
    return times


def demand_pieces(pieces: object, unit: str = "s") -> tuple[tuple[float, float], ...]:
    """Pieces of a record, or of a spectrum, as pairs of numbers, from text or numbers, in their order."""
    parts = pieces.split(",") if isinstance(pieces, str) else pieces
    if not isinstance(parts, (tuple, list)) or not parts:
        raise UsageError(f"pieces are pairs of numbers in {unit}, as {AS[unit]}, not {pieces!r}")
    pairs = []
    for part in parts:
        try:
            start, end = (float(number) for number in (part.split("..") if isinstance(part, str) else part))
        except (TypeError, ValueError):
            example = AS[unit].partition(",")[0]
            raise UsageError(f"a piece is a pair of numbers in {unit}, as {example}, not {part!r}") from None
        if not 0 <= start < end < math.inf:
            raise UsageError(f"a piece begins at 0 {unit} or later and ends after that, unlike {start:g}..{end:g}")
        pairs.append((start, end))
    return tuple(sorted(pairs))


def demand_band(band: Any) -> Any:
    """Check that a band is valid."""
    numbers = isinstance(band, (tuple, list)) and len(band) == 2 and all(isinstance(f, (int, float)) for f in band)
    if band not in ("auto", "all") and not numbers:
        raise UsageError(f"a band must be 'auto', 'all' or two frequencies in Hz, not {band!r}")
    return band


def demand_level(level: float) -> float:
    """The confidence level, which is refused if it is not between 0 and 1."""
    return float(LEVEL.demand(level))


class Units(dict[float, str]):
    """The units of a signal times time to a power, by the power: those that are named, others as they are written."""

    def __init__(self, unit: str, second: str = "s", named: dict[float, str] | None = None) -> None:
        super().__init__(named or {})
        self.unit, self.second = unit, second

    def __missing__(self, power: float) -> str:
        return times(self.unit, power, self.second)


def times(unit: str, power: float, second: str = "s") -> str:
    """A unit times time to a power; `second` is the unit of the time."""
    per = re.fullmatch(rf"(.+?)/{second}(?:\^([\d.]+))?", unit)
    head, before = (per[1], -float(per[2] or 1)) if per else ("1", 1.0) if unit == second else (unit, 0.0)
    size = abs(before + power)
    time = {0.0: "", 0.5: f"sqrt({second})", 1.0: second}.get(size, f"{second}^{size:g}")
    if not time:
        return head
    if before + power < 0:
        return f"{head}/{time}"
    return time if head == "1" else f"{head}*{time}"
