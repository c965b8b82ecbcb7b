"""Covariance between two statistics of one record, over windows of two lengths (docs/derivations.md)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.statistics.row import Statistic
from allanite.terms import NoiseTerm

from .compact import averaged, extrapolation, kinked_nodes, sampled, slower, white_level
from .lagsums import lag_nodes, responses
from .profile import SAMPLES_BEYOND, LagProfile, Windows, profile_of, total
from .windowed import relative, response

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
