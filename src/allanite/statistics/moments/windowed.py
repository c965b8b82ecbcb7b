"""Moments of the statistics over windows (Theo1, modified and Hadamard total, parabolic), and the total deviation."""

# Derivation: docs/derivations.md.

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.statistics.row import Sharp, Statistic
from allanite.terms import NoiseTerm

from . import folded
from .compact import (
    Compact,
    averaged,
    compact,
    expectation,
    extrapolation,
    lattice,
    mean_weights,
    products,
    ratios,
    sampled,
    white_level,
)
from .lagsums import lag_nodes


@lru_cache(maxsize=256)
def _nodes(end: int, bends: frozenset[int] = frozenset()) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights of a sum over v = 1 .. end: with kinks at 1, 2, 4, ... they follow 1/v to ten digits."""
    powers = {1 << k for k in range(end.bit_length())}
    kinks = powers | {end} | {k for k in bends if 1 <= k <= end}
    return lag_nodes([float(k) for k in sorted(kinks)], float(end))


def theo_response(term: NoiseTerm, m: int) -> float:
    """E of a window of m intervals: sum over v of [2D(v) + 2D(m - v) - D(m) - D(m - 2v)]/v."""
    v, weight = _nodes(m // 2)
    D = term.structure
    return float(weight / v @ (2 * D(v) + 2 * D(m - v) - D(np.full_like(v, m)) - D(m - 2 * v)))


def harmonic(m: int) -> float:
    """H_M + 1/(2M), M = m/2: a quarter of E for white angle noise."""
    return float(_sum_of_inverses(np.array(m / 2))) + 1 / m


def _sum_of_inverses(k: FloatArray) -> FloatArray:
    """1 + 1/2 + ... + 1/k."""
    from scipy.special import digamma

    return np.asarray(digamma(k + 1) + np.euler_gamma)


def white_ratio(m: int, count: int) -> float:
    """Ratio r of white angle noise with itself, for L = `count` windows."""
    # With n(l) = max(0, L - l) and w = 1/v, every pair of points of two windows that fall together counts n(l):
    #     T L^2 = 4 L H^2 + 2 n(2M) H^2 + 4 H sum_v w [n(2M - v) + n(v)] + sum_uv w w [2 n(2M - u - v) + 2 n(|u - v|)]
    #             + sum_v w^2 [4 n(2M - v) + 4 n(v) + 10 L] - 4 sum_{v <= M/2} n(v)/v^2
    # except for a few pairs that fall together twice: below 0.5 % from M = 32.
    M, L = m // 2, float(count)
    H = _sum_of_inverses

    def n(lag: FloatArray) -> FloatArray:
        return np.maximum(L - lag, 0.0)

    v, weight = _nodes(M, frozenset((count, 2 * M - count, M - count, M // 2)))
    whole = float(H(np.array(float(M))))
    below, above = np.maximum(v - L, 0.0), np.minimum(v + L, M)
    # sum over u of n(|u - v|)/u and of n(2M - u - v)/u, as sums of 1/u and of 1
    near = (L - v) * (H(v) - H(below)) + (v - below) + (L + v) * (H(above) - H(v)) - (above - v)
    start = np.clip(2 * M - L - v, 0.0, M)
    across = (L - 2 * M + v) * (whole - H(start)) + (M - start)
    single = float(weight / v @ (n(2 * M - v) + n(v)))
    double = float(weight / v @ (2 * across + 2 * near))
    square = float(weight / v**2 @ (4 * n(2 * M - v) + 4 * n(v) + 10 * L - 4 * n(v) * (v <= M // 2)))
    total = 4 * L * whole**2 + 2 * float(n(np.array(2.0 * M))) * whole**2 + 4 * whole * single + double + square
    return total / (L * 4 * harmonic(m)) ** 2


EXACT = (32, 48, 64)
"""Averaging factors, for even m, of the windows that the expectation of a longer one is extrapolated from."""


def response(row: Statistic, terms: Sequence[NoiseTerm], m: int, size: int) -> FloatArray:
    """Expected variance of each term for a sample interval of 1, shape (t,), without the factor tau^(2 power)."""
    # For the total deviation, or a row with a `window` that is no difference; `size` matters to the former alone.
    if row.window is None:
        return folded.response(row, terms, m, size)
    scheme = row.scheme
    if scheme.response is not None:
        return np.array([scheme.response(term, m) for term in terms]) / _norm(row, m) / float(m) ** 2
    levels = [k + m % 2 for k in EXACT] if m > EXACT[-1] else [m]
    D = sampled if scheme.sharp else averaged
    values = []
    for level in levels:
        mean = mean_weights(row.window, level)
        values.append([expectation(mean, D(term, level / m)) / _norm(row, level) for term in terms])
    return np.asarray(extrapolation(levels, m, 1) @ np.array(values)) / float(m) ** 2


def _norm(row: Statistic, m: int) -> float:
    return float(row.norm(np.array([m]))[0])


def relative(row: Statistic, terms: Sequence[NoiseTerm], m: int, count: int, size: int) -> FloatArray:
    """r_ij = T_ij / (E_i E_j), shape (t, t): 1/EDF = p r p with p the terms' shares of the expected variance."""
    # `count` windows in one run without a gap; the total deviation has none but the whole record.
    if row.window is None:
        return folded.relative(terms, m, size)
    scheme = row.scheme
    levels = [k + m % 2 for k in scheme.levels] if m > scheme.levels[-1] else [m]
    parts = []
    for level in levels:
        window = compact(row.window, row.order, level)
        parts.append(ratios(*products(window, terms, row.order, level / m, count), terms))
    r = np.asarray(np.tensordot(extrapolation(levels, m, scheme.power), parts, 1))
    if scheme.sharp is None or len(levels) == 1:
        return r
    for i, term in enumerate(terms):
        if white_level(term):
            r[i] = r[:, i] = _sharp_ratios(row, scheme.sharp, terms, m, count)
            if scheme.sharp.itself is not None:
                r[i, i] = scheme.sharp.itself(m, count)
    return r


