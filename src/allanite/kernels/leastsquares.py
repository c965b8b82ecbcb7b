"""Small systems of equations: Givens rotations, positive definite systems, least squares over what is not negative."""

import math

import numpy as np

from .allan import dot, table, zeros
from .compiling import inner, kernel, once, swift_shared


@kernel
def absorb(factor, rows, values):  # type: ignore[no-untyped-def]
    """Rotate each row (with its value behind it) into the upper triangular `factor`, in place.

    `factor` has shape (p, p + 1), its diagonal is not negative; `rows` (n, p), `values` (n,). Returns what is left of
    each value, shape (n,): the innovation over its standard deviation, where rows and values have unit noise. No cosine
    is negative, so it keeps the innovation's sign.
    """
    p = factor.shape[0]
    left = np.empty(values.size)
    work = np.empty(p + 1)
    for i in range(values.size):
        work[:p] = rows[i]
        work[p] = values[i]
        for j in range(p):
            if work[j] == 0.0:
                continue
            line = factor[j]
            length = math.sqrt(line[j] * line[j] + work[j] * work[j])
            c = line[j] / length
            s = work[j] / length
            line[j] = length
            head = line[j + 1 :]
            tail = work[j + 1 :]
            for k in range(tail.size):
                above = head[k]
                head[k] = c * above + s * tail[k]
                tail[k] = c * tail[k] - s * above
        left[i] = work[p]
    return left


ROUNDING = 1e-15
ALIKE = 1 - 1e-11


@inner
def cholesky(G):  # type: ignore[no-untyped-def]
    """Put the lower root of G in its place; of a pivot at least its rounding is left."""
    for j in range(G.shape[0]):
        pivot = G[j, j]
        for k in range(j):
            for i in range(k):
                G[j, k] -= G[j, i] * G[k, i]
            G[j, k] /= G[k, k]
            pivot -= G[j, k] * G[j, k]
        G[j, j] = math.sqrt(max(pivot, ROUNDING * G[j, j]))


@inner
def forward(root, b):  # type: ignore[no-untyped-def]
    """Put root^-1 b in the place of b."""
    for j in range(b.size):
        for i in range(j):
            b[j] -= root[j, i] * b[i]
        b[j] /= root[j, j]


@inner
def backward(root, b):  # type: ignore[no-untyped-def]
    """Put root'^-1 b in the place of b."""
    for j in range(b.size - 1, -1, -1):
        for i in range(j + 1, b.size):
            b[j] -= root[i, j] * b[i]
        b[j] /= root[j, j]


@inner
def _solve(G, c, passive):  # type: ignore[no-untyped-def]
    """G x = c on the passive set, zero elsewhere."""
    q = c.size
    A, x = table(q, q), zeros(q)
    for i in range(q):
        A[i, i] = 1.0
        if passive[i]:
            x[i] = c[i]
            for j in range(i):
                A[i, j] = G[i, j] if passive[j] else 0.0
    cholesky(A)
    forward(A, x)
    backward(A, x)
    return x


@inner
def _taken(G, j, passive):  # type: ignore[no-untyped-def]
    """Whether a column is another one in use except for its size."""
    found = False
    for k in range(passive.size):
        found |= passive[k] and k != j and G[j, k] > ALIKE
    return found


@once
def _steepest(G, c, x, passive):  # type: ignore[no-untyped-def]
    """The column not in use along which the sum of squares falls fastest, -1 if there is none."""
    best, most = -1, 0.0
    for j in range(c.size):
        most = max(most, 1e-12 * abs(c[j]))
    for j in range(c.size):
        slope = c[j]
        for k in range(x.size):
            slope -= G[j, k] * x[k]
        if not passive[j] and slope > most and not _taken(G, j, passive):
            best, most = j, slope
    return best


@inner
def _towards(x, wanted, passive):  # type: ignore[no-untyped-def]
    """Move x to what is wanted, or as far as nothing falls below zero; the one that is zero there first, or -1."""
    step, leaving = 1.0, -1
    for j in range(x.size):
        if passive[j] and wanted[j] <= 0:
            ratio = x[j] / (x[j] - wanted[j]) if x[j] > 0 else 0.0
            if ratio < step:
                step, leaving = ratio, j
    for j in range(x.size):
        x[j] += step * (wanted[j] - x[j])
    return leaving


@once
def _nnls(G, c, x):  # type: ignore[no-untyped-def]
    """Minimum of x'Gx/2 - c'x over x >= 0, for a G with unit diagonal, in the place of a first x.

    By Lawson and Hanson, and Bro and de Jong; what is positive in the first x is in use from the beginning.
    """
    passive = np.zeros(x.size, np.bool_)
    for j in range(x.size):
        passive[j] = x[j] > 0
    for j in range(x.size):
        if passive[j] and _taken(G, j, passive):
            passive[j], x[j] = False, 0.0
    for _ in range(10 * x.size):
        leaving = _towards(x, _solve(G, c, passive), passive)
        while leaving >= 0:
            passive[leaving], x[leaving] = False, 0.0
            leaving = _towards(x, _solve(G, c, passive), passive)
        best = _steepest(G, c, x, passive)
        if best < 0:
            break
        passive[best] = True


@swift_shared
def weighted_nnls(columns, power, weight, first):  # type: ignore[no-untyped-def]
    """Theta >= 0 with the least sum of weight (power - columns theta)^2, shape (p,), sought from a first one."""
    p = first.size
    G, c, size = table(p, p), zeros(p), zeros(p)
    weighted, x = zeros(power.size), zeros(p)
    for a in range(p):
        for i in range(power.size):
            weighted[i] = weight[i] * columns[a, i]
        size[a] = math.sqrt(dot(weighted, columns[a]))
        c[a] = dot(weighted, power) / size[a]
        for b in range(a):
            G[a, b] = G[b, a] = dot(weighted, columns[b]) / (size[a] * size[b])
        G[a, a], x[a] = 1.0, first[a] * size[a]
    _nnls(G, c, x)
    for a in range(p):
        x[a] /= size[a]
    return x
