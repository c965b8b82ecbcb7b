"""Moments of the statistics over windows (Theo1, modified and Hadamard total, parabolic), and the total deviation."""

# Derivation: docs/derivations.md.

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import scipy

from allanite.core.arrays import FloatArray
from allanite.statistics.row import Sharp, Statistic
from allanite.terms import NoiseTerm

from . import folded

from .compact import (  # isort: skip
    Compact, averaged, compact, expectation, extrapolation, kinked_nodes, lattice, mean_weights, products, ratios,
    sampled, slower, white_level
)  # fmt: skip
from .lagsums import lag_nodes, responses
from .profile import SAMPLES_BEYOND, LagProfile, Windows, profile_of, total


@lru_cache(maxsize=256)
def _nodes(end: int, bends: frozenset[int] = frozenset()) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights of a sum over v = 1 .. end: with kinks at 1, 2, 4, ... they follow 1/v to ten digits."""
    powers = {1 << k for k in range(end.bit_length())}
    kinks = powers | {end} | {k for k in bends if 1 <= k <= end}
    return lag_nodes([float(k) for k in sorted(kinks)], float(end))


def theo_response(term: NoiseTerm, m: int) -> float:
    """E of a window of m intervals: sum over v of [2D(v) + 2D(m - v) - D(m) - D(m - 2v)]/v."""
    v, weight = _nodes(m // 2)
    D = term.structure
    return float(weight / v @ (2 * D(v) + 2 * D(m - v) - D(np.full_like(v, m)) - D(m - 2 * v)))


def harmonic(m: int) -> float:
    """H_M + 1/(2M), M = m/2: a quarter of E for white angle noise."""
    return float(_sum_of_inverses(np.array(m / 2))) + 1 / m


def _sum_of_inverses(k: FloatArray) -> FloatArray:
    """1 + 1/2 + ... + 1/k."""
    return np.asarray(scipy.special.digamma(k + 1) + np.euler_gamma)


def white_ratio(m: int, count: int) -> float:
    """Ratio r of white angle noise with itself, for L = `count` windows."""
    # With n(l) = max(0, L - l) and w = 1/v, every pair of points of two windows that fall together counts n(l):
    #     T L^2 = 4 L H^2 + 2 n(2M) H^2 + 4 H sum_v w [n(2M - v) + n(v)] + sum_uv w w [2 n(2M - u - v) + 2 n(|u - v|)]
    #             + sum_v w^2 [4 n(2M - v) + 4 n(v) + 10 L] - 4 sum_{v <= M/2} n(v)/v^2
    # except for a few pairs that fall together twice: below 0.5 % from M = 32.
    M, L = m // 2, float(count)
    H = _sum_of_inverses

    def n(lag: FloatArray) -> FloatArray:
        return np.maximum(L - lag, 0.0)

    v, weight = _nodes(M, frozenset((count, 2 * M - count, M - count, M // 2)))
    whole = float(H(np.array(float(M))))
    below, above = np.maximum(v - L, 0.0), np.minimum(v + L, M)
    # sum over u of n(|u - v|)/u and of n(2M - u - v)/u, as sums of 1/u and of 1
    near = (L - v) * (H(v) - H(below)) + (v - below) + (L + v) * (H(above) - H(v)) - (above - v)
    start = np.clip(2 * M - L - v, 0.0, M)
    across = (L - 2 * M + v) * (whole - H(start)) + (M - start)
    single = float(weight / v @ (n(2 * M - v) + n(v)))
    double = float(weight / v @ (2 * across + 2 * near))
    square = float(weight / v**2 @ (4 * n(2 * M - v) + 4 * n(v) + 10 * L - 4 * n(v) * (v <= M // 2)))
    total = 4 * L * whole**2 + 2 * float(n(np.array(2.0 * M))) * whole**2 + 4 * whole * single + double + square
    return total / (L * 4 * harmonic(m)) ** 2


EXACT = (32, 48, 64)
"""Averaging factors, for even m, of the windows that the expectation of a longer one is extrapolated from."""


def response(row: Statistic, terms: Sequence[NoiseTerm], m: int, size: int) -> FloatArray:
    """Expected variance of each term for a sample interval of 1, shape (t,), without the factor tau^(2 power)."""
    # For the total deviation, or a row with a `window` that is no difference; `size` matters to the former alone.
    if row.window is None:
        return folded.response(row, terms, m, size)
    scheme = row.scheme
    if scheme.response is not None:
        return np.array([scheme.response(term, m) for term in terms]) / _norm(row, m) / float(m) ** 2
    levels = [k + m % 2 for k in EXACT] if m > EXACT[-1] else [m]
    D = sampled if scheme.sharp else averaged
    values = []
    for level in levels:
        mean = mean_weights(row.window, level)
        values.append([expectation(mean, D(term, level / m)) / _norm(row, level) for term in terms])
    return np.asarray(extrapolation(levels, m, 1) @ np.array(values)) / float(m) ** 2


def _norm(row: Statistic, m: int) -> float:
    return float(row.norm(np.array([m]))[0])


def relative(row: Statistic, terms: Sequence[NoiseTerm], m: int, count: int, size: int) -> FloatArray:
    """r_ij = T_ij / (E_i E_j), shape (t, t): 1/EDF = p r p with p the terms' shares of the expected variance."""
    # `count` windows in one run without a gap; the total deviation has none but the whole record.
    if row.window is None:
        return folded.relative(terms, m, size)
    scheme = row.scheme
    levels = [k + m % 2 for k in scheme.levels] if m > scheme.levels[-1] else [m]
    parts = []
    for level in levels:
        window = compact(row.window, row.order, level)
        parts.append(ratios(*products(window, terms, row.order, level / m, count), terms))
    r = np.asarray(np.tensordot(extrapolation(levels, m, scheme.power), parts, 1))
    if scheme.sharp is None or len(levels) == 1:
        return r
    for i, term in enumerate(terms):
        if white_level(term):
            r[i] = r[:, i] = _sharp_ratios(row, scheme.sharp, terms, m, count)
            if scheme.sharp.itself is not None:
                r[i, i] = scheme.sharp.itself(m, count)
    return r


