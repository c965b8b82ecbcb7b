"""Which terms are there, and how far each could be off: subsets and profiles of the likelihood."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.limits import quantile
from allanite.core.plain import Portable

from .likelihood import Likelihood

PENALTY = 4.0
"""What a term must gain in 2 L to be selected: about the 95 % point of chi-square with one degree of freedom."""

DOUBT = 2.0
"""What any term that gains it in 2 L may do: widen the limits of the others."""


@dataclass(frozen=True, eq=False)
class Subset:
    """The likelihood's minimum with some of the terms free.

    `constants` are the time constants, in samples, of the Gauss-Markov terms among them.
    """

    likelihood: Likelihood
    free: BoolArray
    theta: FloatArray
    value: float
    constants: tuple[float, ...] = ()

    @property
    def aic(self) -> float:
        """Akaike's criterion: 2 L and two for each number that was fitted."""
        return 2 * self.value + 2 * (int((self.theta > 0).sum()) + len(self.constants))

    @cached_property
    def variances(self) -> FloatArray:
        """Of the free thetas, shape (free terms,)."""
        return _variances(self.likelihood, self.theta, self.free)

    def score(self, penalty: float | FloatArray) -> float:
        """2 L + the penalties of the terms."""
        return 2 * self.value + float((penalty * self.free).sum())


def subsets(
    likelihood: Likelihood,
    *,
    must: BoolArray | None = None,
    may: BoolArray | None = None,
    constants: tuple[float, ...] = (),
) -> list[Subset]:
    """Every non-empty subset of the terms, fitted, that holds all that it `must` and no other than it `may`.

    The last one holds all that it may.
    """
    p = likelihood.S.shape[1]
    must = np.zeros(p, dtype=bool) if must is None else must
    may = np.ones(p, dtype=bool) if may is None else may
    masks = (np.array([bool(code >> i & 1) for i in range(p)]) for code in range(1, 2**p))
    wanted = [mask for mask in masks if not (must & ~mask).any() and not (mask & ~may).any()]
    return [Subset(likelihood, free, *likelihood.minimise(free), constants) for free in wanted]


def select(fitted: list[Subset], penalty: float | FloatArray = PENALTY) -> Subset:
    """The subset with the least 2 L + penalty x (number of terms)."""
    return min(fitted, key=lambda subset: subset.score(penalty))


@dataclass(frozen=True, eq=False)
class Profile(Portable):
    """The likelihood of one theta, the other terms of a subset following it.

    `excess` is 2 (L - L at the subset's minimum).
    """

    subset: Subset
    which: int

    @property
    def likelihood(self) -> Likelihood:
        """That of the subset."""
        return self.subset.likelihood

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

    def at(self, value: float, start: FloatArray) -> tuple[float, float, FloatArray]:
        """The excess at theta[which] = value, its derivative, and where the other terms went."""
        theta, least = self.likelihood.minimise(self.subset.free, start, (self.which, value))
        if least == math.inf:  # nothing else could make noise
            return math.inf, 0.0, theta
        return 2 * (least - self.subset.value), 2 * float(self.likelihood.gradient(theta)[self.which]), theta

    def _solve(self, drop: float, outside: float, guess: float) -> float:
        """Newton on the root of the excess, which is nearly straight in theta, kept within a bracket."""
        start, wanted, inside = self.subset.theta, math.sqrt(drop), self.best
        for _ in range(40):
            excess, slope, start = self.at(guess, start)
            root = math.sqrt(max(excess, 0.0))
            if abs(root - wanted) < 1e-3 * wanted:
                break
            inside, outside = (guess, outside) if root < wanted else (inside, guess)
            step = guess + (wanted - root) * 2 * root / slope if slope else math.inf
            guess = step if min(inside, outside) < step < max(inside, outside) else (inside + outside) / 2
        return guess


