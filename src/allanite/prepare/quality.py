"""Is the record fit for the job? Looked at before any number is made of it."""

from collections.abc import Callable

import numpy as np

from allanite.finding import Finding, Quality
from allanite.record import SHORTEST, Record

from .readings import clipped, outliers, quantised, stuck
from .resampled import resampled
from .stillness import level, lines, moving, slope
from .view import View, stretches

SHORT = 600.0
"""Length, s, below which slow terms are hardly ever identified."""


def inspect(record: Record) -> Quality:
    """Look at a record before numbers are made of it.

    Returns
    -------
    Quality
        What was found, what forbids the job first; a record that is refused is not looked at further.
    """
    fatal = tuple(f for check in FIRST if (f := check(record)) is not None)
    if fatal:
        return Quality(fatal)
    view = View(record)
    motion = moving(view)
    if motion is not None and motion.fatal:
        return Quality((motion,))
    found = (motion, *(check(view) for check in CHECKS))
    return Quality(tuple(f for f in found if f is not None))


def _not_finite(record: Record) -> Finding | None:
    # one pass without a mask of the record's size: the sum of finite readings is finite
    with np.errstate(invalid="ignore", over="ignore"):
        if np.isfinite(record.values.sum(dtype=np.float64)):
            return None
    bad = ~np.isfinite(record.values)
    if not bad.any():
        what = "the readings are too large to be added"
        return Finding("range", what, remedy="check the unit and type", fatal=True)
    what = f"{bad.sum()} of {bad.size} readings are not finite"
    if bad.all():
        return Finding("not finite", what, remedy="check the column and the reader's options", fatal=True)
    what += f", the first at sample {int(bad.argmax())}, in {len(stretches(bad))} gap(s)"
    whole = stretches(~bad)
    start, end = (float(v) / record.rate for v in whole[np.diff(whole, axis=1)[:, 0].argmax()])
    remedy = f"the longest stretch without a gap: --from {start:.6g} --until {end:.6g}"
    place = (int(bad.argmax()) / record.rate, (bad.size - int(bad[::-1].argmax())) / record.rate)
    return Finding("gaps", what, "what was lost is not filled in", remedy, place, fatal=True)


def _too_short(record: Record) -> Finding | None:
    if record.size >= SHORTEST:
        return None
    what = f"{record.size} readings are too few for noise coefficients (at least {SHORTEST})"
    return Finding("too short", what, remedy="record for longer", fatal=True)


def _constant(record: Record) -> Finding | None:
    steps = record.values if record.kind != "angle" else np.diff(record.values)
    if steps.min() != steps.max():
        return None
    what = f"the signal never changes (always {steps[0]!r})"
    return Finding("constant", what, remedy="check that the sensor is connected and this is its column", fatal=True)


def _short(view: View) -> Finding | None:
    if view.record.duration >= SHORT:
        return None
    return Finding(
        "short",
        f"{view.record.duration:.4g} s are short",
        "bias instability, rate random walk and ramp are seldom identified in less than ten minutes",
        "record for longer",
    )


FIRST: tuple[Callable[[Record], Finding | None], ...] = (_not_finite, _too_short, _constant)
CHECKS: tuple[Callable[[View], Finding | None], ...] = (
    _short,
    stuck,
    clipped,
    quantised,
    outliers,
    resampled,
    level,
    lines,
    slope,
)
