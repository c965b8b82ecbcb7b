"""Is the record fit for the job, and cutting it to what is."""

from dataclasses import replace

import numpy as np

from .errors import DataError, UsageError
from .finding import Finding, Quality
from .record import SHORTEST, Record, Recording


def inspect(record: Record) -> Quality:
    """Look at a record before numbers are made of it."""
    return Quality(tuple(f for check in CHECKS if (f := check(record)) is not None))


def _not_finite(record: Record) -> Finding | None:
    # one pass without a mask of the record's size: the sum of finite readings is finite
    with np.errstate(invalid="ignore", over="ignore"):
        if np.isfinite(record.values.sum(dtype=np.float64)):
            return None
    bad = ~np.isfinite(record.values)
    if not bad.any():
        what = f"the readings of {record.name!r} are too large to be added"
        return Finding("range", what, remedy="check the unit and type", fatal=True)
    what = f"{bad.sum()} of {bad.size} readings of {record.name!r} are not finite"
    if bad.all():
        return Finding("not finite", what, remedy="check the column and the reader's options", fatal=True)
    what += f", the first at sample {int(bad.argmax())}"
    return Finding("not finite", what, remedy="choose a window without them (from, until)", fatal=True)


def _too_short(record: Record) -> Finding | None:
    if record.size >= SHORTEST:
        return None
    what = f"{record.name!r} has {record.size} readings, too few for noise coefficients (at least {SHORTEST})"
    return Finding("too short", what, remedy="record for longer", fatal=True)


def _constant(record: Record) -> Finding | None:
    steps = record.values if record.kind != "angle" else np.diff(record.values)
    if steps.min() != steps.max():
        return None
    what = f"{record.name!r} never changes (always {steps[0]!r})"
    return Finding("constant", what, remedy="check that the sensor is connected and this is its column", fatal=True)


CHECKS = (_not_finite, _too_short, _constant)


def trim(recording: Recording, start: float | None = None, until: float | None = None) -> Recording:
    """The part of a recording from `start` to `until`, in seconds after its first sample.

    Raises
    ------
    UsageError
        The window is empty, or does not lie within the recording.

    Examples
    --------
    >>> record = Record(np.arange(10.0), rate=2.0, unit="deg/s", name="z")
    >>> trim(Recording((record,)), 1.0, 3.0)["z"].values.tolist()
    [2.0, 3.0, 4.0, 5.0]
    """
    if start is None and until is None:
        return recording
    return replace(recording, records=tuple(_cut(record, start or 0.0, until) for record in recording))


def _cut(record: Record, start: float, until: float | None) -> Record:
    end = record.duration if until is None else until
    if not 0 <= start < end:
        raise UsageError(f"the window from {start} s to {end} s is empty or starts before the record")
    if end > record.duration * (1 + 1e-9):
        raise UsageError(f"the window ends at {end} s, but {record.name!r} is {record.duration:.6g} s long")
    first, last = round(start * record.rate), round(end * record.rate)
    if last - first < 2:
        raise DataError(f"the window from {start} s to {end} s holds {last - first} readings of {record.name!r}")
    extra = len(record.values) - record.size
    origin = (record.start or 0.0) + first / record.rate
    return record.with_values(record.values[first : last + extra], f"cut from {start:g} s to {end:g} s", start=origin)
