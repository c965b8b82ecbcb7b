"""Checks whether a record can support an analysis, before anything is computed."""

from collections.abc import Callable, Sequence

import numpy as np

from allanite.core.aliases import public
from allanite.core.record import SHORTEST, Record
from allanite.core.validity import Finding, Quality
from allanite.phrases.phrase import between, percent, say, say_count

from .bursts import bursts
from .gaps import refusal
from .readings import clipped, outliers, quantized, stuck
from .resampled import resampled
from .stillness import level, lines, moving, slope
from .view import View

SHORT = 600.0  # length, s, below which slow terms are rarely identified


@public
def inspect(record: Record) -> Quality:
    """Check a record before it is analyzed.

    Returns
    -------
    Quality
        The findings, fatal ones first; a refused record is not checked further.
    """
    return checked(record, CHECKS)


def checked(record: Record, checks: Sequence[Callable[[View], Finding | None]]) -> Quality:
    """What some of the checks tell, and motion."""
    view = View(record)
    fatal = _fatal(view)
    if fatal is not None:
        return Quality((fatal,))
    motion = moving(view)
    if motion is not None and motion.fatal:
        return Quality((motion,))
    findings = [f for f in (motion, *(look(view) for look in checks)) if f is not None]
    covered = {other for f in findings for other in COVERS.get(f.name, ())}
    return Quality(tuple(f for f in findings if f.name not in covered))


def _fatal(view: View) -> Finding | None:
    """Why nothing is looked at: values out of range or not finite, too few of them, or all the same."""
    record = view.record
    if record.out_of_range:
        return Finding("range", record.out_of_range, fatal=True)
    if np.isnan(record.extent[0]):
        what = say("{bad} of {size} samples are not finite", bad=record.values.size, size=record.values.size)
        return Finding("not finite", what, remedy=say("check the column and the reader's options"), fatal=True)
    why, short = refusal(record), record.size < SHORTEST
    if why:
        remedy = say("record for longer") if short else ""
        return Finding("too short" if short else "too little left", why, remedy=remedy, fatal=True)
    least, largest = view.extremes
    if least != largest:
        return None
    return constant(float(least))


def constant(value: float) -> Finding:
    """That all samples have the same value."""
    what = say("the signal never changes (always {value:.10g})", value=value)
    remedy = say("check that the sensor is connected and this is its column")
    return Finding("constant", what, remedy=remedy, fatal=True)


def _gaps(view: View) -> Finding | None:
    if view.left is None:
        return None
    size = view.record.size
    lost = size - view.left.size
    runs = np.concatenate(([0], view.joints, [view.left.size]))
    longest = int(np.diff(runs).argmax())
    first, last = view.left[runs[longest]], view.left[runs[longest + 1] - 1]
    holes = np.flatnonzero(np.diff(np.concatenate(([-1], view.left, [size]))) > 1)
    start = float(view.left[holes[0] - 1] + 1) if holes[0] else 0.0
    end = float(view.left[holes[-1]]) if holes[-1] < view.left.size else float(size)
    start, end, first, last = (view.record.cut + at / view.rate for at in (start, end, first, last + 1))
    return Finding("gaps",
        say("{lost} of {size} samples are missing ({share}), in {gaps}, the first from {start:.6g} s",
            lost=lost, size=size, share=percent(lost / size), gaps=say_count(holes.size, "{count} gap", "{count} gaps"),
            start=start),
        say("gaps are not filled: the fit joins the remaining samples and accounts for the joints, curves use "
            "complete windows only"),
        say("the longest stretch without a gap: {selection}", selection=between(first, last))
        if np.diff(runs).max() >= SHORTEST else "",
        (start, end),
    )  # fmt: skip


def _short(view: View) -> Finding | None:
    if view.record.duration >= SHORT:
        return None
    return Finding(
        "short",
        say("the record is only {duration:.4g} s long", duration=view.record.duration),
        say("bias instability, rate random walk and ramp are rarely identified in less than ten minutes"),
        say("record for longer"),
    )


CHECKS: tuple[Callable[[View], Finding | None], ...] = (
    _gaps, _short, stuck, clipped, quantized, outliers, bursts, resampled, level, lines, slope,
)  # fmt: skip

COVERS = {"bursts": ("heavy tails",)}  # findings that say the same as another one with less
