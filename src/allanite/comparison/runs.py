"""Laws of several runs: the mean of their coefficients, and of their variances, whether they scatter or not."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.limits import quantile
from allanite.core.plain import Portable

from .contrast import chi_square

DISTINCT = 0.05  # p up to which two runs differ: one degree of freedom makes their limits twelve standard errors wide


@dataclass(frozen=True, eq=False)
class CommonValue(Portable):
    """The mean of the runs' coefficients, with weights that include the variance between runs."""

    # The variance between runs is that of R. C. Paule, J. Mandel (J. Res. NBS 87 (1982) 377): with it chi-square equals
    # its degrees of freedom. The limits are those of J. Hartung, G. Knapp (Statistics in Medicine 20 (2001) 3875),
    # Student's t with the degrees of freedom of the runs, but never narrower than those of runs that are alike. Two
    # runs that are not distinguished have those of R. T. Birge (Phys. Rev. 40 (1932) 207).
    values: FloatArray  # shape (runs,)
    errors: FloatArray  # standard deviations within the runs
    alike: float  # the coefficient of runs that are alike
    within: Callable[[float], tuple[float, float]]  # its limits
    least: float = -math.inf  # below which no coefficient is

    @property
    def dof(self) -> int:
        """Degrees of freedom of the scatter."""
        return self.values.size - 1

    def _mean(self, between: float) -> tuple[float, float, float]:
        """The mean with a variance between runs, its standard error, and chi-square of one coefficient in all runs."""
        weight = 1 / (self.errors**2 + between)
        mean = float(weight @ self.values / weight.sum())
        return mean, float(weight.sum()) ** -0.5, float(weight @ (self.values - mean) ** 2)

    @property
    def chi_square(self) -> float:
        """Chi-square of one coefficient in all runs."""
        return self._mean(0.0)[2]

    @cached_property
    def between(self) -> float:
        """Variance between runs; 0 where they scatter no more than their errors, or two are not distinguished."""
        from scipy.optimize import brentq

        if self.chi_square <= self.dof or (self.dof == 1 and chi_square(self.chi_square, 1) > DISTINCT):
            return 0.0
        return float(brentq(lambda variance: self._mean(variance)[2] - self.dof, 0.0, self.values.var(ddof=1)))

    @property
    def value(self) -> float:
        """The mean."""
        return self._mean(self.between)[0] if self.between else self.alike

    def limits(self, level: float) -> tuple[float, float]:
        """Limits of the mean."""
        from scipy.special import stdtrit

        z, t = quantile((1 + level) / 2), float(stdtrit(self.dof, (1 + level) / 2))
        mean, error, chi2 = self._mean(self.between)
        if self.between:
            return max(mean - t * error, self.least), mean + t * error
        low, high = self.within(level)
        wider = max((t / z if self.dof > 1 else 1.0) * math.sqrt(chi2 / self.dof), 1.0)
        return max(self.alike - wider * (self.alike - low), self.least), self.alike + wider * (high - self.alike)


@dataclass(frozen=True, eq=False)
class PooledLaw:
    """Chi-square limits of variances averaged by their degrees of freedom, whose sum is `edf`, shape (k,)."""

    edf: FloatArray

    def __call__(self, level: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Degrees of freedom and limits over the variance; see `Curve`."""
        from scipy.special import chdtri

        low, high = (self.edf / chdtri(self.edf, p) for p in ((1 - level) / 2, (1 + level) / 2))
        return self.edf, low, high


def bartlett(variance: FloatArray, edf: FloatArray) -> FloatArray:
    """Probability that variances (runs, k) differ so by chance (k,). M. S. Bartlett, Proc. R. Soc. A 160 (1937) 268."""
    from scipy.special import chdtrc

    runs, whole = len(edf), edf.sum(axis=0)
    mean = (edf * variance).sum(axis=0) / whole
    statistic = whole * np.log(mean) - (edf * np.log(variance)).sum(axis=0)
    correction = 1 + ((1 / edf).sum(axis=0) - 1 / whole) / (3 * (runs - 1))
    return np.asarray(chdtrc(runs - 1, np.maximum(statistic, 0.0) / correction))
