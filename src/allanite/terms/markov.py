"""Gauss-Markov noise: an exponentially correlated rate, averaged over each sample interval."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from allanite.core.language import say

from .row import Block, FloatArray, NoiseTerm, Parameter

SMALL = 0.05
"""t / T below which differences of exponentials are taken from their series."""

FORGOTTEN = 70.0
"""Interval over time constant above which neighbouring means know nothing of each other."""


def _rest(u: FloatArray, order: int) -> FloatArray:
    """exp(-u) without the first `order` terms of its series, without cancellation."""
    u = np.asarray(u, dtype=np.float64)
    k = np.arange(order, order + 9)
    factorials = np.array([math.factorial(i) for i in k])
    series = ((-np.minimum(u, SMALL * 4)[..., None]) ** k / factorials).sum(axis=-1)
    direct = np.exp(-u) - sum((-u) ** i / math.factorial(i) for i in range(order))
    return np.where(u < SMALL * 4, series, direct)


@dataclass(frozen=True)
class _Markov:
    """The functions of Gauss-Markov noise of RMS 1 with a time constant of T sample intervals."""

    T: float

    @cached_property
    def u(self) -> float:
        """One interval over the time constant."""
        return 1 / self.T

    @cached_property
    def loss(self) -> float:
        """1 - exp(-u)."""
        return -math.expm1(-self.u)

    @cached_property
    def variance(self) -> float:
        """Variance of a mean over one interval."""
        return 2 * self.T**2 * float(_rest(np.array(self.u), 2))

    @cached_property
    def neighbour(self) -> float:
        """Covariance of two neighbouring means."""
        return (self.loss * self.T) ** 2

    def structure(self, t: FloatArray) -> FloatArray:
        return np.asarray(2 * self.T**2 * _rest(np.asarray(t, dtype=np.float64) * self.u, 2))

    def derivative(self, order: int, t: FloatArray) -> FloatArray:
        if order == 1:
            return np.asarray(-2 * self.T * np.expm1(-t * self.u))
        return np.asarray(2 * self.T**2 * (-self.u) ** order * np.exp(-t * self.u))

    def summed(self, t: FloatArray) -> FloatArray:
        # second sum of 2T (t - T + T exp(-t/T)) without its constant and its square of t
        T, u, small = self.T, self.u, self.u < SMALL
        t = np.asarray(t, dtype=np.float64)
        excess = u**2 / 12 + u**4 / 360 + u**6 / 20160 if small else (2 * math.cosh(u) - 2) / u**2 - 1
        inverse = 1 / (u**2 * (1 + excess))  # of 2 cosh u - 2
        if small:
            linear = (u**2 * (1 / 120 - 1 / 72) + u**4 * (1 / 5040 - 1 / 2160)) / (1 + excess)
        else:
            linear = T * inverse * (math.sinh(u) - u) - 1 / 6
        return np.asarray(2 * T * (t**3 / 6 * excess / (1 + excess) + linear * t + T * inverse * _rest(t * u, 4)))

    def _covariance(self, h: FloatArray) -> FloatArray:
        beyond = self.neighbour * np.exp(-self.u * np.maximum(np.abs(h) - 1, 0))
        return np.where(h == 0, self.variance, beyond)

    def increments(self, h: FloatArray) -> FloatArray:
        h, C = np.asarray(h, dtype=np.float64), self._covariance
        near = 2 * C(h) - C(np.abs(h - 1)) - C(h + 1)
        return np.where(h < 2, near, -self.neighbour * self.loss**2 * np.exp(-self.u * np.maximum(h - 2, 0)))

    def spectrum(self, f: FloatArray, tau0: float) -> FloatArray:
        p, loss = math.exp(-self.u), self.loss
        s = np.sin(math.pi * tau0 * np.asarray(f, dtype=np.float64)) ** 2
        numerator = 2 * self.T * loss**2 + 4 * s * (p * self.variance - self.neighbour)
        return np.asarray(tau0 * numerator / (loss**2 + 4 * p * s))

    def dct(self, k: FloatArray, n: int) -> FloatArray:
        if self.u > FORGOTTEN:
            return np.full(np.shape(k), self.variance)
        scale = 2 * self.neighbour * math.exp(self.u)
        return np.asarray(self.variance + scale * _cosine_sum(np.asarray(k, dtype=np.float64), n, self.u))


def gauss_markov(T: float) -> NoiseTerm:
    """The row of Gauss-Markov rate noise, with a time constant of T sample intervals."""
    functions = _Markov(T)
    return NoiseTerm(
        symbol="GM",
        title=say("Gauss-Markov noise"),
        meaning=say("exponentially correlated (first-order Gauss-Markov) noise of the rate, with a time constant T"),
        formula=r"\sigma^2(\tau) = (2 s^2 T / \tau) (1 - (T / 2 \tau) (3 - 4 \exp(-\tau/T) + \exp(-2 \tau/T)))",
        reference=say("IEEE Std 952; s is the RMS rate, q = s sqrt(2/T) the driving noise"),
        power=0.0,
        slope=math.nan,
        read_at=math.nan,
        level=math.nan,
        structure=functions.structure,
        derivative=functions.derivative,
        summed=functions.summed,
        increments=functions.increments,
        spectrum=functions.spectrum,
        dct=functions.dct,
        parameters=(Parameter("time_constant", say("time constant"), "s", least=0.0, letter="T", typical=20.0),),
        shape=(T,),
        shaped=lambda shape, rate: gauss_markov(shape[0] * rate),
        density=r"S(f) = \frac{2 s^2 T}{1 + (2 \pi f T)^2}",
        origin="A single relaxation process: a temperature that follows its surroundings, a trapped charge, a filter "
        "at the output, a control loop. Sums of a few such processes with time constants a decade apart can "
        "hardly be distinguished from flicker.",
        advice="A hump: the Allan deviation increases with slope +1/2 up to tau = 1.89 T, where it is 0.617 s, and "
        "decreases with slope -1/2 beyond. Well below T it resembles a rate random walk with K = s sqrt(2/T), "
        "well above an angle random walk with N = s sqrt(2 T). In a Kalman filter it is a state with Phi = "
        "exp(-tau0/T) and the driving noise s^2 (1 - Phi^2). A flat top of the hump is not flicker: the "
        "likelihood distinguishes the two if the record permits.",
        color="#72780E",
        dark="#BBFD7A",
        dash=(8, 1.8, 1.4, 1.8, 1.4, 1.8),
        block=lambda size, shape, h: markov_block(size, shape[0], h),
    )


def markov_block(size: float, T: float, h: float) -> Block:
    """Gauss-Markov noise of RMS `size` and time constant `T`."""
    u = h / T
    loss = -math.expm1(-u)
    var_mean = size**2 * _mean_variance(u)
    Q = np.array([[-math.expm1(-2 * u) * size**2, size**2 * loss**2 / u], [size**2 * loss**2 / u, var_mean]])
    return Block(
        names=((say("Gauss-Markov rate, T = {time:.6g} s", time=T), 0),),
        F=np.array([[-1 / T]]),
        Qc=np.array([[2 * size**2 / T]]),
        Phi=np.array([[math.exp(-u)]]),
        mean=np.array([loss / u]),
        Q=Q,
        P0=np.array([[size**2]]),
        output=np.ones(1),
    )


def _mean_variance(u: float) -> float:
    """(2u - 3 + 4 exp(-u) - exp(-2u)) / u^2, without cancellation: what the noise within the interval adds."""
    if u > 0.3:
        return (2 * u - 3 + 4 * math.exp(-u) - math.exp(-2 * u)) / u**2
    return math.fsum((-1) ** k * (4 - 2.0**k) / math.factorial(k) * u ** (k - 2) for k in range(3, 20))


def _cosine_sum(k: FloatArray, n: int, u: float) -> FloatArray:
    """Sum over h = 1 .. n-1 of exp(-u h) A_k(h): what an exponential covariance gives the k-th DCT-II coefficient.

    A_k(h) = ((n - h) cos(omega h) - sin(omega h) / sin(omega)) / n, omega = pi k / n, summed as a geometric series.
    """
    omega = math.pi * k / n
    z = np.exp(-u + 1j * omega)
    rest = 2 * np.exp(-u / 2) * (np.sinh(u / 2) * np.cos(omega / 2) - 1j * np.cosh(u / 2) * np.sin(omega / 2))
    rest = rest * np.exp(1j * omega / 2)  # 1 - z
    last = math.exp(-u * n) * (1 - 2 * (k % 2))  # z^n
    plain = (z - last) / rest
    weighted = (z - n * last + (n - 1) * last * z) / rest**2
    return np.asarray(plain.real - weighted.real / n - plain.imag / (n * np.sin(omega)))


GAUSS_MARKOV = gauss_markov(1.0)
