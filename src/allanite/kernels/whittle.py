"""The binned Whittle likelihood and its minimum over non-negative theta; see `identification.likelihood.likelihood`.

`columns` are S of the bins and then W of the finite directions, shape (p, bins + finite directions): times theta they
make `m`, the expected power of the bins and the variances of the directions. `data` is (power, count, UU, Uc) with the
bins along the last axis, the directions of any size before the finite ones. All is float64 and contiguous.
"""

import math

import numpy as np
from numba import njit

FAST = {"reassoc", "nsz", "contract"}
SWIFT = {"cache": True, "nogil": True, "error_model": "numpy", "fastmath": FAST}
NOTHING = 1e-250
ROUNDING = 1e-15
SMALLEST_STEP = 1e-4
FASTEST = 0.95
CONVERGED = 1e-7
ITERATIONS = 200
ALIKE = 1 - 1e-11
ROOT_HALF = 0x3FE6A09E667F3BCD  # the bits of sqrt(1/2)
SMALLEST = 2.3e-308


@njit(**SWIFT)
def _dot(a, b):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@njit(**SWIFT)
def _add(total, factor, row):  # type: ignore[no-untyped-def]
    for i in range(total.size):
        total[i] += factor * row[i]


@njit(**SWIFT)
def expectation(columns, theta):  # type: ignore[no-untyped-def]
    """M, shape (bins + finite directions,)."""
    m = np.zeros(columns.shape[1])
    for j in range(theta.size):
        if theta[j] != 0.0:
            _add(m, theta[j], columns[j])
    return m


@njit(**SWIFT)
def _cholesky(G):  # type: ignore[no-untyped-def]
    """Put the lower root of G in its place; of a pivot at least its rounding is left."""
    for j in range(G.shape[0]):
        pivot = G[j, j]
        for k in range(j):
            for i in range(k):
                G[j, k] -= G[j, i] * G[k, i]
            G[j, k] /= G[k, k]
            pivot -= G[j, k] * G[j, k]
        G[j, j] = math.sqrt(max(pivot, ROUNDING * G[j, j]))


@njit(**SWIFT)
def _forward(root, b):  # type: ignore[no-untyped-def]
    """Put root^-1 b in the place of b."""
    for j in range(b.size):
        for i in range(j):
            b[j] -= root[j, i] * b[i]
        b[j] /= root[j, j]


@njit(**SWIFT)
def _backward(root, b):  # type: ignore[no-untyped-def]
    """Put root'^-1 b in the place of b."""
    for j in range(b.size - 1, -1, -1):
        for i in range(j + 1, b.size):
            b[j] -= root[i, j] * b[i]
        b[j] /= root[j, j]


@njit(**SWIFT)
def _normal_matrix(m, UU, Uc):  # type: ignore[no-untyped-def]
    """Lower half of U' M^-1 U, and U' M^-1 c."""
    r, n = Uc.shape
    G, b, inverse = np.zeros((r, r)), np.empty(r), np.empty(n)
    for i in range(n):
        inverse[i] = 1.0 / m[i]
    for j in range(r):
        b[j] = _dot(inverse, Uc[j])
        for k in range(j + 1):
            G[j, k] = _dot(inverse, UU[j, k])
    return G, b


@njit(**SWIFT)
def _directions(m, data):  # type: ignore[no-untyped-def]
    """Root of V^-1, that times eta, each finite direction's own estimate and error variance, their part of 2 L.

    The estimate of a finite direction leaves those of any size unknown, and knows nothing of its variance.
    """
    G, b = _normal_matrix(m, data[2], data[3])
    r, n = data[3].shape
    loose = r - (m.size - n)
    own = np.empty((2, r - loose))
    part = 0.0
    for j in range(loose, r):
        own[0, j - loose], own[1, j - loose] = b[j], G[j, j]
        # a direction without variance gets a precision beyond all others: its eta and V vanish, its part of L too
        precision = 1.0 / max(m[n + j - loose], NOTHING)
        G[j, j] += precision
        part -= math.log(precision)
    _cholesky(G)
    _forward(G, b)
    for j in range(r):
        part += 2 * math.log(G[j, j]) - b[j] * b[j]
    for j in range(loose, r):
        for i in range(loose):
            own[0, j - loose] -= G[j, i] * b[i]
            own[1, j - loose] -= G[j, i] * G[j, i]
        own[0, j - loose] /= own[1, j - loose]
        own[1, j - loose] = 1 / own[1, j - loose]
    return G, b, own, part


