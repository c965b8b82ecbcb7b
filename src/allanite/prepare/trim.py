"""Cutting a record to the part that is fit for the job."""

from dataclasses import replace

from allanite.errors import DataError, UsageError
from allanite.record import Record, Recording


def trim(recording: Recording, start: float | None = None, until: float | None = None) -> Recording:
    """The part of a recording from `start` to `until`, in seconds after its first sample.

    Raises
    ------
    UsageError
        The window is empty, or does not lie within the recording.

    Examples
    --------
    >>> import numpy as np
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
