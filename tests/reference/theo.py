"""Theo1, its form with the bias removed, and the hybrid, from the phase x_0 .. x_N."""

from tests.reference.allan import oadev
from tests.reference.terms import indices, mean, require


def theo1(x, m, tau0):
    """Theo1 at tau = 0.75 m tau0, m even, 2 <= m <= N.

    With h = m/2: 1/(0.75 (m tau0)^2) mean_i sum_{d=0}^{h-1} 1/(h-d) [(x_i - x_{i-d+h}) + (x_{i+m} - x_{i+d+h})]^2.
    D. A. Howe, T. K. Peppler, FCS 2003; NIST SP 1065 eq. 30, which prints it without the 0.75.
    """
    require(m % 2 == 0, "m is even")
    half = m // 2
    i = indices(len(x) - m)
    inner = sum(((x[i] - x[i - d + half]) + (x[i + m] - x[i + d + half])) ** 2 / (half - d) for d in range(half))
    return mean(inner) / (0.75 * (m * tau0) ** 2)


def kf(x, tau0, divisor=30):
    """The mean over i = 0 .. n of Allan (m = 9 + 3i) over Theo1 (m = 12 + 4i), variances at the same tau.

    n = floor(0.1 (N + 1) / 3 - 3), so divisor 30: D. A. Howe, Metrologia 43, 2006; J. A. Taylor, D. A. Howe, 2010.
    Stable32 divides by 6.
    """
    n = len(x) // divisor - 3
    require(n >= 0, f"{3 * divisor} points")
    return mean([oadev(x, 9 + 3 * i, tau0) / theo1(x, 12 + 4 * i, tau0) for i in range(n + 1)])


def theobr(x, m, tau0, divisor=30):
    """Theo1 times kf. Howe 2006."""
    return kf(x, tau0, divisor) * theo1(x, m, tau0)


def theoh(x, m, tau0, divisor=30):
    """Overlapped Allan up to the largest m <= 0.2 N, TheoBR at taus longer than that. Howe 2006; NIST SP 1065 5.2.17.

    m is that of the statistic which makes the point: m <= 0.2 N for Allan, 0.75 m > floor(0.2 N) for TheoBR.
    """
    join = (len(x) - 1) // 5
    if m <= join:
        return oadev(x, m, tau0)
    require(3 * m > 4 * join, "a tau beyond the join")
    return theobr(x, m, tau0, divisor)