@dataclass(frozen=True, eq=False)
class Profiles(Portable):
    """Limits of each theta that hold whichever of the other terms are there.

    The profile of 2 L + sum of `doubt`, over every subset that has the term. Limits that trust the selection cover too
    seldom where it overlooks a weak term; limits that let every term in are 1.4 times too wide where there is none.
    What the record would have seen clearly must therefore gain something before it widens another's limits, and what
    it could hardly have seen nothing: a term that could dominate n_j coefficients must gain ln n_j, at most `DOUBT`.
    """

    fitted: list[Subset]
    chosen: Subset
    everything: Subset
    """The subset in which no term is left out that could take another's place."""

    @cached_property
    def doubt(self) -> FloatArray:
        """What each term must gain in 2 L before it widens the limits of others, shape (p,)."""
        likelihood = self.chosen.likelihood
        m = likelihood.expectation(self.chosen.theta)
        share = likelihood.S / m[:, None]
        dominated = likelihood.count @ (share / share.max(axis=0)) ** 2
        return np.asarray(np.clip(np.log(dominated), 0.0, DOUBT), dtype=np.float64)

    def limits(self, which: int, level: float) -> tuple[float, float]:
        """Two-sided limits of theta; the lower one is 0 where theta = 0 is within; 0 and inf where nothing is known."""
        within = self._within(which, quantile((1 + level) / 2) ** 2)
        low = min((p.lower(drop) for p, drop in within), default=0.0)
        return low, max((p.upper(drop) for p, drop in within), default=math.inf)

    def upper(self, which: int, level: float = 0.95) -> float:
        """One-sided upper limit of theta; the estimate itself for levels up to 0.5."""
        within = self._within(which, max(0.0, quantile(level)) ** 2)
        return max((p.upper(drop) for p, drop in within), default=math.inf)

    def excludes_zero(self, which: int, level: float = 0.95) -> bool:
        """Whether theta = 0 lies below the limits even if every other term is let in without doubt."""
        return Profile(self.everything, which).lower(quantile((1 + level) / 2) ** 2) > 0

    def weighted(self, which: int, nodes: int = 32, prior: float = 1.0) -> tuple[list[FloatArray], FloatArray]:
        """All thetas along the profile of one, with weights of its likelihood times a prior.

        Every term is free; the nodes are evenly spaced in the coefficient from 0 to where nothing is left.
        The prior's density goes as the coefficient to the power `prior`: 1 is flat in theta, 0 in the coefficient.
        """
        profile = Profile(self.everything, which)
        roots = np.linspace(0.0, math.sqrt(profile.upper(16.0)), nodes)
        start, thetas, excess = self.everything.theta, [], []
        for root in roots[::-1]:
            value, _, start = profile.at(root**2, start)
            if value == math.inf:  # no other term makes noise
                break
            thetas.append(start)
            excess.append(value)
        density = roots**prior
        if prior < 1:  # what lies within half a step of 0
            density[0] = (roots[1] / 2) ** (prior + 1) / (prior + 1) / roots[1]
        weight = density[::-1][: len(excess)] * np.exp(-0.5 * (np.array(excess) - min(excess)))
        return thetas, weight / weight.sum()

    def _within(self, which: int, drop: float) -> list[tuple[Profile, float]]:
        """Subsets whose minimum lies within `drop` of the best one's, and what each has left of it."""
        having = [subset for subset in self.fitted if subset.free[which]]
        best = min((subset.score(self.doubt) for subset in having), default=math.inf)
        left = [(subset, drop - (subset.score(self.doubt) - best)) for subset in having]
        return [(Profile(subset, which), rest) for subset, rest in left if rest >= 0]


def standard_error(subset: Subset, which: int, slope: FloatArray | None = None) -> float:
    """Of theta[which], from the expected information of the subset's terms.

    `slope` is how the expected power of the bins changes with something else that is unknown too, shape (bins,).
    """
    at = int(subset.free[:which].sum())
    if slope is None:
        return float(np.sqrt(subset.variances[at]))
    more = subset.likelihood.with_more(slope)
    return float(np.sqrt(_variances(more, np.append(subset.theta, 0.0), np.append(subset.free, True))[at]))


def _variances(likelihood: Likelihood, theta: FloatArray, free: BoolArray) -> FloatArray:
    """From the expected information of the free terms; what it does not tell apart shares it."""
    information = likelihood.information(theta)[np.ix_(free, free)]
    size = np.sqrt(np.diag(information))
    return np.asarray(np.diag(np.linalg.pinv(information / np.outer(size, size), hermitian=True)) / size**2)
