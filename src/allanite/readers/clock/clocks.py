"""Selects the clock: the column named by the user, otherwise by names and units, and of several the steadiest.

Counters of samples or packets show which samples are missing where time stamps do not.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import UNIT, UsageError
from allanite.core.units import unit_of
from allanite.phrases.phrase import join, percent, say
from allanite.readers.columns import headers
from allanite.readers.columns.column import FileColumn, lookup

from .findings import Places, SampleGrid, lost_samples
from .stamps import EVEN, MOST_LOST, TICKS

PLAUSIBLE = (0.1, 50e3)  # sampling rates, Hz, considered plausible when the unit of time stamps is determined
IMUS = (9.0, 4500.0)  # those of most inertial sensors: of two plausible ones, the one within is taken
SLOWEST = 0.5  # rate, Hz, from which on time stamps with fractions are in seconds
EPOCH = (946_684_800.0, 4_102_444_800.0)  # the years 2000 to 2100, s since 1970

_NAME = re.compile(
    r"packet|counter|(^|[^a-z])(cnt|ctr|count|seq|sequence|samples?|index|idx|frame|row|no|id)([^a-z]|$)"
)
_WRAPS = (8, 16, 32, 31)


@dataclass(frozen=True, eq=False)
class ClockSources:
    """Sources of the sampling rate: time stamps and their unit, a counter of samples, a rate stated in the file."""

    stamps: FileColumn | None = None
    unit: str = ""
    counter: FileColumn | None = None
    rate: float | None = None
    source: str = ""
    stated: float | None = None  # a nominal rate from lines of text, only for where there are no time stamps
    stated_source: str = ""
    notes: tuple[str, ...] = ()


def readings(stamps: NDArray[Any]) -> list[tuple[str, float]]:
    """Units of time stamps, each with the mean rate in Hz that it gives; none if the last is not later than the first.

    Examples
    --------
    >>> [f"{rate:g} Hz in {unit}" for unit, rate in readings(np.array([0, 4, 8]))]
    ['0.25 Hz in s', '250 Hz in ms', '250000 Hz in us', '2.5e+08 Hz in ns']
    """
    span = float(stamps[-1]) - float(stamps[0])
    sizes = ((unit, span * unit_of(unit).factor) for unit in ("s", "ms", "us", "ns"))
    return [(unit, (len(stamps) - 1) / size) for unit, size in sizes] if span > 0 else []


def unit_by_rate(stamps: NDArray[Any]) -> tuple[str, str]:
    """The unit of time stamps by their size and by the rates that they give, and why; empty if it remains unknown."""
    rates = {unit: rate for unit, rate in readings(stamps) if PLAUSIBLE[0] <= rate <= PLAUSIBLE[1]}
    since = [unit for unit in rates if EPOCH[0] <= float(stamps[0]) * unit_of(unit).factor <= EPOCH[1]]
    if since:
        return since[0], say("time stamps assumed to be in {unit} since 1970, by their size", unit=since[0])
    # by the usual step, which no jump changes
    if np.any(stamps != np.floor(stamps)) and 0 < float(np.median(np.diff(stamps))) <= 1 / SLOWEST:
        return "s", say("time stamps assumed to be in seconds")
    usual = [unit for unit, rate in rates.items() if IMUS[0] <= rate <= IMUS[1]] or list(rates)
    if len(usual) != 1 or counts_rows(stamps):
        return "", ""
    unit = usual[0]
    if len(rates) == 1:
        return unit, say("integer time stamps assumed to be in {unit}, the only plausible unit", unit=unit)
    other = next(name for name in rates if name != unit)
    return unit, say(
        "integer time stamps assumed to be in {unit}: in {other} their rate would be {rate:.6g} Hz, as of few sensors",
        unit=unit, rate=rates[other], other=other,
    )  # fmt: skip


def counts_rows(stamps: NDArray[Any]) -> bool:
    """Whether whole numbers usually rise by one, as a counter does."""
    return stamps.dtype.kind == "i" and float(np.median(np.diff(stamps[:1000]))) == 1


def addressed(column: FileColumn) -> str:
    """A column of time stamps as it is chosen: with its likely unit, or a placeholder."""
    name = column.position if set(column.name) & set("[]'") else column.name
    return f"{name}[{unit_by_rate(column.values)[0] or UNIT}]"


def find(columns: tuple[FileColumn, ...], option: str | None, chosen: tuple[FileColumn, ...] | None) -> ClockSources:
    """The column of time stamps and its unit, and the counter of samples; neither if the user wants none."""
    free = [column for column in columns if chosen is None or column not in chosen]
    if option is None:
        column, note = _by_name(free)
        unit = _said(column) if column else ""
        return ClockSources(column, unit, counter_of(free, column), notes=(note,) if note else ())
    if option.strip().lower() == "none":
        return ClockSources()
    name, unit = option, ""
    if not any(option.strip() in (column.name, column.header) for column in columns):
        name, _, rest = option.partition("[")
        unit = rest.strip(" ]")
    column = lookup(columns, name, "time")
    if chosen is not None and column in chosen:
        raise UsageError(f"{column.label} is selected both as time and as a channel")
    if unit and not headers.is_time(unit):
        raise UsageError(f"{unit!r} is not a unit of time; for example time='{name.strip()}[us]' with s, ms, us or ns")
    return ClockSources(column, unit or _said(column), counter_of(free, column))


def _by_name(columns: list[FileColumn]) -> tuple[FileColumn | None, str]:
    """The clock among the columns: the steadiest of those with a name or unit of time, and the text for the note."""
    clocks = list[tuple[int, FileColumn]]()
    for column in columns:
        # a capital T is a temperature unless it increases in every row
        if column.text or (column.name == "T" and not np.all(np.diff(column.values) > 0)):
            continue
        rank = headers.clock_rank(column.name)
        # a unit of time makes it a clock with any name, another unit excludes it
        rank = int(rank == 2) if _said(column) else 2 if column.unit else rank
        if rank < 2:
            clocks.append((rank, column))
    if len(clocks) < 2:
        return (clocks[0][1], "") if clocks else (None, "")
    judged = [(steadiness(column.values), rank, i, column) for i, (rank, column) in enumerate(clocks)]
    best = min(judged, key=lambda item: (item[0].trouble, item[1], round(item[0].scatter, 1), item[2]))
    told = (say("{column} {quality}", column=column.label, quality=how.words) for how, _, _, column in judged)
    return best[3], say(
        "{column} is used as the clock, of {count} candidates in the file: {candidates}",
        column=best[3].label, count=len(clocks), candidates=join(", ", told),
    )  # fmt: skip


def _said(column: FileColumn) -> str:
    """The unit of time in the header; empty if there is none."""
    return column.unit if headers.is_time(column.unit) else headers.clock_unit(column.name) if not column.unit else ""


class Steadiness(NamedTuple):
    """How regular time stamps are, whatever their unit: the kind of defect, the scatter of the steps, and a text."""

    trouble: int
    scatter: float
    words: str


def steadiness(stamps: NDArray[Any]) -> Steadiness:
    """How regular time stamps are: those that increase in every row first, then those that repeat, then the rest."""
    steps = np.diff(stamps).astype(np.float64)
    if not np.all(np.isfinite(steps)):
        return Steadiness(3, 0.0, say("has gaps"))
    if not steps.any() or steps.min() < 0:
        return Steadiness(3, 0.0, say("is not increasing") if steps.any() else say("is constant"))
    usual, share = float(np.median(steps)), float((steps == 0).mean())
    if share >= TICKS or not usual:
        return Steadiness(2, share, say("repeats {share} of its time stamps", share=percent(share)))
    scatter = float(np.quantile(np.abs(steps / usual - 1), 0.9))
    return Steadiness(int(scatter > EVEN), scatter, say("scatters by {share} of a step", share=percent(scatter)))


def counter_of(columns: list[FileColumn], clock: FileColumn | None) -> FileColumn | None:
    """The column that counts samples, by its name, if its counts have gaps."""
    named = (column for column in columns if column is not clock and _NAME.search(column.name.strip().lower()))
    return next((column for column in named if places(column) is not None), None)


def counting(columns: Iterable[FileColumn]) -> FileColumn | None:
    """The first column of whole numbers that is named like a counter, whether or not its counts have gaps."""
    named = (column for column in columns if _NAME.search(column.name.strip().lower()))
    return next((column for column in named if column.values.dtype.kind == "i" and len(column.values)), None)


def unwrapped(values: NDArray[Any]) -> tuple[NDArray[Any], int]:
    """Unwrapped integers that start again at a power of two, and the exponent; 0 if they never wrap."""
    if not np.issubdtype(values.dtype, np.integer) or len(values) < 2:
        return values, 0
    steps = np.diff(values.astype(np.int64))
    back = steps < 0
    usual = float(np.median(np.abs(steps)))
    for bits in _WRAPS if back.any() else ():
        # a step over the wrap-around is like any other once the range is added
        over = steps[back] + 2**bits
        inside = values.min() >= 0 and values.max() < 2**bits
        if inside and over.min() >= 0 and np.median(over) <= 3 * usual and over.max() < 2 ** (bits - 1):
            steps[back] = over
            return np.concatenate(([int(values[0])], int(values[0]) + np.cumsum(steps))), bits
    return values, 0


def places(column: FileColumn) -> Places | None:
    """The positions of the rows according to a counter; None if it does not count samples, or none is missing."""
    values = column.values
    if values.dtype.kind == "f" and len(values) and np.all(values == np.floor(values)) and np.abs(values).max() < 2**53:
        values = values.astype(np.int64)
    if not np.issubdtype(values.dtype, np.integer) or len(values) < 10:
        return None
    steps = np.diff(unwrapped(values)[0].astype(np.int64))
    if steps.min() < 1 or steps.min() == steps.max():
        return None
    counted = np.concatenate(([0], np.cumsum(steps // np.gcd.reduce(steps))))
    return counted if counted[-1] + 1 - counted.size <= MOST_LOST * counted[-1] else None


def counted_grid(column: FileColumn | None, interval: float) -> SampleGrid | None:
    """The grid according to a counter; None if the counter shows no gaps."""
    where = None if column is None else places(column)
    if column is None or where is None:
        return None
    source = say("according to the counter {column}", column=column.label)
    return SampleGrid(interval, None, where, (lost_samples(where, interval, source),))
