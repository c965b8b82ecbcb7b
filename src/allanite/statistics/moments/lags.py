"""Sums over lags in a few hundred nodes, by Gauss rules for sums over integers, and second differences of D.

The covariance of two windows is smooth in the lag between them except where an end of one meets an end of the other.
Between such kinks the sum over every lag is replaced by panels of four nodes, exact for polynomials of degree 7 summed
over the integers (Gram polynomials), whose size grows with the distance from the kinks.
"""

import math

import numpy as np

from allanite.terms.row import FloatArray, NoiseTerm

GROWTH = 1.5
"""Size of a panel over its distance from the nearest kink."""

FAR = 30
"""Lag from which second differences of D are taken from its derivatives: directly they would lose their digits."""


def lag_nodes(kinks: list[float], end: float) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights whose weighted sum is that over the lattice from the first kink to `end`, end included.

    Kinks are lattice points (all integers, or all half-integers) at or below `end`, ascending.

    Examples
    --------
    >>> nodes, weights = lag_nodes([0.0, 10.0], 1000.0)
    >>> len(nodes) < 60, round(float((weights * nodes**3).sum()))
    (True, 250500250000)
    """
    nodes: list[float] = []
    weights: list[float] = []
    for kink, following in zip(kinks, [*kinks[1:], None], strict=True):
        nodes.append(kink)
        weights.append(1.0)
        # (first lag, number of lags) of panels covering what lies between two kinks, or beyond the last one
        left, right = kink + 1, end if following is None else following - 1
        panels = []
        while left <= right:
            remaining = round(right - left) + 1
            size = max(4, math.floor(GROWTH * (left - kink)))
            if following is None or remaining <= 4:
                panels.append((left, min(size, remaining)))
                left += size
                continue
            size = min(size, remaining - remaining // 2)
            panels.append((left, size))
            mirrored = min(size, remaining - size)
            panels.append((right - mirrored + 1, mirrored))
            left, right = left + size, right - mirrored
        for first, count in panels:
            x, w = sum_nodes(first, count)
            nodes += x
            weights += w
    return np.array(nodes), np.array(weights)


def sum_nodes(first: float, count: int) -> tuple[list[float], list[float]]:
    """Nodes and weights of the sum over first, first + 1, ..., first + count - 1.

    Examples
    --------
    >>> nodes, weights = sum_nodes(1.0, 100)
    >>> len(nodes), round(sum(w * x**3 for x, w in zip(nodes, weights)))
    (4, 25502500)
    """
    if count <= 4:
        return [first + i for i in range(count)], [1.0] * count
    n2 = float(count) ** 2
    b1, b2, b3 = (n2 - 1) / 12, (n2 - 4) / 15, 9 * (n2 - 9) / 140
    total = b1 + b2 + b3
    far = (total + math.sqrt(total**2 - 4 * b1 * b3)) / 2
    near = b1 * b3 / far
    outer = (count / 2) * (b1 - near) / (far - near)
    inner = count / 2 - outer
    c, a, b = first + (count - 1) / 2, math.sqrt(far), math.sqrt(near)
    return [c - a, c - b, c + b, c + a], [outer, inner, inner, outer]


def second_difference(row: NoiseTerm, n: int) -> FloatArray:
    """D(h+1) - 2 D(h) + D(h-1) at lags h from 0 to n - 1 samples."""
    near = np.arange(min(n, FAR) + 1, dtype=np.float64)
    D = row.structure(near)
    first = np.concatenate(([2 * D[1]], D[2:] - 2 * D[1:-1] + D[:-2]))
    if n <= FAR:
        return first[:n]
    return np.concatenate((first[:FAR], far_difference(row, np.arange(FAR, n, dtype=np.float64))))


def far_difference(row: NoiseTerm, h: FloatArray) -> FloatArray:
    """The same at any lags from `FAR` on, shape of h."""
    series = (row.derivative(k, h) / c for k, c in ((2, 1.0), (4, 12.0), (6, 360.0), (8, 20160.0)))
    return np.asarray(sum(series))


def line_of(row: NoiseTerm) -> tuple[float, float, float] | None:
    """What lags 0 and 1 have beyond the straight line that the covariance of rates is from lag 2 on, and its slope.

    None for other than power laws of an even exponent.
    """
    if row.alpha is None or row.alpha % 2:
        return None
    c = second_difference(row, 4) / 2
    slope = float(c[3] - c[2])
    return float(c[0] - c[2]) + 2 * slope, float(c[1] - c[2]) + slope, slope
