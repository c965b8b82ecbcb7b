"""Which column is the clock: as the user says, or by names and units, and of several the steadiest."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import UsageError
from allanite.readers.columns import headers
from allanite.readers.columns.column import Column, lookup

from . import counter
from .stamps import EVEN, TICKS


@dataclass(frozen=True, eq=False)
class Sources:
    """Whatever may tell the rate: the stamps and their unit, a counter of samples, a rate that the file states."""

    stamps: Column | None = None
    unit: str = ""
    counter: Column | None = None
    rate: float | None = None
    source: str = ""
    notes: tuple[str, ...] = ()


def find(columns: tuple[Column, ...], option: str | None, chosen: tuple[Column, ...] | None) -> Sources:
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
    said = ", ".join(f"{column.label} {how.words}" for how, _, _, column in judged)
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


class Steadiness(NamedTuple):
    """How well stamps keep time, whatever their unit: the kind of trouble, the scatter of their steps, and words."""

    trouble: int
    scatter: float
    words: str


def steadiness(stamps: NDArray[Any]) -> Steadiness:
    """How well stamps keep time: those that rise at every row before those that repeat, and these before the rest."""
    steps = np.diff(stamps).astype(np.float64)
    if not np.all(np.isfinite(steps)):
        return Steadiness(3, 0.0, "has holes")
    if not steps.any() or steps.min() < 0:
        return Steadiness(3, 0.0, "goes back" if steps.any() else "is constant")
    usual, share = float(np.median(steps)), float((steps == 0).mean())
    if share >= TICKS or not usual:
        return Steadiness(2, share, f"repeats {100 * share:.2g} % of its stamps")
    scatter = float(np.quantile(np.abs(steps / usual - 1), 0.9))
    return Steadiness(int(scatter > EVEN), scatter, f"scatters by {100 * scatter:.2g} % of a step")
