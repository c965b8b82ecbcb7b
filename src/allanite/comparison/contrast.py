"""Tests between records: of one noise, and how far apart a coefficient of two can be, with records or without."""

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.errors import DataError, UsageError
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.limits import quantile
from allanite.core.plain import Portable
from allanite.identification.likelihood.likelihood import Likelihood
from allanite.phrases.phrase import say
from allanite.study.job import provenance_of
from allanite.study.recipe import Recipe
from allanite.terms import TERMS

from .change import Homogeneity, alpha_of, changes_of
from .common_likelihood import Joint, drawn, least, tied
from .comparison import Comparison, Pair
from .sources import name_both

DRAWS = 199  # draws of a bootstrap at most
ENOUGH = 10  # draws that reach what was seen, after which the bootstrap stops: p is then known to a third of itself
CLEAR = 1e-4  # a p by chi-square below which nothing is drawn


def homogeneity(joint: Joint, rng: "np.random.Generator") -> Homogeneity:
    """Test of one common model against a model for each record, of the terms that the common model holds."""
    # A sequential Monte Carlo p-value (J. Besag, P. Clifford, Biometrika 78 (1991) 301).
    parts = joint.only(joint.chosen.free)
    theta = joint.chosen.theta[joint.chosen.free]
    statistic = gain(parts, theta)
    dof = theta.size * (len(parts) - 1)
    by_table = chi_square(statistic, dof)
    if by_table < CLEAR:
        return Homogeneity(statistic, dof, by_table, 0)
    reached = 0
    for count in range(1, DRAWS + 1):
        reached += gain(tuple(drawn(part, theta, rng) for part in parts), theta) >= statistic
        if reached == ENOUGH:
            return Homogeneity(statistic, dof, reached / count, count)
    smallest = (reached + 1) / (DRAWS + 1)
    return Homogeneity(statistic, dof, min(smallest, by_table) if reached == 0 else smallest, DRAWS)


def gain(parts: tuple[Likelihood, ...], start: FloatArray) -> float:
    """Twice what separate models gain in L over one common model."""
    free = np.ones(start.size, dtype=bool)
    _, common = tied(parts).minimise(free, start)
    _, separate = least(parts, start)
    return max(2 * (common - separate), 0.0)


def chi_square(value: float, dof: int) -> float:
    """Probability of a larger chi-square."""
    from scipy.special import chdtrc

    return float(chdtrc(dof, value))


@dataclass(frozen=True, eq=False)
class Contrast(Portable):
    """One coefficient of two records, the other terms of each being free."""

    # Their ratio is tan(phi): 0 where the second record has none of it, infinite where the first has none.
    joint: Joint
    which: int

    @cached_property
    def parts(self) -> tuple[Likelihood, ...]:
        """The likelihoods of the terms of the common model and of this one."""
        columns = self.joint.chosen.free.copy()
        columns[self.which] = True
        return self.joint.only(columns)

    @cached_property
    def column(self) -> int:
        """Its place among these terms."""
        return int(self.joint.chosen.free[: self.which].sum())

    @cached_property
    def separate(self) -> tuple[list[FloatArray], float]:
        """Theta of each record by itself, and the sum of the minima."""
        return least(self.parts)

    @property
    def ratio(self) -> float:
        """The second coefficient over the first; NaN where both are zero."""
        first, second = (theta[self.column] for theta in self.separate[0])
        return math.nan if first <= 0 and second <= 0 else math.inf if first <= 0 else math.sqrt(second / first)

    def excess(self, phi: float) -> float:
        """2 (L - its minimum) with the ratio held at tan(phi)."""
        p, i = self.parts[0].S.shape[1], self.column
        thetas, minimum = self.separate
        if p == 1 and phi in (0.0, math.pi / 2):  # no noise at all would be left
            return math.inf
        shared = [np.eye(p, 2 * p - 1), np.eye(p, 2 * p - 1)]
        others = [j for j in range(p) if j != i]
        shared[1][others] = 0.0
        shared[1][others, np.arange(p, 2 * p - 1)] = 1.0
        shared[0][i, i], shared[1][i, i] = math.cos(phi) ** 2, math.sin(phi) ** 2
        start = np.concatenate((thetas[0], thetas[1][others]))
        start[i] = max(thetas[0][i] + thetas[1][i], 1e-12 * float(np.max(start, initial=0.0)))
        _, value = tied(self.parts, shared).minimise(np.ones(2 * p - 1, dtype=bool), start)
        return max(2 * (value - minimum), 0.0)

    @property
    def p(self) -> float:
        """Probability of such a difference by chance, where there is none."""
        return chi_square(self.excess(math.pi / 4), 1)

    def limits(self, level: float) -> tuple[float, float]:
        """Profile limits of the ratio; from 0 to infinity where the records say nothing of it."""
        drop, best = quantile((1 + level) / 2) ** 2, self.ratio
        at = math.pi / 4 if math.isnan(best) else math.atan(best)
        high = self._solve(drop, at, math.pi / 2)
        return math.tan(self._solve(drop, at, 0.0)), math.inf if high == math.pi / 2 else math.tan(high)

    def _solve(self, drop: float, best: float, end: float) -> float:
        """Where the excess is `drop` between the best angle and an end; the end if it is less there."""
        from scipy.optimize import brentq

        if best == end or self.excess(end) <= drop:
            return end
        if self.excess(best) >= drop:  # at a low level, to rounding
            return best
        inside, share = best, 1e-3
        while self.excess(outside := best + min(share, 1 - 1e-9) * (end - best)) < drop:
            inside, share = outside, 3 * share

        def beyond(phi: float) -> float:
            return math.sqrt(self.excess(phi)) - math.sqrt(drop)

        return float(brentq(beyond, inside, outside, xtol=1e-4 * abs(outside - best), rtol=1e-12))


