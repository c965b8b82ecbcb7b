"""Which columns are inertial signals, and what their samples are: unit, kind and scale."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from operator import attrgetter
from typing import NamedTuple, TypeVar

import numpy as np

from allanite.core.errors import SCALE, UNIT, UsageError
from allanite.core.kinds import KIND_WORDS, kinds_of, offered, signal_of_kind
from allanite.core.names import nearest
from allanite.core.units import BASES, USUAL, unit_of
from allanite.core.validity import Finding
from allanite.phrases.phrase import join, say, spelled
from allanite.readers.options import Options

from . import conventions, headers, stated
from .column import FileColumn, lookup, some
from .stated import Stated

T = TypeVar("T")

MOST_DRIVERS = 8  # number of columns beside the signals that are kept


class SignalColumn(NamedTuple):
    """A column with the meaning of its samples, and the origin of that knowledge as text."""

    column: FileColumn
    unit: str
    kind: str
    scale: float | None
    source: str = ""


class Left(NamedTuple):
    """A column that cannot be used: the reason, and what to pass to use it (empty: it is not a signal)."""

    column: FileColumn
    why: str
    ask: str = ""
    open: bool = False  # what it lacks is a unit


@dataclass(frozen=True)
class Choice:
    """The signals of a file, assumptions, columns that are omitted, questions, warnings, columns without a unit."""

    signals: tuple[SignalColumn, ...]
    notes: tuple[str, ...]
    omitted: tuple[str, ...]
    questions: tuple[str, ...]
    findings: tuple[Finding, ...] = ()
    unsaid: tuple[FileColumn, ...] = ()


def named(columns: tuple[FileColumn, ...], keys: tuple[str, ...] | None) -> tuple[FileColumn, ...] | None:
    """The columns chosen by the user, in that order; None if the choice is automatic."""
    if keys is None:
        return None
    chosen = tuple(lookup(columns, key) for key in keys)
    for i, column in enumerate(chosen):
        if column in chosen[:i]:
            raise UsageError(f"{column.label} is selected twice: {', '.join(keys)}")
    return chosen


def choose(
    columns: tuple[FileColumn, ...], options: Options, chosen: tuple[FileColumn, ...] | None, time: FileColumn | None
) -> Choice:
    """The signals among the columns: those chosen, or all that can be signals."""
    for column in chosen or ():
        column.demand_numbers()
    judged = _judged(columns, options, chosen, time)
    signals = tuple(item for item in judged if isinstance(item, SignalColumn))
    unused = [item for item in judged if isinstance(item, Left)]
    notes = (*_grouped((s.source, s.column) for s in signals if s.source), *_of_kind(signals, options))
    findings = tuple(stated.against_headers(map(attrgetter("column", "unit"), signals)))
    reasons = _grouped((say("{reason}:", reason=item.why), item.column) for item in unused)
    if (signals and chosen is None) or not unused:
        omitted = tuple(say("left out, {reason}", reason=reason) for reason in reasons)
        return Choice(signals, notes, omitted, (), findings)
    asked = [
        say("{columns}: {reason}; {remedy}", columns=names, reason=why, remedy=ask)
        for (why, ask), names in _together(((i.why, i.ask), i.column) for i in unused if i.ask)
    ]
    how = spelled("--channels gx,2", "channels=['gx', '2']")
    nothing = say("no column is recognized as an inertial signal; select columns with {option}", option=how)
    others = _grouped((say("{reason}:", reason=item.why), item.column) for item in unused if not item.ask)
    return Choice(signals, notes, tuple(others), tuple(asked) or (nothing,),
                  unsaid=tuple(i.column for i in unused if i.open))  # fmt: skip


NO_UNIT = say("no signal unit in the header, used as plain numbers:")


def beside(columns: tuple[FileColumn, ...]) -> tuple[tuple[SignalColumn, ...], tuple[str, ...]]:
    """Columns for a regression, each with the unit of its header, and a note on those without."""
    signals, plain = [], []
    for column in columns:
        column.demand_numbers()
        fits = headers.known(column.unit) is not None and bool(signal_of_kind(column.unit, "value"))
        kind = "rate" if not fits or signal_of_kind(column.unit, "rate") else "value"
        signals.append(SignalColumn(column, column.unit if fits else "1", column.kind or kind, column.scale))
        plain += [] if fits else [column]
    return tuple(signals), tuple(_grouped((NO_UNIT, c) for c in plain))


def drivers(columns: tuple[FileColumn, ...]) -> tuple[FileColumn, ...]:
    """Columns that may influence a sensor, by name or unit: temperatures, supplies; at most `MOST_DRIVERS`."""
    likely = (c for c in columns if not c.text and c.kind in ("", "rate") and headers.is_driver(c.name, c.unit))
    return tuple(islice(likely, MOST_DRIVERS))


def _judged(
    columns: tuple[FileColumn, ...], options: Options, chosen: tuple[FileColumn, ...] | None, time: FileColumn | None
) -> list[SignalColumn | Left]:
    """What each column is of those chosen, or of all but the clock."""
    asked_of = stated.of_columns(columns, options)
    if chosen is not None:
        return [_resolved(column, asked_of(column).options, applies=True) for column in chosen]
    pool = [column for column in columns if column is not time]
    judged = [_candidate(column, asked_of(column), pool) for column in pool]
    if any(isinstance(item, SignalColumn) for item in judged):
        return judged
    # where there is no signal, the columns with a unit of those that the user would also take
    signals = [(item.column, headers.signal_of(item.column.unit)) for item in judged if not item.column.text]
    wanted = [column for column, signal in signals if signal is not None and signal.name in options.otherwise]
    certain = {column.position for column in wanted if not headers.is_other(column.name)}
    taken = certain or {column.position for column in wanted}
    return [_resolved(i.column, options, applies=True) if i.column.position in taken else i for i in judged]


SENSORS = {"gyro": say("gyro"), "accelerometer": say("accelerometer")}


def _candidate(column: FileColumn, asked: Stated, pool: list[FileColumn]) -> SignalColumn | Left:
    # if the file or the user states the meaning of a column, its name does not matter
    options, signal = asked.options, headers.signal_of(column.unit)
    # the header's unit is that of a signal requested by the user's unit: a current, by unit="A"
    requested = signal is not None and not signal.inertial and signal is headers.signal_of(options.unit or "")
    stated_meaning = bool(column.kind) or asked.named or (requested and not column.text)
    refused = _no_value if options.kind == "value" else _no_signal
    why = "" if stated_meaning else refused(column, options) or _rises(column, options, pool)
    return Left(column, why) if why else _resolved(column, options, applies=asked.named or _applies(column, options))


def _no_signal(column: FileColumn, options: Options) -> str:
    """Why a column is not an inertial signal, by its header; empty if it may be one."""
    if column.text:
        return say("text instead of numbers")
    if headers.is_other(column.name, column.unit):
        return say("not an inertial signal by its name")
    if headers.is_time(column.unit) or (not column.unit and headers.clock_rank(column.name) < 2):
        return say("a time by its header")
    if _said(column) and not headers.inertial(column.unit):
        return say("{unit!r} is not a unit of a gyroscope or accelerometer", unit=column.unit)
    sensor, wanted = headers.sensor_by_name(column.name), headers.inertial(options.unit or "")
    if sensor and wanted and not column.unit and wanted.name != sensor:
        return say("{sensor} by its name, which does not match {unit}", sensor=SENSORS[sensor], unit=options.unit)
    return ""


def _no_value(column: FileColumn, options: Options) -> str:
    """Why a column is not taken as a quantity of its own, by its header; empty if it is."""
    if column.text:
        return say("text instead of numbers")
    if not _said(column):
        named = headers.is_other(column.name) or headers.clock_rank(column.name) < 2
        return say("not an inertial signal by its name") if named else ""
    if headers.is_time(column.unit):
        return say("a time by its header")
    if not _applies(column, options):
        return say("its unit {unit!r} does not match {wanted}", unit=column.unit, wanted=options.unit)
    known = headers.known(column.unit) is not None
    return "" if known and signal_of_kind(column.unit, "value") else _strange(column.unit)


def _strange(unit: str) -> str:
    return say("{unit!r} is not a unit of a quantity that can be analyzed", unit=unit)


def climbs(column: FileColumn, options: Options, pool: Sequence[FileColumn]) -> bool:
    """Whether an unmarked column increases in every row; an integrated angle may, but not as the first of several."""
    may_climb = options.kind in ("angle", "value") and column.position > 1
    values = column.values
    if column.unit or column.text or headers.identifies(column.name) or len(pool) < 2 or len(values) < 10 or may_climb:
        return False
    return bool(np.all(values[1:100] > values[:99][: len(values) - 1]) and np.all(values[1:] > values[:-1]))


def _rises(column: FileColumn, options: Options, pool: list[FileColumn]) -> str:
    if not climbs(column, options, pool):
        return ""
    here = spelled(
        say("--time {column} uses it as time, --channels as a signal", column=column.position),
        say("time='{column}' uses it as time, channels=... as a signal", column=column.position),
    )
    return say("increases in every row like a clock or a counter ({options})", options=here)


def _said(column: FileColumn) -> str:
    """The unit in the header; an unknown one next to the name of a sensor counts as none."""
    return "" if headers.known(column.unit) is None and headers.sensor_by_name(column.name) else column.unit


def _applies(column: FileColumn, options: Options) -> bool:
    """Whether the user's unit, kind and scale apply to this column: not if its header names the other sensor."""
    if options.unit is None or not _said(column):
        return True
    theirs, mine = unit_of(column.unit).dimension, unit_of(options.unit).dimension
    return all(one == other or base == "time" for base, one, other in zip(BASES, theirs, mine, strict=True))


