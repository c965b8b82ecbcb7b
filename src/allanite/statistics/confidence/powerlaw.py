"""Which power law the noise follows at each averaging time (docs/derivations.md)."""

import math
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.kernels import theo
from allanite.statistics.differences import MDEV, OADEV
from allanite.statistics.estimator import AngleRecord, Piece, windows
from allanite.statistics.row import Statistic
from allanite.terms import TERMS

MIN_POINTS = 30  # points from which on the autocorrelation decides
MIN_PIECE = 12  # points of a mean piece below which the angle itself is not correlated, only its differences

MIN_MEANS = 12
"""Means of the rate that are the fewest for a decision; a longer tau is given the law of the longest tau with so many.
"""

BLOCK = 1 << 15  # points that are correlated at a time: the cache holds them

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
    angular = np.array([m for m, law in laws.items() if law.alpha > 0 and m > 3], dtype=np.int64)
    if angular.size:
        whole = tuple(Piece(piece.start, flat(i)) for i, piece in enumerate(angle.pieces))
        plain, modified = (windows(row, angle._replace(pieces=whole), angular) for row in (OADEV, MDEV))
        for i in np.flatnonzero((modified.number > 0) & (plain.variance > 0)).tolist():
            m, ratio = int(angular[i]), float(modified.variance[i] / plain.variance[i])
            # the angle noise, or white rate noise, whose modified over plain Allan variance is nearest
            ratios = {2: 1 / m, 1: 3.37 / (1.04 + 3 * math.log(math.pi * m)), 0: (m**2 + 1) / (2 * m**2)}
            distances = {alpha: abs(math.log(ratio / own)) for alpha, own in ratios.items()}
            alpha = min(distances, key=distances.__getitem__)
            laws[m] = PowerLaw(alpha, symbol_of(alpha), "rn", m)
    return tuple(laws[int(m)] for m in strides)


def _law(angle: AngleRecord, flat: "Flat", m: int, order: int) -> PowerLaw:
    # a piece that has no two differences left at the end says nothing on the way either
    sizes = {i: -(-piece.x.size // m) for i, piece in enumerate(angle.pieces) if piece.x.size > m * (order + 1)}
    enough = sum(sizes.values()) >= MIN_POINTS
    alpha, method = (_lag1(flat, m, sizes, order), "lag1") if enough else (_by_ratio(angle, m, order), "b1")
    return PowerLaw(alpha, symbol_of(alpha), method, m)


Flat = Callable[..., FloatArray]


def _flat(pieces: tuple[Piece, ...]) -> Flat:
    """Every m-th point of one of the pieces, less one parabola whose constant is each piece's own."""
    step = 2 / max(pieces[-1].start + pieces[-1].x.size - 1, 1)
    begins = [step * piece.start - 1 for piece in pieces]
    sums = [theo.parabola_sums(piece.x, begin, step) for piece, begin in zip(pieces, begins, strict=True)]
    means = [total[:3] / piece.x.size for total, piece in zip(sums, pieces, strict=True)]
    # normal equations of u and u^2 less their means; all but orthogonal, they lose no digits that matter
    gram, right = np.zeros((2, 2)), np.zeros(2)
    for (_, u, uu, uuu, uuuu, xu, xuu), (x_mean, u_mean, uu_mean) in zip(sums, means, strict=True):
        cross = uuu - u * uu_mean
        gram += [[uu - u * u_mean, cross], [cross, uuuu - uu * uu_mean]]
        right += [xu - u * x_mean, xuu - uu * x_mean]
    line, square = np.linalg.solve(gram, right).tolist()
    constants = [piece.x[0] + x - line * u - square * uu for piece, (x, u, uu) in zip(pieces, means, strict=True)]

    def flat(which: int, m: int = 1, first: int = 0, last: int | None = None) -> FloatArray:
        some = pieces[which].x[first * m : None if last is None else (last - 1) * m + 1 : m]
        u, pace, t = begins[which] + step * (first * m), step * m, np.arange(some.size, dtype=np.float64)
        z = t * (square * pace**2)
        z += pace * (line + 2 * u * square)
        z *= t
        z += constants[which] + u * (line + u * square)
        return np.asarray(np.subtract(some, z, out=z))

    return flat


def _lag1(flat: Flat, m: int, sizes: Mapping[int, int], most: int) -> int:
    """Alpha from the lag-1 autocorrelation of the angle, differenced at most `most` times (2 or 3)."""
    # the mean of a short piece takes its correlation away; rates, which share one mean, are begun with then
    first = 0 if sum(sizes.values()) >= MIN_PIECE * len(sizes) else 1
    for d, r1 in _correlations(flat, m, sizes, first, most):
        delta = r1 / (1 + r1)
        if d == most or delta < 0.25:
            break
    if d in EDGES:
        return next(alpha for edge, alpha in EDGES[d] if delta < edge)
    return min(2, 2 - round(2 * delta) - 2 * d)


def _correlations(flat: Flat, m: int, sizes: Mapping[int, int], first: int, most: int) -> Iterator[tuple[int, float]]:
    """``sum_i z_i z_{i+1} / sum_i z_i^2`` of the d-th differences of the pieces, beside d; 0 if all is constant."""
    # of the angle less the mean of each piece, of its differences less one mean; two of them for each pass
    for order in range(first, most + 1, 2):
        sums = np.zeros((min(2, most + 1 - order), 5, len(sizes)))
        for i, (which, size) in enumerate(sizes.items()):
            for a in range(0, size - order, BLOCK):
                z = flat(which, m, a, min(a + BLOCK + order + 2, size))
                for d in range(order + len(sums)):
                    z = z[1:] - z[:-1] if d else z
                    if d >= order:
                        here, after = z[:BLOCK], z[1 : BLOCK + 1]
                        before, add = z[: after.size], np.add.reduce
                        own = (here.size, add(here), here @ here, before @ after, add(before) + add(after))
                        sums[d - order, :, i] += own  # type: ignore[arg-type]  # all are numbers
        for d, (count, total, squares, products, pairs) in enumerate(sums, order):
            mean = total.sum() / count.sum() if d else total / count
            power = float((squares - mean * total).sum())
            shared = float((products - mean * pairs + (count - 1) * mean**2).sum())
            # in many short pieces the sums differ in their numbers of terms, and their ratio may pass -1
            share = (float(count.sum()) - 1) / float((count - 1).sum())
            yield d, max(-0.95, shared / power * share) if power > 0 else 0.0


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
