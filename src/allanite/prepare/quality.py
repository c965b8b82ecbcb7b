"""Checks whether a record can support an analysis, before anything is computed."""

from collections.abc import Callable

import numpy as np

from allanite.core.finding import Finding, Quality
from allanite.core.record import SHORTEST, Record
from allanite.phrases.phrase import say, say_count
from allanite.phrases.wording import between, percent

from .gaps import refusal
from .readings import clipped, outliers, quantized, stuck
from .resampled import resampled
from .stillness import level, lines, moving, slope
from .view import View

SHORT = 600.0
"""Length, s, below which slow terms are rarely identified."""


def inspect(record: Record) -> Quality:
    """Check a record before it is analyzed.

    Returns
    -------
    Quality
        The findings, fatal ones first; a refused record is not checked further.
    """
    for check in FIRST:
        fatal = check(record)
        if fatal is not None:
            return Quality((fatal,))
    view = View(record)
    motion = moving(view)
    if motion is not None and motion.fatal:
        return Quality((motion,))
    found = (motion, *(look(view) for look in CHECKS))
    return Quality(tuple(f for f in found if f is not None))


def _out_of_range(record: Record) -> Finding | None:
    if record.out_of_range:
        return Finding("range", record.out_of_range, fatal=True)
    if np.isnan(record.extent[0]):
        what = say("{bad} of {size} samples are not finite", bad=record.values.size, size=record.values.size)
        return Finding("not finite", what, remedy=say("check the column and the reader's options"), fatal=True)
    return None


def _too_little(record: Record) -> Finding | None:
    why = refusal(record)
    name = "too short" if record.size < SHORTEST else "too little left"
    return (
        Finding(name, why, remedy=say("record for longer") if record.size < SHORTEST else "", fatal=True)
        if why
        else None
    )


def _constant(record: Record) -> Finding | None:
    steps = record.steps
    if steps.min() != steps.max():
        steps = steps[np.isfinite(steps)]
        if not steps.size or steps.min() != steps.max():
            return None
    what = say("the signal never changes (always {value:.10g})", value=steps[0])
    return Finding(
        "constant", what, remedy=say("check that the sensor is connected and this is its column"), fatal=True
    )


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
    return Finding(
        "gaps",
        say(
            "{lost} of {size} samples are missing ({share}), in {gaps}, the first from {start:.6g} s",
            lost=lost,
            size=size,
            share=percent(lost / size),
            gaps=say_count(holes.size, "{count} gap", "{count} gaps"),
            start=start,
        ),
        say(
            "gaps are not filled: the fit joins the remaining samples and accounts for the joints, curves use "
            "complete windows only"
        ),
        say("the longest stretch without a gap: {selection}", selection=between(first, last))
        if np.diff(runs).max() >= SHORTEST
        else "",
        (start, end),
    )


def _short(view: View) -> Finding | None:
    if view.record.duration >= SHORT:
        return None
    return Finding(
        "short",
        say("the record is only {duration:.4g} s long", duration=view.record.duration),
        say("bias instability, rate random walk and ramp are rarely identified in less than ten minutes"),
        say("record for longer"),
    )


FIRST: tuple[Callable[[Record], Finding | None], ...] = (_out_of_range, _too_little, _constant)
CHECKS: tuple[Callable[[View], Finding | None], ...] = (
    _gaps,
    _short,
    stuck,
    clipped,
    quantized,
    outliers,
    resampled,
    level,
    lines,
    slope,
)