def _sharp_ratios(row: Statistic, rule: Sharp, terms: Sequence[NoiseTerm], m: int, count: int) -> FloatArray:
    """Ratios of white angle noise with every term where the points of a window meet it one by one, shape (t,)."""
    # White angle noise is correlated only where a point of one window falls on a point of the other: its ratios fall as
    # 1/(m scale(m)). Peaks at the first and the last lag, where ends meet ends, are extrapolated for themselves.
    first, last, smooth = [], [], []
    levels = [k + m % 2 for k in rule.levels]
    for level in levels:
        window = compact(row.window, row.order, level)
        r = rule.scale(level) * _lag_ratios(window, terms, level / m)
        first.append(r[:, 0] - (2 * r[:, 1] - r[:, 2]))
        last.append(r[:, -1] - (2 * r[:, -2] - r[:, -3]))
        r[:, 0] -= first[-1]
        r[:, -1] -= last[-1]
        lag, weight = lattice(window.points, level / m, count)
        smooth.append([np.interp(lag, np.arange(window.points), k, right=0.0) @ weight * level for k in r])
    weights = extrapolation(levels, m, 1)
    ends = weights @ first / count + 2 * max(count - row.span[0] * m, 0) / count**2 * (weights @ last)
    return np.asarray((ends + weights @ smooth / m) / rule.scale(m))


def _lag_ratios(window: Compact, terms: Sequence[NoiseTerm], step: float) -> FloatArray:
    """Covariances of white angle noise times those of each term over both expectations, shape (t, lags)."""
    distance = np.abs(np.arange(window.points)[:, None] + np.arange(1.0 - window.points, window.points))
    white = -2 * window.mean[window.points - 1]
    r = np.zeros((len(terms), window.points))
    for i, term in enumerate(terms):
        D = sampled(term, step)
        E = expectation(window.mean, D)
        if E:
            r[i] = np.sum(window.white * D(distance), axis=1) / (white * E)
    return r


MAX_WHOLE_POINTS = 750  # points of the longer window up to which both are taken as they are
REDUCED_POINTS = 320  # points of two windows together that longer ones are reduced to

MIN_FACTOR = {1: 8, 2: 4}
"""By the power of the extrapolation: the least averaging factor of the shorter of two reduced windows."""