@njit(**SWIFT)
def _solved(root, b):  # type: ignore[no-untyped-def]
    """Eta and V."""
    eta, V = b.copy(), np.eye(b.size)
    _backward(root, eta)
    for row in V:
        _forward(root, row)
        _backward(root, row)
    return eta, V


@njit(**SWIFT)
def directions(theta, columns, data):  # type: ignore[no-untyped-def]
    """Estimates eta of the directions, their covariance V, and their part of 2 L."""
    root, b, _, part = _directions(expectation(columns, theta), data)
    eta, V = _solved(root, b)
    return eta, V, part


@njit(**SWIFT)
def _logarithms(x):  # type: ignore[no-untyped-def]
    """Ln x for positive normal x, several at a time: x = 2^e f with f within sqrt(2) of 1, ln f by artanh's series."""
    bits, rest, result = x.view(np.int64), np.empty(x.size, np.int64), np.empty(x.size)
    f = rest.view(np.float64)
    for i in range(x.size):
        e = (bits[i] - ROOT_HALF) >> 52
        rest[i] = bits[i] - (e << 52)
        result[i] = e * math.log(2.0)
    for i in range(x.size):
        s = (f[i] - 1) / (f[i] + 1)
        t = s * s
        p = ((((t / 21 + 1 / 19) * t + 1 / 17) * t + 1 / 15) * t + 1 / 13) * t + 1 / 11
        p = ((((p * t + 1 / 9) * t + 1 / 7) * t + 1 / 5) * t + 1 / 3) * t + 1
        result[i] += 2 * s * p
    return result


@njit(**SWIFT)
def _plain(m, power, count):  # type: ignore[no-untyped-def]
    """2 L of the bins alone; infinite where the expectation is not positive."""
    n = power.size
    positive = 0
    for i in range(n):
        positive += m[i] > SMALLEST
    if positive < n:
        return np.inf
    logarithm, total = _logarithms(m[:n]), 0.0
    for i in range(n):
        total += count[i] * (logarithm[i] + power[i] / m[i])
    return total


@njit(**SWIFT)
def _evaluated(theta, columns, data):  # type: ignore[no-untyped-def]
    """L, infinite where the expectation is not positive; m and what `_directions` found."""
    m = expectation(columns, theta)
    plain = _plain(m, data[0], data[1])
    found = _directions(m, data)
    return (0.5 * (plain + found[3]) if plain < np.inf else np.inf), m, found


@njit(**SWIFT)
def value(theta, columns, data):  # type: ignore[no-untyped-def]
    """L; infinite where the expectation is not positive."""
    return _evaluated(theta, columns, data)[0]


@njit(**SWIFT)
def _completed(m, found, data):  # type: ignore[no-untyped-def]
    power, count, UU, Uc = data
    root, b, own, _ = found
    eta, V = _solved(root, b)
    n, more = power.size, np.zeros(power.size)
    for j in range(eta.size):
        _add(more, -2 * eta[j], Uc[j])
        for k in range(j + 1):
            _add(more, (eta[j] * eta[k] + V[j, k]) * (1.0 if k == j else 2.0), UU[j, k])
    full, rest, weight = np.empty(m.size), np.zeros(m.size), np.ones(m.size)
    for i in range(n):
        full[i], weight[i] = power[i] + more[i] / count[i], count[i]
    full[n:], rest[n:] = own[0] ** 2, own[1]
    return full, m + rest, rest, weight


@njit(**SWIFT)
def completed(theta, columns, data):  # type: ignore[no-untyped-def]
    """Power, expectation, the part of it that is not the terms', and count: of the bins and then of the directions."""
    _, m, found = _evaluated(theta, columns, data)
    return _completed(m, found, data)


@njit(**SWIFT)
def _solve(G, c, passive):  # type: ignore[no-untyped-def]
    """G x = c on the passive set, zero elsewhere."""
    q = c.size
    A, x = np.zeros((q, q)), np.zeros(q)
    for i in range(q):
        A[i, i] = 1.0
        if passive[i]:
            x[i] = c[i]
            for j in range(i):
                A[i, j] = G[i, j] if passive[j] else 0.0
    _cholesky(A)
    _forward(A, x)
    _backward(A, x)
    return x


