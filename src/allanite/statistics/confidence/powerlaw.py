"""Which power law the noise follows at each averaging time (docs/derivations.md)."""

import math
from bisect import bisect_right
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.statistics.differences import MDEV, OADEV
from allanite.statistics.estimator import AngleRecord, Piece, windows
from allanite.statistics.row import Statistic
from allanite.terms import TERMS

MIN_POINTS = 30  # points from which on the autocorrelation decides
MIN_PIECE = 12  # points of a mean piece below which the angle itself is not correlated, only its differences

MIN_MEANS = 12
"""Means of the rate that are the fewest for a decision; a longer tau is given the law of the longest tau with so many.
"""

DIFFERENCED = 1 << 16  # points that are differenced at a time

MAX_COMPARED = 500
"""Means of the rate, in the longest pieces, that decide by the ratio of two variances; it costs their square."""

EDGES = {
    2: ((-0.64, 0), (-0.04, -1), (np.inf, -2)),
    3: ((-1.57, 0), (-0.82, -1), (-0.27, -2), (0.12, -3), (np.inf, -4)),
}
"""Differences taken -> (delta below, alpha), half-way between the exact values of the laws.

The published rule, alpha = 2 - round(2 delta) - 2d, supposes noise that is fractionally differenced at the sampling
step. Sampled every tau, the d-th differences of x have the autocovariance (-1)^(d+1)/2 delta^2d D(h), and from it
r1/(1 + r1) is at d = 2 -1, -0.277, 0.2 for N, B, K and at d = 3 -2, -1.149, -0.5, -0.037, 0.283 for alpha = 0 .. -4.
"""

STEEP: dict[int, Callable[[FloatArray], FloatArray]] = {
    -3: lambda t: t**4 * np.log(np.where(t > 0, t, 1.0)),
    -4: lambda t: t**5,
}
"""alpha -> D(t) except for a positive factor, beyond those of random walk of the rate."""

LAWS = (2, 0, -1, -2, -3, -4)
"""The alphas between which the ratio decides. Flicker of the angle is omitted: it looks like its white noise."""


def symbol_of(alpha: int) -> str:
    """The term of `TERMS` with the exponent alpha, or the nearest safe one."""
    # Flicker and random walk of the ramp have no term: the one with the fewest degrees of freedom (K) is used, so that
    # no interval is too narrow.
    term = next((symbol for symbol, row in TERMS.items() if row.alpha == alpha), None)
    return term or symbol_of(alpha - 1 if alpha > 0 else alpha + 1)


class PowerLaw(NamedTuple):
    """The power law of the noise at an averaging time."""

    # `alpha` is the exponent of the spectrum of the rate: 2 and 1 white and flicker angle noise, 0, -1, -2 white,
    # flicker and random walk rate noise, -3, -4 flicker and random walk of the ramp. `symbol` is its term, or the
    # nearest safe one (`symbol_of`). `method` is "lag1" (autocorrelation), "b1" (ratio of variances) or "rn" (modified
    # over plain Allan variance). `m` is the averaging factor at which it was found; smaller than the one requested
    # where that leaves too few points.
    alpha: int
    symbol: str
    method: str
    m: int


