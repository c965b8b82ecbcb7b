"""Subsets of the terms and profiles of their likelihood; the distribution of a coefficient averaged over models."""

# Derivation: docs/derivations.md.

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.plain import Portable

from .likelihood import Likelihood

PENALTY = 4.0
"""What a term must gain in 2 L to be selected: about the 95 % point of chi-square with one degree of freedom."""


@dataclass(frozen=True, eq=False)
class Subset:
    """The likelihood's minimum with some of the terms free."""

    likelihood: Likelihood
    free: BoolArray
    theta: FloatArray
    value: float

    @cached_property
    def covariance(self) -> FloatArray:
        """Covariance of the free thetas, from their information; what that does not distinguish shares it."""
        information = self.information[np.ix_(self.free, self.free)]
        # where loose directions take all that a few bins tell, rounding leaves less than nothing
        size = np.outer(*[np.sqrt(np.abs(np.diag(information)))] * 2)
        return np.asarray(np.linalg.pinv(information / size, hermitian=True) / size)

    @cached_property
    def information(self) -> FloatArray:
        """Expected information of all thetas, shape (p, p)."""
        return self.likelihood.information(self.theta)

    def score(self, penalty: float | FloatArray) -> float:
        """2 L + the penalties of the terms."""
        return 2 * self.value + float((penalty * self.free).sum())


def subsets(likelihood: Likelihood) -> list[Subset]:
    """Every non-empty subset of the terms, fitted; the last one holds all of them."""
    p = likelihood.S.shape[1]
    masks = (np.array([bool(code >> i & 1) for i in range(p)]) for code in range(1, 2**p))
    return [Subset(likelihood, free, *likelihood.minimise(free)) for free in masks]


def select(fitted: list[Subset], penalty: float | FloatArray = PENALTY) -> Subset:
    """The subset with the least 2 L + penalty x (number of terms)."""
    return min(fitted, key=lambda subset: subset.score(penalty))


@dataclass(frozen=True, eq=False)
class ThetaProfile(Portable):
    """The likelihood of one theta, the other terms of a subset following it."""

    # `excess` is 2 (L - L at the subset's minimum).
    subset: Subset
    which: int

    @property
    def best(self) -> float:
        """Theta at the minimum."""
        return float(self.subset.theta[self.which])

    def lower(self, drop: float) -> float:
        """Where the excess is `drop` below the minimum; 0 if it is less at 0."""
        if drop < 1e-3:
            return self.best
        if self.best <= 0 or self.at(0.0, self.subset.theta)[0] <= drop:
            return 0.0
        return self._solve(drop, 0.0, max(self.best - self._width * math.sqrt(drop), 0.1 * self.best))

    def upper(self, drop: float) -> float:
        """Where the excess is `drop` above the minimum."""
        if drop < 1e-3:
            return self.best
        guess = self.best + self._width * math.sqrt(drop)
        high = guess
        while self.at(high, self.subset.theta)[0] < drop:
            high = self.best + 2 * (high - self.best)
        return self._solve(drop, high, min(guess, high))

    @cached_property
    def _width(self) -> float:
        """Standard error from the curvature: where to start looking."""
        return standard_error(self.subset, self.which)

    def at(self, value: float, start: FloatArray) -> tuple[float, FloatArray]:
        """The excess at theta[which] = value, infinite if nothing else makes noise; and where the other terms went."""
        theta, least = self.subset.likelihood.minimise(self.subset.free, start, (self.which, value))
        return 2 * (least - self.subset.value), theta

    def weighted(self, nodes: int = 32, prior: float = 1.0) -> tuple[list[FloatArray], FloatArray]:
        """All thetas along the profile, with weights of its likelihood times a prior."""
        # The nodes are evenly spaced in the coefficient from 0 to where nothing is left. The prior's density goes as
        # the coefficient to the power `prior`: 1 is flat in theta, 0 in the coefficient.
        roots = np.linspace(0.0, math.sqrt(self.upper(16.0)), nodes)
        start, thetas, excess = self.subset.theta, [], []
        for root in roots[::-1]:
            value, start = self.at(root**2, start)
            if value == math.inf:  # no other term makes noise
                break
            thetas.append(start)
            excess.append(value)
        density = roots**prior
        if prior < 1:  # what lies within half a step of 0
            density[0] = (roots[1] / 2) ** (prior + 1) / (prior + 1) / roots[1]
        weight = density[::-1][: len(excess)] * np.exp(-0.5 * (np.array(excess) - min(excess)))
        return thetas, weight / weight.sum()

    def _solve(self, drop: float, outside: float, guess: float) -> float:
        """Newton on the root of the excess, which is nearly straight in theta, kept within a bracket."""
        start, wanted, inside = self.subset.theta, math.sqrt(drop), self.best
        for _ in range(40):
            excess, start = self.at(guess, start)
            root = math.sqrt(max(excess, 0.0))
            if abs(root - wanted) < 1e-3 * wanted:
                break
            inside, outside = (guess, outside) if root < wanted else (inside, guess)
            slope = 2 * float(self.subset.likelihood.gradient(start)[self.which]) if excess < math.inf else 0.0
            step = guess + (wanted - root) * 2 * root / slope if slope else math.inf
            guess = step if min(inside, outside) < step < max(inside, outside) else (inside + outside) / 2
        return guess