def _resolved(column: FileColumn, options: Options, *, applies: bool) -> SignalColumn | Left:
    stated_unit = _said(column) if column.kind or options.kind == "value" or headers.signal_of(column.unit) else ""
    own = options if applies else replace(options, unit=None, units=(), kind=None, scale=None)
    unit = own.unit or stated_unit
    if not unit and headers.is_raw(column.header):
        option = spelled(f"--scale {SCALE}", "scale='0.01deg/s'")
        ask = say("pass the size of one count with its unit, {option}", option=option)
        return Left(column, say("counts by the header"), ask, open=True)
    if not unit:
        return Left(column, say("the unit is unknown"), _ask_unit(None), open=True)
    known, scale = (column.kind, column.scale) if unit == column.unit else ("", None)
    fits = kinds_of(unit)
    counts = own.worth is not None and "rate" not in fits and "count" in fits and _counts(column)
    kind = own.kind or known or ("count" if counts else "")
    if not fits:
        return Left(column, _strange(unit), _ask_unit(own.unit), open=True)
    meanings = offered(unit, integers=_whole(column))
    if (kind or "rate") not in fits:
        unclear = say("{unit!r} does not determine what a sample is", unit=unit)
        reason = say("{unit!r} does not match kind {kind!r}", unit=unit, kind=kind) if kind else unclear
        return Left(column, reason, say("pass what a sample is: {meanings}", meanings=meanings))
    scale = scale if own.worth is None else own.worth
    return SignalColumn(column, unit, kind or fits[0], scale, _source(column, options, unit, applies))


