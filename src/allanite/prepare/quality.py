"""Is the record fit for the job? Looked at before any number is made of it."""

import numpy as np

from allanite.finding import Finding, Quality
from allanite.record import SHORTEST, Record


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
