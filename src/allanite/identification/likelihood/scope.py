"""Where a noise model holds: behind which filter, at which frequencies, and how well.

The terms are asked to explain the whole spectrum first. Where they do not, what is tried is, in this order: a low-pass
filter before the readings; leaving out resonances and unsteady lines; both; a misfit of a few per cent of the power,
which widens the limits; a band of frequencies; a larger misfit. The first that explains what it reads is taken.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray
from allanite.identification.checks.goodness import cell_of, goodness
from allanite.terms import TERMS

from .families import Found, fitted
from .humps import humps
from .portion import Portion, Tuned
from .selection import Subset
from .tuning import FALL, falls, left_open, octave_levels, tuning

MASKED = 0.25
"""Share of the bins that may be left out as humps."""

ENOUGH, DECADES = 1000, 1.5
"""Coefficients, and decades of frequency, that a band must hold: a test of fewer has no power."""

PASSES = 0.05
"""p value of a band that is taken; its upper end is then halved, its lower end doubled."""

SMALL, LARGE = 0.03, 0.1
"""Misfits, rms over cells of the spectrum as a share of the power, that are accepted before and after the bands."""

RISE = 1.5
"""Ratio of the highest level of the power to the lowest below it, by which a strong noise of the angle is seen."""

LOUD = 0.5
"""Power that may be left out, over that of the model."""

REMOTE = 4.0
"""Subsets that lose more than this in L are not tried at other cut-offs."""


def scoped(found: Found, *, rival: bool) -> Found:
    """The first way to read the spectrum in which the terms explain it; the plain one if there is none."""
    if explains(found):
        return found
    for candidate in _candidates(found, rival):
        if explains(candidate):
            return candidate
    return found


def explains(found: Found) -> bool:
    """Whether the model explains what is read."""
    return goodness(found.seen, found.chosen.likelihood, found.chosen.theta, found.used).explained


def _candidates(found: Found, rival: bool) -> Iterator[Found]:
    """Ways to read the spectrum, the one that leaves out least first."""
    whole = found.part
    best = found
    for behind in _behind(whole, rival):
        best = behind
        yield behind
    out = humps(best)
    masked = whole.but(used=whole.used & ~out)
    if out.any() and out.sum() <= MASKED * out.size and _quiet(best, ~out):
        best = fitted(masked, rival=rival)
        yield best
        for behind in _behind(masked, rival):
            best = behind
            yield behind
    yield from _approximately(best.part, rival, SMALL)
    yield from _behind_angle(masked, rival)
    yield from _bands(best.part, rival)
    yield from _approximately(best.part, rival, LARGE)


def _quiet(found: Found, used: BoolArray) -> bool:
    """Whether what is not read has less than half of the power beyond the model's: else the sensor was not at rest."""
    seen, part = found.seen, found.part
    m = part.whole.S @ found.chosen.theta * part.gain
    excess = np.maximum(seen.power - m, 0) * seen.count
    return float(excess[~used].sum()) < LOUD * float(m @ seen.count)


def _behind(part: Portion, rival: bool) -> Iterator[Found]:
    """Behind a filter, which hides the noise of the angle."""
    rate = part.among(tuple(symbol for symbol in part.noise if not TERMS[symbol].edge))
    if rate.noise and falls(part) > FALL:
        yield from _tuned(rate, rival)


def _behind_angle(part: Portion, rival: bool) -> Iterator[Found]:
    """Behind a filter, with a noise of the angle that is so strong that the power rises before it falls."""
    levels = octave_levels(part)
    rises = levels.max() > RISE * levels[: max(1, len(levels) // 2)].min()
    if any(TERMS[symbol].edge for symbol in part.noise) and (rises or falls(part) > 3 * FALL):
        yield from _tuned(part, rival)


def _tuned(part: Portion, rival: bool) -> Iterator[Found]:
    tuned = tuning(part)
    if tuned.believed:
        found = fitted(part.but(filter=tuned.filters[0]), rival=rival)
        yield replace(found, elsewhere=partial(_elsewhere, others=tuned.likely[1:]))


def _elsewhere(found: Found, others: tuple[Tuned, ...]) -> list[Subset]:
    """Subsets at the other cut-offs, and with the other filters, that the likelihood leaves open."""
    part = found.part
    assert part.filter is not None  # noqa: S101 - it was tuned
    free = [s.free for s in found.every if s.value < found.plain.value + REMOTE]
    parts = [part.but(filter=one).likelihood for one in (*left_open(part, part.filter), *others)]
    return [Subset(one, mask, *one.minimise(mask)) for one in parts for mask in free]


def _approximately(part: Portion, rival: bool, most: float) -> Iterator[Found]:
    """With less trust in cells of many coefficients, as if each had a misfit of its own; the least that is needed."""
    cell = cell_of(part.seen, part.used)
    nu = np.bincount(cell[part.used], part.seen.count[part.used])[cell]
    for misfit in most / 2 ** np.arange(1.0, -0.1, -0.5):
        trust = 1 / (1 + misfit**2 * nu / 2)
        yield fitted(part.but(filter=part.filter, trust=trust), rival=rival)


def _bands(part: Portion, rival: bool) -> Iterator[Found]:
    seen = part.seen
    half = seen.rate / 2
    lowest = seen.rate / (2 * seen.size)
    top = float(seen.frequency(seen.first[part.used][-1]))
    f = seen.frequency(seen.first)
    def inside(low, high):
        return part.used & (f >= low) & (seen.frequency(seen.first + seen.count - 1) <= high)
    def enough(used):
        g = f[used]
        return used.sum() >= 24 and seen.count[used].sum() >= ENOUGH and np.log10(g[-1] / g[0]) >= DECADES
    spans = []
    highs = [half] + list(half * 2.0 ** -np.arange(0.5, 16, 0.5))
    lows = [0.0] + list(lowest * 2.0 ** np.arange(2, 16))
    for low in lows:
        for high in highs:
            if low < high:
                spans.append((low, high))
    spans.sort(key=lambda s: -np.log(s[1] / max(s[0], lowest)))
    for low, high in spans:
        final = (2 * low, high / 2 if high < half else high)
        if final[0] >= final[1] or not enough(inside(*final)):
            continue
        used = inside(low, high)
        p2 = part.but(used=used, filter=part.filter)
        lik = p2.likelihood
        theta, _ = lik.minimise(np.ones(lik.S.shape[1], dtype=bool))
        if goodness(seen, lik, theta, used).p >= PASSES:
            yield fitted(part.but(used=inside(*final), filter=part.filter), rival=rival)