@np.errstate(all="ignore")
def _whole(column: FileColumn) -> bool:
    """Whether all samples that are not missing are whole numbers."""
    begin = column.values[:1000]  # mostly enough to see that they are not
    return all(bool(np.all(np.isnan(v) | (np.isfinite(v) & (np.rint(v) == v)))) for v in (begin, column.values))


@np.errstate(all="ignore")
def _counts(column: FileColumn) -> bool:
    """Whether whole numbers are as independent as the counts of each sample interval, which their sum is not."""
    values = column.values.astype(np.float64)
    kept, squares = values[np.isfinite(values)], np.square(np.diff(values))
    squares = squares[np.isfinite(squares)]
    return bool(_whole(column) and squares.size and squares.mean() > 0.2 * kept.var() > 0)


def _source(column: FileColumn, options: Options, unit: str, applies: bool) -> str:
    """Origin of the unit; empty if the user gave it and the header agrees, or a warning says that it does not."""
    if not column.unit or (options.unit == unit == column.unit) or stated.contradicts(column, unit):
        return ""
    known = conventions.convention_of(column)
    if unit != column.unit:
        return say("unit {unit} as requested, overriding the header of", unit=unit)
    if column.kind:
        plain = say("kind {kind} from the file for", kind=KIND_WORDS[column.kind])
        meaning = {"kind": KIND_WORDS[column.kind], "scale": column.scale, "unit": unit}
        return plain if column.scale is None else say("kind {kind} of {scale:g} {unit} from the file for", **meaning)
    if known is not None:
        return say("unit {unit} by the definition of {family} for", unit=unit, family=known.family)
    if applies:
        return say("unit {unit} from the header of", unit=unit)
    return say("unit {unit}, which does not match {wanted}, from the header of", unit=unit, wanted=options.unit)


def _of_kind(signals: tuple[SignalColumn, ...], options: Options) -> list[str]:
    if options.kind is not None:
        return []
    kinds = sorted({(signal.kind, signal.unit) for signal in signals if signal.kind != signal.column.kind})
    return [
        say("a sample in {unit} is used as the {kind} over a sample interval", unit=unit, kind=KIND_WORDS[kind])
        for kind, unit in kinds
    ]


def _together(items: Iterable[tuple[T, FileColumn]]) -> list[tuple[T, str]]:
    """Each statement, with the names of all columns that it applies to."""
    groups: dict[T, list[str]] = {}
    for statement, column in items:
        groups.setdefault(statement, []).append(repr(column.header or column.name))
    return [(statement, some(names, 12)) for statement, names in groups.items()]


def _grouped(items: Iterable[tuple[str, FileColumn]]) -> list[str]:
    """One sentence for each text, with all its columns."""
    return [join(" ", (text, names)) for text, names in _together(items)]


def _ask_unit(given: str | None) -> str:
    meant = unit_meant(given)
    if meant:
        return say("did you mean {unit}?", unit=meant)
    unit = spelled(f"--unit {UNIT}", "unit='deg/s'")
    return say("pass the unit of the samples, {unit}, or write it in the header as in 'gx [deg/s]'", unit=unit)


def unit_meant(given: str | None) -> str:
    """The unit of samples that is like the given one; empty if none is."""
    return nearest(given, [unit for unit in USUAL if kinds_of(unit)]) if given else ""
