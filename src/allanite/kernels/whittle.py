"""The binned Whittle likelihood and its minimum over non-negative theta; see `allanite.noise.likelihood`.

`data` is (S, power, count, UU, Uc, W, flat) as of a `Likelihood`, all float64 and contiguous but for the boolean flat.
"""

import math

import numpy as np
from numba import njit

FAST = {"reassoc", "nsz", "contract"}
NOTHING = 1e-250
SMALLEST_STEP = 1e-4
CONVERGED = 1e-7
ITERATIONS = 200
ALIKE = 1 - 1e-11


@njit(cache=True, nogil=True, fastmath=FAST)
def expectation(S, theta):  # type: ignore[no-untyped-def]
    """M = S theta, shape (bins,)."""
    m = np.zeros(S.shape[0])
    for j in range(theta.size):
        if theta[j] != 0.0:
            column = S[:, j]
            for i in range(m.size):
                m[i] += theta[j] * column[i]
    return m


@njit(cache=True, nogil=True, fastmath=FAST)
def _normal_matrix(m, UU, Uc):  # type: ignore[no-untyped-def]
    """U' M^-1 U and U' M^-1 c."""
    r = Uc.shape[1]
    G, b = np.zeros((r, r)), np.zeros(r)
    for i in range(m.size):
        inverse = 1.0 / m[i]
        for j in range(r):
            b[j] += inverse * Uc[i, j]
            for k in range(r):
                G[j, k] += inverse * UU[i, j, k]
    return G, b


@njit(cache=True, nogil=True)
def directions(m, theta, data):  # type: ignore[no-untyped-def]
    """Estimates eta of the directions, their covariance V, and their part of 2 L."""
    _, _, _, UU, Uc, W, flat = data
    G, b = _normal_matrix(m, UU, Uc)
    part = 0.0
    for j in range(flat.size):
        if not flat[j]:
            # a direction without variance gets a precision beyond all others: its eta and V vanish, its part of L too
            precision = 1.0 / max(np.dot(W[j], theta), NOTHING)
            G[j, j] += precision
            part -= math.log(precision)
    V = np.ascontiguousarray(np.linalg.inv(G))
    eta = V @ b
    root = np.linalg.cholesky(G)
    for j in range(flat.size):
        part += 2 * math.log(root[j, j])
    return eta, V, part - np.dot(b, eta)


@njit(cache=True, nogil=True, fastmath=FAST)
def _plain(m, power, count):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(m.size):
        total += count[i] * (math.log(m[i]) + power[i] / m[i])
    return total


@njit(cache=True, nogil=True)
def value(theta, data):  # type: ignore[no-untyped-def]
    """L; infinite where the expectation is not positive."""
    m = expectation(data[0], theta)
    if not m.min() > 0:
        return np.inf
    return 0.5 * (_plain(m, data[1], data[2]) + directions(m, theta, data)[2])


@njit(cache=True, nogil=True)
def _estimates(m, data):  # type: ignore[no-untyped-def]
    """Each finite direction's estimate and error variance, the flat ones unknown; finite ones are orthogonal."""
    flat = data[6]
    A, b = _normal_matrix(m, data[3], data[4])
    finite, loose = np.flatnonzero(~flat), np.flatnonzero(flat)
    precision, moment = np.empty(finite.size), np.empty(finite.size)
    B, d = np.empty((loose.size, loose.size)), np.empty(loose.size)
    for i in range(loose.size):
        d[i] = b[loose[i]]
        for j in range(loose.size):
            B[i, j] = A[loose[i], loose[j]]
    inverse = np.ascontiguousarray(np.linalg.inv(B)) if loose.size else B
    for i in range(finite.size):
        row = np.empty(loose.size)
        for j in range(loose.size):
            row[j] = A[finite[i], loose[j]]
        share = inverse @ row
        precision[i] = A[finite[i], finite[i]] - np.dot(share, row)
        moment[i] = b[finite[i]] - np.dot(share, d)
    return moment / precision, 1.0 / precision


@njit(cache=True, nogil=True)
def completed(theta, data):  # type: ignore[no-untyped-def]
    """Power, expectation, the part of it that is not the terms', and count: of the bins and then of the directions."""
    S, power, count, UU, Uc, W, flat = data
    m = expectation(S, theta)
    eta, V, _ = directions(m, theta, data)
    estimate, error = _estimates(m, data)
    n, extra, r = m.size, error.size, flat.size
    result = np.zeros((4, n + extra))
    for i in range(n):
        more = 0.0
        for j in range(r):
            more -= 2 * Uc[i, j] * eta[j]
            for k in range(r):
                more += UU[i, j, k] * (eta[j] * eta[k] + V[j, k])
        result[0, i] = power[i] + more / count[i]
        result[1, i] = m[i]
        result[3, i] = count[i]
    at = n
    for j in range(r):
        if not flat[j]:
            result[0, at] = estimate[at - n] ** 2
            result[1, at] = np.dot(W[j], theta) + error[at - n]
            result[2, at] = error[at - n]
            result[3, at] = 1.0
            at += 1
    return result


