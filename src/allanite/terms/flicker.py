"""Bias instability: flicker rate noise; and flicker of the angle.

Its spectrum is 1 / (2 sin(pi f)) at f periods a sample (N. J. Kasdin, 1995): 1 / (2 pi f) far below the sampling rate,
so that it is to the angle what bias instability is to the rate.
"""

import math

import numpy as np

from allanite.phrases.phrase import say

from .row import FloatArray, NoiseTerm

LN2 = math.log(2.0)


def _flicker_structure(t: FloatArray) -> FloatArray:
    t = np.asarray(t, dtype=np.float64)
    return -(t * t) * np.log(np.where(t > 0, t, 1.0)) / math.pi


def _flicker_derivative(order: int, t: FloatArray) -> FloatArray:
    if order == 1:
        return -(2 * np.log(t) + 1) * t / math.pi
    if order == 2:
        return -(2 * np.log(t) + 3) / math.pi
    sign = 1 if order % 2 else -1
    return -2 * sign * math.factorial(order - 3) / t ** (order - 2) / math.pi


def _flicker_increments(h: FloatArray) -> FloatArray:
    near = np.minimum(h, 30.0)
    D = _flicker_structure
    direct = -0.5 * (6 * D(near) - 4 * D(np.abs(near - 1)) - 4 * D(near + 1) + D(np.abs(near - 2)) + D(near + 2))
    far = np.maximum(h, 30.0) ** -2.0
    # fourth difference of h^2 ln h in powers of 1/h: the direct form loses (h^4) digits
    series = -far * (2 + far * (2 + far * (3 + far * 17 / 3))) / (2 * math.pi)
    return np.where(h < 30, direct, series)


def _flicker_series(t: FloatArray) -> FloatArray:
    """Euler-Maclaurin series of the second sum of t^2 ln t."""
    log = np.log(t)
    powers = 1 / (3024 * t**2) - 1 / (14400 * t**4) + 4.5094e-5 / t**6
    return t**4 * (log / 12 - 7 / 144) - t * t * log / 12 + log / 120 + powers + ZETA3 / (4 * math.pi**2) * t


def _flicker_near() -> FloatArray:
    """The second sum at 0 .. 13: the recursion down from where the series is exact."""
    e = np.zeros(14)
    e[12:] = _flicker_series(np.array([12.0, 13.0]))
    for k in range(12, 0, -1):
        e[k - 1] = k * k * math.log(k) + 2 * e[k] - e[k + 1]
    return e


ZETA3 = 1.2020569031595942
_FLICKER_NEAR = _flicker_near()


def _flicker_summed(t: FloatArray) -> FloatArray:
    t = np.asarray(t, dtype=np.float64)
    near = (t < 12) & (t == np.floor(t))
    table = _FLICKER_NEAR[np.where(near, t, 0).astype(np.int64)]
    return -np.where(near, table, _flicker_series(np.where(near, 12.0, t))) / math.pi


FLICKER_EDGE = np.array([0.7737, 0.9028, 0.9311, 0.9499, 0.9592, 0.9664, 0.9709, 0.9747])


def _flicker_spectrum(f: FloatArray, tau0: float) -> FloatArray:
    from scipy.special import zeta

    x = np.asarray(f, dtype=np.float64) * tau0
    aliases = zeta(3, x) + zeta(3, 1 - x)
    return np.asarray(4 * tau0 * np.sin(math.pi * x) ** 2 * aliases / (2 * math.pi) ** 3)


def _flicker_dct(k: FloatArray, n: int) -> FloatArray:
    # the DCT-II nearly diagonalizes flicker: a factor of k alone, for any n (computed exactly for k <= 8)
    edge = np.where(k < 8.5, FLICKER_EDGE[np.clip(k, 1, 8).astype(np.int64) - 1],
                    1 - 2 / (math.pi**2 * np.maximum(k, 1)))  # fmt: skip
    return np.asarray(_flicker_spectrum(k / (2.0 * n), 1.0) * edge)


FLICKER = NoiseTerm(
    symbol="B", synonyms=("BI",), title=say("bias instability"),
    meaning=say("flicker (1/f) noise of the rate; the Allan deviation has a floor at 0.664 B"),
    quantity_title=say("flicker of the {quantity}"),
    quantity_meaning=say("flicker (1/f) noise; the Allan deviation has a floor at 0.664 B"),
    formula=r"\sigma^2(\tau) = (2 \ln 2 / \pi) B^2",
    reference="IEEE Std 952", power=0.0, slope=0.0, read_at=1.0, level=2 * LN2 / math.pi,
    structure=_flicker_structure, derivative=_flicker_derivative, summed=_flicker_summed,
    increments=_flicker_increments, spectrum=_flicker_spectrum, dct=_flicker_dct, dct_error=4e-3,
    density=r"S(f) = \frac{B^2}{2 \pi f}",
    origin="Flicker noise of electronics, of the discharge in a ring laser, and of systems with many relaxation times: "
    "a power spectral density that increases as 1/f towards low frequencies, so that every decade of time "
    "contributes as much bias drift as the one before.",
    advice="The flat part of the curve lies at 0.664 B. The minimum of the curve is not B: angle and rate random walk "
    "alone have a minimum, at sqrt(2 N K / sqrt(3)), without any flicker. It has no finite-dimensional state "
    "model; in a Kalman filter it is approximated by one or several Gauss-Markov processes.",
    typical=1.0, color="#146A4E", dark="#31C697", dash=(8, 2, 1.6, 2), alpha=-1, automatic=True, substitute="GM",
)  # fmt: skip

