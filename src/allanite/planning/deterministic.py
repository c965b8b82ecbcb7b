"""How accurate a ramp and a warm-up can be beside known noise."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.model import Model, Term
from allanite.identification.checks.whitening import deviations
from allanite.identification.likelihood.spectrum import SINGLE
from allanite.prepare.gaps import whole
from allanite.terms import NoiseTerm, ramp_coefficients

TIME_STEP = 1.001
"""Factor on the time constant by which the waveform is differentiated."""

MIXING_NODES = 200
"""Nodes of Gauss's rule for the covariance of two coefficients."""

LOWEST = SINGLE
"""Coefficients of the cosine transform that tell of a ramp, whose power falls as k^-4."""


def ramp_error(noise: Sequence[Term], n: int, rate: float, edge: float) -> float:
    """Standard error of a ramp beside known noise and an unknown bias, in the unit of the rate per sample.

    `edge` is the variance of what quantization does at both ends of the record, as far as higher coefficients leave it.
    """
    k = np.arange(1.0, min(LOWEST, n - 1) + 1)
    end = np.sqrt(2 / n) * np.cos(np.pi / (2 * n) * k) * (k % 2)  # the odd half of both ends
    covariance = edge * np.outer(end, end)
    for t in noise:
        row = t.sampled(rate)
        covariance += t.power(rate) * (np.diag(row.dct(k, n)) + mixing(row, k.size, n))
    size, ramp = np.sqrt(np.diag(covariance)), ramp_coefficients(k, n)
    return float((ramp / size @ np.linalg.solve(covariance / np.outer(size, size), ramp / size)) ** -0.5)


def mixing(row: NoiseTerm, block: int, n: int) -> FloatArray:
    """Covariance of the coefficients 1 .. block of n rates, except for its diagonal, shape (block, block).

    With c(h) = D''(h) / 2 the covariance of rates, ``2 n int_0^1 A_kl(u) c(n u) du`` for k, l of equal parity, where

        A_kl(u) = (2 / pi) (k sin(pi k u) - l sin(pi l u)) / (l^2 - k^2)

    is the correlation of the two cosines at the distance u. It is zero for white noise and for random walks.
    """
    v, weight = np.polynomial.legendre.leggauss(MIXING_NODES)
    v, weight = (v + 1) / 2, weight / 2
    u = v**2  # a logarithm at u = 0 becomes smooth
    k = np.arange(1.0, block + 1)
    waves = k * (np.sin(math.pi * np.outer(u, k)).T @ (2 * v * weight * row.derivative(2, n * u)))
    apart = k[None, :] ** 2 - k[:, None] ** 2
    both = (np.subtract.outer(k, k) % 2 == 0) & (apart != 0)
    return np.where(both, n * 2 / math.pi * (waves[:, None] - waves[None, :]) / np.where(both, apart, 1.0), 0.0)


def transient_errors(t: Term, noise: Sequence[Term], n: int, rate: float) -> tuple[float, ...]:
    """Relative standard errors of size and time constant beside known noise and an unknown bias."""
    from scipy.fft import dct

    at, deviation = deviations(Model(tuple(noise)), whole(n), rate)
    scale = np.interp(np.arange(1.0, n), at, deviation)

    def seen(factor: float) -> FloatArray:
        wave = replace(t, shape=(t.shape[0] * factor,)).sampled(rate).waveform
        assert wave is not None  # noqa: S101 - a warm-up has one
        return np.asarray(t.value * dct(wave(n), norm="ortho")[1:] / scale)

    slopes = np.stack((seen(1.0), (seen(TIME_STEP) - seen(1 / TIME_STEP)) / (2 * math.log(TIME_STEP))))
    information = slopes @ slopes.T
    if not np.linalg.det(information) > 0:
        return math.inf, math.inf
    size, time = np.sqrt(np.diag(np.linalg.inv(information))).tolist()
    return size, time
