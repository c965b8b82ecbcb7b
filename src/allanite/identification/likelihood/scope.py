"""For which frequencies a noise model holds, with which filter, and how well.

The terms first have to explain the whole spectrum. If they do not, they are read behind a low-pass filter, with and
without angle noise before it, and beside Gauss-Markov noise of a few samples: of those that explain the spectrum, the
one of the best score is used. If none does, the following is tried, in this order: resonances, with their skirts,
without and with a filter; a misfit of a few per cent of the power, which widens the intervals; a band of frequencies; a
larger misfit. The first that gives an adequate fit is used.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import chain

import numpy as np

from allanite.core.arrays import BoolArray
from allanite.identification.checks.goodness import goodness
from allanite.terms import TERMS, WHITE

from .band import HIDDEN, Portion, Tuned
from .model_selection import Found, fitted
from .resonances import excess
from .selection import Subset
from .spectrum import FEWEST
from .tuning import Tuning, left_open, rolls_off, tuning

MASKED = 0.75
"""Share of the bins that resonances may hide."""

FLOOR = 0.8
"""Share of the power of an octave that the white noise has where it is seen."""

ENOUGH, DECADES = 1000, 1.5
"""Coefficients, and decades of frequency, that a band must hold: a test of fewer has no power."""

PASSES = 0.05
"""p-value of an accepted band; its upper end is then halved, its lower end doubled."""

SMALL, LARGE = 0.03, 0.1
"""Misfits, RMS over cells of the spectrum as a share of the power, that are accepted before and after the bands."""

NEARLY = 8.0
"""Factor by which the highest frequency may be lowered before a small misfit is accepted instead."""

RATHER = 0.05
"""The lowest cut-off of a filter that has angle noise before it, cycles per sample."""

RETUNED, SETTLED = 3, 0.1
"""Times that a cut-off is tuned again beside Gauss-Markov noise, until that gains less than this in 2 L."""

WRONG = 0.5
"""Misfit of a cell beyond chance, as a share of the power, from which a model is not a description of it."""

LOUD = 3.0
"""Power that may be omitted, over that of the model."""

STOP = 0.003
"""Gain below which a filter leaves nothing to be read."""

REMOTE = 4.0
"""Subsets that lose more than this in L are not tried at other cut-offs."""


def scoped(found: Found, *, rival: bool, choice: str = "auto") -> Found:
    """The first way to read the spectrum in which the terms explain it; the plain one if there is none.

    Of all frequencies, or those that were asked for, no filter is assumed; of the latter resonances are left out.
    """
    if not explains(found):
        return next(filter(explains, WAYS[choice](found.base, rival)), found)
    if choice != "auto" or not rolls_off(found.base):
        return found
    return min((found, *filter(explains, _whole(found.base, rival))), key=lambda each: each.score)


def behind_filter(part: Portion) -> Found:
    """What is behind a filter, if the record shows one, whether it explains the spectrum or not."""
    return next(_behind(part, rival=False), None) or fitted(part, rival=False)


def explains(found: Found) -> bool:
    """Whether the terms explain what is read."""
    return goodness(found.seen, found.full.likelihood, found.full.theta, found.used).explained


def _candidates(whole: Portion, rival: bool) -> Iterator[Found]:
    """Ways to read the spectrum: all of it before a part of it, without a filter before behind one."""
    yield from _whole(whole, rival)
    masked: list[Portion] = []
    for candidate in _masked(whole, rival):
        if not any(candidate.part.excess is part.excess for part in masked):
            masked.append(candidate.base.but())
        yield candidate
    parts = [*reversed(masked), whole]
    for part in parts:
        yield from _bands(part, rival, NEARLY)
    yield from _approximately(parts[0], rival, SMALL)
    for part in parts:
        yield from _bands(part, rival)
    yield from _approximately(parts[0], rival, LARGE)


def _whole(part: Portion, rival: bool) -> Iterator[Found]:
    """All that is read, behind a filter or with Gauss-Markov noise of a few samples, the best score first."""
    angle = [i for i, symbol in enumerate(part.noise) if TERMS[symbol].edge]
    both = _tuned(part, rival, lowest=RATHER) if angle else ()
    through = (*_behind(part, rival), *(found for found in both if found.chosen.theta[angle].all()))
    quick = _quick(part, rival) if part.excess is None else ()
    yield from sorted((*through, *quick), key=lambda found: found.score)


def _quick(part: Portion, rival: bool) -> Iterator[Found]:
    """With Gauss-Markov noise as quick as the samples allow, where no filter explains what falls with frequency."""
    if rival:
        yield fitted(part, rival=rival, shortest=0.0)


def _masked(whole: Portion, rival: bool) -> Iterator[Found]:
    """Beside resonances, without the frequencies that they hide, then behind a filter too.

    Resonances are looked for above the floor of the terms; behind the filter that describes what falls beside them;
    and above a floor of any shape, then behind the filter that is found beside those.
    """
    part, best, seen = whole, behind_filter(whole).part, set[tuple[Portion | None, bool]]()
    for smooth, start in ((False, whole), (False, best), (True, whole), (False, None)):
        part = start or part
        looked = (part if part.filter else None, smooth)  # without a filter they are the same
        if looked in seen:
            continue
        seen.add(looked)
        loud, through = excess(part, smooth=smooth) or (None, None)
        if loud is None or (loud.hidden & part.used).sum() > MASKED * whole.used.size:
            continue
        masked = replace(whole.but(used=part.used & ~loud.hidden), excess=loud)
        rate = masked if through is None else masked.among(_rates(whole)).but(filter=through)
        found = fitted(rate, rival=rival)
        if not _quiet(found, masked.used):
            continue
        for candidate in (found, *_whole(masked, rival)):
            if candidate.part.filter is not None:
                part = whole.but(used=candidate.used | (loud.hidden & part.used), filter=candidate.part.filter)
            if shows_floor(candidate):
                yield candidate


def shows_floor(found: Found) -> bool:
    """Whether an octave at least shows the white noise of the model, if there is any, rather than what is added."""
    which = [i for i, symbol in enumerate(found.noise) if TERMS[symbol].slope == WHITE]
    likelihood, theta = found.chosen.likelihood, found.chosen.theta
    white = likelihood.S[:, which] @ theta[which]
    total, count = likelihood.expectation(theta), found.seen.count[found.used]
    octave = np.floor(np.log2(found.seen.first[found.used])).astype(int)
    share = np.bincount(octave, white * count) / np.maximum(np.bincount(octave, total * count), np.finfo(float).tiny)
    return not white.any() or bool((share[np.bincount(octave, count) >= ENOUGH] > FLOOR).any())


def _quiet(found: Found, used: BoolArray, *, bare: bool = False) -> bool:
    """Whether what is not read has less than half of the power beyond the model's: else the sensor was not at rest."""
    seen, part = found.seen, found.part
    m = found.expected_power * part.passed
    if bare:  # the angle noise, which a band does not see, excuses nothing above one that begins above zero
        angle = [i for i, symbol in enumerate(found.noise) if TERMS[symbol].edge]
        m = m - part.whole.S[:, angle] @ found.chosen.theta[angle] * part.passed
    excess = np.maximum(seen.power - m, 0) * seen.count
    return float(excess[~used].sum()) < LOUD * float(m @ seen.count)


