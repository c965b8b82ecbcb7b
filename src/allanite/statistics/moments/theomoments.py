"""What is Theo1's own: its expectation in a few hundred nodes, and how white angle noise scatters it.

A window of m = 2M intervals holds the differences ``x_-M + x_M - x_-d - x_d``, d = M - v, of weight 1/v, v = 1..M.
"""

from functools import lru_cache

import numpy as np

from allanite.statistics.row import FloatArray
from allanite.terms import NoiseTerm

from .lags import lag_nodes


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
    """Ratio r of white angle noise with itself, for L = `count` windows.

    With n(l) = max(0, L - l) and w = 1/v, every pair of points of two windows that fall together counts n(l):

        T L^2 = 4 L H^2 + 2 n(2M) H^2 + 4 H sum_v w [n(2M - v) + n(v)] + sum_uv w w [2 n(2M - u - v) + 2 n(|u - v|)]
                + sum_v w^2 [4 n(2M - v) + 4 n(v) + 10 L] - 4 sum_{v <= M/2} n(v)/v^2

    except for a few pairs that fall together twice: below 0.5 % from M = 32.
    """
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
