"""The ramps of two records: signed, each with the law that what hides it leaves."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.limits import quantile
from allanite.identification.likelihood.selection import Subset, ThetaProfile
from allanite.terms import TERMS

from .common_likelihood import Joint


@dataclass(frozen=True, eq=False)
class RampLaw:
    """A ramp in SI as a mixture of normal laws: one for each strength of the noise of the longest memory.

    That noise is known from a few powers only; averaging over it gives the wide tails of Student's t.
    """

    centre: FloatArray
    spread: FloatArray
    weight: FloatArray

    @property
    def value(self) -> float:
        """The mean."""
        return float(self.weight @ self.centre)

    @property
    def error(self) -> float:
        """The standard deviation."""
        return math.sqrt(float(self.weight @ (self.spread**2 + (self.centre - self.value) ** 2)))

    def minus(self, other: "RampLaw", factor: float = 1.0) -> "RampLaw":
        """The law of this ramp less `factor` times another."""
        return RampLaw(
            np.subtract.outer(self.centre, factor * other.centre).ravel(),
            np.hypot.outer(self.spread, factor * other.spread).ravel(),
            np.multiply.outer(self.weight, other.weight).ravel(),
        )

    @property
    def below(self) -> float:
        """Probability of less than zero."""
        from scipy.special import ndtr

        return float(self.weight @ ndtr(-self.centre / self.spread))

    @property
    def p(self) -> float:
        """Two-sided probability of zero."""
        return 2 * min(self.below, 1 - self.below, 0.5)


def ramp_law(joint: Joint, i: int) -> RampLaw | None:
    """The ramp of record i of several; None where the band leaves nothing of it."""
    part, seen = joint.parts[i], joint.seen[i]
    if not part.flat.any():
        return None
    slope = [np.nan_to_num(TERMS[symbol].slope, nan=-math.inf) for symbol in joint.symbols]
    free = np.ones(part.S.shape[1], dtype=bool)
    thetas, weight = ThetaProfile(Subset(part, free, *part.minimise(free)), int(np.argmax(slope))).weighted()
    found = [part.directions(theta)[:2] for theta in thetas]
    size = seen.unit_factor * seen.rate
    centre = np.array([eta[-1] for eta, _ in found]) + seen.slope
    return RampLaw(size * centre, size * np.sqrt([V[-1, -1] for _, V in found]), weight)


@dataclass(frozen=True, eq=False)
class RampContrast:
    """The second ramp against the first."""

    first: RampLaw
    second: RampLaw

    @property
    def ratio(self) -> float:
        """The second ramp over the first, with the sign."""
        return self.second.value / self.first.value

    @property
    def p(self) -> float:
        """Probability of such a difference by chance, where there is none."""
        return self.second.minus(self.first).p

    def limits(self, level: float) -> tuple[float, float]:
        """Limits of the ratio: what the second less ratio times the first leaves near zero (E. C. Fieller, 1954).

        From minus to plus infinity where the first ramp itself is not distinguished from zero.
        """
        if self.first.p >= 1 - level:
            return -math.inf, math.inf
        # where the mean is, the median need not be: each end is sought on both sides of it
        ends = [self._quantile((1 - level) / 2), self._quantile((1 + level) / 2)]
        return min(ends), max(ends)

    def _quantile(self, share: float) -> float:
        """The ratio at which the probability is `share` that the second less ratio times the first is below zero."""
        from scipy.optimize import brentq

        def off(ratio: float) -> float:
            return self.second.minus(self.first, ratio).below - share

        best = self.ratio
        step = 0.1 * max(abs(best), 1.0)
        while off(best - step) * off(best + step) > 0:
            step *= 2
        return float(brentq(off, best - step, best + step, rtol=1e-6))


@dataclass(frozen=True, eq=False)
class CommonRamp:
    """What the ramps of several records have in common: their mean, weighted by their variances."""

    laws: Sequence[RampLaw]

    @property
    def values(self) -> FloatArray:
        """The ramp of each record."""
        return np.array([law.value for law in self.laws])

    @property
    def errors(self) -> FloatArray:
        """Standard deviations."""
        return np.array([law.error for law in self.laws])

    @property
    def value(self) -> float:
        """The mean."""
        return float(np.average(self.values, weights=self.errors**-2))

    @property
    def chi_square(self) -> float:
        """Chi-square of one ramp in all records."""
        return float((((self.values - self.value) / self.errors) ** 2).sum())

    @property
    def dof(self) -> int:
        """Degrees of freedom of chi-square."""
        return len(self.laws) - 1

    def limits(self, level: float) -> tuple[float, float]:
        """Limits of the common ramp, wider where the ramps scatter more than they should (R. T. Birge, 1932)."""
        wider = max(1.0, self.chi_square / self.dof)
        half = quantile((1 + level) / 2) * math.sqrt(wider / float((self.errors**-2).sum()))
        return self.value - half, self.value + half
