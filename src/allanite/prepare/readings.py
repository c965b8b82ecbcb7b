"""Checks of single samples: stuck, clipped, coarse, outlying."""

import math
from typing import NamedTuple

import numpy as np
import scipy

from allanite.core.arrays import stretches
from allanite.core.record import Record
from allanite.core.validity import Finding
from allanite.phrases.phrase import join, longest_without, percent, say, say_count, spelled, windowing

from .outliers import MOST, TAIL, Outliers
from .rounding import FEW_CODES, grid
from .view import NONE, View

RARE = 1e-4  # probability that a check fails for a clean record


def stuck(view: View) -> Finding | None:
    """Runs of one value that are significantly long, given how often neighbours are equal."""
    same = row = view.steps[1:] == view.steps[:-1]
    for step in (1, 2, 4):
        row = row[step:] & row[:-step]
    if not row.any():  # of eight
        return None
    runs = stretches(same)
    length = np.diff(runs, axis=1)[:, 0]
    without = max((same.sum() - length.max()) / same.size, 1 / same.size)
    # coarse samples of a smooth signal repeat in runs: allow three times the length of independent ones
    longest = max(10.0, 3 * math.log(RARE / same.size) / math.log(min(without, 0.999)))
    bad = runs[length > longest]
    if not bad.size:
        return None
    first, last = int(bad[0, 0]), int(bad[0, 1])
    lost = int((bad[:, 1] - bad[:, 0]).sum())
    return Finding("stuck",
        say("the output is stuck in {places}, the first from {first:.6g} s to {last:.6g} s; {lost} samples in all",
            places=say_count(len(bad), "{count} place", "{count} places"), first=view.seconds(first),
            last=view.seconds(last), lost=lost),
        say("repeated values of a sensor or logger make the noise look smaller"),
        say("choose a window without it ({choice})",
            choice=longest_without(((view.seconds(a), view.seconds(b + 1)) for a, b in bad.tolist()), view.ends)),
        (view.seconds(first), view.seconds(last)),
    )  # fmt: skip


class Clipping(NamedTuple):
    """How many samples are equal to the smallest and to the largest value, the first and last of them, of how many."""

    low: int
    high: int
    first: int
    last: int
    size: int
    even: bool  # every eighth of the record has some: noise reaches the limits, not a drift

    @property
    def factor(self) -> float:
        """What is left of N if the noise is white: the standard deviation of a normal one within the limits."""
        ndtr, ndtri = scipy.special.ndtr, scipy.special.ndtri
        a, b = max(float(ndtri(self.low / self.size)), -40.0), min(-float(ndtri(self.high / self.size)), 40.0)
        below, above = float(ndtr(a)), float(ndtr(-b))
        lower, upper = (math.exp(-0.5 * z * z) / math.sqrt(2 * math.pi) for z in (a, b))
        mean = lower - upper + a * below + b * above
        square = 1 - below - above + a * lower - b * upper + a * a * below + b * b * above
        return math.sqrt(square - mean**2)


def clipping(view: View) -> Clipping | None:
    """Samples at the limits of the range: the largest or smallest value occurs more often than the next one."""
    y, at = view.steps, []
    for edge, count, beside in zip(view.extremes, view.limited, (np.min, np.max), strict=True):
        many = count >= 10 and count > 1.5 * np.count_nonzero(y == beside(y[y != edge]))
        at.append(np.flatnonzero(y == edge) if many else NONE)
    both = np.sort(np.concatenate(at))
    if not both.size or grid(y)[0] <= FEW_CODES // 2:
        return None
    even = np.unique(both * 8 // y.size).size == 8
    return Clipping(at[0].size, at[1].size, int(both[0]), int(both[-1]), y.size, even)


def clipped(view: View) -> Finding | None:
    """The finding about clipping."""
    limits = clipping(view)
    if limits is None:
        return None
    low, high = view.extremes
    sides = (
        say("{count} samples are equal to the {side} value, {edge:.6g}", count=count, side=side, edge=float(edge))
        for count, side, edge in ((limits.high, say("upper"), high), (limits.low, say("lower"), low))
        if count
    )
    where = say("the first at {first:.6g} s, the last at {last:.6g} s", first=view.seconds(limits.first),
                last=view.seconds(limits.last))  # fmt: skip
    lost = say("the noise beyond the range of the sensor is missing, and the coefficients are too small")
    if limits.even:
        lost = say("{lost}: N is {factor:.2g} times that of the sensor if the noise is white", lost=lost,
                   factor=limits.factor)  # fmt: skip
    return Finding("clipped",
        join(", ", (*sides, where)), lost,
        say("use a larger range, or a window without it ({choice})", choice=windowing()),
        (view.seconds(limits.first), view.seconds(limits.last + 1)),
    )  # fmt: skip


def quantized(view: View) -> Finding | None:
    """A quantization step that is coarse relative to the noise; a separate warning if the noise is no dither."""
    steps = view.rounding
    if not steps.coarse or view.pulses:  # a count is a rounded angle by nature; the fit tells whether that is a noise
        return None
    size = steps.step * (view.record.scale or 1.0)
    step = say("quantized to {size:.4g} {unit}, fast noise {noise:.2g} step",
               size=size, unit=view.record.unit, noise=steps.noise)  # fmt: skip
    what = join(", ", filter(None, (steps.counted, step)))
    if steps.undithered:
        return Finding(
            "no dither",
            what,
            say("the rounding error depends on the signal and is not a noise; N and Q are not meaningful"),
            say("use a finer output of the sensor, or add dither before rounding"),
        )
    return Finding(
        "quantized",
        what,
        say("rounding of a rate adds white noise of step/sqrt(12) to N, rounding of an angle is Q")
        if view.record.signal.inertial
        else say("rounding adds white noise of step/sqrt(12) to N"),
        say("use a finer output of the sensor if N matters"),
    )


def outliers(view: View) -> Finding | None:
    """Samples far from the median of their neighbours, or the heavy tails that they belong to."""
    return outlying(view.record, view.outliers, view.steps.size)


def outlying(record: Record, found: Outliers, size: int) -> Finding | None:
    """The finding about outliers of a record of which so many samples remain."""
    if found.heavy:
        why = say("more than {share} of all: another noise rather than single outliers", share=percent(MOST))
        if found.heavy <= MOST * size:
            why = say("and more than Gaussian noise has beyond {tail:.2g}: heavy tails rather than single outliers",
                      tail=TAIL * found.limit)  # fmt: skip
        samples = say_count(found.heavy, "{count} sample", "{count} samples")
        return Finding(
            "heavy tails",
            say("{samples} beyond {limit:.2g} standard deviations, {why}", samples=samples, limit=found.limit, why=why),
            say("the noise is not Gaussian, or its level changes quickly: the intervals are too narrow"),
            say("inspect the samples; none are excluded"),
        )
    if not found.at.size:
        return None
    cut, rate = record.cut, record.rate
    return Finding("outliers",
        found.words(record),
        say("each of them adds to curves and spectra at all short averaging times"),
        say("exclude them there, too ({option}), or choose a window without them ({choice})",
            option=spelled("--outliers mark", "prepare.mark_outliers"), choice=windowing()),
        (cut + float(found.at[0]) / rate, cut + float(found.at[-1] + 1) / rate),
    )  # fmt: skip
