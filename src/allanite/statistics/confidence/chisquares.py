"""Quantiles of a weighted sum of chi-squares by the saddlepoint of Lugannani and Rice.

V = sum_j w_j chi^2(d_j) + W has the cumulant function

    K(t) = c t / (1 - 2 u t) - sum_j d_j/2 ln(1 - 2 w_j t)

where W, of mean c, is what a deterministic part adds to squares of weight u (a noncentral chi-square).

At the saddlepoint t the value is x = K'(t), and with r = sign(t) sqrt(2 (t x - K)), v = t sqrt(K'')

    P(V < x) = Phi(r) + phi(r) (1/r - 1/v)

so that the quantile is found by one search over t.
"""

import math
from typing import NamedTuple

import numpy as np

from allanite.statistics.row import FloatArray

NEAR = 1e-4
"""|t| in standard deviations below which the limit at the mean is taken."""


BISECTIONS = 36
"""Steps to a quantile: to 1e-9 of it."""

NEWTON, STRIDE, START = 3, 4.0, 1e-6
"""Steps from one deviate to the next, the longest of them, and where the first begins."""


class ChiSquareSum(NamedTuple):
    """Weights and degrees of freedom, shape (k, j); mean and weight of the deterministic part, shape (k,)."""

    weight: FloatArray
    dof: FloatArray
    mean: FloatArray
    beside: FloatArray


def quantiles(mixture: ChiSquareSum, p: float) -> FloatArray:
    """The value below which V lies with probability p, shape (k,).

    Examples
    --------
    >>> one = ChiSquareSum(np.array([[0.1]]), np.array([[10.0]]), np.zeros(1), np.zeros(1))
    >>> quantiles(one, 0.975).round(2).item()  # chi-square with 10 degrees of freedom over 10: 2.0483
    2.05
    """
    top = _pole(mixture)
    low, high = np.full(top.shape, -40.0), np.full(top.shape, 40.0)
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        # from -infinity to the pole, t = top (1 - exp(-y))
        below = _probability(*_saddle(mixture, -top * np.expm1(-middle))[:3]) < p
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return _saddle(mixture, -top * np.expm1(-(low + high) / 2))[3]


def table(mixture: ChiSquareSum, deviates: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Values of V near normal deviates, which rise, and their exact deviates, shape (deviates, k) each.

    The saddlepoint is taken where its root r is the deviate, by Newton's steps from one to the next.
    """
    from scipy.special import ndtri

    top, found = _pole(mixture), []
    middle = int(np.abs(deviates).argmin())
    for way in (range(middle, -1, -1), range(middle + 1, deviates.size)):
        y = np.full(top.shape, START)
        for i in way:
            for _ in range(NEWTON):
                t = -top * np.expm1(-y)
                r, v, _, _ = _saddle(mixture, t)
                r = np.where(np.abs(v) < 0.01, v, r)  # where the difference t x - K loses its digits, they are alike
                slope = v**2 / (t * r) * (top - t)  # dr/dy = (t K'' / r) dt/dy, and v = t sqrt(K'')
                y = y + np.clip((deviates[i] - r) / np.maximum(slope, 1e-12), -STRIDE, STRIDE)
                y = np.where(np.abs(y) < START, START, y)
            r, v, skewness, x = _saddle(mixture, -top * np.expm1(-y))
            found.append((i, x, ndtri(_probability(r, v, skewness))))
    found.sort(key=lambda one: one[0])
    return np.array([x for _, x, _ in found]), np.array([z for _, _, z in found])


def _pole(mixture: ChiSquareSum) -> FloatArray:
    return np.asarray(1 / (2 * np.maximum(mixture.weight.max(axis=1), mixture.beside)))


def _probability(r: FloatArray, v: FloatArray, skewness: FloatArray) -> FloatArray:
    """P(V < x) at a saddlepoint."""
    from scipy.special import ndtr

    with np.errstate(divide="ignore", invalid="ignore"):
        probability = ndtr(r) + np.exp(-r * r / 2) / math.sqrt(2 * math.pi) * (1 / r - 1 / v)
    return np.where(np.abs(v) < NEAR, 0.5 + skewness / (6 * math.sqrt(2 * math.pi)), probability)


def _saddle(mixture: ChiSquareSum, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    K, x, K2, K3 = cumulants(mixture, t)
    r = np.sign(t) * np.sqrt(np.maximum(2 * (t * x - K), 0))
    return r, t * np.sqrt(K2), K3 / K2**1.5, x


def cumulants(mixture: ChiSquareSum, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """K and its first three derivatives at t, shape (k,) each."""
    weight, dof, c, u = mixture
    pole = 1 - 2 * u * t
    rest = 1 - 2 * weight * t[:, None]
    part = weight / rest
    K = c * t / pole - (dof * np.log(rest)).sum(axis=1) / 2
    K1 = c / pole**2 + (dof * part).sum(axis=1)
    K2 = 4 * c * u / pole**3 + 2 * (dof * part**2).sum(axis=1)
    K3 = 24 * c * u * u / pole**4 + 8 * (dof * part**3).sum(axis=1)
    return K, K1, K2, K3
