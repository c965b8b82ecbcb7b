"""For which frequencies a noise model holds, with which filter, and how well.

The terms first have to explain the whole spectrum. If they do not, the following is tried, in this order: a low-pass
filter; Gauss-Markov noise of a few samples; a low-pass filter behind strong angle noise; excluding resonances and
unsteady lines; both; a misfit of a few per cent of the power, which widens the intervals; a band of frequencies; a
larger misfit. The first that gives an adequate fit is used.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import chain

import numpy as np

from allanite.core.arrays import BoolArray
from allanite.core.units import Signal
from allanite.identification.checks.goodness import goodness
from allanite.terms import TERMS

from .described import expected_power, largest_misfit
from .families import Found, fitted
from .humps import humps
from .portion import Portion, Tuned
from .selection import Subset
from .spectrum import FEWEST
from .tuning import FALL, falls, left_open, octave_levels, tuning
from .warmup import WarmUp, without_warm_up

MASKED = 0.25
"""Share of the bins that may be omitted as humps."""

LOOKS = 4
"""Fits without the humps, whose model shows how far their skirts reach."""

ENOUGH, DECADES = 1000, 1.5
"""Coefficients, and decades of frequency, that a band must hold: a test of fewer has no power."""

PASSES = 0.05
"""p-value of an accepted band; its upper end is then halved, its lower end doubled."""

SMALL, LARGE = 0.03, 0.1
"""Misfits, RMS over cells of the spectrum as a share of the power, that are accepted before and after the bands."""

NEARLY = 8.0
"""Factor by which the highest frequency may be lowered before a small misfit is accepted instead."""

RISE = 1.5
"""Ratio of the highest level of the power to the lowest below it, by which a strong angle noise is seen."""

HIGH = 3.0
"""Height of a hump, over the model, from which a band below it is read instead of both sides."""

WRONG = 0.5
"""Misfit of a cell beyond chance, as a share of the power, from which a model is not a description of it."""

LOUD = 3.0
"""Power that may be omitted, over that of the model."""

STOP = 0.003
"""Gain below which a filter leaves nothing to be read."""

REMOTE = 4.0
"""Subsets that lose more than this in L are not tried at other cut-offs."""


def scoped(found: Found, *, rival: bool, free: bool = True) -> Found:
    """The first way to read the spectrum in which the terms explain it; the plain one if there is none.

    Where what is read is not free, nothing of it is omitted, and no filter is assumed.
    """
    if explains(found):
        return found
    for candidate in _candidates(found, rival) if free else _quick(found.base, rival):
        if explains(candidate):
            return candidate
    return found


def steady(found: Found, signal: Signal, *, rival: bool, free: bool) -> tuple[WarmUp | None, Found]:
    """What explains the spectrum beside a warm-up, if there is one, and that; `free` to choose what is read."""
    first = scoped(found, rival=rival, free=free)
    warm, best = without_warm_up(first, signal)
    if warm or not free or (first.used[0] and explains(first)):
        return warm, best
    warm, best = without_warm_up(found, signal)
    second = scoped(best, rival=rival) if warm else first
    return (warm, second) if warm and second.used[0] and explains(second) else (None, first)


def explains(found: Found) -> bool:
    """Whether the terms explain what is read."""
    return goodness(found.seen, found.full.likelihood, found.full.theta, found.used).explained


def _candidates(found: Found, rival: bool) -> Iterator[Found]:
    """Ways to read the spectrum, the one that omits least first."""
    whole, best = found.base, found
    for best in chain(_behind(whole, rival), _quick(whole, rival), _behind_angle(whole, rival)):
        yield best
    for source in (found, best):
        for best in _masked(source, whole, rival):
            yield best
    last = best.base
    yield from _bands(last, rival, NEARLY)
    yield from _approximately(last, rival, SMALL)
    yield from _bands(last, rival)
    yield from _approximately(last, rival, LARGE)


def _masked(source: Found, whole: Portion, rival: bool) -> Iterator[Found]:
    """Without the humps of a fit, then behind a filter too; a high one, or one at the top, ends a band instead."""
    out = humps(source) & whole.used
    for _ in range(LOOKS):
        masked = whole.but(used=whole.used & ~out)
        if not 0 < out.sum() <= MASKED * out.size:
            return
        found = fitted(masked, rival=rival)
        further = humps(found) & whole.used
        if not (further & ~out).any():
            break
        out |= further
    if not _quiet(found, masked.used):
        return
    if out[-1] or _high(found, out) > HIGH:
        # the skirts of a high one reach far
        yield from _bands(masked, rival, NEARLY)
        return
    yield found
    yield from _behind(masked, rival)
    yield from _behind_angle(masked, rival)


def _high(found: Found, out: BoolArray) -> float:
    """The highest power that is omitted, over that of the model."""
    return float((found.seen.power / (expected_power(found) * found.part.gain))[out].max())


def _quiet(found: Found, used: BoolArray, *, bare: bool = False) -> bool:
    """Whether what is not read has less than half of the power beyond the model's: else the sensor was not at rest."""
    seen, part = found.seen, found.part
    m = expected_power(found) * part.gain
    if bare:  # the angle noise, which a band does not see, excuses nothing above one that begins above zero
        angle = [i for i, symbol in enumerate(found.noise) if TERMS[symbol].edge]
        m = m - part.whole.S[:, angle] @ found.chosen.theta[angle] * part.gain
    excess = np.maximum(seen.power - m, 0) * seen.count
    return float(excess[~used].sum()) < LOUD * float(m @ seen.count)