def whole_lattice(p: int, q: int, counts: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Distances x >= 0 of windows of p <= q samples, and weights of the sum over all pairs, singly while they meet."""
    # `counts` are the numbers of windows: of both, the first one starts with the record.
    first, end = -((q - p) // 2), math.ceil(max(counts[1], p - q + counts[0])) - 1
    near = min(end, p + SAMPLES_BEYOND)
    s, weight = np.arange(first, near + 1.0), np.ones(near + 1 - first)
    if end > near:
        rest, weights = lag_nodes([float(near)], float(end))
        s, weight = np.concatenate((s, rest[1:])), np.concatenate((weight, weights[1:]))

    def pairs(s: FloatArray) -> FloatArray:
        return np.asarray(np.maximum(np.minimum(counts[0], counts[1] - s) - np.maximum(0.0, -s), 0.0))

    x = s - (p - q) / 2
    return x, weight * (pairs(s) + np.where(x > 0, pairs(p - q - s), 0.0)) / (counts[0] * counts[1])


def pair_lattice(half: float, step: float, counts: tuple[float, float], first: float) -> tuple[FloatArray, FloatArray]:
    """Distances x >= 0, in units of 1/step samples, and weights of the sum over all pairs of windows."""
    # `counts` are the numbers of windows, M1 >= M2; `half` the distance at which the windows no longer overlap, `first`
    # the distance nearest to zero. The rule is that of `compact.lattice`.
    M1, M2 = counts
    start = round(2 * first) / 2
    end = (M1 + M2) / 2
    if end <= 3 * half / step:
        lag = start + np.arange(max(math.ceil(end - start), 1.0))
        weight = np.ones(lag.size)
    else:
        kinks = (half % 1 + np.arange(math.ceil(half) + 1)) / step
        kinks = np.unique(np.concatenate(([start], kinks[kinks > start], [(M1 - M2) / 2])))
        within = (kinks >= start) & (kinks <= end)
        lag, weight = kinked_nodes(np.asarray(kinks[within], np.float64), end - 1)
    pairs = np.clip(end - lag, 0.0, M2)
    return lag * step, weight * pairs * np.where(lag > 0, 2.0, 1.0) / (M1 * M2)


class WindowPair(NamedTuple):
    """Two statistics at an averaging factor each, the first with the shorter windows, and their numbers of windows."""

    rows: tuple[Statistic, Statistic]
    m: tuple[int, int]
    counts: tuple[float, float]

    @property
    def windows(self) -> tuple[Windows, Windows]:
        """What makes them."""
        first, second = (row.window for row in self.rows)
        if first is None or second is None:
            raise TypeError(f"{self.rows[first is not None].name} has no window")
        return first, second

    @property
    def span(self) -> tuple[int, int]:
        """Sample intervals of a window over m."""
        return self.rows[0].span[0], self.rows[1].span[0]

    @property
    def points(self) -> int:
        """Points of the two windows."""
        return sum(row.span[0] * m + row.span[1] + 1 for row, m in zip(self.rows, self.m, strict=True))

    @property
    def whole(self) -> bool:
        """Whether they are taken as they are."""
        return self.rows[1].span[0] * self.m[1] < MAX_WHOLE_POINTS

    @property
    def power(self) -> int:
        """That of the extrapolation."""
        return min(row.scheme.power for row in self.rows)

    @property
    def sharp(self) -> bool:
        """Whether the windows hold single points of the angle."""
        return any(row.scheme.sharp or (row.differences and not row.summed) for row in self.rows)

    def shortened(self, k: int) -> "WindowPair":
        """The same with k for the longer window, in a record that is as many times shorter."""
        windows = self.counts[1] * k / self.m[1]
        shorter = self._replace(m=(self.m[0], k))
        first, second = (row.span[0] * m + row.span[1] for row, m in zip(shorter.rows, shorter.m, strict=True))
        return shorter._replace(counts=(windows + (second - first), windows))


@dataclass(frozen=True)
class Pairs:
    """Covariances under these terms, noise; `known` are the profiles of the windows that were met."""

    terms: Sequence[NoiseTerm]
    known: dict[tuple[Any, ...], LagProfile] = field(default_factory=dict)

    def products(self, rows: tuple[Statistic, Statistic], m: tuple[int, int], size: int) -> FloatArray:
        """T_ij of variances of the rate in a record without gaps, unit sample interval, shape (t, t)."""
        if rows[0].span[0] * m[0] > rows[1].span[0] * m[1]:
            rows, m = (rows[1], rows[0]), (m[1], m[0])
        counts = [float(row.count(size, np.array([k]))[0]) for row, k in zip(rows, m, strict=True)]
        pair = WindowPair(rows, m, (counts[0], counts[1]))
        if pair.whole:
            sums = [row.norm(np.array([k]))[0] * float(k) ** 2 for row, k in zip(rows, m, strict=True)]
            E = self._profile(pair, 1.0, sampled).E / np.array(sums)[:, None]
        else:
            E = np.array([
                np.asarray(responses(row, self.terms, np.array([k]))[:, 0]) if row.differences
                else response(row, self.terms, k, size)
                for row, k in zip(rows, m, strict=True)
            ])  # fmt: skip
        scale = np.sqrt(E.prod(axis=0))
        r = self.within(pair)
        if rows[0] is rows[1] and m[0] == m[1] and rows[0].scheme.sharp and not pair.whole:
            white = np.array([white_level(term) > 0 for term in self.terms])
            r = np.where(white[:, None] | white, relative(rows[0], self.terms, m[0], int(counts[0]), size), r)
        return np.asarray(np.outer(scale, scale) * r)

    def within(self, pair: WindowPair) -> FloatArray:
        """T_ij over the root of the terms' four expectations, shape (t, t)."""
        # As it is, reduced, or extrapolated in the ratio of the windows.
        if pair.whole:
            return self._whole(pair)
        a, b = pair.span
        (m, k), step = pair.m, pair.rows[1].step
        least = MIN_FACTOR[pair.power]
        widest = (MAX_WHOLE_POINTS - 1) / (b * m) if m <= least else (REDUCED_POINTS / least - a) / b
        if k <= widest * m:
            # averaging factors of the shorter window, as even or odd as m, the largest below `top`
            even, top = max(pair.rows[0].step, 2), REDUCED_POINTS / (a + b * k / m)
            tops = [int(top / 2**i) for i in range(3 if pair.power == 1 else 2)]
            levels = sorted({max(n - (n - m) % even, m % even + even) for n in tops})
            reduced = []
            for level in levels:  # between two factors for the longer window
                wanted = k / m * level
                below = int(wanted) // step * step
                at = self._reduced(pair, (level, below))
                if below != wanted:
                    share = math.log(wanted / below) / math.log1p(step / below)
                    at = (1 - share) * at + share * self._reduced(pair, (level, below + step))
                reduced.append(at)
            return np.asarray(np.tensordot(extrapolation(levels, m, pair.power), reduced, 1))
        widest = 2 ** int(math.log2(widest))
        near, nearer = (pair.shortened(int(w * m) // step * step) for w in (widest, widest / 2))
        far, close = (self.within(p) * p.counts[0] for p in (near, nearer))
        ratio = near.m[1] / nearer.m[1]
        fall = np.clip(np.divide(far, close, out=np.zeros_like(far), where=close != 0), 0.0, 1.0)
        more = math.log(k / near.m[1]) / math.log(ratio)
        return np.asarray(far * fall**more / pair.counts[0])

    def _reduced(self, pair: WindowPair, m: tuple[int, int]) -> FloatArray:
        """With windows of m intervals in place of its own, that last as long."""
        step = m[0] / pair.m[0]
        shorter = pair._replace(m=m)
        profile = self._profile(shorter, step, averaged)
        T = total(profile, *pair_lattice(profile.last + 1, step, pair.counts, pair.points % 2 / 2))
        white = np.array([white_level(term) > 0 for term in self.terms])
        if not pair.sharp or not white.any():
            return T
        # white angle noise where the points of the windows meet one by one: as in a record that is shorter
        shorter = shorter._replace(counts=(pair.counts[0] * step, pair.counts[1] * step))
        return np.where(white[:, None] | white, step * self._whole(shorter, step), T)

    def _whole(self, pair: WindowPair, step: float = 1.0) -> FloatArray:
        """With its windows as they are, samples lasting 1/step."""
        profile = self._profile(pair, step, sampled)
        return total(profile, *whole_lattice(*profile.sizes, pair.counts))

    def _profile(self, pair: WindowPair, step: float, D: Any) -> LagProfile:
        alike = all(term.alpha is not None and not term.per_sample for term in self.terms)
        key = (pair.windows, pair.m, None if alike else step, D)
        if key not in self.known:
            order = sum(row.order for row in pair.rows)
            terms = [slower(term, step, D) for term in self.terms]
            self.known[key] = profile_of(pair.windows, pair.m, terms, order=order, between=D is averaged)
        return self.known[key]
