"""Expectation, covariance and degrees of freedom of a statistic, from its differences and the terms' D(t).

Everything is linear or bilinear in D: with w the binomial weights of the difference of order q,

    E[V]      = -1/2 sum_ab w_a w_b D(|a - b| tau) / (norm tau^2)
    C(h)      = -1/2 (-1)^q delta_m1^q delta_m2^q D(h)     covariance of two differences whose centres are h apart
    Var[V]    = 2 sum_h n(h) (C_n(h)^2 + 2 C_n(h) C_d(h)) / (norm^2 tau^4 M^2)

where C_n is the part of the noise and C_d that of deterministic terms (a ramp), whose square is no variance.
"""

import math
from collections.abc import Callable
from functools import cache

import numpy as np

from allanite.curve import Law
from allanite.model import Model
from allanite.record import Record
from allanite.terms import NoiseTerm

from .lags import lag_nodes
from .row import FloatArray, IntArray, Statistic

FAR = 40
"""A difference of D over m at a lag beyond FAR m is taken from derivatives: there it would lose its digits."""

TAIL = 1000
"""Half widths of the windows beyond which only flicker is left, with less than 1e-10 of the sum."""


def expectation(row: Statistic, structure: Callable[[FloatArray], FloatArray], tau: FloatArray) -> FloatArray:
    """Expected variance at `tau` (s, shape (k,)) of a process with structure function `structure`."""
    weights = _binomial(row.order)
    total = np.zeros_like(tau)
    for lag in range(1, row.order + 1):
        total -= float(weights[lag:] @ weights[: weights.size - lag]) * structure(lag * tau)
    return total / (row.norm(np.ones(1, np.int64)) * tau**2)


def edf(row: Statistic, model: Model, m: IntArray, size: int, rate: float) -> FloatArray:
    """Equivalent degrees of freedom 2 E^2 / Var at averaging factors `m`, for a record of `size` intervals.

    Exact for the model's mixture but for the quadrature, 1e-7.
    """
    return np.array([1 / _relative_variance(row, model, int(k), size, rate) for k in m])


def covariance(row: Statistic, model: Model, m: IntArray, size: int, rate: float) -> FloatArray:
    """Covariance between the variances at averaging factors `m` of one record, SI, shape (k, k); overlapped rows."""
    result = np.empty((m.size, m.size))
    for i, j in np.ndindex(result.shape):
        if i <= j:
            small, large = sorted((int(m[i]), int(m[j])))
            T, _ = _products(row, model, (small, large), size)
            powers = _sample_coefficients(model, rate)
            scale = np.prod(row.norm(np.array([small, large]))) * (small * large / rate**2) ** 2
            result[i, j] = result[j, i] = 2 * powers @ T @ powers / scale
    return result


