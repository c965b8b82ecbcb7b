"""A rate with the covariance exp(-u |t|), averaged over each sample interval: what correlated noise is made of.

For a complex u, whose real part is positive, the functions are the analytic continuations. Sums of two conjugate
exponentials with conjugate weights are a damped oscillation.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

Values = NDArray[Any]
"""Real for a real u, complex for a complex one."""

SMALL = 0.05
"""Size of u below which differences of exponentials are taken from their series."""


def rest(u: Values | complex, order: int) -> Values:
    """exp(-u) without the first `order` terms of its series, without cancellation."""
    u = np.asarray(u)
    small = np.abs(u) < SMALL * 4
    k = np.arange(order, order + 9)
    factorials = np.array([math.factorial(i) for i in k])
    series = ((-np.where(small, u, 0.0)[..., None]) ** k / factorials).sum(axis=-1)
    direct = np.exp(-u) - sum((-u) ** i / math.factorial(i) for i in range(order))
    return np.where(small, series, direct)


@dataclass(frozen=True)
class Exponential:
    """The columns of a row for the covariance exp(-u |t|), t in sample intervals."""

    u: complex

    @cached_property
    def T(self) -> complex:
        """The time constant."""
        return 1 / self.u

    @cached_property
    def loss(self) -> complex:
        """1 - exp(-u)."""
        return complex(-np.expm1(-self.u)) if isinstance(self.u, complex) else -math.expm1(-self.u)

    @cached_property
    def variance(self) -> complex:
        """Variance of a mean over one interval."""
        found: complex = 2 * self.T**2 * rest(self.u, 2).item()
        return found

    @cached_property
    def neighbour(self) -> complex:
        """Covariance of two neighbouring means."""
        return (self.loss * self.T) ** 2

    def structure(self, t: Values) -> Values:
        """D(t)."""
        return np.asarray(2 * self.T**2 * rest(np.asarray(t, dtype=np.float64) * self.u, 2))

    def derivative(self, order: int, t: Values) -> Values:
        """Derivatives of D."""
        if order == 1:
            return np.asarray(-2 * self.T * np.expm1(-t * self.u))
        return np.asarray(2 * self.T**2 * (-self.u) ** order * np.exp(-t * self.u))

    def summed(self, t: Values) -> Values:
        """Second sum of D, without its constant and its square of t."""
        T, u, small = self.T, self.u, abs(self.u) < SMALL
        t = np.asarray(t, dtype=np.float64)
        excess = u**2 / 12 + u**4 / 360 + u**6 / 20160 if small else (2 * np.cosh(u) - 2) / u**2 - 1
        inverse = 1 / (u**2 * (1 + excess))  # of 2 cosh u - 2
        if small:
            linear = (u**2 * (1 / 120 - 1 / 72) + u**4 * (1 / 5040 - 1 / 2160)) / (1 + excess)
        else:
            linear = T * inverse * (np.sinh(u) - u) - 1 / 6
        return np.asarray(2 * T * (t**3 / 6 * excess / (1 + excess) + linear * t + T * inverse * rest(t * u, 4)))

    def increments(self, h: Values) -> Values:
        """Covariance of the first differences of the means."""
        h, C = np.asarray(h, dtype=np.float64), self._covariance
        near = 2 * C(h) - C(np.abs(h - 1)) - C(h + 1)
        return np.where(h < 2, near, -self.neighbour * self.loss**2 * np.exp(-self.u * np.maximum(h - 2, 0)))

    def _covariance(self, h: Values) -> Values:
        beyond = self.neighbour * np.exp(-self.u * np.maximum(np.abs(h) - 1, 0))
        return np.where(h == 0, self.variance, beyond)

    def spectrum(self, f: Values, tau0: float) -> Values:
        """Two-sided spectral density of the means."""
        p, loss = np.exp(-self.u), self.loss
        s = np.sin(math.pi * tau0 * np.asarray(f, dtype=np.float64)) ** 2
        numerator = 2 * self.T * loss**2 + 4 * s * (p * self.variance - self.neighbour)
        return np.asarray(tau0 * numerator / (loss**2 + 4 * p * s))

    def dct(self, k: Values, n: int) -> Values:
        """Variance of the k-th coefficient of the DCT-II of n means."""
        f = np.asarray(k, dtype=np.float64) / (2 * n)
        return np.asarray(self.spectrum(f, 1.0) - self.T**2 * self.ends(k, n))

    def ends(self, k: Values, n: int) -> Values:
        """What the ends of a record add to the k-th coefficient of the DCT-II of the derivative of such a process.

        The sums of exp(-u h) over h < n are geometric series.
        """
        k = np.asarray(k, dtype=np.float64)
        s = np.sin((0.5 * math.pi / n) * k) ** 2
        other = np.where(k % 2 == 0, -np.expm1(-self.u * n), 1 + np.exp(-self.u * n))  # 1 - (-1)^k exp(-u n)
        return np.asarray(4 / n * (1 - s) * other * self.lorentzian(s) ** 2)

    def lorentzian(self, s: Values) -> Values:
        """(1 - p)^2 / ((1 - p)^2 + 4 p s) with p = exp(-u), at s = sin^2(omega / 2): 1 at low frequencies."""
        return np.asarray(1 / (1 + 4 * s * np.exp(-self.u) / self.loss**2))
