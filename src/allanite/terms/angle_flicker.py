"""Flicker of the angle (flicker phase noise of clocks), as a sampled process.

Its spectrum is 1 / (2 sin(pi f)) at f periods a sample (N. J. Kasdin, 1995): 1 / (2 pi f) far below the sampling rate,
so that it is to the angle what bias instability is to the rate.
"""

import math

import numpy as np

from allanite.phrases.phrase import say

from .row import FloatArray, NoiseTerm

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
    symbol="F",
    title=say("flicker of the angle"),
    titles={"accelerometer": say("flicker of the velocity"), "dimensionless": say("flicker of the time")},
    meaning=say("flicker (1/f) noise of the angle; flicker phase noise of clocks"),
    quantity_title=say("flicker of the integrated {quantity}"),
    quantity_meaning=say("flicker (1/f) noise of the integral"),
    formula=r"\sigma^2(\tau) \approx (F^2 / \pi \tau^2) (3 \ln(\tau / \tau_0) + 5.20)",
    reference=say("NIST SP 1065; sampled as by N. J. Kasdin, Proc. IEEE 83 (1995) 802"),
    power=1.0,
    slope=-1.0,
    read_at=1.0,
    level=16 / (3 * math.pi),
    structure=_structure,
    derivative=_derivative,
    summed=_summed,
    increments=_increments,
    spectrum=lambda f, tau0: 2 / tau0 * np.sin(math.pi * f * tau0),
    dct=_dct,
    density=r"S(f) = \frac{2 F^2}{\tau_0} \sin(\pi f \tau_0) \approx 2 \pi f F^2",
    origin="1/f noise of what measures the angle: of the electronics of an encoder, of a phase detector, of the "
    "interpolation of a resolver; of amplifiers and dividers in clocks.",
    advice="Between quantization and angle random walk. In the Allan and Hadamard deviations its slope is nearly that "
    "of quantization, -1, from which the modified Allan deviation and the spectrum tell it. Its size depends on the "
    "bandwidth, here half the sampling rate. It is looked for when its symbol is among the terms that are asked for. "
    "It has no finite-dimensional state model; a filter takes quantization of a similar size in its place.",
    typical=0.5,
    color="#310698",
    dark="#F9F24A",
    dash=(4, 1.2),
    alpha=1,
    per_sample=True,
)