def law(row: Statistic, model: Model, record: Record, m: IntArray) -> Law:
    """The confidence law of a curve: chi-square with the exact degrees of freedom; computed when first asked."""

    @cache
    def degrees() -> FloatArray:
        return edf(row, model, m, record.size, record.rate)

    def limits(level: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        from scipy.special import gammaincinv

        e = degrees()
        low, high = (e / (2 * gammaincinv(e / 2, p)) for p in ((1 + level) / 2, (1 - level) / 2))
        return e, low, high

    return limits


def _binomial(order: int) -> FloatArray:
    return np.array([(-1.0) ** k * math.comb(order, k) for k in range(order + 1)])


def _sample_coefficients(model: Model, rate: float) -> FloatArray:
    """Squared coefficients that go with D in units of the sample interval (x in SI)."""
    return np.array([t.value**2 * rate ** (2 * t.row.power - 2) for t in model])


def _relative_variance(row: Statistic, model: Model, m: int, size: int, rate: float) -> float:
    """Half the relative variance, 1/EDF = sum p_i p_j r_ij with p the shares of the expectation."""
    T, E = _products(row, model, (m, m), size)
    powers = _sample_coefficients(model, rate)
    return float(powers @ T @ powers / (powers @ E) ** 2)


def _products(row: Statistic, model: Model, m: tuple[int, int], size: int) -> tuple[FloatArray, FloatArray]:
    """T_ij = sum_h n(h) C_i C_j / (M1 M2) without the deterministic squares, and E_i = C_i(0) for equal m."""
    M1, M2 = (int(k) for k in row.count(size, np.array(m)))
    h, weight = (_overlapped_lags if row.overlapped else _strided_lags)(row, m, (M1, M2))
    pairs = np.minimum(min(M1, M2), (M1 + M2) / 2 - h / (1 if row.overlapped else m[0]))
    weight = weight * pairs / (float(M1) * M2) * np.where(h > 0, 2.0, 1.0)
    C = np.array([_lag_covariance(t.row, row.order, m, h) for t in model])
    T = (C * weight) @ C.T
    deterministic = np.array([t.row.waveform is not None for t in model])
    T[np.outer(deterministic, deterministic)] = 0.0
    return T, C[:, 0]


def _overlapped_lags(row: Statistic, m: tuple[int, int], M: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
    half = row.order / 2
    steps = np.arange(-half, half + 1)
    end = min(sum(M) / 2 - 1, math.floor(TAIL * half * sum(m)))
    offset = 0.5 * (row.order * (m[1] - m[0]) % 2)
    where = {abs(a * m[0] + b * m[1]) for a in steps for b in steps} | {abs(M[0] - M[1]) / 2, offset}
    return lag_nodes(sorted(k for k in where if offset <= k <= end), end + offset if end % 1 != offset else end)


def _strided_lags(row: Statistic, m: tuple[int, int], M: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
    """Windows that start every m samples: the lags are few, and beyond 60 windows nothing is left."""
    h = m[0] * np.arange(min(M[0], 61), dtype=np.float64)
    return h, np.ones_like(h)


def _lag_covariance(term: NoiseTerm, order: int, m: tuple[int, int], h: FloatArray) -> FloatArray:
    """C(h) of a term of coefficient 1, in units of the sample interval, m[0] <= m[1], h >= 0."""
    reach = order * (m[0] + m[1]) / 2
    near = h <= 20 * reach
    C = np.empty_like(h)
    C[near] = _differences(term, order, m, h[near])
    C[~near] = _far_field(term, order, m, h[~near])
    return (-0.5 if order % 2 == 0 else 0.5) * C


def _differences(term: NoiseTerm, order: int, m: tuple[int, int], h: FloatArray) -> FloatArray:
    total = np.zeros_like(h)
    for k, weight in enumerate(_binomial(order)):
        total += weight * _one_difference(term, order, m[0], h + (order / 2 - k) * m[1])
    return total


def _one_difference(term: NoiseTerm, order: int, m: int, t: FloatArray) -> FloatArray:
    """Central difference of D(|t|) over m."""
    far = np.abs(t) > FAR * m
    result = np.zeros_like(t)
    for k, weight in enumerate(_binomial(order)):
        result[~far] += weight * term.structure(np.abs(t[~far] + (order / 2 - k) * m))
    if far.any():
        c1 = order / 24
        c2 = c1**2 / 2 - order / 2880
        c3 = c1**3 / 6 - c1 * order / 2880 + order / 181440
        t_ = np.abs(t[far])
        series = sum(
            c * float(m) ** (2 * i) * term.derivative(order + 2 * i, t_) for i, c in enumerate((1, c1, c2, c3))
        )
        result[far] = float(m) ** order * np.sign(t[far]) ** order * series
    return result


def _far_field(term: NoiseTerm, order: int, m: tuple[int, int], h: FloatArray) -> FloatArray:
    a, b = float(m[0]), float(m[1])
    A = order * (a**2 + b**2) / 24
    B = order * (a**4 + b**4) / 2880
    C = order * (a**6 + b**6) / 181440
    weights = (1.0, A, A**2 / 2 - B, A**3 / 6 - A * B + C)
    series = sum(w * term.derivative(2 * order + 2 * i, h) for i, w in enumerate(weights))
    return (a * b) ** order * np.asarray(series)
