"""Moments of statistics whose windows are differences, exact except for the quadrature of the lag sums."""

# Derivation: docs/derivations.md.

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.statistics.row import Statistic, binomials
from allanite.terms import NoiseTerm

GROWTH = 1.5  # size of a panel over its distance from the nearest kink

FAR_LAG = 30
"""Lag from which second differences of D are taken from its derivatives: directly they would lose their digits."""


def lag_nodes(kinks: list[float], end: float) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights whose weighted sum is that over the lattice from the first kink to `end`, end included."""
    # Kinks are lattice points (all integers, or all half-integers) at or below `end`, ascending.
    panels: list[tuple[float, int]] = []  # (first lag, number of lags), covering what lies between two kinks, or beyond
    for kink, following in zip(kinks, [*kinks[1:], None], strict=True):
        panels.append((kink, 1))
        low, high = kink + 1, end if following is None else following - 1
        while low <= high:
            remaining = round(high - low) + 1
            size = max(4, math.floor(GROWTH * (low - kink)))
            if following is None or remaining <= 4:
                panels.append((low, min(size, remaining)))
                low += size
                continue
            size = min(size, remaining - remaining // 2)
            panels.append((low, size))
            mirrored = min(size, remaining - size)
            panels.append((high - mirrored + 1, mirrored))
            low, high = low + size, high - mirrored
    first, count = np.array(panels).T
    nodes, weights, _ = sum_nodes(first, count.astype(np.int64))
    return nodes, weights


def sum_nodes(first: FloatArray, count: IntArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Nodes and weights of the sums over first, first + 1, ..., first + count - 1, and where each sum's begin."""
    size = np.minimum(count, 4)
    starts = np.cumsum(size) - size
    nodes, weights = np.repeat(first - starts, size) + np.arange(size.sum()), np.ones(size.sum())
    long = count > 4
    n, at = count[long].astype(np.float64), starts[long, None] + np.arange(4)
    b1, b2, b3 = (n**2 - 1) / 12, (n**2 - 4) / 15, 9 * (n**2 - 9) / 140
    total = b1 + b2 + b3
    far = (total + np.sqrt(total**2 - 4 * b1 * b3)) / 2
    near = b1 * b3 / far
    outer = (n / 2) * (b1 - near) / (far - near)
    inner, c, a, b = n / 2 - outer, first[long] + (n - 1) / 2, np.sqrt(far), np.sqrt(near)
    nodes[at], weights[at] = np.array([c - a, c - b, c + b, c + a]).T, np.array([outer, inner, inner, outer]).T
    return nodes, weights, starts


def second_difference(row: NoiseTerm, n: int) -> FloatArray:
    """D(h+1) - 2 D(h) + D(h-1) at lags h from 0 to n - 1 samples."""
    near = np.arange(min(n, FAR_LAG) + 1, dtype=np.float64)
    D = row.structure(near)
    first = np.concatenate(([2 * D[1]], D[2:] - 2 * D[1:-1] + D[:-2]))
    if n <= FAR_LAG:
        return first[:n]
    return np.concatenate((first[:FAR_LAG], far_difference(row, np.arange(FAR_LAG, n, dtype=np.float64))))


def far_difference(row: NoiseTerm, h: FloatArray) -> FloatArray:
    """The same at any lags from `FAR_LAG` on, shape of h."""
    series = (row.derivative(k, h) / c for k, c in ((2, 1.0), (4, 12.0), (6, 360.0), (8, 20160.0)))
    return np.asarray(sum(series))


def line_of(row: NoiseTerm) -> tuple[float, float, float] | None:
    """What lags 0 and 1 have beyond the straight line that the covariance of rates is from lag 2 on, and its slope."""
    # None for other than power laws of an even exponent.
    if row.alpha is None or row.alpha % 2:
        return None
    c = second_difference(row, 4) / 2
    slope = float(c[3] - c[2])
    return float(c[0] - c[2]) + 2 * slope, float(c[1] - c[2]) + slope, slope