def outlying(joint: Joint) -> list[float]:
    """For each record the probability that it would differ as much from all others by chance; shape (records,)."""
    free = joint.chosen.free
    parts, theta = joint.only(free), joint.chosen.theta[free]
    whole = np.ones(theta.size, dtype=bool)
    _, together = tied(parts).minimise(whole, theta)
    chances = []
    for i, part in enumerate(parts):
        _, rest = tied(parts[:i] + parts[i + 1 :]).minimise(whole, theta)
        _, own = part.minimise(whole, theta)
        chances.append(chi_square(max(2 * (together - rest - own), 0.0), theta.size))
    return chances


def spread(joint: Joint, which: int) -> tuple[float, float]:
    """Chi-square of one coefficient being the same in all records, the other terms of each being free, and its p."""
    contrast = Contrast(joint, which)
    parts, i, (thetas, separate) = contrast.parts, contrast.column, contrast.separate
    apart = np.arange(parts[0].S.shape[1]) != i
    maps = mixed(apart, len(parts))
    start = np.concatenate(([np.mean([t[i] for t in thetas])], *(t[apart] for t in thetas)))
    _, value = tied(parts, maps).minimise(np.ones(start.size, dtype=bool), start)
    statistic = max(2 * (value - separate), 0.0)
    return statistic, chi_square(statistic, len(parts) - 1)


def mixed(apart: BoolArray, count: int) -> list[FloatArray]:
    """Maps of `tied` for so many parts: columns that are `apart`, shape (p,), are of each part, the others common."""
    p, own = apart.size, int(apart.sum())
    maps = []
    for j in range(count):
        H = np.zeros((p, p - own + count * own))
        H[~apart, np.arange(p - own)] = 1.0
        H[apart, p - own + j * own + np.arange(own)] = 1.0
        maps.append(H)
    return maps


def partly_common(joint: Joint, apart: Collection[str]) -> list[dict[str, float]]:
    """Coefficients of each record, SI, every term let in: only those of the symbols `apart` differ between records."""
    # A weak term is better known from all records together than from each.
    maps = mixed(np.array([s in apart for s in joint.symbols]), len(joint.parts))
    together = tied(joint.parts, maps)
    theta, _ = together.minimise(np.ones(together.S.shape[1], dtype=bool))
    return [dict(zip(joint.symbols, np.sqrt(H @ theta).tolist(), strict=True)) for H in maps]