def _sharp_ratios(row: Statistic, rule: Sharp, terms: Sequence[NoiseTerm], m: int, count: int) -> FloatArray:
    """Ratios of white angle noise with every term where the points of a window meet it one by one, shape (t,)."""
    # White angle noise is correlated only where a point of one window falls on a point of the other: its ratios fall as
    # 1/(m scale(m)). Peaks at the first and the last lag, where ends meet ends, are extrapolated for themselves.
    first, last, smooth = [], [], []
    levels = [k + m % 2 for k in rule.levels]
    for level in levels:
        window = compact(row.window, row.order, level)
        r = rule.scale(level) * _lag_ratios(window, terms, level / m)
        first.append(r[:, 0] - (2 * r[:, 1] - r[:, 2]))
        last.append(r[:, -1] - (2 * r[:, -2] - r[:, -3]))
        r[:, 0] -= first[-1]
        r[:, -1] -= last[-1]
        lag, weight = lattice(window.points, level / m, count)
        smooth.append([np.interp(lag, np.arange(window.points), k, right=0.0) @ weight * level for k in r])
    weights = extrapolation(levels, m, 1)
    ends = weights @ first / count + 2 * max(count - row.span[0] * m, 0) / count**2 * (weights @ last)
    return np.asarray((ends + weights @ smooth / m) / rule.scale(m))


def _lag_ratios(window: Compact, terms: Sequence[NoiseTerm], step: float) -> FloatArray:
    """Covariances of white angle noise times those of each term over both expectations, shape (t, lags)."""
    distance = np.abs(np.arange(window.points)[:, None] + np.arange(1.0 - window.points, window.points))
    white = -2 * window.mean[window.points - 1]
    r = np.zeros((len(terms), window.points))
    for i, term in enumerate(terms):
        D = sampled(term, step)
        E = expectation(window.mean, D)
        if E:
            r[i] = np.sum(window.white * D(distance), axis=1) / (white * E)
    return r