def identify_power_law(angle: AngleRecord, row: Statistic, times: FloatArray) -> tuple[PowerLaw, ...]:
    """The power law of a record's noise at averaging times, in sample intervals (`grids.times`), which are rounded."""
    # The angle is `integrated` for this row or one of the same order, which says how steep a law the row converges for:
    # alpha >= -2, or -4 for third differences.
    # Lag 1: the angle less a parabola, at every m-th point, is differenced d = 0, 1, .. times until ``delta = r1 / (1 +
    # r1) < 1/4``, or d = 2 (third differences: 3), with r1 its lag-1 autocorrelation. Then ``alpha = 2 - round(2 delta)
    # - 2d`` for d < 2, and by `EDGES` beyond. Pieces between gaps share one parabola except for its constant, and their
    # products are pooled.
    # B1: the variance of the m-sample means of the rate over their Allan variance, and for third differences that about
    # a line over their Hadamard variance, is compared with its exact expectation for each law. A ramp is not removed in
    # the former.
    # Each tau costs n/m; where m > 3 and alpha > 0 also two passes over n.
    # W. J. Riley & C. A. Greenhall, Power law noise identification using the lag 1 autocorrelation, EFTF 2004; NIST SP
    # 1065 section 5.5; J. A. Barnes, NBS Technical Note 375, 1969 (B1).
    # the largest averaging factor that leaves enough means of the rate, at least 1
    sizes = np.array([piece.x.size - 1 for piece in angle.pieces])
    candidates = range(1, int(sizes.sum()) // MIN_MEANS + 1)
    longest = max(1, bisect_right(candidates, -MIN_MEANS, key=lambda m: -int((sizes // m).sum())))
    strides = np.clip(np.rint(times), 1, longest).astype(np.int64)
    flat = _flat(angle.pieces)
    laws = {int(m): _law(angle, flat, int(m), max(2, row.order)) for m in np.unique(strides)}
    return tuple(laws[int(m)] for m in strides)


def _law(angle: AngleRecord, flat: Callable[[int], list[FloatArray]], m: int, order: int) -> PowerLaw:
    # a piece that has no two differences left at the end says nothing on the way either
    long = [x for x, piece in zip(flat(m), angle.pieces, strict=True) if piece.x.size > m * (order + 1)]
    enough = sum(x.size for x in long) >= MIN_POINTS
    alpha, method = (lag1(long, order), "lag1") if enough else (_by_ratio(angle, m, order), "b1")
    if alpha > 0 and m > 3:
        whole = tuple(Piece(piece.start, x) for piece, x in zip(angle.pieces, flat(1), strict=True))
        plain, modified = (windows(row, angle._replace(pieces=whole), np.array([m])) for row in (OADEV, MDEV))
        if modified.number[0] and plain.variance[0]:
            # the angle noise, or white rate noise, whose modified over plain Allan variance is nearest
            ratio = float(modified.variance[0] / plain.variance[0])
            ratios = {2: 1 / m, 1: 3.37 / (1.04 + 3 * math.log(math.pi * m)), 0: (m**2 + 1) / (2 * m**2)}
            alpha, method = min(ratios, key=lambda alpha: abs(math.log(ratio / ratios[alpha]))), "rn"
    return PowerLaw(alpha, symbol_of(alpha), method, m)


def _flat(pieces: tuple[Piece, ...]) -> Callable[[int], list[FloatArray]]:
    """Every m-th point of the pieces, as a function of m, less one parabola whose constant is each piece's own."""
    from allanite.kernels.theo import less_parabola, parabola_sums

    step = 2 / max(pieces[-1].start + pieces[-1].x.size - 1, 1)
    begins = [step * piece.start - 1 for piece in pieces]
    sums = [parabola_sums(piece.x, begin, step) for piece, begin in zip(pieces, begins, strict=True)]
    means = [total[:3] / piece.x.size for total, piece in zip(sums, pieces, strict=True)]
    # normal equations of u and u^2 less their means; all but orthogonal, they lose no digits that matter
    gram, right = np.zeros((2, 2)), np.zeros(2)
    for (_, u, uu, uuu, uuuu, xu, xuu), (x_mean, u_mean, uu_mean) in zip(sums, means, strict=True):
        cross = uuu - u * uu_mean
        gram += [[uu - u * u_mean, cross], [cross, uuuu - uu * uu_mean]]
        right += [xu - u * x_mean, xuu - uu * x_mean]
    line, square = np.linalg.solve(gram, right).tolist()
    constants = [piece.x[0] + x - line * u - square * uu for piece, (x, u, uu) in zip(pieces, means, strict=True)]
    return lambda m: [
        less_parabola(piece.x, m, begin, step, (constant, line, square))
        for piece, begin, constant in zip(pieces, begins, constants, strict=True)
    ]


def _dot(a: list[FloatArray], b: list[FloatArray]) -> float:
    return sum(float(x @ y) for x, y in zip(a, b, strict=True))


def lag1(pieces: list[FloatArray], most: int) -> int:
    """Alpha from the lag-1 autocorrelation of the angle, overwritten, differenced at most `most` times (2 or 3)."""
    # the mean of a short piece takes its correlation away; rates, which share one mean, are begun with then
    first = 0 if sum(z.size for z in pieces) >= MIN_PIECE * len(pieces) else 1
    pieces = [_differences(z) if first else np.subtract(z, z.mean(), out=z) for z in pieces]
    for d in range(first, most + 1):
        r1 = _autocorrelation(pieces)
        delta = r1 / (1 + r1)
        if d == most or delta < 0.25:
            break
        pieces = [_differences(z) for z in pieces]
    if d in EDGES:
        return next(alpha for edge, alpha in EDGES[d] if delta < edge)
    return min(2, 2 - round(2 * delta) - 2 * d)


def _differences(z: FloatArray) -> FloatArray:
    """Successive differences in the memory of z, by blocks, since numpy would copy all of what overlaps."""
    last = z.size - 1
    for a in range(0, last, DIFFERENCED):
        z[a : min(a + DIFFERENCED, last)] = np.diff(z[a : a + DIFFERENCED + 1])
    return z[:last]


def _autocorrelation(pieces: list[FloatArray]) -> float:
    """``sum_i z_i z_{i+1} / sum_i z_i^2`` of the pieces together, less their mean; 0 if all is constant."""
    total, count = sum(float(z.sum()) for z in pieces), sum(z.size for z in pieces)
    pieces = [np.subtract(z, total / count, out=z) for z in pieces]
    squares = _dot(pieces, pieces)
    pairs = sum(max(z.size - 1, 0) for z in pieces)
    if not squares:
        return 0.0
    # the two sums have other numbers of terms in many short pieces: their ratio may then pass -1, a correlation not
    products = _dot([z[:-1] for z in pieces], [z[1:] for z in pieces])
    return max(-0.95, products / squares * (count - 1) / pairs)


def _by_ratio(angle: AngleRecord, m: int, order: int) -> int:
    """Alpha whose expected ratio is nearest in the logarithm; 0 where nothing can be compared."""
    laws = [alpha for alpha in LAWS if alpha >= 2 - 2 * order]
    # the longest pieces, with about as many means as are compared
    sizes = np.array([(piece.x.size - 1) // m for piece in angle.pieces])
    falling = np.argsort(-sizes, kind="stable")
    pieces = [angle.pieces[i] for i in falling[: np.searchsorted(np.cumsum(sizes[falling]), MAX_COMPARED) + 1]]
    rates = [np.diff(piece.x[::m]) for piece in pieces]
    starts = [piece.start / m + np.arange(y.size, dtype=np.float64) for piece, y in zip(pieces, rates, strict=True)]
    forms, start, rate = ratio_forms(starts, order), np.concatenate(starts), np.concatenate(rates)
    spread, local = (float(rate @ form @ rate) for form in forms)
    if not min(spread, local) > 0:  # of a line, rounding leaves a negative sum
        return 0
    expected = np.array([expected_ratio(forms, start, alpha) for alpha in laws])
    return laws[int(np.argmin(np.abs(np.log(spread / local / expected))))]


def ratio_forms(starts: list[FloatArray], order: int) -> tuple[FloatArray, FloatArray]:
    """Two quadratic forms of the means of the rate, whose ratio is B1 for order 2."""
    # They are the variance about a constant and the Allan variance; for order 3 that about a line and the Hadamard
    # variance. The means of each piece begin at `starts`, in units of their length.
    start = np.concatenate(starts)
    trend, _ = np.linalg.qr(np.vander(start - start.mean(), order - 1))
    spread = (np.eye(start.size) - trend @ trend.T) / max(start.size - order + 1, 1)
    piece = np.repeat(np.arange(len(starts)), [s.size for s in starts])
    rows = np.diff(np.eye(start.size), order - 1, axis=0)[piece[order - 1 :] == piece[: 1 - order]]
    return spread, rows.T @ rows / (math.comb(2 * order - 2, order - 1) * max(len(rows), 1))


def expected_ratio(forms: tuple[FloatArray, FloatArray], start: FloatArray, alpha: int) -> float:
    """Ratio of the forms' expectations for a power law."""
    D = STEEP[alpha] if alpha in STEEP else TERMS[symbol_of(alpha)].structure
    lag = np.abs(np.subtract.outer(start, start))
    covariance = 0.5 * (D(lag + 1) + D(np.abs(lag - 1)) - 2 * D(lag))
    spread, local = (float(np.sum(form * covariance)) for form in forms)
    return spread / local
