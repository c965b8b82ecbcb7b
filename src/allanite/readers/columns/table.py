"""Table: the uninterpreted columns of a file. Every reader fills one.

The properties of a Recording beyond its numbers are one line of JSON, which each written format stores.
"""

import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import UNIT, AllaniteError, Cure, DataError, UsageError
from allanite.core.kinds import signal_of_kind
from allanite.core.record import Record, Recording
from allanite.core.syntax import identifiers
from allanite.core.validity import Finding
from allanite.phrases.phrase import join, say, spelled
from allanite.readers.clock import clocks, sampling_rate as clock
from allanite.readers.options import Options

from . import channels, conventions, gravity, proposal, resolver, sensors, shapes, stated
from .column import RATE_NAMES, FileColumn, unique

KEY = "allanite"  # the name under which a format stores it
SLOW = 5.0  # sampling rate, Hz, up to which sensors are seldom sampled, but logged

DROPPED = say("if the logger drops samples without averaging, N is too large by up to sqrt(f_sensor/f_log)")

SOURCE = say("the description in the file")


@dataclass(frozen=True, eq=False)
class FileTable:
    """The columns of a file in its order, what the file states about them, and the assumptions so far."""

    columns: tuple[FileColumn, ...]
    rate: float | None = None  # Hz; None if the file does not state it
    rate_source: str = ""  # the place where it does
    notes: tuple[str, ...] = field(default=())
    start: float | None = None  # time of the first sample, s
    nominal: tuple[float | None, str] = (None, "")  # a rate, Hz, that applies only without time stamps, and its place

    def recording(self, options: Options) -> Recording:
        """The channels as records with common sample times."""
        if options.sincos:
            plain = replace(options, sincos=None, unit="1", kind="value")
            waves = self._unmarked(plain).recording(plain)
            return resolver.with_angles(waves, len(options.sincos) // 2, options.kind or "value")
        if max((len(column.values) for column in self.columns), default=0) < 2:
            raise DataError(
                say("the file contains fewer than 2 rows of numbers; a record needs thousands, one row per sample")
            )
        sense = self.sense(options)
        time = sense.sources.stamps
        signals = [signal.column for signal in sense.signals]
        if not signals and not sense.choice.questions:
            raise DataError(say("the file contains times and no samples; a recording needs at least one channel"))
        _demand_rows([*signals, *([time] if time else [])])
        beat = clock.beat(sense.sources, options.rate, lambda: repeated([column.values for column in signals]))
        doubts = sense.demand(beat)
        records = tuple(_record(signal, beat, self.start) for signal in sense.signals)
        around = [c for c in sense.columns if c is not time and len(c.values) == len(signals[0].values)]
        taken = set(map(id, signals))
        drivers = channels.beside(channels.drivers(tuple(c for c in around if id(c) not in taken)))[0]
        others = tuple(_record(signal, beat, self.start) for signal in drivers)
        notes, (first, step) = sense.notes(beat), shapes.stride(records)
        if step > 1:
            notes = (*notes, shapes.note(records, step))
            records, others = (shapes.thinned(some, first, step) for some in (records, others))
        return Recording(records, notes=notes, findings=sense.findings(beat, doubts), others=others)

    def sense(self, options: Options) -> "Sense":
        """What the columns are: which of them are signals, and which are the clock."""
        columns, joined = sensors.joined(conventions.applied(unique(self.columns)), options)
        chosen = channels.named(columns, options.channels)
        # a column whose meaning the file states is a clock only if the user says so
        open_ = tuple(c for c in columns if not c.kind) if options.time is None else columns
        nominal, place = self.nominal
        sources = replace(
            clocks.find(open_, options.time, chosen),
            rate=self.rate, source=self.rate_source, stated=nominal, stated_source=place,
        )  # fmt: skip
        taken = channels.named(columns, options.along) or ()
        units, options = stated.apart(columns, taken, options)
        along, plain = channels.beside(tuple(replace(c, unit=units.get(c, c.unit)) for c in taken))
        open_to_choice = tuple(column for column in columns if column not in taken)
        choice = channels.choose(open_to_choice, options, chosen, sources.stamps)
        return Sense(columns, sources, choice, along, ((*self.notes, *joined), plain), options)

    def _unmarked(self, options: Options) -> "FileTable":
        """The table whose selected columns have no unit and kind: sine and cosine in any unit have the same angle."""
        wanted = channels.named(self.columns, options.channels) or ()
        columns = (replace(c, unit="", kind="", scale=None) if c in wanted else c for c in self.columns)
        return replace(self, columns=tuple(columns))


@dataclass(frozen=True, eq=False)
class Sense:
    """The meaning of the columns of a table: clock, signals, columns to read in addition; `assumed` by its steps."""

    columns: tuple[FileColumn, ...]
    sources: clocks.ClockSources
    choice: channels.Choice
    along: tuple[channels.SignalColumn, ...]
    assumed: tuple[tuple[str, ...], tuple[str, ...]]
    options: Options

    @property
    def signals(self) -> tuple[channels.SignalColumn, ...]:
        """The signals, then the columns to read in addition."""
        return (*self.choice.signals, *self.along)

    def demand(self, beat: clock.Beat) -> tuple[gravity.Doubt, ...]:
        """Ask for what is not known; doubts about what is."""
        questions = [*beat.questions, *self.choice.questions]
        if questions:
            asked, why, known = self._proposed(beat)
            clock, unsaid = [self.sources.stamps] if self.sources.stamps else self._rising, self.choice.unsaid
            numbers = [column for column in self.columns if not column.text and column.values.size]
            rows = proposal.overview(numbers, unsaid, clock, known) if unsaid or clock else ()
            words = "; ".join((*questions, *why, *(() if unsaid else self.choice.omitted)))
            choice = "rate" if beat.questions else "unit"
            more = proposal.printed(rows) if unsaid else ()
            raise UsageError(words, choice=choice, cure=asked, columns=rows, more=more)
        stated = self.options.unit or self.options.units
        doubts = tuple(gravity.doubts(self.choice.signals, beat.rate))
        against = None if stated else gravity.contradiction(self.choice.signals, doubts)
        if against is not None:
            what, unit = against
            raise UsageError(what, choice="unit", cure=("", spelled(f"--unit '{unit}'", f"unit='{unit}'")))
        return doubts

    @property
    def _rising(self) -> list[FileColumn]:
        """Columns that rise as time stamps do, and are not used."""
        free = [column for column in self.columns if column not in [signal.column for signal in self.signals]]
        return [c for c in free if self.options.time is None and channels.climbs(c, self.options, self.columns)]

    def _proposed(self, beat: clock.Beat) -> tuple[Cure, tuple[str, ...], dict[int, str]]:
        """What to type about the clock and the columns without a unit, why, and units by positions of columns."""
        given, unsaid = self.options.unit, self.choice.unsaid
        known = {signal.column.position: signal.unit for signal in self.choice.signals}
        if given and unsaid:
            return (given, channels.unit_meant(given) or UNIT), (), known
        proposals = [proposal.clock(self._rising, self.sources)] if beat.questions else []
        proposals += [proposal.units(unsaid, proposals[0].rate if proposals else beat.rate)] if unsaid else []
        known |= {position: unit for proposed in proposals for position, unit in proposed.units.items()}
        return ("", " ".join(p.words for p in proposals)), tuple(why for p in proposals for why in p.why), known

    def notes(self, beat: clock.Beat) -> tuple[str, ...]:
        """The assumptions."""
        before, after = self.assumed
        rates = (signal_of_kind(s.unit, s.kind) for s in self.choice.signals if s.kind == "rate")
        # samples of an inertial sensor that are dropped are not in the others
        slow = 0 < beat.rate <= SLOW and any(what is not None and what.inertial for what in rates)
        earth = gravity.earth(self.choice.signals, beat.rate)
        own = (*([DROPPED] if slow else []), *self.choice.notes, *earth, *self.choice.omitted)
        return (*before, *beat.notes, *own, *after)

    def findings(self, beat: clock.Beat, doubts: Iterable[gravity.Doubt]) -> tuple[Finding, ...]:
        """The findings about the clock, and about the meaning of the columns."""
        return (*beat.findings, *self.choice.findings, *(doubt.finding() for doubt in doubts))


def repeated(columns: Sequence[NDArray[Any]]) -> NDArray[np.bool_]:
    """Which rows repeat the row before in every column, shape (n - 1,); (False,) without a column."""
    same = [values[1:] == values[:-1] for values in columns]
    return np.logical_and.reduce(same) if same else np.zeros(1, dtype=bool)


def _record(signal: channels.SignalColumn, beat: clock.Beat, stated: float | None) -> Record:
    values, name = signal.column.values, signal.column.name
    start, history = stated if beat.start is None else beat.start, signal.column.history
    # a float this large becomes another integer without an error
    if signal.kind == "count" and values.dtype.kind == "f" and np.any(np.abs(values) >= 2.0**63):
        raise DataError(say("{column} contains counts beyond the range of 64-bit integers; use {option}",
                            column=signal.column.label,
                            option=spelled("--kind increment", "kind=increment")))  # fmt: skip
    put, kind = beat.grid.put(values), signal.kind
    if kind == "count" and np.isnan(put).any():  # a gap is not an integer: the same numbers, as increments
        kind = "increment"
    history = (*history, *beat.grid.history)
    return Record(put, beat.rate, signal.unit, kind, signal.scale, name=name, start=start, history=history)


def _demand_rows(columns: list[FileColumn]) -> None:
    lengths = {column.label: len(column.values) for column in columns}
    if len(set(lengths.values())) > 1:
        each = (say("{column} has {length}", column=label, length=length) for label, length in lengths.items())
        raise DataError(say("the columns have different lengths ({which}); select columns of one length with {option}",
                            which=join(", ", each), option=spelled("--channels", "channels=...")))  # fmt: skip
    for label, length in lengths.items():
        if length < 2:
            raise DataError(say("{column} contains {length} numbers; a record needs thousands, one row per sample",
                                column=label, length=length))  # fmt: skip


def described(recording: Recording, headers: Sequence[str]) -> str:
    """Rate, start and the description of each channel, with the header of its column, in ASCII."""
    channels = [
        {"header": header}
        | {name: getattr(record, name) for name in ("name", "unit", "kind", "scale")}
        | {"integers": record.values.dtype.kind == "i", "history": list(record.history)}
        for record, header in zip(recording, headers, strict=True)
    ]
    description = {
        KEY: 1, "type": "Recording", "rate": recording[0].rate, "start": recording[0].start, "channels": channels,
    }  # fmt: skip
    # behind a separator a spreadsheet computes what begins with such a sign
    return re.sub("(?<=[,;])[=+@-]", lambda sign: f"\\u{ord(sign[0]):04x}", json.dumps(description))


def keys(recording: Recording) -> list[str]:
    """A unique name for each channel that any format accepts: ASCII letters, digits and _."""
    return identifiers([record.name for record in recording], "channel", taken=(KEY, *RATE_NAMES))


def with_units(names: Sequence[str], recording: Recording) -> list[str]:
    """Headers of columns with these names whose units the file states."""
    return [f"{name.strip()} [{record.unit}]".strip() for name, record in zip(names, recording, strict=True)]


def restored(table: FileTable, text: str | bytes) -> FileTable:
    """The columns with their stored description; a description that does not fit them is ignored, with a note."""
    if not text:
        return table
    try:
        description = json.loads(text)
        columns = list[FileColumn]()
        written = description["channels"]
        for column, channel in zip(_ordered(table.columns, written), written, strict=True):
            kind, unit, scale = str(channel["kind"]), str(channel["unit"]), channel["scale"]
            if signal_of_kind(unit, kind) is None or column.text:
                raise ValueError(unit)
            # JSON text may contain 1.0 as an integer
            values = column.values if channel["integers"] else column.values.astype(np.float64)
            scale, history = None if scale is None else _positive(scale), channel["history"]
            columns.append(replace(
                column, values=values, name=str(channel["name"]), unit=unit, kind=kind, scale=scale,
                history=tuple(join("", [str(step)]) for step in history),
            ))  # fmt: skip
        start = None if description["start"] is None else float(description["start"])
        rate = _positive(description["rate"])
        return replace(table, columns=tuple(columns), rate=rate, rate_source=SOURCE, start=start)
    except (AllaniteError, ValueError, TypeError, KeyError, AttributeError, OverflowError, RecursionError):
        note = say("{source} does not match its columns (were they changed since it was written?) and is ignored",
                   source=SOURCE)  # fmt: skip
        return replace(table, notes=(*table.notes, note))


def _ordered(columns: Sequence[FileColumn], channels: Sequence[dict[str, Any]]) -> Sequence[FileColumn]:
    """The columns in the order in which they were written: other programs may sort them, or list them by name."""
    written: list[Any] = [channel.get("header") for channel in channels]
    headers = [column.header for column in columns]
    if written == headers or None in written or not any(headers):
        return columns
    if sorted(written) != sorted(headers) or len(set(headers)) < len(headers):
        raise ValueError(headers)
    return [columns[headers.index(header)] for header in written]


def _positive(number: Any) -> float:
    if isinstance(number, bool) or not 0 < number < float("inf"):
        raise ValueError(number)
    return float(number)