@njit(**SWIFT)
def _steepest(G, c, x, passive):  # type: ignore[no-untyped-def]
    """The column not in use along which the sum of squares falls fastest, -1 if there is none."""
    best, most = -1, 1e-12 * np.abs(c).max()
    for j in range(c.size):
        slope = c[j] - _dot(G[j], x)
        if not passive[j] and slope > most and not _taken(G, j, passive):
            best, most = j, slope
    return best


@njit(**SWIFT)
def _taken(G, j, passive):  # type: ignore[no-untyped-def]
    """Whether a column is another one in use but for its size."""
    for k in range(passive.size):
        if passive[k] and k != j and G[j, k] > ALIKE:
            return True
    return False


@njit(**SWIFT)
def _nnls(G, c, x):  # type: ignore[no-untyped-def]
    """Minimum of x'Gx/2 - c'x over x >= 0, for a G with unit diagonal, in the place of a first x.

    By Lawson and Hanson, and Bro and de Jong; what is positive in the first x is in use from the beginning.
    """
    q = c.size
    passive = x > 0
    for j in range(q):
        if passive[j] and _taken(G, j, passive):
            passive[j], x[j] = False, 0.0
    for _ in range(10 * q):
        while passive.any():
            wanted = _solve(G, c, passive)
            step, leaving = 1.0, -1
            for j in range(q):
                if passive[j] and wanted[j] <= 0:
                    ratio = x[j] / (x[j] - wanted[j]) if x[j] > 0 else 0.0
                    if ratio < step:
                        step, leaving = ratio, j
            for j in range(q):
                x[j] += step * (wanted[j] - x[j])
            if leaving < 0:
                break
            passive[leaving], x[leaving] = False, 0.0
        best = _steepest(G, c, x, passive)
        if best < 0:
            break
        passive[best] = True


@njit(**SWIFT)
def weighted_nnls(columns, power, weight, first):  # type: ignore[no-untyped-def]
    """Theta >= 0 with the least sum of weight (power - columns theta)^2, shape (p,), sought from a first one."""
    p = first.size
    G, c, size = np.empty((p, p)), np.empty(p), np.empty(p)
    weighted = np.empty(power.size)
    for a in range(p):
        for i in range(power.size):
            weighted[i] = weight[i] * columns[a, i]
        size[a] = math.sqrt(_dot(weighted, columns[a]))
        c[a] = _dot(weighted, power) / size[a]
        for b in range(a):
            G[a, b] = G[b, a] = _dot(weighted, columns[b]) / (size[a] * size[b])
        G[a, a] = 1.0
    x = first * size
    _nnls(G, c, x)
    return x / size


@njit(**SWIFT)
def _stretch(theta, move, rate):  # type: ignore[no-untyped-def]
    """How much further than `move` to go, if every next one is `rate` times as long; not beyond theta = 0."""
    step = 1.0 / (1.0 - min(max(rate, -1.0), FASTEST))
    for j in range(theta.size):
        if move[j] < 0:
            step = min(step, max(1.0, -theta[j] / move[j]))
    return step


@njit(**SWIFT)
def minimise(theta, moving, columns, data):  # type: ignore[no-untyped-def]
    """Theta at the least L and that L: Fisher scoring from `theta` with step halving, only the moving ones >= 0 move.

    Nothing moves where L is infinite. Where the model is wrong, the steps of Fisher scoring shrink evenly: after two of them the sum of all is gone.
    """
    best, m, found = _evaluated(theta, columns, data)
    if best == np.inf or not moving.any():
        return theta, best
    held = expectation(columns, np.where(moving, 0.0, theta))
    own, before = columns[moving], np.zeros(m.size)
    for _ in range(ITERATIONS):
        power, expected, rest, count = _completed(m, found, data)
        weight = count / expected**2
        target = theta.copy()
        target[moving] = weighted_nnls(own, power - rest - held, weight, theta[moving])
        move = target - theta
        shift = expectation(columns, move)
        size = _dot(weight, before**2)
        stretch = _stretch(theta, move, _dot(weight, before * shift) / size) if size > 0 else 1.0
        step, least, close = stretch, np.inf, CONVERGED + ROUNDING * abs(best)
        while step > SMALLEST_STEP:
            trial = np.maximum(theta + step * move, 0.0)
            least, m, found = _evaluated(trial, columns, data)
            if least <= best + close:
                break
            step = min(step / 2, 1.0)
        if not least < best:
            break
        before = shift if step == 1.0 else np.zeros(m.size)
        gain, theta, best = best - least, trial, least
        if gain < close:
            break
    return theta, best