def _behind(part: Portion, rival: bool) -> Iterator[Found]:
    """Behind a filter, which hides the angle noise."""
    rate = part.among(tuple(symbol for symbol in part.noise if not TERMS[symbol].edge))
    if rate.noise and falls(part) > FALL:
        yield from _tuned(rate, rival)


def _quick(part: Portion, rival: bool) -> Iterator[Found]:
    """With Gauss-Markov noise as quick as the samples allow, where no filter explains what falls with frequency."""
    if rival:
        yield fitted(part, rival=rival, shortest=0.0)


def _behind_angle(part: Portion, rival: bool) -> Iterator[Found]:
    """Behind a filter, with angle noise that is so strong that the power rises before it falls."""
    levels = octave_levels(part)
    rises = levels.max() > RISE * levels[: max(1, len(levels) // 2)].min()
    if any(TERMS[symbol].edge for symbol in part.noise) and (rises or falls(part) > 3 * FALL):
        yield from _tuned(part, rival)


def _tuned(part: Portion, rival: bool) -> Iterator[Found]:
    tuned = tuning(part)
    # what leaks into the stop band of a filter, or is added behind it, is no part of the model
    open_ = part.used & (tuned.filters[0].gain(part.seen) > STOP)
    if tuned.believed and not open_[part.used].all():
        part = part.but(used=open_)
        tuned = tuning(part)
    if tuned.believed:
        found = fitted(part.but(filter=tuned.filters[0]), rival=rival)
        yield replace(found, elsewhere=partial(_elsewhere, others=tuned.likely[1:]))


def _elsewhere(found: Found, others: tuple[Tuned, ...]) -> list[Subset]:
    """Subsets at the other cut-offs, and with the other filters, that the likelihood leaves open."""
    part = found.part
    assert part.filter is not None  # noqa: S101 - it was tuned
    near = [s for s in found.every if s.value < found.plain.value + REMOTE]
    parts = [part.but(filter=one).likelihood for one in (*left_open(part, part.filter), *others)]
    return [Subset(one, s.free, *one.minimise(s.free, s.theta)) for one in parts for s in near]


def _approximately(part: Portion, rival: bool, most: float) -> Iterator[Found]:
    """With a misfit in every cell, the smallest first."""
    for misfit in most / 2 ** np.arange(1.0, -0.1, -0.5):
        found = fitted(part.doubted(float(misfit)), rival=rival)
        if largest_misfit(found) < WRONG:
            yield found


def _bands(part: Portion, rival: bool, most: float = math.inf) -> Iterator[Found]:
    """In a band of frequencies: the widest in which all terms together explain the spectrum, and what is left of it.

    A band that just passes the test holds at its ends what leaks in from beyond, less than the test sees but more than
    the standard errors: the ends are moved inwards by an octave.
    """
    top = float(part.seen.frequency(part.seen.first[part.used][-1]))
    whole = bool(part.used[-1])
    for low, high in _spans(part):
        if most < math.inf and (low > 0 or high < top / most):
            continue
        used = _inside(part, low, high)
        if not used.any():
            continue
        reach = float(part.seen.frequency(part.seen.first[used][-1]))
        final = _inside(part, 2 * low, high if whole and high >= part.seen.rate / 2 else reach / 2)
        if not _enough(part, final):
            continue
        likelihood = part.but(used=used).likelihood
        theta, _ = likelihood.minimise(np.ones(likelihood.S.shape[1], dtype=bool))
        if goodness(part.seen, likelihood, theta, used).p >= PASSES:
            # the angle noise, and the foot of what is above, may lie just below what a selection sees
            angle = tuple(symbol for symbol in part.noise if TERMS[symbol].edge)
            found = fitted(replace(part.but(used=final), kept=angle), rival=rival)
            if _quiet(found, final, bare=low > 0):
                yield found


def _spans(part: Portion) -> list[tuple[float, float]]:
    """Bands of half-octave ends, Hz, the widest in octaves first."""
    half, lowest = part.seen.rate / 2, part.seen.rate / (2 * part.seen.size)
    octaves = math.log2(part.seen.size)
    highs = half * 2.0 ** -np.arange(0.0, octaves, 0.5)
    lows = [0.0, *(lowest * 2.0 ** np.arange(2.0, octaves))]
    spans = [(float(low), float(high)) for low in lows for high in highs if 4 * low < high]
    return sorted(spans, key=lambda span: max(span[0], lowest) / span[1])


def _inside(part: Portion, low: float, high: float) -> BoolArray:
    seen = part.seen
    above, below = seen.frequency(seen.first) >= low, seen.frequency(seen.first + seen.count - 1) <= high
    return np.asarray(part.used & above & below)


def _enough(part: Portion, used: BoolArray) -> bool:
    """Whether a band holds so much that its test has power."""
    if used.sum() < FEWEST or part.seen.count[used].sum() < ENOUGH:
        return False
    first = part.seen.first[used]
    return bool(first[-1] >= first[0] * 10**DECADES)
