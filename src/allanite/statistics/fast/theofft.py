"""Theo1 from the autocorrelation of a record, in O(N log N) for a group of m and O(m log^2 m) for each of them."""

# Derivation: docs/derivations.md.

from functools import cache

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.kernels import theo

from .everytau import LEFT_OVER, groups, prefix
from .frames import Edges, autocorrelation, framed, triangles

DIRECT, FRAMES = 0.16, 40.0  # time of a pair of differences by the definition, and of framing a point, ns

ONE, EVERY = (1e6, 250.0), 0.2
"""Time of one m by transforms, and for each of its points; of all m up to the largest, over its square, ns."""


def theo1_sums(x: FloatArray, m: IntArray) -> FloatArray:
    """Sum over i < x.size - m and v = 1 .. m/2 of (x[i] - x[i+v] + x[i+m] - x[i+m-v])^2 / v for ascending even m."""
    result, todo = np.zeros(m.shape), np.ones(m.shape, dtype=bool)
    cost = DIRECT * (m // 2) * np.maximum(x.size - m, 0)
    for low, high in groups(x.size, 1):
        here = (m >= low) & (m < high)
        most = int(m[here].max(initial=0))
        if cost[here].sum() > FRAMES * x.size + min(here.sum() * (ONE[0] + ONE[1] * most), EVERY * most**2):
            products, edges = framed(x, most, 1, whole=high > x.size - 1)
            result[here] = _of_frames(products, edges, m[here])
            todo[here] = result[here] < LEFT_OVER * products[0]
    result[todo] = theo.theo1(x, m[todo])
    return result


def split(points: int, m: IntArray, threads: int) -> list[IntArray]:
    """Parts that threads deal with apart, by places in m: the groups, the largest first."""
    ends = [np.searchsorted(m, low) for low, _ in groups(points, 1)]
    return [piece for piece in np.split(np.arange(m.size), ends)[::-1] if piece.size]


def _of_frames(R: FloatArray, edges: Edges, m: IntArray) -> FloatArray:
    most = int(m[-1])
    squares = np.sum([sign * prefix(e) for e, sign in zip(edges.edges, edges.signs, strict=True)], axis=0)
    A, D = -2 * R - 0.5 * squares, -R[: most + 1 : 2]
    if m.size * (ONE[0] + ONE[1] * most) > EVERY * most**2:
        rows = np.array([e[:most] for e in edges.edges])
        first, second = (sums[m // 2] for sums in theo.every_theo1(A.copy(), D.copy(), rows, np.array(edges.signs)))
    else:
        first, second = np.empty(m.size), np.empty(m.size)
        for i, n in enumerate(m.tolist()):
            k = n // 2
            weights = 1 / np.arange(1, k + 1)
            own = A[:n] + sum(sign * autocorrelation(e[:n]) for e, sign in zip(edges.edges, edges.signs, strict=True))
            mirrored = D[k - 1 :: -1] + triangles(edges, (1, -2, n), k + 1)[1:]
            first[i] = weights @ own[1 : k + 1] + weights @ own[n - 1 : k - 1 : -1]
            second[i] = weights @ mirrored
    return np.asarray(_harmonic(most // 2)[m // 2] * (4 * R[0] + 2 * R[m] - squares[m]) + 2 * (first - second))


@cache
def _harmonic(k: int) -> FloatArray:
    return np.concatenate(([0.0], np.cumsum(1 / np.arange(1, k + 1))))