PANELS, NODES = np.array([0, 1, 2, 4, 6, 9, 13, 18, 25, 40.0]), 16
"""Panels of the integral over exp(-x), and nodes in each."""


def _structure(t: FloatArray) -> FloatArray:
    # at whole samples 4/pi (1 + 1/3 + ... + 1/(2t - 1))
    from scipy.special import digamma

    t = np.asarray(t, dtype=np.float64)
    return np.asarray(2 / math.pi * (digamma(t + 0.5) - digamma(0.5)))


def _derivative(order: int, t: FloatArray) -> FloatArray:
    from scipy.special import polygamma

    return np.asarray(2 / math.pi * polygamma(order, np.asarray(t) + 0.5))


def _second_sum(t: FloatArray) -> FloatArray:
    from scipy.special import digamma

    s = np.asarray(t, dtype=np.float64) + 1.5
    product = (s - 1) * (s - 2)
    return np.asarray(product / 2 * digamma(s) - product / 4 - s * (s - 1) / 2 - digamma(0.5) * (s - 1.5) ** 2 / 2)


def _summed(t: FloatArray) -> FloatArray:
    first, second = _second_sum(np.array([0.0, 1.0]))
    return np.asarray(2 / math.pi * (_second_sum(t) - first - (second - first) * np.asarray(t)))


def _increments(h: FloatArray) -> FloatArray:
    # -4/pi / (4 h^2 - 1) is the covariance of the rate
    h = np.asarray(h, dtype=np.float64)
    return np.asarray(4 / math.pi * (2 / (1 - 4 * h**2) - 1 / (1 - 4 * (h - 1) ** 2) - 1 / (1 - 4 * (h + 1) ** 2)))


def _dct(k: FloatArray, n: int) -> FloatArray:
    """Exactly: sums over h < n of the covariance with cosines, by partial fractions in 1 / (2h +- 1)."""
    k = np.asarray(k, dtype=np.float64)
    half = (0.5 * math.pi / n) * k
    turn = np.exp(1j * half)
    whole = 0.5 * np.log(np.abs(1 / np.tan(half / 2))) + 0.25j * math.pi  # artanh(turn)
    # the sum over h >= n of exp(i omega (h + 1/2 - n)) / (2h + 1), omega = 2 half, as an integral over exp(-x)
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    width = np.diff(PANELS) / 2
    x = (PANELS[:-1, None] + width[:, None] * (1 + nodes)).ravel()
    w = (width[:, None] * weights).ravel() * np.exp(-x) / (4 * n)
    tail = np.array([np.sum(w / np.sinh(x / (2 * n) - 1j * a)) for a in np.atleast_1d(half)]).reshape(np.shape(half))
    tail = tail * (1 - 2 * (k % 2))
    plus = (whole - turn - tail) / turn
    minus = (whole - tail - (1 - 2 * (k % 2)) / turn / (2 * n - 1)) * turn
    plain, weighted = 2 / math.pi * (plus - minus), -(plus + minus) / math.pi
    ends = weighted.real + plain.imag / np.sin(2 * half)
    return np.asarray(4 / math.pi + 2 * plain.real - 2 / n * ends)


ANGLE_FLICKER = NoiseTerm(
    symbol="F", title=say("flicker of the angle"),
    titles={"accelerometer": say("flicker of the velocity"), "dimensionless": say("flicker of the time")},
    meaning=say("flicker (1/f) noise of the angle; flicker phase noise of clocks"),
    quantity_title=say("flicker of the integrated {quantity}"),
    quantity_meaning=say("flicker (1/f) noise of the integral"),
    formula=r"\sigma^2(\tau) \approx (F^2 / \pi \tau^2) (3 \ln(\tau / \tau_0) + 5.20)",
    reference=say("NIST SP 1065; sampled as by N. J. Kasdin, Proc. IEEE 83 (1995) 802"),
    power=1.0, slope=-1.0, read_at=1.0, level=16 / (3 * math.pi), structure=_structure, derivative=_derivative,
    summed=_summed, increments=_increments, spectrum=lambda f, tau0: 2 / tau0 * np.sin(math.pi * f * tau0), dct=_dct,
    density=r"S(f) = \frac{2 F^2}{\tau_0} \sin(\pi f \tau_0) \approx 2 \pi f F^2",
    origin="1/f noise of what measures the angle: of the electronics of an encoder, of a phase detector, of the "
    "interpolation of a resolver; of amplifiers and dividers in clocks.",
    advice="Between quantization and angle random walk. In the Allan and Hadamard deviations its slope is nearly that "
    "of quantization, -1, from which the modified Allan deviation and the spectrum tell it. Its size depends on the "
    "bandwidth, here half the sampling rate. It is looked for when its symbol is among the terms that are asked for. "
    "It has no finite-dimensional state model; a filter takes quantization of a similar size in its place.",
    typical=0.5, color="#310698", dark="#F9F24A", dash=(4, 1.2), alpha=1, per_sample=True,
)  # fmt: skip
