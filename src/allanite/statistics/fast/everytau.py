"""Differences of the angle at very many averaging factors, in O(N log^2 N) for all of them (docs/derivations.md)."""

from itertools import combinations

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.kernels import squared, summed, theo
from allanite.statistics.row import binomials, interleaved

from .frames import Edges, framed, triangles

FIRST_FRAMED = 64  # averaging factors below it are summed directly
OCTAVES = {False: 3, True: 1}  # octaves of a group: differences of a running sum cancel faster

MIN_WINDOW_SHARE = 0.01
"""Share of the points below which so few windows are left that they are summed directly: little stands beside much."""

LEFT_OVER = 1e-5  # share of the frames' squares below which a sum is made again directly, for nine digits
MIN_FACTORS = 200  # averaging factors of a group that take as long directly


def dense(x: FloatArray, m: IntArray, order: int, *, summed: bool = False) -> FloatArray:
    """Sums of squared differences at ascending averaging factors, however many, shape of m."""
    # The differences are of `order` 2 or 3; of the running sum of x, which has one point more, if `summed`.
    if m.size <= MIN_FACTORS:
        return _direct(x, m, order, summed)
    points = x.size + summed
    result = np.empty(m.shape)
    todo = np.ones(m.shape, dtype=bool)
    # the largest first: what it needs most memory for, the others find freed
    for low, high in groups(points, order, summed=summed)[::-1]:
        here = slice(*np.searchsorted(m, (low, min(high, int((1 - MIN_WINDOW_SHARE) * points) // order))))
        if here.stop - here.start > MIN_FACTORS:
            reach, whole = order * int(m[here][-1]), order * high >= points
            products, edges = framed(x, reach, order - 1, summed=summed, whole=whole)
            # sums over the windows, were there no edges
            c = binomials(order)
            total = np.full(m[here].shape, sum(v * v for v in c) * products[0])
            for a, b in combinations(range(order + 1), 2):
                total += 2 * c[a] * c[b] * products[(b - a) * m[here]]
            result[here] = total
            squares = float(products[0])
            del products  # as long as the record
            _less_edges(result[here], edges, m[here], order)
            # what is left of so much more has lost its digits: a strong vibration at whole periods
            todo[here] = result[here] < LEFT_OVER * squares
    result[todo] = _direct(x, m[todo], order, summed)
    return result


def _direct(x: FloatArray, m: IntArray, order: int, modified: bool) -> FloatArray:
    """By the definition: for small m, for those with few windows, and where they are few."""
    return np.asarray(summed.modified(x, m) if modified else squared.overlapped(x, m, order))


def groups(points: int, order: int, *, summed: bool = False) -> list[tuple[int, int]]:
    """Averaging factors from .. to below, that share frames; the last group takes the record as one."""
    bounds, low, times = [], FIRST_FRAMED, 1 << OCTAVES[summed]
    while order * low < points:
        # four windows make a frame
        whole = points <= 4 * order * times * low
        bounds.append((low, (points - 1) // order + 1 if whole else times * low))
        low = bounds[-1][1]
    return bounds


def split(points: int, m: IntArray, threads: int, *, order: int, summed: bool = False) -> list[IntArray]:
    """Parts of many averaging factors that threads deal with apart, by places in m: the groups, the largest first."""
    if m.size <= MIN_FACTORS:
        return interleaved(points, m, threads)
    ends = [np.searchsorted(m, high) for _, high in groups(points + summed, order, summed=summed)]
    pieces = np.split(np.arange(m.size), [np.searchsorted(m, FIRST_FRAMED), *ends])
    return [piece for piece in pieces[::-1] if piece.size]


def _less_edges(total: FloatArray, edges: Edges, m: IntArray, order: int) -> None:
    """Take the windows that hang over the edges from the sums, in place."""
    c = binomials(order)
    for e, sign in zip(edges.edges, edges.signs, strict=True):
        squares = prefix(e)
        for a in range(1, order + 1):
            total -= sign * c[a] ** 2 * squares[a * m]
    for a, b in combinations(range(1, order + 1), 2):
        total -= 2 * c[a] * c[b] * triangles(edges, (a, b - a, 0), int(m[-1]) + 1)[m]


def prefix(e: FloatArray) -> FloatArray:
    """Running sums of e^2, one more than e has."""
    return theo.running_squares(np.ascontiguousarray(e))  # type: ignore[no-any-return]
