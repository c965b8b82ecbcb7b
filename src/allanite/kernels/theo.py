"""Theo1 by its definition."""

import numpy as np

from .allan import dot
from .compiling import kernel, part, swift_part

_BLOCK = 2048


@swift_part
def _pair_squares(ends, near, far):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(ends.size):
        difference = ends[i] - (near[i] + far[i])
        total += difference * difference
    return total


@kernel
def theo1(x, m):  # type: ignore[no-untyped-def]
    """Sum over i < x.size - m and v = 1 .. m/2 of (x[i] - x[i+v] + x[i+m] - x[i+m-v])^2 / v for every even m."""
    sums = np.zeros(m.size)
    for j in range(m.size):
        sums[j] = _one(x, m[j])
    return sums


@part
def _one(x, m):  # type: ignore[no-untyped-def]
    z, ends = np.empty(_BLOCK + m), np.empty(_BLOCK)
    total = 0.0
    for start in range(0, x.size - m, _BLOCK):
        count = min(_BLOCK, x.size - m - start)
        piece = x[start : start + count + m]
        slope = (piece[-1] - piece[0]) / (piece.size - 1)
        for i in range(piece.size):
            z[i] = (piece[i] - piece[0]) - slope * i
        for i in range(count):
            ends[i] = z[i] + z[m + i]
        for v in range(1, m // 2 + 1):
            total += _pair_squares(ends[:count], z[v : v + count], z[m - v : m - v + count]) / v
    return total


@swift_part
def _add_points(A, e, f, points):  # type: ignore[no-untyped-def]
    """A[i] += points[0] e[i] + points[1] e[i-1] + points[2] f[i] + points[3] f[i-1], e and f from i = -1 on."""
    e0, e1, f0, f1 = points
    ea, eb, fa, fb = e[1:], e[:-1], f[1:], f[:-1]
    for i in range(A.size):
        A[i] += (e0 * ea[i] + e1 * eb[i]) + (f0 * fa[i] + f1 * fb[i])


@swift_part
def _add_mirrored(D, e, f, weights):  # type: ignore[no-untyped-def]
    """D[u] += e[0][u] e[1][u] + f[0][u] f[1][u]; gives the sum of weights[u] D[u]."""
    (a, b), (c, d) = e, f
    total = 0.0
    for u in range(D.size):
        D[u] += a[u] * b[u] + c[u] * d[u]
        total += weights[u] * D[u]
    return total


@kernel
def every_theo1(A, D, edges, signs):  # type: ignore[no-untyped-def]
    """Sum over v of (A_m[v] + A_m[m-v]) / v and of D_m[k-v] / v, v = 1 .. k = m/2, for all m = 2, 4 ...: two arrays.

    A_m[l] is A[l] plus the products of the first m points of the edges that lie l apart; D_m[u] is D[u] plus those of
    points that lie u beside one of the first k, on both sides. From one m to the next two points are added to A, and
    one centre to D (B. Lewis, IEEE Trans. UFFC 67, 2020, is such a recursion). `edges`: (v, 2 K), v even, with `signs`.
    """
    most = edges.shape[1] // 2
    first, second = np.zeros(most + 1), np.zeros(most + 1)
    weights = 1.0 / np.arange(1, most + 1)
    falling = weights[::-1].copy()
    backward = edges[:, ::-1].copy()
    signed = backward * signs.reshape(-1, 1)
    end = 2 * most
    for k in range(1, most + 1):
        m = 2 * k
        for b in range(0, signs.size, 2):
            e, f, E, F = edges[b], edges[b + 1], backward[b], backward[b + 1]
            s, t = signs[b], signs[b + 1]
            # the points l = 1, 2 ... before point j lie in the backward edge from end - j on
            points = s * e[m - 2], s * e[m - 1], t * f[m - 2], t * f[m - 1]
            _add_points(A[1 : m - 1], E[end - m + 1 : end], F[end - m + 1 : end], points)
            A[m - 1] += s * e[m - 1] * e[0] + t * f[m - 1] * f[0]
            # beside the new centre, with its sign in the points on the left
            left, right = (signed[b, end - k :], signed[b + 1, end - k :]), (e[k - 1 : m - 1], f[k - 1 : m - 1])
            second[k] = _add_mirrored(D[:k], (left[0], right[0]), (left[1], right[1]), falling[most - k :])
        first[k] = dot(weights[:k], A[1 : k + 1]) + dot(falling[most - k :], A[k:m])
    return first, second