@njit(cache=True, nogil=True)
def _solve(G, c, passive):  # type: ignore[no-untyped-def]
    """G x = c on the passive set, zero elsewhere."""
    which = np.flatnonzero(passive)
    A, b = np.empty((which.size, which.size)), np.empty(which.size)
    for i in range(which.size):
        b[i] = c[which[i]]
        for j in range(which.size):
            A[i, j] = G[which[i], which[j]]
    x = np.zeros(c.size)
    x[which] = np.linalg.solve(A, b)
    return x


@njit(cache=True, nogil=True)
def _pass_over(slope, G, passive):  # type: ignore[no-untyped-def]
    """Leave out columns that are one of those in use but for their size."""
    for j in range(slope.size):
        for k in np.flatnonzero(passive):
            if G[j, k] > ALIKE:
                slope[j] = -np.inf


@njit(cache=True, nogil=True)
def _nnls(G, c):  # type: ignore[no-untyped-def]
    """Minimum of x'Gx/2 - c'x over x >= 0, for a G with unit diagonal (Lawson and Hanson; Bro and de Jong)."""
    q = c.size
    x, passive = np.zeros(q), np.zeros(q, dtype=np.bool_)
    for _ in range(10 * q):
        slope = c - G @ x
        slope[passive] = -np.inf
        _pass_over(slope, G, passive)
        best = np.argmax(slope)
        if passive.all() or slope[best] <= 1e-12 * np.abs(c).max():
            return x
        passive[best] = True
        while True:
            wanted = _solve(G, c, passive)
            step, leaving = 1.0, -1
            for j in range(q):
                if passive[j] and wanted[j] <= 0:
                    ratio = x[j] / (x[j] - wanted[j]) if x[j] > 0 else 0.0
                    if ratio < step:
                        step, leaving = ratio, j
            x = x + step * (wanted - x)
            if leaving < 0:
                break
            passive[leaving] = False
            x[~passive] = 0.0
            if not passive.any():
                break
    return x


@njit(cache=True, nogil=True, fastmath=FAST)
def weighted_nnls(S, power, weight, moving):  # type: ignore[no-untyped-def]
    """Non-negative least squares of weight (power - S theta) over the moving columns, columns normalised."""
    which = np.flatnonzero(moving)
    q = which.size
    X = np.empty((q, S.shape[0]))
    size = np.empty(q)
    for a in range(q):
        column = S[:, which[a]]
        row = X[a]
        total = 0.0
        for i in range(row.size):
            row[i] = weight[i] * column[i]
            total += row[i] * row[i]
        size[a] = math.sqrt(total)
        for i in range(row.size):
            row[i] /= size[a]
    G, c = np.empty((q, q)), np.zeros(q)
    for a in range(q):
        row = X[a]
        for i in range(row.size):
            c[a] += row[i] * weight[i] * power[i]
        for b in range(a + 1):
            other = X[b]
            total = 0.0
            for i in range(row.size):
                total += row[i] * other[i]
            G[a, b] = G[b, a] = total
    return _nnls(G, c) / size


@njit(cache=True, nogil=True)
def minimise(theta, moving, columns, data):  # type: ignore[no-untyped-def]
    """Theta at the least L and that L: Fisher scoring from `theta` with step halving, only the moving ones >= 0 move.

    `columns` are S of the bins and W of the finite directions, shape (bins + finite directions, p).
    """
    best = value(theta, data)
    for _ in range(ITERATIONS):
        power, m, rest, count = completed(theta, data)
        held = np.where(moving, 0.0, theta)
        target = theta.copy()
        target[moving] = weighted_nnls(columns, power - rest - expectation(columns, held), np.sqrt(count) / m, moving)
        step, found = 1.0, np.inf
        while step > SMALLEST_STEP:
            trial = theta + step * (target - theta)
            found = value(trial, data)
            if found <= best:
                break
            step /= 2
        if step <= SMALLEST_STEP:
            return theta, best
        theta = trial
        if best - found < CONVERGED:
            return theta, found
        best = found
    return theta, best
