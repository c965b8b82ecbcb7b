"""The law of the cut-off: between which frequencies the power that reaches the samples is halved, over all models."""

# Derivation: docs/derivations.md.

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from allanite.core.arrays import FloatArray
from allanite.core.limits import quantile
from allanite.core.plain import Portable
from allanite.identification.likelihood.filters import FILTERS

from .components import COMPONENTS, Part
from .estimates import Answer
from .fitting import Fitted, fitted, place_of, refined_values, sizes_inside, values_of
from .frame import LOWEST_CUTOFF, starts_of
from .laws import Entry
from .refining import refined

HALF = 0.5  # power at the cut-off, over that at low frequencies: -3 dB, a definition

SHAPES = COMPONENTS["filter"].grain[0]
"""Logarithm by which the limits are widened, as far as states of the search are taken for one: filters that no row has
exactly are described by the nearest (`benchmarks/check.py`)."""

CLOSE = 0.005  # step in the logarithm of a cut-off at which the lowest one that a record admits is known
BROAD_SHAPE = 5.0  # quality of a resonance up to which it may describe the shape of a filter instead of vibration

SHAPE_RATIO = 16.0
"""Ratio of the cut-off and a frequency up to which power that differs may be due to the shape of the filter."""

CUTOFF_GRID = 2048  # frequencies up to half the sampling rate at which the cut-off of the samples is looked for


@dataclass(frozen=True, eq=False)
class CutoffLaw(Portable):
    """Limits of a cut-off, Hz; the upper one is infinite where models without a filter weigh enough."""

    weight: FloatArray  # shape (models,); of the models with a filter, of all
    # low, high, spread: shape (models,); logarithms of their cut-offs, cycles a sample, before and behind the
    # sampling in their order, and their error
    low: FloatArray
    high: FloatArray
    spread: FloatArray
    bare: Fitted | None  # the heaviest model without a filter
    rate: float  # sampling rate, Hz

    def __call__(self, level: float) -> tuple[float, float]:
        """Two-sided limits."""
        tail = (1 - level) / 2
        low = quantile_of(self.weight, self.low, self.spread, tail)
        high = quantile_of(self.weight, self.high, self.spread, 1 - tail)
        if math.isinf(high) and self.bare is not None:
            known = math.inf if math.isfinite(low) else halved(self.bare, LOWEST_CUTOFF / 2)
            low = min(low, math.log(min(known, lowest_cutoff(self.bare, level))))
        return self.rate * math.exp(low - SHAPES), self.rate * math.exp(high + SHAPES)


def cutoff_law(answer: Answer) -> CutoffLaw:
    """The law of the cut-off over the models of an average."""
    having = [e for e in answer.entries if e.f.state.filter is not None]
    low, high = np.log([cutoffs_of(e.f) for e in having]).reshape(-1, 2).T
    bare = next((e.f for e in answer.entries if e.f.state.filter is None), None)
    weight = np.array([e.weight for e in having])
    return CutoffLaw(weight, low, high, errors_in(having), bare, answer.scale.rate)


def errors_in(having: Sequence[Entry]) -> FloatArray:
    """Standard errors of the logarithms of the cut-offs of models with a filter."""
    return np.array([errors_of(e.f, part)[0] for e in having for part in e.f.state.of("filter")])


def cutoffs_of(f: Fitted) -> tuple[float, float]:
    """The lowest and the highest that the cut-off of a filter may be called; cycles a sample."""
    # That of its row before the sampling and behind it, and where the power of all that is fast falls to half: a filter
    # that no row has is described by one that other components correct.
    part = f.state.filter
    assert part is not None  # noqa: S101 - asked of models with a filter
    cutoff = part.shape[0]
    x = np.arange(1, CUTOFF_GRID + 1) / (2 * CUTOFF_GRID)
    several = (cutoff, _halved(x, FILTERS[part.label].gain(x, cutoff)), halved(f, cutoff / SHAPE_RATIO))
    return min(several), min(max(c for c in several if math.isfinite(c)), FILTERS[part.label].widest)


