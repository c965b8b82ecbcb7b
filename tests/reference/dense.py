"""Moments of a statistic from full matrices: E = tr(A G), T_ij = tr(A G_i A G_j), A as the definition writes it."""

import numpy as np


def quadratic_form(row, m, n):
    """A with ``variance = x' A x`` for n intervals of length 1, shape (n + 1, n + 1)."""
    A = np.zeros((n + 1, n + 1))
    count = int(row.count(n, np.array([m]))[0])
    if row.window is None:
        for c in total_rows(m, n):
            A += np.outer(c, c)
    else:
        weights, filters = row.window(m)
        window = (filters.T * weights) @ filters
        for i in range(count):
            A[i : i + len(window), i : i + len(window)] += window
    return A / (count * float(row.norm(np.array([m]))[0]) * m**2)


def ramp_weights(row, m, n):
    """A x for the ramp x of n intervals, window by window, each less the line through its ends, which it removes."""
    x = np.arange(n + 1.0) ** 2 / 2
    count = int(row.count(n, np.array([m]))[0])
    weights, filters = row.window(m)
    points, v = filters.shape[1], np.zeros(n + 1)
    for i in range(count):
        part = x[i : i + points] - np.linspace(x[i], x[i + points - 1], points)
        v[i : i + points] += (weights * (filters @ part)) @ filters
    return v / (count * float(row.norm(np.array([m]))[0]) * m**2)


def total_rows(m, n):
    """Weights of x*_{i-m} - 2 x*_i + x*_{i+m}, i = 1..n-1, with x*_{-j} = 2 x_0 - x_j, x*_{n+j} = 2 x_n - x_{n-j}."""
    for i in range(1, n):
        c = np.zeros(n + 1)
        c[i] -= 2
        for j in (i - m, i + m):
            end = 0 if j < 0 else n
            if 0 <= j <= n:
                c[j] += 1
            else:
                c[end] += 2
                c[2 * end - j] -= 1
        yield c


def moments(A, terms):
    """Expected variance of each term, (t,), and r_ij = T_ij/(E_i E_j), (t, t), 0 for two deterministic terms."""
    n = A.shape[0] - 1
    lag = np.abs(np.subtract.outer(np.arange(n + 1.0), np.arange(n + 1.0)))
    products, summands = [], []
    for term in terms:
        G = -0.5 * term.structure(lag)
        if term.waveform is not None:
            x = np.concatenate(([0.0], np.cumsum(term.waveform(n))))
            G = np.outer(x, x)
        products.append(A @ G)
        summands.append(np.sum(np.abs(A * G)))
    E = np.array([np.trace(P) for P in products])
    T = np.array([[np.sum(P * Q.T) for Q in products] for P in products])
    deterministic = np.array([term.waveform is not None for term in terms])
    T[np.outer(deterministic, deterministic)] = 0.0
    # the Hadamard rows remove a ramp, but for what rounding leaves
    E[np.abs(E) < 1e-13 * np.array(summands)] = 0.0
    scale = np.outer(E, E)
    return E, np.divide(T, scale, out=np.zeros_like(T), where=scale != 0)


def covariance(forms, terms, powers):
    """Covariance of the quadratic forms x'Ax of Gaussian noise beside what is deterministic, shape (k, k).

    2 tr(A G B G) + 4 mu'A G B mu, with x of mean mu; `powers` are the squares of the coefficients.
    """
    n = forms[0].shape[0] - 1
    lag = np.abs(np.subtract.outer(np.arange(n + 1.0), np.arange(n + 1.0)))
    G, mean = np.zeros((n + 1, n + 1)), np.zeros(n + 1)
    for term, power in zip(terms, powers, strict=True):
        if term.waveform is None:
            G -= 0.5 * power * term.structure(lag)
        else:
            mean += np.sqrt(power) * np.concatenate(([0.0], np.cumsum(term.waveform(n))))
    products = [A @ G for A in forms]
    return np.array([[2 * np.sum(P * Q.T) + 4 * mean @ P @ B @ mean for Q, B in zip(products, forms, strict=True)]
                     for P in products])  # fmt: skip