FAR_STRIDES = 40  # a difference over m at a lag beyond FAR m is taken from derivatives: there it would lose its digits
TAIL = 1000  # half widths of the windows beyond which only flicker is left, with less than 1e-10 of the sum
PANELS, OSCILLATIONS = 3, 1000  # panels in each period of a covariance that oscillates, and periods that are divided so


class CovarianceField(NamedTuple):
    """A function of the lag and its derivatives, (order, t)."""

    value: Callable[[FloatArray], FloatArray]
    derivative: Callable[[int, FloatArray], FloatArray]


NO_FIELD = CovarianceField(np.zeros_like, lambda _, t: np.zeros_like(t))
"""F of a polynomial that the differences remove."""


def field_of(row: Statistic, term: NoiseTerm) -> CovarianceField:
    """F: the structure function of what the row takes differences of."""
    degree = 2 * term.slope + 2 + 2 * row.summed  # of F
    if term.waveform is not None and degree < 2 * row.differences:
        return NO_FIELD
    if not row.summed:
        return CovarianceField(term.structure, term.derivative)
    D = term.derivative

    def second_sum(order: int, t: FloatArray) -> FloatArray:
        # the inverse of a second difference, 1 / (2 cosh x - 2), in powers of the derivative x
        return np.asarray(D(order, t) / 12 - D(order - 2, t) - D(order + 2, t) / 240 + D(order + 4, t) / 6048)

    return CovarianceField(lambda t: np.asarray(-term.summed(t)), second_sum)


def responses(row: Statistic, terms: Sequence[NoiseTerm], m: IntArray | FloatArray) -> FloatArray:
    """Expected variance of each term with coefficient 1 for a unit sample interval, shape (t, k); m of shape (k,)."""
    order = row.differences
    lags = np.abs(np.arange(-order, order + 1.0))[:, None] * m
    twice = (-0.5 if order % 2 == 0 else 0.5) * np.convolve(binomials(order), binomials(order))
    C = np.array([twice @ field_of(row, term).value(lags) for term in terms])
    return np.asarray(C / (row.norm(m) * np.square(m, dtype=np.float64)))


def products(
    row: Statistic, terms: Sequence[NoiseTerm], m: IntArray, runs: Sequence[Sequence[tuple[int, int]]]
) -> FloatArray:
    """T of pairs m, shape (k, 2), the shorter first, over `runs` of each, shape (k, t, t); unit sample and norm 1."""
    # Runs are (samples, how many such runs). Windows of different runs are independent except for a trace of flicker.
    # The square of the mean that deterministic terms give the windows is no variance: their own entries are 0.
    total = np.zeros((len(m), len(terms), len(terms)))
    whole = np.zeros((len(m), 2))
    period = min((term.period for term in terms if term.period), default=0.0)
    sums: list[tuple[int, FloatArray, FloatArray]] = []  # place of the pair, lags, weights
    for k, pair in enumerate(m):
        for size, times in runs[k]:
            M = row.count(size, pair).astype(np.float64)
            whole[k] += times * M
            if M.min() > 0:
                h, weight = _windows_apart(row, (int(pair[0]), int(pair[1])), (int(M[0]), int(M[1])), period)
                sums.append((k, h, times * weight))
    if sums:
        each = [h.size for _, h, _ in sums]
        lags, factors = np.concatenate([h for _, h, _ in sums]), m[np.repeat([k for k, _, _ in sums], each)].T
        C = np.array([_covariance(field_of(row, term), row.differences, factors, lags) for term in terms])
        for (k, _, weight), here in zip(sums, np.split(C, np.cumsum(each)[:-1], axis=1), strict=True):
            total[k] += (here * weight) @ here.T
    deterministic = np.array([term.waveform is not None for term in terms])
    total[:, np.outer(deterministic, deterministic)] = 0.0
    return np.asarray(total / whole.prod(axis=1)[:, None, None])


