"""Checks of single readings: stuck, clipped, coarse, spiky."""

import math

import numpy as np

from allanite.core.finding import Finding
from allanite.core.wording import percent, plural

from .outliers import MOST, TAIL, Outliers
from .rounding import FEW_CODES, grid, rounding
from .view import View, stretches

RARE = 1e-4
"""Probability with which a check may be wrong about a clean record."""


def stuck(view: View) -> Finding | None:
    """Runs of one value that are longer than chance makes them, given how often neighbours are equal at all."""
    same = view.steps[1:] == view.steps[:-1]
    share = float(same.mean())
    if share == 0:
        return None
    runs = stretches(same)
    length = np.diff(runs, axis=1)[:, 0]
    without = max((same.sum() - length.max()) / same.size, 1 / same.size)
    # coarse readings of a smooth signal are equal in runs: three times what independent ones would make
    longest = max(10.0, 3 * math.log(RARE / same.size) / math.log(min(without, 0.999)))
    bad = runs[length > longest]
    if not bad.size:
        return None
    first, last = int(bad[0, 0]), int(bad[0, 1])
    lost = int((bad[:, 1] - bad[:, 0]).sum())
    return Finding(
        "stuck",
        f"the readings stand still in {plural(len(bad), 'place')}, first from {view.seconds(first):.6g} s to "
        f"{view.seconds(last):.6g} s; {lost} readings in all",
        "a sensor or logger that repeats itself looks quieter than it is",
        "choose a window without it (--from, --until)",
        (view.seconds(first), view.seconds(last)),
    )


def clipped(view: View) -> Finding | None:
    """The largest or smallest reading occurs more often than the next one inwards."""
    y = view.steps
    for edge, side in ((y.max(), "upper"), (y.min(), "lower")):
        at = y == edge
        count = int(at.sum())
        if count < 10:
            continue
        inner = y[~at]
        beside = inner.max() if side == "upper" else inner.min()
        if count > 1.5 * int((inner == beside).sum()) and grid(view.steps)[0] > FEW_CODES // 2:
            first, last = int(at.argmax()), at.size - 1 - int(at[::-1].argmax())
            return Finding(
                "clipped",
                f"{count} readings lie exactly at the {side} end, {float(edge):.6g}, "
                f"the first at {view.seconds(first):.6g} s, the last at {view.seconds(last):.6g} s",
                "the noise beyond the sensor's range is missing, and coefficients come out too small",
                "use a wider range, or a window without it (--from, --until)",
                (view.seconds(first), view.seconds(last + 1)),
            )
    return None


def quantised(view: View) -> Finding | None:
    """A step that is coarse against the noise; without enough noise to dither it, a warning of its own."""
    found = rounding(view.steps, view.fast)
    if not found.coarse:
        return None
    size = found.step * (view.record.scale or 1.0)
    what = f"{found.counted}quantised to {size:.4g} {view.record.unit}, fast noise {found.noise:.2g} step"
    if found.undithered:
        return Finding(
            "no dither",
            what,
            "the rounding error is no noise here: it depends on the signal, and N and Q are not meaningful",
            "use a finer output of the sensor, or add dither before rounding",
        )
    return Finding(
        "quantised",
        what,
        "rounding a rate adds white noise of step/sqrt(12) to N, rounding an angle is Q",
        "use a finer output of the sensor if N matters",
    )


def _why(view: View, found: Outliers) -> str:
    """Why readings beyond the limit are no outliers."""
    if found.heavy > MOST * view.steps.size:
        return f"more than {percent(MOST)} of all: another noise, not single outliers"
    return f"and more than Gaussian noise has beyond {TAIL * found.limit:.2g}: heavy tails, not single outliers"


def outliers(view: View) -> Finding | None:
    """Readings far off the median of those around them, or the heavy tails that they belong to."""
    found = view.outliers
    if found.heavy:
        return Finding(
            "heavy tails",
            f"{plural(found.heavy, 'reading')} beyond {found.limit:.2g} standard deviations, {_why(view, found)}",
            "the noise is not Gaussian, or its level changes fast: intervals are too narrow",
            "look at the readings; nothing is left out",
        )
    if not found.at.size:
        return None
    cut = view.record.cut
    return Finding(
        "outliers",
        found.words(view.record),
        "each adds to curves and spectra at every short averaging time",
        "leave them out there, too (--outliers mark), or choose a window without them (--from, --until)",
        (cut + float(found.at[0]) / view.rate, cut + float(found.at[-1] + 1) / view.rate),
    )
