"""Which columns are inertial signals, and what their readings are: unit, kind and scale."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple, TypeVar

import numpy as np

from allanite.core.errors import UsageError
from allanite.core.record import KINDS, explain_kinds
from allanite.core.units import BASES, signal_with, unit_of
from allanite.readers.options import Options

from . import headers
from .column import Column, lookup, some

T = TypeVar("T")

ASK_UNIT = (
    "pass unit='deg/s' (--unit deg/s) with what the readings are in, or write it into the header as in 'gx [deg/s]'; a "
    "unit of angle or velocity (arcsec, m/s) needs kind (--kind) too, one of rate, increment, angle, count"
)


MOST_DRIVERS = 8
"""Columns beside the signals that are kept."""


class Signal(NamedTuple):
    """A column with what its readings are, and the words on where that is known from."""

    column: Column
    unit: str
    kind: str
    scale: float | None
    source: str = ""


class Left(NamedTuple):
    """A column that cannot be taken: why, and what to pass so that it can (empty: it is no signal)."""

    column: Column
    why: str
    ask: str = ""


@dataclass(frozen=True)
class Choice:
    """The signals of a file, what was assumed about them, what was left out, and what must be asked."""

    signals: tuple[Signal, ...]
    notes: tuple[str, ...]
    left: tuple[str, ...]
    questions: tuple[str, ...]


def named(columns: tuple[Column, ...], keys: tuple[str, ...] | None) -> tuple[Column, ...] | None:
    """The columns that the user chose, in that order; None if the choice is left to the file."""
    if keys is None:
        return None
    chosen = tuple(lookup(columns, key) for key in keys)
    for i, column in enumerate(chosen):
        if column in chosen[:i]:
            raise UsageError(f"{column.label} is chosen twice: {', '.join(keys)}")
    return chosen


def choose(
    columns: tuple[Column, ...], options: Options, chosen: tuple[Column, ...] | None, time: Column | None
) -> Choice:
    """The signals among the columns: the chosen ones, or all that can be one."""
    pool = [column for column in columns if column is not time] if chosen is None else list(chosen)
    for column in chosen or ():
        column.demand_numbers()
    found = [
        _candidate(column, options, pool) if chosen is None else _resolved(column, options, applies=True)
        for column in pool
    ]
    signals = tuple(item for item in found if isinstance(item, Signal))
    left = [item for item in found if isinstance(item, Left)]
    notes = (*_grouped((s.source, s.column) for s in signals if s.source), *_of_kind(signals, options))
    reasons = _grouped((f"{item.why}:", item.column) for item in left)
    if (signals and chosen is None) or not left:
        return Choice(signals, notes, tuple(f"left out, {reason}" for reason in reasons), ())
    asked = [
        f"{names}: {why}; {ask}" for (why, ask), names in _together(((i.why, i.ask), i.column) for i in left if i.ask)
    ]
    nothing = "no column is recognised as an inertial signal; choose with channels=['gx', '2'] (--channels gx,2)"
    others = _grouped((f"{item.why}:", item.column) for item in left if not item.ask)
    return Choice(signals, notes, tuple(others), tuple(asked) or (nothing,))


def beside(columns: tuple[Column, ...]) -> tuple[tuple[Signal, ...], tuple[str, ...]]:
    """Columns that something else depends on, each with the unit of its header, and the words where it has none."""
    signals, plain = [], []
    for column in columns:
        column.demand_numbers()
        size = headers.known(column.unit)
        fits = size is not None and signal_with(size.dimension) is not None
        signals.append(Signal(column, column.unit if fits else "1", column.kind or "rate", column.scale))
        plain += [] if fits else [column]
    return tuple(signals), tuple(_grouped(("no unit of a signal in the header, taken as numbers:", c) for c in plain))


def drivers(columns: tuple[Column, ...]) -> tuple[Column, ...]:
    """Columns that may drive what a sensor says, by name or unit: temperatures, supplies; only so many of them."""
    found = (c for c in columns if not c.text and c.kind in ("", "rate") and headers.is_driver(c.name, c.unit))
    return tuple(islice(found, MOST_DRIVERS))


def _candidate(column: Column, options: Options, pool: list[Column]) -> Signal | Left:
    # a file that says what the readings of a column are needs no reading of names
    said = bool(column.kind) or _asked_for(column, options)
    why = "" if said else _no_signal(column, options) or _rises(column, options, pool)
    return Left(column, why) if why else _resolved(column, options, applies=_applies(column, options))


def _no_signal(column: Column, options: Options) -> str:
    """Why a column, by its header, is no inertial signal; empty if it may be one."""
    if column.text:
        return "text and not numbers"
    if headers.is_other(column.name, column.unit):
        return "no inertial signal by its name"
    if headers.is_time(column.unit) or (not column.unit and headers.clock_rank(column.name) < 2):
        return "a time by its header"
    if _said(column) and not headers.inertial(column.unit):
        return f"{column.unit!r} is no unit of a gyroscope or accelerometer"
    sensor, wanted = headers.sensor_by_name(column.name), headers.inertial(options.unit or "")
    if sensor and wanted and not column.unit and wanted.name != sensor:
        return f"of the {sensor} by its name, which {options.unit} does not fit"
    return ""


def _asked_for(column: Column, options: Options) -> bool:
    """Whether the header's unit is that of a signal which the user's unit asks for: a current, by unit="A"."""
    signal = headers.signal_of(column.unit)
    wanted = signal is not None and not signal.inertial and signal is headers.signal_of(options.unit or "")
    return wanted and not column.text


def _rises(column: Column, options: Options, pool: list[Column]) -> str:
    """Whether an unmarked column climbs at every row; an integrated angle may, but not as the first of several."""
    may_climb = options.kind == "angle" and column.position > 1
    values = column.values
    if column.unit or len(pool) < 2 or len(values) < 10 or may_climb:
        return ""
    if not (np.all(values[1:100] > values[:99][: len(values) - 1]) and np.all(values[1:] > values[:-1])):
        return ""
    here = (
        f"time='{column.position}' (--time {column.position}) takes it as time, channels=... (--channels) as a signal"
    )
    return f"rising at every row like a clock or a counter ({here})"


def _said(column: Column) -> str:
    """The unit in the header; one that nobody knows, beside the name of a sensor, counts as none."""
    return "" if headers.known(column.unit) is None and headers.sensor_by_name(column.name) else column.unit


def _applies(column: Column, options: Options) -> bool:
    """Whether the user's unit, kind and scale are meant for this column: not if its header names the other sensor."""
    if options.unit is None or not _said(column):
        return True
    theirs, mine = unit_of(column.unit).dimension, unit_of(options.unit).dimension
    return [p for base, p in zip(BASES, theirs, strict=True) if base != "time"] == [
        p for base, p in zip(BASES, mine, strict=True) if base != "time"
    ]


