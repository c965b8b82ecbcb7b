"""Bursts: short stretches in which the fast noise is much stronger, as by knocks, radio, or a supply that switches."""

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import scipy

from allanite.core.arrays import BoolArray, FloatArray, stretches
from allanite.core.validity import Finding
from allanite.phrases.phrase import percent, say

from .view import EIGHT, View, containing

SPANS = (EIGHT, 32, 128)  # samples of a block whose power is compared with that of the others
FEWEST_BLOCKS = 100
TAIL = 0.01  # probability that noise of one level shows a block that is called loud
MANY = 6.0  # standard deviations of their number by which there are more loud blocks than by chance
CLUSTERED = 2.0  # times as often as by chance that loud blocks follow each other in bursts
FEWEST_BURSTS = 5  # separate stretches; fewer are changes of the level, or motion
LONGEST = 1 / 32  # share of the record up to which a stretch is a burst
USUAL = 0.4  # share of the samples up to which the stronger noise is that of bursts
MATTERS = 0.1  # relative change of the fast noise by the bursts above which they are reported
DITHERED = 0.6  # fast noise over the step of rounding below which the power of rounded noise has another law
SINGLE = 8  # samples around an outlier without another one: it is no burst


def bursts(view: View) -> Finding | None:
    """Bursts, their share of the samples, and what remains of N without them."""
    if not view.fast or view.rounding.noise < DITHERED:
        return None
    known = [each for each in map(_loud, _powers(view), SPANS) if each is not None]
    if not known:
        return None
    loud, excess, span = max(known, key=lambda each: each[1] * math.sqrt(each[2]))
    runs = stretches(loud)
    share = float(loud.mean()) - TAIL
    if excess < MATTERS or len(runs) < FEWEST_BURSTS or share > USUAL:
        return None
    if np.diff(runs, axis=1).max() > max(2, LONGEST * loud.size):
        return None
    return Finding("bursts",
        say("bursts of stronger noise, about {length:.2g} s long, in {share} of the samples",
            length=float(np.diff(runs, axis=1).mean()) * span / view.rate, share=percent(share)),
        say("N is that of all samples: without the bursts about {factor:.2g} times as large", factor=1 / (1 + excess)),
        say("look for knocks, radio or a supply that switches"),
        (view.seconds(float(runs[0, 0]) * span), view.seconds(float(runs[-1, 1]) * span)),
    )  # fmt: skip


def _powers(view: View) -> Iterator[FloatArray]:
    """Mean squares of the second differences, without those of single outliers, in blocks of each length."""
    at = view.outlying
    apart = np.diff(at, prepend=-SINGLE, append=view.steps.size + SINGLE)
    single = at[(apart[:-1] >= SINGLE) & (apart[1:] >= SINGLE)]
    power = (view.sweep if single.size == at.size else view.swept(containing(single))).eights / EIGHT
    for length, span in pairwise((EIGHT, *SPANS)):
        many = span // length
        power = power[: power.size // many * many].reshape(-1, many) @ np.full(many, 1 / many)
        yield power


def _loud(power: FloatArray, span: int) -> tuple[BoolArray, float, int] | None:
    """The loud blocks, and what they add to the fast noise of the others, relative to it; None without bursts."""
    count = power.size
    if count < FEWEST_BLOCKS:
        return None
    # sorted at once, which is faster than to look for two quantiles
    low, middle = np.interp(np.array((0.25, 0.5)) * (count - 1), np.arange(count), np.sort(power)).tolist()
    if not 0 < low < middle:
        return None
    mean, limit = _law(float(middle / low))
    loud = np.asarray(power > limit * middle)
    share, chance = float(loud.mean()), count * TAIL
    # heavy tails make loud blocks as well, but not one after the other
    together = float(np.mean(loud[1:] & loud[:-1])) > CLUSTERED * share**2
    if loud.sum() < chance + MANY * math.sqrt(chance) or not together:
        return None
    return loud, math.sqrt(max(float(power.mean() / (mean * middle)), 1.0)) - 1, span


def _law(ratio: float) -> tuple[float, float]:
    """Mean of the power of blocks of one level, and the limit of loud ones, over the median."""
    # a Gamma law, whose shape the ratio of the median and the lower quartile tells: bursts change neither much
    shapes = np.geomspace(0.2, 2000, 300)
    ratios = scipy.special.gammaincinv(shapes, 0.5) / scipy.special.gammaincinv(shapes, 0.25)
    shape = float(np.exp(np.interp(-math.log(ratio), -np.log(ratios), np.log(shapes))))
    median = float(scipy.special.gammaincinv(shape, 0.5))
    return shape / median, float(scipy.special.gammaincinv(shape, 1 - TAIL)) / median