def _behind(part: Portion, rival: bool) -> Iterator[Found]:
    """Behind a filter, which hides the angle noise."""
    rate = part.among(_rates(part))
    if rate.noise:
        yield from _tuned(rate, rival)


def _rates(part: Portion) -> tuple[str, ...]:
    """The terms without angle noise."""
    return tuple(symbol for symbol in part.noise if not TERMS[symbol].edge)


def _tuned(part: Portion, rival: bool, lowest: float = 0.0) -> Iterator[Found]:
    """Behind the filter that describes the record best, if it gains enough and its cut-off is not below `lowest`."""
    tuned = tuning(part)
    # what leaks into the stop band of a filter, or is added behind it, is no part of the model
    open_ = part.used & (tuned.filters[0].gain(part.seen) > STOP)
    if tuned.believed and not open_[part.used].all():
        part = part.but(used=open_)
        tuned = tuning(part)
    if not tuned.believed:
        return
    found = _through(part, tuned, rival)
    for _ in range(RETUNED):  # the cut-off was tuned without Gauss-Markov noise, which may have taken its place
        if found.search is None or found.markov is None:
            break
        again = _through(part, tuning(found.part.shaped(found.markov.constants)), rival)
        if again.score > found.score - SETTLED:
            break
        found = again
    if found.part.filter is not None and found.part.filter.cutoff > lowest:
        yield found


