"""Comparison of two fits without their records: the ratios of coefficients from their intervals alone."""

import math
from dataclasses import dataclass

from allanite.core.errors import DataError, UsageError
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.phrases.phrase import say
from allanite.study.provenance import provenance_of
from allanite.study.recipe import Recipe

from .change import alpha_of, changes_of
from .comparison import Comparison, Pair
from .sources import name_both


@dataclass(frozen=True, eq=False)
class IntervalContrast:
    """A coefficient of one fit against that of another, independent one.

    The limits recover a variance on either side from each interval, on the scale of logarithms, where the intervals of
    coefficients above zero are nearly symmetric.

    References
    ----------
    A. Donner, G. Y. Zou, Statistical Methods in Medical Research 21 (2012) 347: the method of variance estimates
    recovery.
    """

    first: Estimate
    second: Estimate

    def __post_init__(self) -> None:
        for estimate in (self.first, self.second):
            if estimate.limits is None:
                raise UsageError(
                    f"the method {estimate.method!r} gives no intervals, which a comparison needs; use method='whittle'"
                )

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


def _sizes(estimate: Estimate, level: float) -> tuple[float, float, float]:
    """Size of a coefficient between its limits; 0 where it was not found."""
    low, high = estimate.interval(level)
    if estimate.value is None:
        return 0.0, 0.0, max(abs(low), abs(high))
    if low <= 0 <= high:
        return 0.0, abs(estimate.value), max(abs(low), abs(high))
    return min(abs(low), abs(high)), abs(estimate.value), max(abs(low), abs(high))


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
        raise DataError(
            f"only sensors of one kind can be compared, not {before.signal.name} and {after.signal.name} signals"
        )
    common = [e.symbol for e in before if e.symbol in [other.symbol for other in after]]
    contrasts = {s: IntervalContrast(before[s], after[s]) for s in common}
    changes = changes_of(contrasts, (before, after), recipe.level)
    pair = Pair(name_both(before, after), changes=changes, fits=(before, after), alpha=alpha_of(recipe.level))
    notes = (say("compared by the intervals of the coefficients only; a comparison of the records is more sensitive"),)
    used = Recipe(level=recipe.level)  # nothing else of it counts
    return Comparison((pair,), used, (), notes, provenance_of(), (say("before"), say("after")))
