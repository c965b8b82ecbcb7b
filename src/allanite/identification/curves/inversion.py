"""Limits of the coefficients of a curve by inversion: the values that a test does not reject.

A variance V_k with few degrees of freedom is far from Gaussian, and its scatter grows with the coefficient itself. Its
cube root is nearly Gaussian (Wilson and Hilferty): with E_k and nu_k its expectation and degrees of freedom,

    z_k = ((V_k / E_k)^(1/3) - 1 + a_k) / sqrt(a_k),    a_k = 2 / (9 nu_k)

is standard normal, and the z have the correlations R of the V. The excess of

    z' R^-1 z + log det R - 2 sum log dz_k/dV_k

above its minimum, the other squares profiled and E, nu and R all taken at the tested values, is the likelihood ratio.
"""

from dataclasses import dataclass
from functools import cached_property
from math import inf, isfinite, sqrt

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.limits import quantile
from allanite.core.plain import Portable

IMPOSSIBLE = 1e12
"""Misfit of squares under which the points have no covariance."""

DOUBLINGS = 60
"""Doublings of a coefficient after which it has no limit."""

PRECISE = 1e-3
"""Relative precision of a limit, over its distance from the best value."""


@dataclass(frozen=True, eq=False)
class Ratios(Portable):
    """Likelihood ratios of the squares of the coefficients of a curve.

    Attributes
    ----------
    columns, products : arrays, shapes (k, t) and (k, k, t, t)
        Expectation and covariance of the points under terms with coefficients of 1.
    variance : array, shape (k,)
    start, error : arrays, shape (t,)
        Squares of the coefficients near the minimum, and their standard errors, infinite if not observed.
    """

    columns: FloatArray
    products: FloatArray
    variance: FloatArray
    start: FloatArray
    error: FloatArray

    def cost(self, theta: FloatArray) -> tuple[float, FloatArray]:
        """-2 log likelihood and its derivatives, shape (t,)."""
        from scipy.linalg.lapack import dpotrf, dpotri

        k, t = self.columns.shape
        products = self.products.reshape(k * k, t * t)
        covariance = (products @ np.outer(theta, theta).ravel()).reshape(k, k)
        scatter = np.diag(covariance)
        if not np.all(scatter > 0):
            return IMPOSSIBLE, np.zeros(t)
        root, expected = np.sqrt(scatter), self.columns @ theta
        units = np.outer(root, root)
        triangle, failed = dpotrf(covariance / units, lower=1)
        if failed:
            return IMPOSSIBLE, np.zeros(t)
        inverse = np.tril(dpotri(triangle, lower=1)[0])
        inverse += np.tril(inverse, -1).T
        spread, cube = root / (3 * expected), np.cbrt(self.variance / expected)
        z = (cube - 1) / spread + spread
        w = inverse @ z
        cost = z @ w + 2 * np.log(np.diag(triangle) * spread / cube).sum()
        # by the covariance at given expectations, then by those
        steepness = spread - (cube - 1) / spread
        form = inverse - np.outer(w, w)
        by_root = 2 * w * steepness + 2 - 2 * (1 - w * z)
        slope = form / units + np.diag(by_root / (2 * scatter))
        by_expected = -2 * w * (cube / (3 * spread) + steepness) / expected - 4 / (3 * expected)
        return float(cost), 2 * (slope.ravel() @ products).reshape(t, t) @ theta + by_expected @ self.columns

    def least(self, theta: FloatArray, fixed: int | None = None) -> tuple[FloatArray, float]:
        """Squares that minimize the cost, from where to begin, and the minimum; one of them may be fixed."""
        from scipy.optimize import minimize

        free = np.isfinite(self.error)
        if fixed is not None:
            free[fixed] = False
        theta = theta.copy()
        if not free.any():
            return theta, self.cost(theta)[0]
        unit = self.error[free]

        def cost(u: FloatArray) -> tuple[float, FloatArray]:
            theta[free] = u * unit
            value, slopes = self.cost(theta)
            return value, slopes[free] * unit

        found = minimize(cost, theta[free] / unit, jac=True, method="L-BFGS-B", bounds=[(0, None)] * unit.size)
        theta[free] = found.x * unit
        return theta, float(found.fun)

    @cached_property
    def best(self) -> tuple[FloatArray, float]:
        """The minimum."""
        return self.least(self.start)

    def excess(self, which: int, value: float) -> float:
        """Likelihood ratio of a value of a coefficient, the others profiled; below 0 by rounding only."""
        theta, least = self.best
        theta = theta.copy()
        theta[which] = value**2
        return self.least(theta, which)[1] - least


@dataclass(frozen=True, eq=False)
class Inverted:
    """Limits of a coefficient, from the likelihood ratio that a standard normal deviate would have."""

    ratios: Ratios
    which: int

    def __call__(self, level: float) -> tuple[float, float]:
        """Two-sided limits."""
        reach = quantile((1 + level) / 2)
        return self._crossing(-reach), self._crossing(reach)

    def upper(self, level: float) -> float:
        """One-sided upper limit."""
        return self._crossing(quantile(level))

    def _crossing(self, deviate: float) -> float:
        """Where the signed root of the ratio is a deviate."""
        from scipy.optimize import brentq

        ratios, sign = self.ratios, 1 if deviate > 0 else -1
        error = float(ratios.error[self.which])
        if not isfinite(error):
            return inf if sign > 0 else 0.0

        def over(value: float) -> float:
            return sqrt(max(ratios.excess(self.which, value), 0.0)) - abs(deviate)

        best = sqrt(ratios.best[0][self.which])
        step = sqrt(best**2 + 2 * abs(deviate) * error) - best
        for reach in step * 2.0 ** np.arange(DOUBLINGS):
            end = max(best + sign * float(reach), 0.0)
            if over(end) > 0:
                return float(brentq(over, best, end, xtol=PRECISE * step))
            if not end:
                return 0.0
        return inf