def _resolved(column: Column, options: Options, *, applies: bool) -> Signal | Left:
    said = _said(column) if column.kind or headers.signal_of(column.unit) else ""
    unit = (options.unit if applies else None) or said
    if not unit:
        return Left(column, "the unit is not known", ASK_UNIT)
    kept = unit == column.unit
    kind = (options.kind if applies else None) or (column.kind if kept else "")
    fits = [name for name, (power, _, _) in KINDS.items() if signal_with(unit_of(unit).dimension, power)]
    if not fits:
        return Left(column, f"{unit!r} is no unit of a gyroscope or accelerometer", ASK_UNIT)
    if kind and kind not in fits:
        return Left(
            column, f"{unit!r} does not fit kind {kind!r}", f"pass kind as one of {', '.join(fits)}: {explain_kinds()}"
        )
    if not kind and len(fits) > 1:
        return Left(
            column,
            f"{unit!r} does not say what a reading is (kind does, or unit {unit}/s if it is a rate)",
            f"pass kind='{fits[0]}' (--kind {fits[0]}): {explain_kinds()}",
        )
    scale = options.worth if applies and options.scale is not None else column.scale if kept else None
    return Signal(column, unit, kind or fits[0], scale, _source(column, options, unit, applies))


def _source(column: Column, options: Options, unit: str, applies: bool) -> str:
    """Where the unit is known from; empty where the user said it and the header does not object."""
    if not column.unit or (options.unit == unit == column.unit):
        return ""
    if unit != column.unit:
        return f"unit {unit} as asked, over the header of"
    if column.kind:
        scale = "" if column.scale is None else f" of {column.scale:g} {unit}"
        return f"kind {column.kind}{scale} from the file for"
    return (
        f"unit {unit} from the header of"
        if applies
        else f"unit {unit}, which {options.unit} does not fit, from the header of"
    )


def _of_kind(signals: tuple[Signal, ...], options: Options) -> list[str]:
    if options.kind is not None:
        return []
    kinds = sorted({(signal.kind, signal.unit) for signal in signals if signal.kind != signal.column.kind})
    return [f"a reading in {unit} is taken as the {kind} over a sample interval" for kind, unit in kinds]


def _together(items: Iterable[tuple[T, Column]]) -> list[tuple[T, str]]:
    """Each thing that is said, with the names of all columns of which it is."""
    groups: dict[T, list[str]] = {}
    for said, column in items:
        groups.setdefault(said, []).append(repr(column.header or column.name))
    return [(said, some(names, 12)) for said, names in groups.items()]


def _grouped(items: Iterable[tuple[str, Column]]) -> list[str]:
    """One sentence for each text, with all its columns."""
    return [f"{text} {names}" for text, names in _together(items)]