@dataclass(frozen=True, eq=False)
class IntervalContrast:
    """A coefficient of one fit against that of another, independent one."""

    # The limits recover a variance on either side from each interval, on the scale of logarithms, where the intervals
    # of coefficients above zero are nearly symmetric (A. Donner, G. Y. Zou, Statistical Methods in Medical Research 21
    # (2012) 347).
    first: Estimate
    second: Estimate

    def __post_init__(self) -> None:
        for estimate in (self.first, self.second):
            if estimate.limits is None:
                raise UsageError(f"the method {estimate.method!r} gives no intervals, which a comparison needs; use "
                                 "method='whittle'")  # fmt: skip

    @property
    def ratio(self) -> float:
        """The second coefficient over the first; NaN where neither was found."""
        first, second = self.first.value, self.second.value
        if first is None and second is None:
            return math.nan
        return math.inf if first is None else (second or 0.0) / first

    @property
    def p(self) -> float:
        """One less the level at which the limits of the ratio reach 1."""
        low, high = 0.0, 1 - 1e-12
        for _ in range(50):
            middle = (low + high) / 2
            under, over = self.limits(middle)
            low, high = (low, middle) if under <= 1 <= over else (middle, high)
        return 1 - low

    def limits(self, level: float) -> tuple[float, float]:
        """Limits of the ratio; from 0 (for a signed coefficient: minus infinity) to infinity where it is open."""
        (l1, v1, u1), (l2, v2, u2) = (_sizes(e, level) for e in (self.first, self.second))
        if ((self.first.value or 0.0) < 0) != ((self.second.value or 0.0) < 0):
            return -_over(u2, l1), 0.0
        low = math.exp(-math.hypot(_log(v2, l2), _log(u1, v1))) if min(l2, v1) > 0 and math.isfinite(u1) else 0.0
        high = math.exp(math.hypot(_log(u2, v2), _log(v1, l1))) if min(l1, v2) > 0 and math.isfinite(u2) else math.inf
        if v1 > 0 and v2 > 0:
            return low * v2 / v1, high * v2 / v1
        if v1 > 0:  # the second one was not found
            return 0.0, _over(u2, l1)
        return _over(l2, u1), math.inf


def shape_contrasts(before: Fit, after: Fit) -> dict[tuple[str, str], IntervalContrast]:
    """Contrasts of terms with a shape that both fits have: by symbol, and by the parameters of the shape."""
    contrasts = {}
    both = [(e, other) for e in before for other in after if e.symbol == other.symbol]
    for e, other in ((e, o) for e, o in both if e.claimed and o.claimed and e.shape_limits and o.shape_limits):
        contrasts[e.symbol, ""] = IntervalContrast(e, other)
        for i, parameter in enumerate(TERMS[e.symbol].parameters):
            contrasts[e.symbol, parameter.name] = IntervalContrast(_parameter(e, i), _parameter(other, i))
    return contrasts


def _parameter(estimate: Estimate, i: int) -> Estimate:
    """A parameter of the shape in the place of the coefficient."""
    assert estimate.shape_limits is not None  # noqa: S101 - the caller has looked
    return replace(estimate, value=estimate.shape[i], limits=partial(_limits_of, estimate.shape_limits, i))


def _limits_of(limits: Callable[[float], tuple[tuple[float, float], ...]], i: int, level: float) -> tuple[float, float]:
    return limits(level)[i]


def _sizes(estimate: Estimate, level: float) -> tuple[float, float, float]:
    """Size of a coefficient between its limits; 0 where it was not found."""
    low, high = estimate.interval(level)
    least = 0.0 if estimate.value is None or low <= 0 <= high else min(abs(low), abs(high))
    return least, abs(estimate.value or 0.0), max(abs(low), abs(high))


def _over(above: float, below: float) -> float:
    """Their ratio; infinite over nothing, and 0 of nothing."""
    return 0.0 if above <= 0 else math.inf if below <= 0 else above / below


def _log(above: float, below: float) -> float:
    return math.log(above / below) if below > 0 else math.inf


def compare_fits(before: object, after: object, recipe: Recipe) -> Comparison:
    """What has changed between two fits, by the intervals of their coefficients."""
    if not (isinstance(before, Fit) and isinstance(after, Fit)):
        raise UsageError("a fit can only be compared with a fit; pass both records, which carry more information")
    if before.signal is not after.signal:
        raise DataError(f"only sensors of one kind can be compared, not {before.signal.name} and {after.signal.name} "
                        "signals")  # fmt: skip
    both = ((e, other) for e in before for other in after if e.symbol == other.symbol)
    contrasts = {(e.symbol, ""): IntervalContrast(e, other) for e, other in both} | shape_contrasts(before, after)
    changes = changes_of(contrasts, (before, after), recipe.level)
    pair = Pair(name_both(before, after), changes=changes, fits=(before, after), alpha=alpha_of(recipe.level))
    notes = (say("compared by the intervals of the coefficients only; a comparison of the records is more sensitive"),)
    used = Recipe(level=recipe.level)  # nothing else of it counts
    return Comparison((pair,), used, (), notes, provenance_of(), (say("before"), say("after")))