def standard_error(subset: Subset, which: int) -> float:
    """Standard error of theta[which], from the expected information of the subset's terms."""
    return float(np.sqrt(abs(np.diag(subset.covariance)[int(subset.free[:which].sum())])))


def correlation(subset: Subset) -> FloatArray:
    """Correlation of the estimates of the free terms, shape (f, f): that of theta, and of its root."""
    size = np.sqrt(np.abs(np.diag(subset.covariance)))  # see `covariance`
    return np.asarray(np.clip(subset.covariance / np.outer(size, size), -1, 1))


AKAIKE = 2.0  # penalty of a term in 2 L
HEAVY_SHARE = 0.98  # share of all weight that the subsets have which are looked at: the heaviest
PROFILE_END = 16.0  # excess of 2 L at which a profile ends
STEP_GROWTH = 1.2  # ratio of successive steps along a profile; the first is half a standard error
MAX_STEPS = 200  # along a profile to either side, at most
LAW_POINTS = 1001  # number of values of the coefficient at which a law is tabulated
BEYOND_PROFILE = 9.0  # standard deviations: beyond the end of a profile


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


@dataclass(frozen=True, eq=False)
class Trace(Portable):
    """The profile of one subset: signed root of the excess of 2 L at values of the root of theta, rising."""

    subset: Subset
    root: FloatArray
    deviate: FloatArray

    def at(self, root: FloatArray) -> FloatArray:
        """Signed roots of the excess in between."""
        return np.interp(root, self.root, self.deviate, left=-BEYOND_PROFILE, right=BEYOND_PROFILE)


def traced(subset: Subset, which: int) -> Trace:
    """Walk along a profile to either side of its minimum, each step from where the other terms went before."""
    best = math.sqrt(float(subset.theta[which]))
    # where theta is a standard error greater, the other terms known
    known = float(subset.information[which, which])
    if known <= 0:  # loose directions take all that the lowest bins tell: as large as the whole power there
        likelihood = subset.likelihood
        known = float((likelihood.S[:, which] / likelihood.power).max()) ** 2
    error = 1 / math.sqrt(known)
    first = (math.hypot(best, math.sqrt(error)) - best) / 2
    sides, moving = [], subset.free.copy()
    moving[which] = False
    for sign in (-1.0, 1.0):
        at, step, theta, side = best, first, subset.theta, []
        for _ in range(MAX_STEPS):
            if at <= 0 and sign < 0:
                break
            at, step = max(at + sign * step, 0.0), step * STEP_GROWTH
            theta = theta.copy()
            theta[which] = at**2
            theta, least = subset.likelihood.moved(theta, moving)
            if least == math.inf:  # it lies outside
                theta, least = subset.likelihood.minimise(subset.free, theta, (which, at**2))
            excess = 2 * (least - subset.value)
            side.append((at, sign * min(math.sqrt(max(excess, 0.0)), BEYOND_PROFILE)))
            if excess > PROFILE_END:
                break
        sides.append(side)
    root, deviate = zip(*reversed(sides[0]), (best, 0.0), *sides[1], strict=True)
    return Trace(subset, np.array(root), np.array(deviate))


def traces(fitted: Sequence[Subset], which: int, penalty: FloatArray) -> list[Trace]:
    """Profiles of the subsets that hold a term and have weight under the penalties of the terms, shape (p,)."""
    having = [subset for subset in fitted if subset.free[which]]
    weight = _weights(having, penalty)
    order = np.argsort(-weight)
    heavy = np.zeros(len(having), dtype=bool)
    heavy[order[: np.searchsorted(np.cumsum(weight[order]), HEAVY_SHARE) + 1]] = True
    return [traced(subset, which) for subset, weighs in zip(having, heavy, strict=True) if weighs]


def _weights(fitted: Sequence[Subset], penalty: FloatArray) -> FloatArray:
    """Weights of subsets."""
    score = np.array([subset.score(penalty) for subset in fitted])
    weight = np.exp(-0.5 * (score - score.min(initial=math.inf)))
    return np.asarray(weight / weight.sum())


def law(along: Sequence[Trace], penalty: FloatArray) -> Law:
    """The law of a coefficient under the penalties of the terms, shape (p,)."""
    weight = _weights([trace.subset for trace in along], penalty)
    low, high = min(trace.root[0] for trace in along), max(trace.root[-1] for trace in along)
    root = np.linspace(low, high, LAW_POINTS)
    density = weight @ [np.exp(-0.5 * trace.at(root) ** 2) for trace in along]
    below = np.concatenate(([0.0], np.cumsum(density[1:] + density[:-1])))
    zero = weight @ [float(scipy.special.ndtr(trace.at(np.zeros(1))[0])) for trace in along]
    return Law(root, below / below[-1], float(zero))
