"""Equivalent degrees of freedom as published, in literal lines. N is the number of points of the angle everywhere."""

import math

GR_TABLE_1 = {2: ((2 / 3, 1 / 3), (7 / 9, 1 / 2), (22 / 25, 2 / 3)),
              1: ((0.840, 0.345), (0.997, 0.616), (1.141, 0.843)), 0: ((1.079, 0.368), (1.033, 0.607), (1.184, 0.848)),
              -1: (None, (1.048, 0.534), (1.180, 0.816)), -2: (None, (1.302, 0.535), (1.175, 0.777)),
              -3: (None, None, (1.194, 0.703)), -4: (None, None, (1.489, 0.702))}  # fmt: skip
GR_TABLE_2 = {2: ((3 / 2, 1 / 2), (35 / 18, 1), (231 / 100, 3 / 2)),
              1: ((78.6, 25.2), (790.0, 410.0), (9950.0, 6520.0)), 0: ((2 / 3, 1 / 6), (2 / 3, 1 / 3), (7 / 9, 1 / 2)),
              -1: (None, (0.852, 0.375), (0.997, 0.617)), -2: (None, (1.079, 0.368), (1.033, 0.607)),
              -3: (None, None, (1.053, 0.553)), -4: (None, None, (1.302, 0.535))}  # fmt: skip
GR_TABLE_3 = ((6.0, 4.0), (15.23, 12.0), (47.8, 40.0))
J_MAX = 100


def s_w(t, alpha):
    t = abs(t)
    if t == 0:
        return 0.0
    return {
        2: -t, 1: t**2 * math.log(t), 0: t**3, -1: -(t**4) * math.log(t), -2: -(t**5), -3: t**6 * math.log(t), -4: t**7,
    }[alpha]  # fmt: skip


def s_x(t, F, alpha):
    if math.isinf(F):
        return s_w(t, alpha + 2)
    return F**2 * (2 * s_w(t, alpha) - s_w(t - 1 / F, alpha) - s_w(t + 1 / F, alpha))


def s_z(t, F, alpha, d):
    return sum((-1) ** k * math.comb(2 * d, d + k) * s_x(t + k, F, alpha) for k in range(-d, d + 1))


def basic_sum(J, M, S, F, law):
    total = s_z(0, F, *law) ** 2 + (1 - J / M) * s_z(J / S, F, *law) ** 2
    return total + 2 * sum((1 - j / M) * s_z(j / S, F, *law) ** 2 for j in range(1, J))


def greenhall_riley(alpha, d, m, N, *, modified=False, overlapped=True):
    """C. A. Greenhall & W. J. Riley, Uncertainty of stability variances based on finite differences, PTTI 2003.

    d is 1, 2, 3 for first, Allan, Hadamard differences.
    """
    assert alpha + 2 * d > 1, "the variance does not exist"
    F = 1 if modified else m
    S = m if overlapped else 1
    L = m // F + m * d
    assert N >= L, "the record is too short"
    M = 1 + S * (N - L) // m
    J = min(M, (d + 1) * S)
    r = M / S
    law = (alpha, d)
    if F == 1:
        return by_regime(J, M, S, law, (GR_TABLE_1, 1, 1, 1, s_z(0, 1, *law) ** 2))
    if alpha <= 0:
        near = m if m * (d + 1) <= J_MAX else math.inf
        return by_regime(J, M, S, law, (GR_TABLE_2, near, math.inf, 1, s_z(0, math.inf, *law) ** 2))
    if alpha == 1:
        b0, b1 = GR_TABLE_3[d - 1]
        head = (b0 + b1 * math.log(m)) ** 2
        return by_regime(J, M, S, law, (GR_TABLE_2, m, J_MAX / r, head, head))
    return white_angle(M, r, d)


