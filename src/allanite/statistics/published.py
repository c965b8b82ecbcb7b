"""Equivalent degrees of freedom as published, for comparison with tables and other programs.

Each formula takes the exponent alpha of the spectrum of the rate, the averaging factor m and the number N of points of
the angle. A power law that a publication does not treat is a KeyError. `docs/published_formulas.md` has their errors:
the exact degrees of freedom of any model are `allanite.statistics.edf`.
"""

import math
from collections.abc import Callable, Mapping

import numpy as np

from allanite.core.arrays import FloatArray

MAX_LAGS = 100  # lags that are summed

TABLE_1 = {
    2: ((2 / 3, 1 / 3), (7 / 9, 1 / 2), (22 / 25, 2 / 3)), 1: ((0.840, 0.345), (0.997, 0.616), (1.141, 0.843)),
    0: ((1.079, 0.368), (1.033, 0.607), (1.184, 0.848)), -1: ((), (1.048, 0.534), (1.180, 0.816)),
    -2: ((), (1.302, 0.535), (1.175, 0.777)), -3: ((), (), (1.194, 0.703)), -4: ((), (), (1.489, 0.702)),
}  # fmt: skip
"""Coefficients of Greenhall and Riley's table 1, by alpha and order of the difference."""

TABLE_2 = {
    2: ((3 / 2, 1 / 2), (35 / 18, 1.0), (2.31, 1.5)), 1: ((78.6, 25.2), (790.0, 410.0), (9950.0, 6520.0)),
    0: ((2 / 3, 1 / 6), (2 / 3, 1 / 3), (7 / 9, 1 / 2)), -1: ((), (0.852, 0.375), (0.997, 0.617)),
    -2: ((), (1.079, 0.368), (1.033, 0.607)), -3: ((), (), (1.053, 0.553)), -4: ((), (), (1.302, 0.535)),
}  # fmt: skip
"""Those of table 2."""

TABLE_3 = ((6.0, 4.0), (15.23, 12.0), (47.8, 40.0))  # those of table 3, for alpha = 1


def _angle(t: FloatArray, alpha: int) -> FloatArray:
    """Generalized autocovariance of the angle, except for a factor."""
    t = np.abs(t)
    power = t ** (3 - alpha)
    sign = (-1.0) ** ((alpha + 1) // 2)
    return np.asarray(sign * (power if alpha % 2 == 0 else power * np.log(np.where(t > 0, t, 1.0))))


def _differences(t: FloatArray, F: float, law: tuple[int, int]) -> FloatArray:
    alpha, d = law
    terms = []
    for k in range(-d, d + 1):
        s = t + k
        if math.isinf(F):
            mean = _angle(s, alpha + 2)
        else:
            mean = F**2 * (2 * _angle(s, alpha) - _angle(s - 1 / F, alpha) - _angle(s + 1 / F, alpha))
        terms.append((-1.0) ** k * math.comb(2 * d, d + k) * mean)
    return np.asarray(np.sum(terms, axis=0))


def _summed(law: tuple[int, int], lags: int, windows: float, stride: float, F: float) -> float:
    j = np.arange(lags + 1.0)
    weight = np.where((j > 0) & (j < lags), 2.0, 1.0) * np.where(j > 0, 1 - j / windows, 1.0)
    return float(weight @ _differences(j / stride, F, law) ** 2)


def greenhall_riley(alpha: int, m: int, N: int, *, d: int, modified: bool = False, overlapped: bool = True) -> float:
    """That of differences of order d (2 Allan, 3 Hadamard); C. A. Greenhall & W. J. Riley, PTTI 2003."""
    law, S = (alpha, d), m if overlapped else 1
    table, F, mean = (TABLE_1, 1.0, m) if modified else (TABLE_2, float(m), 1)
    M = 1 + S * (N - mean - m * d) // m
    J, r = min(M, (d + 1) * S), M / S
    if not modified and alpha == 2:
        return _white_angle(M, r, d)
    a0, a1 = table[alpha][d - 1]
    if J <= MAX_LAGS:
        F = math.inf if not modified and alpha <= 0 and m * (d + 1) > MAX_LAGS else F
        return M * float(_differences(np.zeros(1), F, law)[0]) ** 2 / _summed(law, J, M, S, F)
    b0, b1 = TABLE_3[d - 1]
    head = (b0 + b1 * math.log(m)) ** 2 if not modified and alpha == 1 else 1.0
    if r >= d + 1:
        return r * head / (a0 - a1 / r)
    F = 1.0 if modified else MAX_LAGS / r if alpha == 1 else math.inf
    if head == 1.0:
        head = float(_differences(np.zeros(1), F, law)[0]) ** 2
    return MAX_LAGS * head / _summed(law, MAX_LAGS, MAX_LAGS, MAX_LAGS / r, F)


def _white_angle(M: int, r: float, d: int) -> float:
    K = math.ceil(r)
    if d >= K:
        tail = sum((1 - k / r) * math.comb(2 * d, d - k) ** 2 for k in range(1, K))
        return M / (1 + 2 / math.comb(2 * d, d) ** 2 * tail)
    a0, a1 = TABLE_2[2][d - 1]
    return M / (a0 - a1 / r)


def total(alpha: int, m: int, N: int) -> float:
    """That of totdev, tau up to half the record; NIST SP 1065 section 5.4.3."""
    b, c = {0: (1.50, 0.0), -1: (1.17, 0.22), -2: (0.93, 0.36)}[alpha]
    return b * (N - 1) / m - c


def modified_total(alpha: int, m: int, N: int) -> float:
    """That of mtotdev and ttotdev; D. A. Howe & F. Vernotte, PTTI 1999."""
    b, c = {2: (1.90, 2.10), 1: (1.20, 1.40), 0: (1.10, 1.20), -1: (0.85, 0.50), -2: (0.75, 0.31)}[alpha]
    return b * (N - 1) / m - c


def hadamard_total(alpha: int, m: int, N: int) -> float:
    """That of htotdev; D. A. Howe et al., PTTI 2000."""
    table: Mapping[int, tuple[float, float]] = {
        0: (0.559, 1.004), -1: (0.868, 1.140), -2: (0.938, 1.696), -3: (2.554, 0.974), -4: (3.149, 1.276),
    }  # fmt: skip
    b0, b1 = table[alpha]
    return (N - 1) / m / (b0 + b1 * m / (N - 1))


def theo1(alpha: int, m: int, N: int) -> float:
    """That of Theo1, and by convention of TheoBR; T. N. Tasset, D. A. Howe & D. B. Percival, FCS 2004."""
    t = 0.75 * m
    formulas: dict[int, Callable[[], float]] = {
        2: lambda: 0.86 * (N + 1) * (N - 4 * t / 3) / (N - t) * t / (t + 1.14),
        1: lambda: (4.798 * N**2 - 6.374 * N * t + 12.387 * t) / (math.sqrt(t + 36.6) * (N - t)) * t / (t + 0.3),
        0: lambda: ((4.1 * N + 0.8) / t - (3.1 * N + 6.5) / N) * t**1.5 / (t**1.5 + 5.2),
        -1: lambda: (2 * N**2 - 1.3 * N * t - 3.5 * t) / (N * t) * t**3 / (t**3 + 2.3),
        -2: lambda: (4.4 * N - 2) / (2.9 * t)
        * ((4.4 * N - 1) ** 2 - 8.6 * t * (4.4 * N - 1) + 11.4 * t**2) / (4.4 * N - 3) ** 2,
    }  # fmt: skip
    return formulas[alpha]()