def _windows_apart(
    row: Statistic, m: tuple[int, int], n: tuple[int, int], period: float
) -> tuple[FloatArray, FloatArray]:
    """Lags between windows of a run that has n of them, and how many pairs there are at each."""
    if row.overlapped:
        h, weight = _overlapped(row, m, n, period)
    else:  # windows that start every m samples: the lags are few, and beyond 60 windows nothing is left
        h = m[0] * np.arange(min(n[0], 61), dtype=np.float64)
        weight = np.ones_like(h)
    pairs = np.minimum(min(n), sum(n) / 2 - h / (1 if row.overlapped else m[0]))
    return h, weight * pairs * np.where(h > 0, 2.0, 1.0)


def _overlapped(row: Statistic, m: tuple[int, int], M: tuple[int, int], period: float) -> tuple[FloatArray, FloatArray]:
    half = row.differences / 2
    steps = np.arange(-half, half + 1)
    end = min(sum(M) / 2 - 1, math.floor(TAIL * half * sum(m)))
    offset = 0.5 * (row.differences * (m[1] - m[0]) % 2)
    where = {abs(a * m[0] + b * m[1]) for a in steps for b in steps} | {abs(M[0] - M[1]) / 2, offset}
    if period:  # an oscillation is not smooth between the kinks
        step = max(period / PANELS, 1.0)
        where |= {offset + round(k * step) for k in range(min(OSCILLATIONS * PANELS, int((end - offset) / step)))}
    return lag_nodes(sorted(k for k in where if offset <= k <= end), end + offset if end % 1 != offset else end)


def covariance_of_windows(row: Statistic, term: NoiseTerm, m: int | IntArray, h: FloatArray) -> FloatArray:
    """C(h) of a term of coefficient 1 between windows of m, unit sample interval and norm, h >= 0, shape of h."""
    return _covariance(field_of(row, term), row.differences, np.broadcast_to(m, (2, *h.shape)), h)


def _covariance(field: CovarianceField, order: int, m: IntArray, h: FloatArray) -> FloatArray:
    """C(h) between windows of two averaging factors, those of each lag, shape (2, lags)."""
    a, b = m.astype(np.float64)
    near = h <= 20 * order * (a + b) / 2
    C = np.empty_like(h)
    offsets = (order / 2 - np.arange(order + 1.0))[:, None] * b[near]
    C[near] = np.asarray(binomials(order) @ _one_difference(field, order, a[near], h[near] + offsets))
    if not near.all():
        a, b = a[~near], b[~near]
        s2, s4, s6 = order * (a**2 + b**2) / 24, order * (a**4 + b**4) / 2880, order * (a**6 + b**6) / 181440
        weights = (1.0, s2, s2**2 / 2 - s4, s2**3 / 6 - s2 * s4 + s6)
        series = sum(w * field.derivative(2 * order + 2 * i, h[~near]) for i, w in enumerate(weights))
        C[~near] = (a * b) ** order * np.asarray(series)
    return (-0.5 if order % 2 == 0 else 0.5) * C


def _one_difference(field: CovarianceField, order: int, m: FloatArray, t: FloatArray) -> FloatArray:
    """Central difference of F(|t|) over m, one for each column of t, shape of t."""
    m = np.broadcast_to(m, t.shape)
    far = np.abs(t) > FAR_STRIDES * m
    result = np.empty_like(t)
    points = np.abs(t[~far] + (order / 2 - np.arange(order + 1.0))[:, None] * m[~far])
    result[~far] = np.asarray(binomials(order) @ field.value(points))
    if far.any():
        size, stride = np.abs(t[far]), m[far]
        c1 = order / 24
        c2 = c1**2 / 2 - order / 2880
        c3 = c1**3 / 6 - c1 * order / 2880 + order / 181440
        series = sum(
            c * stride ** (2 * i) * field.derivative(order + 2 * i, size) for i, c in enumerate((1, c1, c2, c3))
        )
        result[far] = np.sign(t[far]) ** order * np.asarray(stride**order * series)
    return result
