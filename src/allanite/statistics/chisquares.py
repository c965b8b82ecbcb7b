"""Quantiles of a weighted sum of chi-squares by the saddlepoint of Lugannani and Rice.

V = shift + sigma Z + sum_j w_j chi^2(d_j) has the cumulant function

    K(t) = shift t + sigma^2 t^2 / 2 - sum_j d_j/2 ln(1 - 2 w_j t)

At the saddlepoint t the value is x = K'(t), and with r = sign(t) sqrt(2 (t x - K)), v = t sqrt(K'')

    P(V < x) = Phi(r) + phi(r) (1/r - 1/v)

so that the quantile is found by one search over t.
"""

import math
from typing import NamedTuple

import numpy as np

from .row import FloatArray

NEAR = 1e-4
"""|t| in standard deviations below which the limit at the mean is taken."""


class Mixture(NamedTuple):
    """Weights and degrees of freedom, shape (k, j); shift and variance of a normal part, shape (k,)."""

    weight: FloatArray
    dof: FloatArray
    shift: FloatArray
    sigma2: FloatArray


def quantiles(mixture: Mixture, p: float) -> FloatArray:
    """The value below which V lies with probability p, shape (k,).

    Examples
    --------
    >>> one = Mixture(np.array([[0.1]]), np.array([[10.0]]), np.zeros(1), np.zeros(1))
    >>> round(quantiles(one, 0.975)[0], 2)  # chi-square with 10 degrees of freedom over 10: 2.0483
    2.05
    """
    from scipy.special import ndtr

    top = 1 / (2 * mixture.weight.max(axis=1))
    low, high = np.full(top.shape, -40.0), np.full(top.shape, 40.0)
    for _ in range(60):
        middle = (low + high) / 2
        # from -infinity to the pole, t = top (1 - exp(-y))
        t = -top * np.expm1(-middle)
        r, v, skewness, _ = _saddle(mixture, t)
        with np.errstate(divide="ignore", invalid="ignore"):
            probability = ndtr(r) + np.exp(-r * r / 2) / math.sqrt(2 * math.pi) * (1 / r - 1 / v)
        probability = np.where(np.abs(v) < NEAR, 0.5 + skewness / (6 * math.sqrt(2 * math.pi)), probability)
        below = probability < p
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return _saddle(mixture, -top * np.expm1(-(low + high) / 2))[3]


def _saddle(mixture: Mixture, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    weight, dof, shift, sigma2 = mixture
    rest = 1 - 2 * weight * t[:, None]
    part = weight / rest
    x = shift + sigma2 * t + (dof * part).sum(axis=1)
    K = shift * t + sigma2 * t * t / 2 - (dof * np.log(rest)).sum(axis=1) / 2
    K2 = sigma2 + 2 * (dof * part**2).sum(axis=1)
    K3 = 8 * (dof * part**3).sum(axis=1)
    r = np.sign(t) * np.sqrt(np.maximum(2 * (t * x - K), 0))
    return r, t * np.sqrt(K2), K3 / K2**1.5, x