def _through(part: Portion, tuned: Tuning, rival: bool) -> Found:
    found = fitted(part.but(filter=tuned.filters[0]), rival=rival)
    return replace(found, elsewhere=partial(_elsewhere, others=tuned.likely[1:]))


def _elsewhere(found: Found, others: tuple[Tuned, ...]) -> list[Subset]:
    """Subsets at the other cut-offs, and with the other filters, that the likelihood leaves open."""
    part, chosen = found.shaped, found.chosen
    assert part.filter is not None  # noqa: S101 - it was tuned
    every = [*found.every, *([found.markov] if found.markov else [])]
    near = [s for s in every if s.value < chosen.value + REMOTE]
    return [
        Subset(likelihood, s.free, *likelihood.minimise(s.free, s.theta), s.constants)
        for through in (*left_open(part, part.filter), *others)
        for s in near
        for likelihood in [part.but(filter=through).known(s.constants)]
    ]


def _approximately(part: Portion, rival: bool, most: float) -> Iterator[Found]:
    """With a misfit in every cell, the smallest first."""
    for misfit in most / 2 ** np.arange(1.0, -0.1, -0.5):
        found = fitted(part.doubted(float(misfit)), rival=rival)
        if found.largest_misfit < WRONG:
            yield found


def _bands(part: Portion, rival: bool, most: float = math.inf) -> Iterator[Found]:
    """In a band of frequencies: the widest in which all terms together explain the spectrum, and what is left of it.

    A band that just passes the test holds at its ends what leaks in from beyond, less than the test sees but more than
    the standard errors: the ends are moved inwards by an octave.
    """
    top = float(part.seen.frequency(part.seen.first[part.used][-1]))
    whole = bool(part.used[-1])
    # bands of half-octave ends, Hz, the widest in octaves first
    seen = part.seen
    half, lowest = seen.rate / 2, seen.rate / (2 * seen.size)
    octaves = math.log2(seen.size)
    highs = half * 2.0 ** -np.arange(0.0, octaves, 0.5)
    lows = [0.0, *(lowest * 2.0 ** np.arange(2.0, octaves))]
    spans = [(float(low), float(high)) for low in lows for high in highs if 4 * low < high]
    for low, high in sorted(spans, key=lambda span: max(span[0], lowest) / span[1]):
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
            inside = part.but(used=final)
            shows_angle = part.seen.frequency(part.seen.first[final][-1]) >= HIDDEN * part.seen.rate / 2
            found = fitted(inside if shows_angle else inside.among(_rates(part) or part.noise), rival=rival)
            if _quiet(found, final, bare=low > 0):
                yield found


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


WAYS: dict[str, Callable[[Portion, bool], Iterator[Found]]] = {
    "auto": _candidates,
    "asked": lambda part, rival: chain(_quick(part, rival), _masked(part, rival)),
    "all": _quick,
}
"""Ways to read the spectrum, by the choice of frequencies: found, asked for, or all."""
