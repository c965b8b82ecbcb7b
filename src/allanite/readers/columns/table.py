"""Table: the columns of a file before anybody has said what they are. Every reader fills one."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError, UsageError
from allanite.core.record import Record, Recording
from allanite.readers.clock import beat as clock
from allanite.readers.clock import clocks
from allanite.readers.options import Options

from . import channels
from .column import Column, unique


@dataclass(frozen=True, eq=False)
class Table:
    """The columns of a file, what the file itself says about them, and what was assumed so far.

    Parameters
    ----------
    columns : tuple of Column
        In the order of the file.
    rate, rate_source
        Sampling rate in Hz, if the file states one, and where it does.
    notes : tuple of str
        What was assumed when the file was taken apart.
    start : float, optional
        Time of the first sample, s, if the file states one.
    """

    columns: tuple[Column, ...]
    rate: float | None = None
    rate_source: str = ""
    notes: tuple[str, ...] = field(default=())
    start: float | None = None

    def recording(self, options: Options) -> Recording:
        """The channels as records on one clock.

        Raises
        ------
        UsageError
            Rate, unit or kind is neither in the file nor in the options, or a chosen column does not exist.
        DataError
            The columns hold too few rows or text, or the stamps follow no even grid.
        """
        if max((len(column.values) for column in self.columns), default=0) < 2:
            raise DataError(
                "the file holds fewer than 2 rows of numbers; a record needs thousands, one row for each sample"
            )
        table = replace(self, columns=unique(self.columns))
        chosen = channels.named(table.columns, options.channels)
        # a column of which the file says what its readings are is a clock only if the user says so
        open_ = tuple(c for c in table.columns if not c.kind) if options.time is None else table.columns
        sources = replace(clocks.find(open_, options.time, chosen), rate=table.rate, source=table.rate_source)
        time = sources.stamps
        along, said = channels.beside(channels.named(table.columns, options.along) or ())
        taken = [signal.column for signal in along]
        open_to_choice = tuple(column for column in table.columns if column not in taken)
        choice = channels.choose(open_to_choice, options, chosen, time)
        signals = [signal.column for signal in (*choice.signals, *along)]
        _demand_rows([*signals, *([time] if time else [])])
        beat = clock.beat(sources, options.rate, lambda: _repeated(signals))
        questions = [*beat.questions, *choice.questions]
        if questions:
            raise UsageError("; ".join((*questions, *choice.left)))
        records = tuple(_record(signal, beat, table.start) for signal in (*choice.signals, *along))
        notes = (*table.notes, *beat.notes, *choice.notes, *choice.left, *said)
        return Recording(records, notes=notes, findings=beat.grid.findings)


def _repeated(columns: list[Column]) -> NDArray[np.bool_]:
    """Which rows have the readings of the row before in every column, shape (n - 1,); (False,) without a column."""
    same = [column.values[1:] == column.values[:-1] for column in columns]
    return np.logical_and.reduce(same) if same else np.zeros(1, dtype=bool)


def _record(signal: channels.Signal, beat: clock.Beat, stated: float | None) -> Record:
    values, name = signal.column.values, signal.column.name
    start, history = stated if beat.start is None else beat.start, signal.column.history
    # a float this large turns into another integer without a word
    if signal.kind == "count" and values.dtype.kind == "f" and np.any(np.abs(values) >= 2.0**63):
        raise DataError(f"{signal.column.label} holds counts beyond the range of 64-bit integers; use kind='increment'")
    put, kind = beat.grid.put(values), signal.kind
    if beat.grid.lost and kind == "count":  # a gap is no integer: the same numbers, as increments
        kind = "increment"
    history = (*history, *beat.grid.history)
    return Record(put, beat.rate, signal.unit, kind, signal.scale, name=name, start=start, history=history)


def numbers(values: NDArray[Any], header: str) -> NDArray[Any]:
    """Readings of any real type as native float64 or int64."""
    copy = values.base is not None  # a part of a matrix, which it would keep, or of a file, which may change
    if values.dtype.kind in "iu":
        fits = values.dtype != np.uint64 or not len(values) or values.max() <= np.iinfo(np.int64).max
        return values.astype(np.int64 if fits else np.float64, copy=copy)
    if values.dtype.kind == "f":
        with np.errstate(over="ignore"):
            return values.astype(np.float64, copy=copy)
    raise DataError(f"{header!r} holds values of type {values.dtype}, real numbers are expected")


def _demand_rows(columns: list[Column]) -> None:
    lengths = {column.label: len(column.values) for column in columns}
    if len(set(lengths.values())) > 1:
        which = ", ".join(f"{label} has {length}" for label, length in lengths.items())
        raise DataError(
            f"the columns have different lengths ({which}); choose those of one length with channels=... (--channels)"
        )
    for label, length in lengths.items():
        if length < 2:
            raise DataError(f"{label} holds {length} numbers; a record needs thousands, one row for each sample")