def by_regime(J, M, S, law, case):
    """Cases 1 to 3: the sum while it is short, its fit, or the sum thinned out to J_MAX lags."""
    alpha, d = law
    table, near, far, scale, head = case
    r = M / S
    if J <= J_MAX:
        return M * s_z(0, near, *law) ** 2 / basic_sum(J, M, S, near, law)
    if r >= d + 1:
        a0, a1 = table[alpha][d - 1]
        return r * scale / (a0 - a1 / r)
    return J_MAX * head / basic_sum(J_MAX, J_MAX, J_MAX / r, far, law)


def white_angle(M, r, d):
    """Case 4: alpha = 2, not modified, m > 1."""
    K = math.ceil(r)
    if d >= K:
        tail = sum((1 - k / r) * math.comb(2 * d, d - k) ** 2 for k in range(1, K))
        return M / (1 + 2 / math.comb(2 * d, d) ** 2 * tail)
    a0, a1 = GR_TABLE_2[2][d - 1]
    return M / (a0 - a1 / r)


def overlapped_allan(alpha, m, N):
    """D. A. Howe, D. W. Allan & J. A. Barnes, 1981; NIST SP 1065 table 5."""
    if alpha == 2:
        return (N + 1) * (N - 2 * m) / (2 * (N - m))
    if alpha == 1:
        return math.exp(math.sqrt(math.log((N - 1) / (2 * m)) * math.log((2 * m + 1) * (N - 1) / 4)))
    if alpha == 0:
        return (3 * (N - 1) / (2 * m) - 2 * (N - 2) / N) * 4 * m**2 / (4 * m**2 + 5)
    if alpha == -1:
        return 2 * (N - 2) ** 2 / (2.3 * N - 4.9) if m == 1 else 5 * N**2 / (4 * m * (N + 3 * m))
    assert alpha == -2, "no closed form"
    return (N - 2) / m * ((N - 1) ** 2 - 3 * m * (N - 1) + 4 * m**2) / (N - 3) ** 2


def total(alpha, m, N):
    """NIST SP 1065; tau up to half the record."""
    b, c = {0: (1.50, 0.0), -1: (1.17, 0.22), -2: (0.93, 0.36)}[alpha]
    return b * (N - 1) / m - c


def modified_total(alpha, m, N):
    """D. A. Howe & F. Vernotte, PTTI 1999; NIST SP 1065."""
    table = {2: (1.90, 2.10), 1: (1.20, 1.40), 0: (1.10, 1.20), -1: (0.85, 0.50), -2: (0.75, 0.31)}
    b, c = table[alpha]
    return b * (N - 1) / m - c


def hadamard_total(alpha, m, N):
    """D. A. Howe et al., PTTI 2000; NIST SP 1065."""
    table = {0: (0.559, 1.004), -1: (0.868, 1.140), -2: (0.938, 1.696), -3: (2.554, 0.974), -4: (3.149, 1.276)}
    b0, b1 = table[alpha]
    return (N - 1) / m / (b0 + b1 * m / (N - 1))


def theo1(alpha, m, N):
    """T. N. Tasset, D. A. Howe & D. B. Percival, FCS 2004; NIST SP 1065. t = 0.75 m."""
    t = 0.75 * m
    if alpha == 2:
        return 0.86 * (N + 1) * (N - 4 * t / 3) / (N - t) * t / (t + 1.14)
    if alpha == 1:
        return (4.798 * N**2 - 6.374 * N * t + 12.387 * t) / (math.sqrt(t + 36.6) * (N - t)) * t / (t + 0.3)
    if alpha == 0:
        return ((4.1 * N + 0.8) / t - (3.1 * N + 6.5) / N) * t**1.5 / (t**1.5 + 5.2)
    if alpha == -1:
        return (2 * N**2 - 1.3 * N * t - 3.5 * t) / (N * t) * t**3 / (t**3 + 2.3)
    assert alpha == -2, "no closed form"
    return (4.4 * N - 2) / (2.9 * t) * ((4.4 * N - 1) ** 2 - 8.6 * t * (4.4 * N - 1) + 11.4 * t**2) / (4.4 * N - 3) ** 2
