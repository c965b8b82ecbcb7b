"""Checks of single readings: stuck, clipped, coarse, spiky."""

import math

import numpy as np

from allanite.finding import Finding

from .view import View, stretches

RARE = 1e-4
"""Probability with which a check may be wrong about a clean record."""

COARSE = 0.5
"""Quantization step over the fast noise's standard deviation from which the step shows in the numbers."""

NO_DITHER = 0.3
"""Fast noise over the step below which rounding errors are no white noise any more. After rounding it shows as one or
two codes: noise of 0.3 step already takes three within a few hundred readings."""

NEARBY = 256
"""Readings among which codes are counted."""

FEW_CODES = 16
"""Distinct readings up to which they are counted out."""


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
        f"the readings stand still {len(bad)} time(s), first from {view.seconds(first):.6g} s to "
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
        if count > 1.5 * int((inner == beside).sum()) and _grid(view)[0] > FEW_CODES // 2:
            first = int(at.argmax())
            return Finding(
                "clipped",
                f"{count} readings lie exactly at the {side} end, {float(edge):.6g}, "
                f"the first at {view.seconds(first):.6g} s",
                "the noise beyond the sensor's range is missing, and coefficients come out too small",
                "use a wider range, or a window without it (--from, --until)",
                (view.seconds(first), view.seconds(y.size)),
            )
    return None


def quantised(view: View) -> Finding | None:
    """A step that is coarse against the noise; without enough noise to dither it, a warning of its own."""
    codes, step = _grid(view)
    if step == 0 or (step < COARSE * view.fast and codes > FEW_CODES):
        return None
    size = step * (view.record.scale or 1.0)
    counted = f"{codes} distinct values, " if codes <= FEW_CODES else ""
    what = f"{counted}quantised to {size:.4g} {view.record.unit}, fast noise {view.fast / step:.2g} step"
    if undithered(view, step):
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


def undithered(view: View, step: float) -> bool:
    """Whether there is too little fast noise to make rounding errors of readings on a grid of `step` random."""
    return view.fast < NO_DITHER * step or _codes_nearby(view) <= 2


def _codes_nearby(view: View) -> float:
    """Median number of distinct readings in stretches of 256."""
    y = view.steps
    starts = np.linspace(0, max(y.size - NEARBY, 0), 50).astype(int)
    return float(np.median([np.unique(y[start : start + NEARBY]).size for start in starts]))


def _grid(view: View) -> tuple[int, float]:
    """Number of distinct readings in a sample, and their step; step 0 if they lie on no grid."""
    y = view.steps
    starts = np.linspace(0, max(y.size - 20_000, 0), 10).astype(int)
    part = y if y.size <= 200_000 else np.concatenate([y[start : start + 20_000] for start in starts])
    codes = np.unique(part)
    if codes.size > 0.2 * part.size or codes.size < 2:
        return codes.size, 0.0
    gaps = np.diff(codes.astype(np.float64))
    # readings printed with rounding differ by multiples of the step to within a part of it
    step = float(np.median(gaps[gaps < 1.5 * gaps.min()]))
    multiples = gaps / step
    even = np.abs(multiples - np.rint(multiples)) < 0.1
    return codes.size, step if even.mean() > 0.95 else 0.0


def outliers(view: View) -> Finding | None:
    """Readings off the line between their neighbours by more than any noise of this length."""
    from scipy.special import ndtri

    limit = -float(ndtri(RARE / 2 / view.bends.size)) * 1.05
    scale = view.fast * math.sqrt(6.0)
    high = np.abs(view.bends) > limit * scale
    count = int(high.sum())
    if not count or count > 0.02 * high.size:
        return None
    at = np.flatnonzero(high)
    events = 1 + int((np.diff(at) > 3).sum())
    first = int(at[0]) + 1
    worst = float(np.abs(view.bends[at]).max()) / scale
    return Finding(
        "outliers",
        f"{events} outlier(s), the first at {view.seconds(first):.6g} s, the largest {worst:.3g} standard deviations",
        "a spike adds to every short averaging time, and N and Q come out too large",
        "mark them (prepare.mark_outliers), or choose a window without them (--from, --until)",
        (view.seconds(first), view.seconds(int(at[-1]) + 1)),
    )
