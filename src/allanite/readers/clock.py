"""The sampling rate: from the user, from the file, or from an even column of stamps; never a guess."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.errors import DataError, UsageError
from allanite.record import FloatArray
from allanite.units import unit_of

from . import counter, headers
from .column import Column, lookup
from .faults import ROWS
from .grid import Grid, fit, seconds_since, steadiness

PLAUSIBLE = (0.5, 20e3)
"""Rates, Hz, between which the unit of integer stamps is looked for."""

ASK = (
    "pass rate=100 (--rate 100) with the sampling rate in Hz, "
    "or name the column of stamps: time='stamp[us]' (--time 'stamp[us]')"
)


@dataclass(frozen=True, eq=False)
class Beat:
    """The sampling rate in Hz, the time of the first sample in s, the grid, what was assumed and what must be asked."""

    rate: float = 0.0
    start: float | None = None
    notes: tuple[str, ...] = ()
    questions: tuple[str, ...] = ()
    grid: Grid = Grid()


@dataclass(frozen=True, eq=False)
class Sources:
    """Whatever may tell the rate: the stamps and their unit, a counter of samples, a rate that the file states."""

    stamps: Column | None = None
    unit: str = ""
    counter: Column | None = None
    rate: float | None = None
    source: str = ""
    notes: tuple[str, ...] = ()


def find(
    columns: tuple[Column, ...], option: str | None, chosen: tuple[Column, ...] | None
) -> Sources:
    """The column of stamps and its unit, and the counter of samples; neither if the user wants none.

    Raises
    ------
    UsageError
        The column that the user names does not exist, is a chosen channel, or its unit is not one of time.
    """
    free = [column for column in columns if chosen is None or column not in chosen]
    if option is None:
        column, note = _by_name(free)
        unit = _said(column) if column else ""
        return Sources(column, unit, counter.find(free, column), notes=(note,) if note else ())
    if option.strip().lower() == "none":
        return Sources()
    name, unit = option, ""
    if not any(option.strip() in (column.name, column.header) for column in columns):
        name, _, rest = option.partition("[")
        unit = rest.strip(" ]")
    column = lookup(columns, name)
    if chosen is not None and column in chosen:
        raise UsageError(f"{column.label} is asked for as time and as a channel")
    if unit and not headers.is_time(unit):
        raise UsageError(f"{unit!r} is not a unit of time; for example time='{name.strip()}[us]' with s, ms, us or ns")
    return Sources(column, unit or _said(column), counter.find(free, column))


def _by_name(columns: list[Column]) -> tuple[Column | None, str]:
    """The clock among the columns: the steadiest of those whose names or units say time, and the words about it."""
    ranked = [(_rank(column), column) for column in columns if not column.text and _may_be_clock(column)]
    clocks = [(rank, column) for rank, column in ranked if rank < 2]
    if len(clocks) < 2:
        return (clocks[0][1], "") if clocks else (None, "")
    judged = [(steadiness(column.values), rank, i, column) for i, (rank, column) in enumerate(clocks)]
    best = min(judged, key=lambda item: (item[0].trouble, item[1], round(item[0].scatter, 1), item[2]))
    said = ", ".join(f"{column.label} {how}" for how, _, _, column in judged)
    return best[3], f"{best[3].label} is taken as the clock, of {len(clocks)} that the file has: {said}"


def _rank(column: Column) -> int:
    """How surely a column is a clock: a unit of time makes one of any name, a unit of something else forbids it."""
    rank = headers.clock_rank(column.name)
    if _said(column):
        return 0 if rank < 2 else 1
    return 2 if column.unit else rank


def _may_be_clock(column: Column) -> bool:
    """A capital T is a temperature unless it rises at every row."""
    return column.name != "T" or bool(np.all(np.diff(column.values) > 0))


def _said(column: Column) -> str:
    """The unit of time that the header says; empty if it says none."""
    return column.unit if headers.is_time(column.unit) else headers.clock_unit(column.name) if not column.unit else ""


def beat(sources: Sources, rate: float | None, repeated: Callable[[], NDArray[np.bool_]]) -> Beat:
    """The sampling rate, and the grid on which the rows stand.

    Parameters
    ----------
    sources : Sources
        What may tell it.
    rate : float or None
        What the user says; it wins.
    repeated : callable
        Says which rows have the readings of the row before, shape (n - 1,).

    Raises
    ------
    DataError
        There is no other source than the stamps, and they give no rate.
    """
    given = rate if rate is not None else sources.rate
    first = sources.notes
    if rate is None and sources.rate is not None:
        first = (*first, f"rate {_shown(sources.rate)} Hz from {sources.source}")
    column = sources.stamps
    if column is None or (given and column.text):
        unused = () if column is None else (f"{column.label} holds text and was not used",)
        return _unstamped(sources.counter, given, (*first, *unused))
    column.demand_numbers()
    stamps, wrapped = counter.unwrapped(column.values)
    again = (f"{column.label} starts again at 2^{wrapped}: it was continued",) if wrapped else ()
    unit, guessed = (sources.unit, "") if sources.unit else _guess(stamps, given)
    if not unit:
        return Beat(given, notes=first) if given else Beat(questions=(_ask_unit(column),))
    elapsed = seconds_since(stamps, unit)
    grid = _counted(sources.counter, elapsed) or fit(elapsed, column.label, repeated)
    if grid.trouble and not given:
        if not elapsed.any():
            return Beat(questions=(f"{grid.trouble} and give no rate: {ASK}",))
        raise DataError(f"{grid.trouble}; {ROWS}, or time=... (--time) for another column")
    if grid.trouble:
        return Beat(float(given or 0), notes=(*first, f"{grid.trouble}; the rows are taken as evenly spaced"), grid=grid)
    notes = _notes(column.label, (given, 1 / grid.interval), guessed, grid.lost)
    origin = stamps[0] if grid.rows is None else stamps[grid.rows[0]]
    return Beat(given or 1 / grid.interval, float(origin) * unit_of(unit).factor, (*first, *again, *notes), (), grid)


def _unstamped(column: Column | None, given: float | None, notes: tuple[str, ...]) -> Beat:
    """What can be said without stamps: losses by a counter, if the rate is given."""
    if given:
        return Beat(given, notes=notes, grid=counter.grid(column, 1 / given) or Grid())
    hint = "" if column is None else f" (the counter {column.label} says which samples were lost, but not their rate)"
    return Beat(questions=(f"the file does not say its sampling rate{hint}: {ASK}",))


def _counted(column: Column | None, elapsed: FloatArray) -> Grid | None:
    """The grid that a counter with holes says, if the stamps go forward at all."""
    places = None if column is None else counter.places(column)
    if column is None or places is None or not elapsed[-1] > 0 or not np.isfinite(elapsed[-1]):
        return None
    return counter.grid(column, float(elapsed[-1]) / int(places[-1]))


def _notes(label: str, rates: tuple[float | None, float], guessed: str, lost: int) -> list[str]:
    given, measured = rates
    counted = f", {lost} lost intervals counted" if lost else ""
    if given is None:
        return [f"rate {_shown(measured)} Hz from {label}{counted}{guessed}"]
    if abs(given / measured - 1) <= 1e-3:
        return []
    return [f"rate {_shown(given)} Hz is used, but the stamps of {label} say {_shown(measured)} Hz{counted}{guessed}"]


def _shown(rate: float) -> str:
    return repr(float(f"{rate:.7g}"))


def _guess(stamps: NDArray[Any], given: float | None) -> tuple[str, str]:
    """The unit of stamps whose header says none, and the words for the note."""
    if not np.all(np.isfinite(stamps)) or np.any(stamps != np.floor(stamps)):
        return "s", ", its stamps taken as seconds"
    low, high = (given / 3, 3 * given) if given else PLAUSIBLE
    fits = [unit for unit, rate in _readings(stamps) if low <= rate <= high]
    only = "which fits the rate" if given else "the only unit that makes sense"
    return (fits[0], f", its integer stamps taken as {fits[0]}, {only}") if len(fits) == 1 else ("", "")


def _readings(stamps: NDArray[Any]) -> list[tuple[str, float]]:
    span = float(stamps[-1]) - float(stamps[0])
    return [(unit, (len(stamps) - 1) / (span * unit_of(unit).factor)) for unit in ("s", "ms", "us", "ns") if span > 0]


def _ask_unit(column: Column) -> str:
    readings = ", ".join(f"{rate:.6g} Hz as {unit}" for unit, rate in _readings(column.values))
    how = f"time='{column.name}[ms]' (--time '{column.name}[ms]'), or rate=100 (--rate 100)"
    if not readings:
        return f"the last stamp of {column.label} is not later than the first: {ASK}"
    return f"the unit of the integer stamps of {column.label} is not known ({readings}): pass {how}"
