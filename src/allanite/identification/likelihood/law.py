"""The distribution of one coefficient, averaged over the models consistent with the record.

A term that was not selected need not be zero, and a selected one is not certain. Each subset of the terms that contains
the coefficient c has a profile likelihood, 2 L_s(c) with the other terms optimized; the distribution of c is

    p(c) ~ sum_s exp(-(2 L_s(c) + sum of the penalties of the other terms of s) / 2),   c >= 0,

flat in the coefficient. A penalty of 2 for each term is that of H. Akaike (1974, eq. 8), whose weights exp(-AIC / 2) K.
P. Burnham and D. R. Anderson (2002, section 2.9) average over; it gives intervals that remain valid if a weak term is
hidden.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.plain import Portable

from .selection import Subset

AKAIKE = 2.0
"""Penalty of a term in 2 L."""

HELD = 0.98
"""Share of all weight that the subsets have which are looked at: the heaviest."""

REACH = 16.0
"""Excess of 2 L at which a profile ends."""

GROWTH = 1.2
"""Ratio of successive steps along a profile; the first is half a standard error."""

STEPS = 200
"""Along a profile to either side, at most."""

POINTS = 1001
"""Number of values of the coefficient at which a law is tabulated."""

FAR = 9.0
"""Standard deviations: beyond the end of a profile."""


@dataclass(frozen=True, eq=False)
class Law(Portable):
    """The law of the root of a theta."""

    # root, below: shape (points,); values, and the probability of less
    root: FloatArray
    below: FloatArray
    zero: float  # confidence, one-sided, with which the likelihood leaves zero: that of zero or less

    def quantile(self, p: float) -> float:
        """The value below which the root lies with probability p."""
        return float(np.interp(p, self.below, self.root))

    def limits(self, level: float) -> tuple[float, float]:
        """Two-sided limits; the lower one is 0 if the likelihood does not exclude it."""
        tail = (1 - level) / 2
        return 0.0 if self.zero >= tail else self.quantile(tail), self.quantile(1 - tail)

    @property
    def spread(self) -> float:
        """Standard deviation."""
        middle, weight = (self.root[1:] + self.root[:-1]) / 2, np.diff(self.below)
        return math.sqrt(float(weight @ (middle - weight @ middle) ** 2))


@dataclass(frozen=True, eq=False)
class Trace(Portable):
    """The profile of one subset: signed root of the excess of 2 L at values of the root of theta, rising."""

    subset: Subset
    root: FloatArray
    deviate: FloatArray

    def at(self, root: FloatArray) -> FloatArray:
        """Signed roots of the excess in between."""
        return np.interp(root, self.root, self.deviate, left=-FAR, right=FAR)


def traced(subset: Subset, which: int) -> Trace:
    """Walk along a profile to either side of its minimum, each step from where the other terms went before."""
    best = math.sqrt(float(subset.theta[which]))
    # where theta is a standard error greater, the other terms known
    known = float(subset.likelihood.information(subset.theta)[which, which])
    if known <= 0:  # loose directions take all that the lowest bins tell: as large as the whole power there
        likelihood = subset.likelihood
        known = float((likelihood.S[:, which] / likelihood.power).max()) ** 2
    error = 1 / math.sqrt(known)
    first = (math.hypot(best, math.sqrt(error)) - best) / 2
    sides = []
    for sign in (-1.0, 1.0):
        at, step, theta, side = best, first, subset.theta, []
        for _ in range(STEPS):
            if at <= 0 and sign < 0:
                break
            at, step = max(at + sign * step, 0.0), step * GROWTH
            theta, least = subset.likelihood.minimise(subset.free, theta, (which, at**2))
            excess = 2 * (least - subset.value)
            side.append((at, sign * min(math.sqrt(max(excess, 0.0)), FAR)))
            if excess > REACH:
                break
        sides.append(side)
    root, deviate = zip(*reversed(sides[0]), (best, 0.0), *sides[1], strict=True)
    return Trace(subset, np.array(root), np.array(deviate))


def traces(fitted: Sequence[Subset], which: int, penalties: Iterable[FloatArray]) -> list[Trace]:
    """Profiles of the subsets that hold a term and have weight under any of the penalties."""
    having = [subset for subset in fitted if subset.free[which]]
    heavy = np.zeros(len(having), dtype=bool)
    for penalty in penalties:
        weight = _weights(having, penalty)
        order = np.argsort(-weight)
        heavy[order[: np.searchsorted(np.cumsum(weight[order]), HELD) + 1]] = True
    return [traced(subset, which) for subset, there in zip(having, heavy, strict=True) if there]


def _weights(fitted: Sequence[Subset], penalty: FloatArray) -> FloatArray:
    """Weights of subsets; time constants and cut-offs that were tried share the weight of their set of terms."""
    kinds = [(subset.free.tobytes(), len(subset.constants)) for subset in fitted]
    score = np.array([subset.score(penalty) for subset in fitted])
    share = [subset.prior / kinds.count(kind) for subset, kind in zip(fitted, kinds, strict=True)]
    weight = np.exp(-0.5 * (score - score.min(initial=math.inf))) * share
    return np.asarray(weight / weight.sum())


def law(along: Sequence[Trace], penalty: FloatArray) -> Law:
    """The law of a coefficient under the penalties of the terms, shape (p,)."""
    from scipy.special import ndtr

    weight = _weights([trace.subset for trace in along], penalty)
    low, high = min(trace.root[0] for trace in along), max(trace.root[-1] for trace in along)
    root = np.linspace(low, high, POINTS)
    density = weight @ [np.exp(-0.5 * trace.at(root) ** 2) for trace in along]
    below = np.concatenate(([0.0], np.cumsum(density[1:] + density[:-1])))
    zero = weight @ [float(ndtr(trace.at(np.zeros(1))[0])) for trace in along]
    return Law(root, below / below[-1], float(zero))


@dataclass(frozen=True, eq=False)
class RampLimits:
    """Limits of a signed ramp, in SI, whose law is a mixture of normal laws."""

    centre: FloatArray
    spread: FloatArray
    weight: FloatArray

    def __call__(self, level: float) -> tuple[float, float]:
        """Two-sided limits."""
        return self.quantile((1 - level) / 2), self.quantile((1 + level) / 2)

    def quantile(self, p: float) -> float:
        """The value below which the ramp lies with probability p, by bisection."""
        from scipy.special import ndtr

        low, high = float((self.centre - 40 * self.spread).min()), float((self.centre + 40 * self.spread).max())
        for _ in range(60):
            middle = (low + high) / 2
            below = self.weight @ ndtr((middle - self.centre) / self.spread) < p
            low, high = (middle, high) if below else (low, middle)
        return (low + high) / 2

    def upper(self, level: float) -> float:
        """One-sided limit of the size."""
        return max(abs(limit) for limit in self(2 * level - 1))
