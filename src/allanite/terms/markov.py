"""Gauss-Markov noise: an exponentially correlated rate, averaged over each sample interval."""

import math

import numpy as np

from .row import FloatArray, NoiseTerm, Parameter

SMALL = 0.05
"""t / T below which differences of exponentials are taken from their series."""


def _rest(u: FloatArray, order: int) -> FloatArray:
    """exp(-u) without the first `order` terms of its series, without cancellation."""
    u = np.asarray(u, dtype=np.float64)
    k = np.arange(order, order + 9)
    factorials = np.array([math.factorial(i) for i in k])
    series = ((-np.minimum(u, SMALL * 4)[..., None]) ** k / factorials).sum(axis=-1)
    direct = np.exp(-u) - sum((-u) ** i / math.factorial(i) for i in range(order))
    return np.where(u < SMALL * 4, series, direct)


def _shape(u: float) -> tuple[float, float, float, float]:
    """For u = 1/T: exp(-u), the variance of a mean over one interval, its covariance with the next, 1 - exp(-u)."""
    loss = -math.expm1(-u)
    return math.exp(-u), 2 * float(_rest(np.array(u), 2)) / u**2, (loss / u) ** 2, loss


def gauss_markov(T: float) -> NoiseTerm:
    """The row of Gauss-Markov noise of the rate, with a time constant of T sample intervals."""
    u = 1 / T
    p, variance, neighbour, loss = _shape(u)

    def structure(t: FloatArray) -> FloatArray:
        return np.asarray(2 * T * T * _rest(np.asarray(t, dtype=np.float64) * u, 2))

    def derivative(order: int, t: FloatArray) -> FloatArray:
        if order == 1:
            return np.asarray(-2 * T * np.expm1(-t * u))
        return np.asarray(2 * T * T * (-u) ** order * np.exp(-t * u))

    def summed(t: FloatArray) -> FloatArray:
        # second sum of 2T (t - T + T exp(-t/T)), without even powers of t up to the fourth, which third differences
        # of the sums remove, and without the cancellation that they would bring
        t = np.asarray(t, dtype=np.float64)
        excess = u**2 / 12 + u**4 / 360 + u**6 / 20160 if u < SMALL else (2 * math.cosh(u) - 2) / u**2 - 1
        inverse = 1 / (u**2 * (1 + excess))  # of 2 cosh u - 2
        if u < SMALL:
            linear = (u**2 * (1 / 120 - 1 / 72) + u**4 * (1 / 5040 - 1 / 2160)) / (1 + excess)
        else:
            linear = T * inverse * (math.sinh(u) - u) - 1 / 6
        return np.asarray(2 * T * (t**3 / 6 * excess / (1 + excess) + linear * t + T * inverse * _rest(t * u, 5)))

    def covariance(h: FloatArray) -> FloatArray:
        return np.where(h == 0, variance, neighbour * np.exp(-u * np.maximum(np.abs(h) - 1, 0)))

    def increments(h: FloatArray) -> FloatArray:
        h = np.asarray(h, dtype=np.float64)
        near = 2 * covariance(h) - covariance(np.abs(h - 1)) - covariance(h + 1)
        return np.where(h < 2, near, -neighbour * loss**2 * np.exp(-u * np.maximum(h - 2, 0)))

    def spectrum(f: FloatArray, tau0: float) -> FloatArray:
        s = np.sin(math.pi * tau0 * np.asarray(f, dtype=np.float64)) ** 2
        numerator = 2 * T * loss**2 + 4 * s * (p * variance - T * T * loss**2)
        return np.asarray(tau0 * numerator / (loss**2 + 4 * p * s))

    def dct(k: FloatArray, n: int) -> FloatArray:
        if p < 1e-30:  # one interval has forgotten the one before
            return np.full(np.shape(k), variance)
        return variance + 2 * neighbour / p * _cosine_sum(np.asarray(k, dtype=np.float64), n, u)

    return NoiseTerm(
        symbol="GM",
        title="Gauss-Markov noise",
        meaning="noise of the rate that forgets itself exponentially, with a time constant T",
        formula=r"\sigma^2(\tau) = (2 s^2 T / \tau) (1 - (T / 2 \tau) (3 - 4 e^{-\tau/T} + e^{-2 \tau/T}))",
        reference="IEEE Std 952; s is the effective value of the rate, q = s sqrt(2/T) its driving noise",
        power=0.0,
        slope=math.nan,
        read_at=math.nan,
        level=math.nan,
        structure=structure,
        derivative=derivative,
        summed=summed,
        increments=increments,
        spectrum=spectrum,
        dct=dct,
        parameters=(Parameter("time_constant", "s", least=0.0),),
        shape=(T,),
        shaped=lambda shape, rate: gauss_markov(shape[0] * rate),
        density=r"S(f) = \frac{2 s^2 T}{1 + (2 \pi f T)^2}",
        origin="One relaxation: a temperature that follows its surroundings, a trapped charge, a filter in front of "
        "the output, a control loop. Sums of a few such processes with time constants a decade apart are hardly told "
        "from flicker.",
        advice="A hump: the Allan deviation rises with slope +1/2 up to tau = 1.89 T, where it is 0.617 s, and falls "
        "with slope -1/2 beyond. Well below T it looks like a rate random walk with K = s sqrt(2/T), well above like "
        "an angle random walk with N = s sqrt(2 T). A Kalman filter takes it as a state with "
        "Phi = exp(-tau0/T) and the driving noise s^2 (1 - Phi^2). Do not call it flicker because the top of the hump "
        "is flat: the ranking of both by the likelihood tells them apart where the record can.",
    )


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
