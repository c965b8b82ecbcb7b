"""The sampling rate: from the user, from the file, or from an even column of stamps; never a guess."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.errors import DataError, UsageError
from allanite.units import unit_of

from . import headers
from .column import Column, lookup
from .grid import departure, remedy, seconds_since

PLAUSIBLE = (0.5, 20e3)
"""Rates, Hz, between which the unit of integer stamps is looked for."""

ASK = (
    "pass rate=100 (--rate 100) with the sampling rate in Hz, "
    "or name the column of stamps: time='stamp[us]' (--time 'stamp[us]')"
)


@dataclass(frozen=True)
class Beat:
    """The sampling rate in Hz, the time of the first sample in s, what was assumed, and what must be asked."""

    rate: float = 0.0
    start: float | None = None
    notes: tuple[str, ...] = ()
    questions: tuple[str, ...] = ()


def find(
    columns: tuple[Column, ...], option: str | None, chosen: tuple[Column, ...] | None
) -> tuple[Column | None, str]:
    """The column of stamps and its unit; no column if there is none or the user wants none.

    Raises
    ------
    UsageError
        The column that the user names does not exist, is a chosen channel, or its unit is not one of time.
    """
    if option is None:
        return _by_name([column for column in columns if chosen is None or column not in chosen])
    if option.strip().lower() == "none":
        return None, ""
    name, unit = option, ""
    if not any(option.strip() in (column.name, column.header) for column in columns):
        name, _, rest = option.partition("[")
        unit = rest.strip(" ]")
    column = lookup(columns, name)
    if chosen is not None and column in chosen:
        raise UsageError(f"{column.label} is asked for as time and as a channel")
    if unit and not headers.is_time(unit):
        raise UsageError(f"{unit!r} is not a unit of time; for example time='{name.strip()}[us]' with s, ms, us or ns")
    return column, unit or _said(column)


def _by_name(columns: list[Column]) -> tuple[Column | None, str]:
    ranked = [
        (headers.clock_rank(column.name), column) for column in columns if not column.text and _may_be_clock(column)
    ]
    # a unit of time makes a clock of a column that is not called one; a unit of something else forbids it
    ranked = [
        (0 if rank < 2 and _said(c) else 1 if _said(c) else rank, c) for rank, c in ranked if _said(c) or not c.unit
    ]
    best = min((rank for rank, _ in ranked), default=2)
    if best == 2:
        return None, ""
    column = next(c for rank, c in ranked if rank == best)
    return column, _said(column)


def _may_be_clock(column: Column) -> bool:
    """A capital T is a temperature unless it rises at every row."""
    return column.name != "T" or bool(np.all(np.diff(column.values) > 0))


def _said(column: Column) -> str:
    """The unit of time that the header says; empty if it says none."""
    return column.unit if headers.is_time(column.unit) else headers.clock_unit(column.name) if not column.unit else ""


def beat(column: Column | None, unit: str, rate: float | None, stated: tuple[float | None, str]) -> Beat:
    """The sampling rate.

    Parameters
    ----------
    column, unit
        The stamps and their unit as `find` gives them.
    rate : float or None
        What the user says; it wins.
    stated : (float or None, str)
        What the file says besides its stamps, and where.

    Raises
    ------
    DataError
        There is no other source than the stamps, and they follow no even grid.
    """
    given = rate if rate is not None else stated[0]
    first = () if rate is not None or stated[0] is None else (f"rate {_shown(stated[0])} Hz from {stated[1]}",)
    if column is None:
        return (
            Beat(given, notes=first) if given else Beat(questions=(f"the file does not say its sampling rate: {ASK}",))
        )
    if given and column.text:
        return Beat(given, notes=(*first, f"{column.label} holds text and was not used"))
    column.demand_numbers()
    stamps = column.values
    unit, guessed = (unit, "") if unit else _guess(stamps)
    if not unit:
        return Beat(given, notes=first) if given else Beat(questions=(_ask_unit(column),))
    elapsed = seconds_since(stamps, unit)
    trouble, wander = departure(elapsed, len(stamps), column.label)
    if trouble and not given:
        raise DataError(f"{trouble}; {remedy(elapsed)}")
    if trouble:
        return Beat(float(given or 0), notes=(*first, f"{trouble}; the samples are taken as evenly spaced"))
    measured = (len(stamps) - 1) / float(elapsed[-1])
    notes = _notes(column.label, (given, measured), guessed, wander)
    return Beat(given or measured, float(stamps[0]) * unit_of(unit).factor, (*first, *notes))


def _notes(label: str, rates: tuple[float | None, float], guessed: str, wander: str) -> list[str]:
    given, measured = rates
    remarks = [wander] if wander else []
    if given is None:
        return [f"rate {_shown(measured)} Hz from {label}{guessed}", *remarks]
    if abs(given / measured - 1) <= 1e-3:
        return remarks
    return [f"rate {_shown(given)} Hz is used, but the stamps of {label} say {_shown(measured)} Hz{guessed}", *remarks]


def _shown(rate: float) -> str:
    return repr(float(f"{rate:.7g}"))


def _guess(stamps: NDArray[Any]) -> tuple[str, str]:
    """The unit of stamps whose header says none, and the words for the note."""
    if not np.all(np.isfinite(stamps)) or np.any(stamps != np.floor(stamps)):
        return "s", ", its stamps taken as seconds"
    fits = [unit for unit, rate in _readings(stamps) if PLAUSIBLE[0] <= rate <= PLAUSIBLE[1]]
    return (
        (fits[0], f", its integer stamps taken as {fits[0]}, the only unit that makes sense")
        if len(fits) == 1
        else ("", "")
    )


def _readings(stamps: NDArray[Any]) -> list[tuple[str, float]]:
    span = float(stamps[-1]) - float(stamps[0])
    return [(unit, (len(stamps) - 1) / (span * unit_of(unit).factor)) for unit in ("s", "ms", "us", "ns") if span > 0]


def _ask_unit(column: Column) -> str:
    readings = ", ".join(f"{rate:.6g} Hz as {unit}" for unit, rate in _readings(column.values))
    how = f"time='{column.name}[ms]' (--time '{column.name}[ms]'), or rate=100 (--rate 100)"
    if not readings:
        return f"the last stamp of {column.label} is not later than the first: {ASK}"
    return f"the unit of the integer stamps of {column.label} is not known ({readings}): pass {how}"
