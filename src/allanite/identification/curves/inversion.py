"""Limits of the coefficients of a curve by inversion: the values that a test does not reject (docs/derivations.md)."""

from dataclasses import dataclass
from functools import cached_property
from math import inf, isfinite, sqrt

import numpy as np
import scipy

from allanite.core.arrays import FloatArray
from allanite.core.limits import quantile
from allanite.core.plain import Portable
from allanite.core.splines import cubic, valued

IMPOSSIBLE = 1e12  # misfit of squares under which the points have no covariance
DOUBLINGS = 60  # doublings of a coefficient after which it has no limit
PRECISE = 1e-3  # relative precision of a limit, over its distance from the best value

NODES, ENDS = 15, 4.5
"""Values of each slow coefficient at which the likelihood is integrated, and the deviates of the profile at their ends.
"""

PROFILE_STEPS, LEAST_COST_GAIN = 4, 0.1
"""Steps to profiled terms, at most, and what another must gain in -2 log likelihood."""

FINE_VALUES = 1001  # values of a coefficient between which its likelihood ratio is interpolated


@dataclass(frozen=True, eq=False)
class RatioLimits(Portable):
    """Likelihood ratios of the squares of the coefficients of a curve."""

    # columns, products: shapes (k, t) and (k, k, t, t); expectation and covariance of the points for coefficients of 1
    columns: FloatArray
    products: FloatArray
    variance: FloatArray  # shape (k,)
    # start, error: shape (t,); squares of the coefficients near the minimum, and their standard errors, infinite if
    # not observed
    start: FloatArray
    error: FloatArray
    slow: tuple[int, ...] = ()  # terms that are integrated over, not profiled

    def cost(self, theta: FloatArray) -> tuple[float, FloatArray]:
        """-2 log likelihood and its derivatives, shape (t,)."""
        k, t = self.columns.shape
        products = self.products.reshape(k * k, t * t)
        covariance = (products @ np.outer(theta, theta).ravel()).reshape(k, k)
        scatter = np.diag(covariance)
        if not np.all(scatter > 0):
            return IMPOSSIBLE, np.zeros(t)
        root, expected = np.sqrt(scatter), self.columns @ theta
        units = np.outer(root, root)
        triangle, failed = scipy.linalg.lapack.dpotrf(covariance / units, lower=1)
        if failed:
            return IMPOSSIBLE, np.zeros(t)
        inverse = np.tril(scipy.linalg.lapack.dpotri(triangle, lower=1)[0])
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

        bounds = [(0, None)] * unit.size
        least = scipy.optimize.minimize(cost, theta[free] / unit, jac=True, method="L-BFGS-B", bounds=bounds)
        theta[free] = least.x * unit
        return theta, float(least.fun)

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

    def crossing(self, which: int, deviate: float) -> float:
        """Where the signed root of the ratio of a coefficient, the others profiled, is a deviate."""
        sign, error = 1 if deviate > 0 else -1, float(self.error[which])
        if not isfinite(error):
            return inf if sign > 0 else 0.0

        def over(value: float) -> float:
            return sqrt(max(self.excess(which, value), 0.0)) - abs(deviate)

        best = sqrt(self.best[0][which])
        step = sqrt(best**2 + 2 * abs(deviate) * error) - best
        for reach in step * 2.0 ** np.arange(DOUBLINGS):
            end = max(best + sign * float(reach), 0.0)
            if over(end) > 0:
                return float(scipy.optimize.brentq(over, best, end, xtol=PRECISE * step))
            if not end:
                return 0.0
        return inf

    @cached_property
    def integrated(self) -> dict[int, tuple[FloatArray, FloatArray]]:
        """Values of each slow coefficient, and signed roots of their likelihood ratios, the others integrated."""
        # Shapes (fine,); both rise.
        ends = {i: (self.crossing(i, -ENDS), self.crossing(i, ENDS)) for i in self.slow}
        axes = {i: np.linspace(low, high, NODES) for i, (low, high) in ends.items() if isfinite(high)}
        if not axes:
            return {}
        at = np.array([node.ravel() for node in np.meshgrid(*axes.values(), indexing="ij")])
        # likelihood at squares of slow terms, shape (terms, nodes), over its maximum, the others profiled
        slow = list(axes)
        squares = at**2
        best = self.best[0]
        covariance = np.einsum("ijab,a,b", self.products, best, best)
        H = 2 * np.asarray(self.columns.T @ np.linalg.solve(covariance, self.columns))
        rest = [i for i in np.flatnonzero(np.isfinite(self.error)).tolist() if i not in slow]
        inner, follow = H[np.ix_(rest, rest)], -np.linalg.solve(H[np.ix_(rest, rest)], H[np.ix_(rest, slow)])
        cost, theta = np.empty(squares.shape[1]), best.copy()
        for k, square in enumerate(squares.T):
            theta[slow], theta[rest] = square, np.maximum(best[rest] + follow @ (square - best[slow]), 0.0)
            for _ in range(PROFILE_STEPS):
                cost[k], slopes = self.cost(theta)
                step = np.maximum(theta[rest] - np.linalg.solve(inner, slopes[rest]), 0.0) - theta[rest]
                gain = float(-step @ (slopes[rest] + inner @ step / 2))
                if gain < LEAST_COST_GAIN:
                    break
                theta[rest] += step
        density = np.asarray(np.exp((cost.min() - cost) / 2)).reshape([NODES] * len(axes))
        ratios = {}
        for i, root in axes.items():
            along = density
            for axis, (j, other) in reversed(list(enumerate(axes.items()))):
                if j != i:  # flat in the square
                    along = np.tensordot(along, other, (axis, 0))
            ratios[i] = signed(root, along)
        return ratios


def signed(root: FloatArray, likelihood: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Values of a coefficient, closer together, and signed roots of their likelihood ratios."""
    value = np.linspace(root[0], root[-1], FINE_VALUES)
    cost = valued(root, cubic(root, -2 * np.log(np.maximum(likelihood, 1e-300 * likelihood.max()))), value)
    sign = np.where(np.arange(FINE_VALUES) < cost.argmin(), -1.0, 1.0)
    return value, np.maximum.accumulate(sign * np.sqrt(cost - cost.min()))


@dataclass(frozen=True, eq=False)
class Inverted:
    """Limits of a coefficient, from the likelihood ratio that a standard normal deviate would have."""

    ratios: RatioLimits
    which: int

    def __call__(self, level: float) -> tuple[float, float]:
        """Two-sided limits."""
        reach = quantile((1 + level) / 2)
        return self._at(-reach), self._at(reach)

    def upper(self, level: float) -> float:
        """One-sided upper limit."""
        return self._at(quantile(level))

    @property
    def evidence(self) -> float:
        """Likelihood ratio of the term against its absence."""
        if self.which not in self.ratios.integrated:
            return self.ratios.excess(self.which, 0.0)
        value, deviate = self.ratios.integrated[self.which]
        return inf if value[0] > 0 else float(deviate[0] ** 2)

    def _at(self, deviate: float) -> float:
        if self.which not in self.ratios.integrated:
            return self.ratios.crossing(self.which, deviate)
        value, deviates = self.ratios.integrated[self.which]
        return float(np.interp(deviate, deviates, value))
