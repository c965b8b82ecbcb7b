"""A noise model of the form of a target that lies above the noise that was identified, and above its upper limits.

White noise N' wider than N needs a slow term of the size

    K^2 = max over tau of 3 (A(tau) - N'^2 / tau) / tau

to cover the Allan variance A on a span; of N and flicker B at most sqrt(3) (0.664 B)^2 / (2 sqrt(N'^2 - N^2)) on any
span, by the inequality of the means. A larger N' needs a smaller K. Of these models, and of those with a Gauss-Markov
process in place of the random walk where the target has one, that is taken whose predicted errors after a time without
aid, from ten times the beginning of the span to its end, exceed those of the best filter least. Where the span was not
asked for, a random walk is fitted to the first two decades of it only: it is not tight over more, errs on the safe side
at longer times, and would cost much at short ones.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import reduce
from operator import add

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.model import Model, Term
from allanite.core.units import Signal
from allanite.phrases.phrase import say
from allanite.statistics import expected

from .choice import COVER
from .content import Axis
from .stated_noise import AxisNoise, Outages, largest, unfielded
from .target import Target

WIDEST = 8.0  # the largest N' over N that is tried
WIDENINGS = 40  # white noises that are tried
LEAST = 1e-6  # share of the variance that the slow term has at least: no file without one

SETTLED = 10.0
"""The shortest time without aid whose cost counts, over the shortest averaging time: before, white noise dominates."""

TIGHT = 100.0
"""The longest time whose cost counts for a random walk, over the shortest averaging time, if no span was asked for."""

TIMES = 4  # correlation times that are tried in a decade, and times without aid


def covered(target: Target, axes: Sequence[Axis], groups: Sequence[Sequence[AxisNoise]], *, asked: bool) -> list[Axis]:
    """The axes, each with the model that covers the noises of its group; `asked`: the span was asked for."""
    fits = {id(n.axis): fit for group in groups for fit in (_fit(target, group, asked=asked),) for n in group}
    own = ((axis, fits.get(id(axis), axis.fit)) for axis in axes)
    return [replace(axis, fit=replace(fit, name=axis.fit.name, lines=axis.fit.lines)) for axis, fit in own]


def _fit(target: Target, noises: Sequence[AxisNoise], *, asked: bool) -> Fit:
    model, (low, high) = covering(target, noises, asked=asked), noises[0].tau[[0, -1]].tolist()
    units = [(term, term.signal.sheet[term.row.power]) for term in unfielded(target, noises)]
    what = ", ".join(f"{term.symbol} {term.to(unit):.3g} {unit}" for term, unit in units)
    note = say("covers {what} from {low:.4g} to {high:.4g} s", what=what or say("the noise"), low=low, high=high)
    estimates = (Estimate(t.symbol, t.signal, t.value, None, "reported", None, COVER, shape=t.shape, reason=note)
                 for t in model)  # fmt: skip
    return Fit(tuple(estimates), COVER, model.signal, model)


def covering(target: Target, noises: Sequence[AxisNoise], *, asked: bool) -> Model:
    """The model of the target's form that covers the noises at the least cost."""
    tau = noises[0].tau
    allan = np.max([noise.upper for noise in noises], axis=0)
    times = np.geomspace(tau[0], tau[-1], max(2, round(TIMES * np.log10(tau[-1] / tau[0])) + 1))
    outages, last = Outages(tuple(times.tolist())), tau[-1] if asked or target.markov else TIGHT * tau[0]
    late = (times >= 0.999 * min(SETTLED * tau[0], tau[-1])) & (times <= 1.001 * max(last, SETTLED * tau[0]))
    truths = [outages.of(noise.steady) for noise in noises]
    best = np.max([cov.errors(outages.weights(cov)) for cov in truths], axis=0)
    signal = noises[0].axis.fit.signal
    kept = _kept(target, noises)
    narrow = max((t.value for n in noises for t in n.model if t.symbol == "N"), default=np.sqrt(allan[0] * tau[0]))
    white, whites = Term("N", 1.0, signal), np.geomspace(narrow, WIDEST * narrow, WIDENINGS)
    rest = allan - sum((expected(term, "oadev", tau) for term in kept), np.zeros(tau.shape))
    uncovered = rest - np.multiply.outer(whites**2, expected(white, "oadev", tau))
    fixed = reduce(add, (outages.of(Model(term)) for term in kept), outages.of(Model(white)) * whites**2)
    candidates: list[tuple[float, Model]] = []
    for slow in _slow(target, signal, tau):
        slow_allan = expected(slow, "oadev", tau)
        power = np.maximum(np.max(uncovered / slow_allan, axis=1), LEAST * np.min(allan / slow_allan))
        cov = fixed + outages.of(Model(slow)) * power
        weights = outages.weights(cov)
        predicted = cov.errors(weights)
        # a curve that lies above does not quite suffice: neither may the errors exceed what is predicted
        wider = np.max([np.max(truth.errors(weights) / predicted, axis=1) for truth in truths], axis=0).clip(min=1.0)
        cost = wider * np.max((predicted / best)[:, late], axis=1)
        i = int(cost.argmin())
        sizes = np.sqrt(wider[i] * np.array([whites[i] ** 2, power[i], *(term.value**2 for term in kept)])).tolist()
        terms = [replace(term, value=value) for term, value in zip((white, slow, *kept), sizes, strict=True)]
        candidates.append((float(cost[i]), Model(tuple(terms))))
    return min(candidates, key=lambda pair: pair[0])[1]


def _kept(target: Target, noises: Sequence[AxisNoise]) -> tuple[Term, ...]:
    """Terms beside N and K for which the target has fields, the largest of the axes."""
    named = {f.term for f in target.fields if f.needed is False and f.term}
    return largest(term for noise in noises for term in noise.model if term.symbol in named)


def _slow(target: Target, signal: Signal, tau: FloatArray) -> Iterator[Term]:
    """The slow terms that are tried: a random walk, and Gauss-Markov processes if the target has them."""
    yield Term("K", 1.0, signal)
    if target.markov:
        for time in np.geomspace(tau[0], 10 * tau[-1], round(TIMES * np.log10(10 * tau[-1] / tau[0])) + 1):
            yield Term("GM", 1.0, signal, (float(time),))