def halved(f: Fitted, lowest: float) -> float:
    """Where the power of all but drift and narrow peaks falls to half of its highest; infinity if it does not."""
    # From the frequency `lowest` on, cycles a sample: what is below, of whatever shape, is no filter's.
    frame = f.frame
    apart = np.zeros(f.theta.size, dtype=bool)
    apart[: len(frame.powers)] = frame.slow
    inside = [p for p in f.state if COMPONENTS[p.name].inside]
    apart[len(frame.powers) : sizes_inside(frame, f.state)] = [
        # whether it is drift; quick Gauss-Markov noise beside white noise is a filter's shape, too
        p.label != "GM" or 2 * math.pi * p.shape[0] * lowest > 1 for p in inside
    ]  # fmt: skip
    loud = [p.shape[1] > BROAD_SHAPE for p in f.state.of("resonance")]
    apart[apart.size - len(loud) :] = loud
    power = f.m - f.likelihood.S[:, apart] @ f.theta[apart]
    x = frame.centre / (2 * frame.size)
    near = x >= lowest
    return _halved(x[near], power[near] / max(power[near].max(initial=0.0), 1e-300)) if near.any() else math.inf


def _halved(x: FloatArray, gain: FloatArray) -> float:
    """The frequency beyond the highest gain from which less than half is left; infinity if there is none."""
    highest = int(gain.argmax())
    below = np.flatnonzero(gain[highest:] < HALF)
    if not below.size:
        return math.inf
    at = slice(highest + max(int(below[0]) - 1, 0), highest + int(below[0]) + 1)
    return float(np.interp(-HALF, -gain[at], x[at]))


def errors_of(f: Fitted, part: Part) -> FloatArray:
    """Standard errors of the logarithms of the shape of a part, everything else unknown."""
    at = int(np.count_nonzero(f.theta > 0)) + place_of(f.state, part)
    return np.sqrt(np.maximum(np.diag(f.covariance)[at : at + refined_values(part)], 0.0))


def quantile_of(w: FloatArray, centre: FloatArray, spread: FloatArray, p: float) -> float:
    """The point below which a mixture of normal laws has the weight p; infinity where it has less in all."""
    if w.sum() <= p:
        return math.inf
    spread = np.maximum(spread, 1e-9)
    x = np.linspace(float((centre - 5 * spread).min()), float((centre + 5 * spread).max()), 2001)
    return float(np.interp(p, w @ scipy.special.ndtr((x - centre[:, None]) / spread[:, None]), x))


def lowest_cutoff(bare: Fitted, level: float) -> float:
    """The lowest cut-off that a record without a filter admits: that of the rows which changes its value by least."""
    drop = quantile((1 + level) / 2) ** 2
    return min(_lowest_of(bare, row, drop) for row in FILTERS)


def _lowest_of(bare: Fitted, row: str, drop: float) -> float:
    """The same of one row: the value of the fit rises by `drop`; the highest cut-off of all rows if it always does."""

    def excess(cutoff: float) -> float:
        return _with_filter(bare, Part("filter", row, (cutoff,))).value - bare.value - drop

    # the longest window of one sample is no filter
    high = starts_of(row)[0] if FILTERS[row].whole else FILTERS[row].widest
    if excess(high) > 0:
        return max(other.widest for other in FILTERS.values())
    low = high
    while low > LOWEST_CUTOFF and excess(low) <= 0:
        high, low = low, low / 1.5
    while math.log(high / low) > CLOSE:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if excess(middle) > 0 else (low, middle)
    return high


def _with_filter(bare: Fitted, part: Part) -> Fitted:
    """A model behind a filter, with every term free but noise of the angle that it lacks: behind one, that is white."""
    free = bare.free.copy()
    free[: len(bare.frame.powers)] |= ~bare.frame.angle
    tried = fitted(bare.frame, bare.state.having(part), free, bare, bare.v)
    if not bare.v.size:
        return tried
    return refined(tried, 2, held=np.ones(values_of(tried.state).size, dtype=bool))
