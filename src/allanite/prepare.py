"""Is the record fit for the job, and cutting it to what is."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .errors import DataError, UsageError
from .record import SHORTEST, Record, Recording


@dataclass(frozen=True)
class Finding:
    """Something about a record that the reader of its numbers must know."""

    name: str
    fatal: bool
    what: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.what}; {self.remedy}"


@dataclass(frozen=True)
class Quality:
    """What was found about a record before anything was computed."""

    findings: tuple[Finding, ...]

    @property
    def refusal(self) -> str:
        """Why the record cannot support the job; empty if it can."""
        return "; ".join(str(f) for f in self.findings if f.fatal)

    @property
    def warnings(self) -> tuple[Finding, ...]:
        """What must stand beside the numbers."""
        return tuple(f for f in self.findings if not f.fatal)

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "findings": [{"name": f.name, "fatal": f.fatal, "what": f.what, "remedy": f.remedy} for f in self.findings]
        }


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
        return Finding(
            "range", True, f"the readings of {record.name!r} are too large to be added", "check the unit and type"
        )
    which = f"{bad.sum()} of {bad.size} readings of {record.name!r} are not finite"
    if bad.all():
        return Finding("not finite", True, which, "check the column and the reader's options")
    first = int(bad.argmax())
    return Finding(
        "not finite", True, f"{which}, the first at sample {first}", "choose a window without them (from, until)"
    )


def _too_short(record: Record) -> Finding | None:
    if record.size >= SHORTEST:
        return None
    what = f"{record.name!r} has {record.size} readings, too few for noise coefficients (at least {SHORTEST})"
    return Finding("too short", True, what, "record for longer")


def _constant(record: Record) -> Finding | None:
    steps = record.values if record.kind != "angle" else np.diff(record.values)
    if steps.min() != steps.max():
        return None
    what = f"{record.name!r} never changes (always {steps[0]!r})"
    return Finding("constant", True, what, "check that the sensor is connected and this is its column")


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
