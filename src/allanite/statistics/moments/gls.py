"""Covariance of a model's rates, its inverse, and generalized least squares (docs/derivations.md)."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from allanite.core.errors import UsageError
from allanite.core.model import Term
from allanite.terms.row import FloatArray

from .lagsums import second_difference

PRECISION = 1e-11  # residual, over that of the start, at which the conjugate gradients stop
MAX_STEPS = 500  # steps of the conjugate gradients; they need 5 to 40


def autocovariance(terms: Iterable[Term], n: int, rate: float) -> FloatArray:
    """Generalized covariance of mean rates at lags 0 to n - 1 samples, rate squared, SI; deterministic terms have none.

    >>> from allanite import N, Q
    >>> autocovariance(N(1.0, "rad/sqrt(s)") + Q(1.0, "rad"), 3, 2.0).tolist()
    [10.0, -4.0, 0.0]
    """
    total = np.zeros(n)
    for t in terms:
        if t.row.waveform is None:
            total += t.power(rate) * second_difference(t.sampled(rate), n) / 2
    return total


@dataclass(frozen=True, eq=False)
class Covariance:
    """Covariance of `size` mean rates under the noise `terms` at `rate` Hz; see the module.

    >>> from allanite import K, N
    >>> covariance = Covariance((N(1.0, "rad/sqrt(s)"), K(0.1, "rad/s^1.5")), 5, 1.0)
    >>> v = covariance.solve(np.array([0.0, 0.0, 1.0, 0.0, 0.0]))
    >>> np.abs(np.round(covariance.times(v) - covariance.times(v)[0], 9)).tolist()
    [0.0, 0.0, 1.0, 0.0, 0.0]
    """

    terms: tuple[Term, ...]
    size: int
    rate: float

    @cached_property
    def first_row(self) -> FloatArray:
        """Generalized covariance by lag, shape (size,)."""
        return autocovariance(self.terms, self.size, self.rate)

    @cached_property
    def spectrum(self) -> FloatArray:
        """Variance of the coefficients 1 to size - 1 of the orthonormal DCT-II, shape (size - 1,)."""
        k = np.arange(1, self.size, dtype=np.float64)
        noise = (t for t in self.terms if t.row.waveform is None)
        power = np.sum([t.power(self.rate) * t.sampled(self.rate).dct(k, self.size) for t in noise], axis=0)
        if not np.all(power > 0):
            raise UsageError("a covariance needs at least one noise term with a coefficient above zero")
        return np.asarray(power)

    @cached_property
    def _ring(self) -> FloatArray:
        """Transform of the circulant matrix in which C is embedded: real, because it is symmetric."""
        c = self.first_row
        length = scipy.fft.next_fast_len(2 * self.size - 1, real=True)
        return np.asarray(scipy.fft.rfft(np.concatenate((c, np.zeros(length - 2 * self.size + 1), c[:0:-1]))).real)

    def times(self, v: FloatArray) -> FloatArray:
        """C v, shape (size,); for a contrast defined up to a constant."""
        length = scipy.fft.next_fast_len(2 * self.size - 1, real=True)
        return np.asarray(scipy.fft.irfft(scipy.fft.rfft(v, length) * self._ring, length)[: self.size])

    def variance(self, v: FloatArray) -> float:
        """v'Cv: the variance of v'y, for a contrast v or, where all terms are stationary, any v."""
        if np.ptp(v) == 0:  # of a mean, by lags
            c, lag = self.first_row if v[0] else np.zeros(self.size), np.arange(1.0, self.size)
            return float(v[0]) ** 2 * float(self.size * c[0] + 2 * ((self.size - lag) @ c[1:]))
        return float(v @ self.times(v))

    def _precondition(self, r: FloatArray) -> FloatArray:
        c = scipy.fft.dct(r, norm="ortho")
        c[0] = 0.0
        c[1:] /= self.spectrum
        return np.asarray(scipy.fft.idct(c, norm="ortho", overwrite_x=True))

    def solve(self, b: FloatArray) -> FloatArray:
        """The contrast v with C v = b up to a constant, by preconditioned conjugate gradients; shape (size,).

        R. H. Chan, M. K. Ng, SIAM Review 38 (1996) 427.
        """
        # scipy's cg stops by the plain norm of the residual, in which a random walk hides the rest: it does not arrive
        v = np.zeros(self.size)
        r = b - b.mean()
        z = self._precondition(r)
        p, rho = z.copy(), float(r @ z)
        goal = PRECISION**2 * rho
        for _ in range(MAX_STEPS):
            if rho <= goal:
                return v
            q = self.times(p)
            q -= q.mean()
            step = rho / float(p @ q)
            v += step * p
            r -= step * q
            z = self._precondition(r)
            rho, last = float(r @ z), rho
            p = z + (rho / last) * p
        raise UsageError(
            f"the covariance of {', '.join(map(str, self.terms))} cannot be inverted at {self.size} samples"
        )
