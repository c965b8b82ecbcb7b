"""Covariance between two statistics of one record, over windows of two lengths.

With A, B the quadratic forms of the windows, and two windows whose centres are x samples apart,

    c_ij(x) = sum_rs w_r w_s C^i_rs(x) C^j_rs(x)        T_ij = sum_x n(x) c_ij(x) / (M1 M2)        Cov = 2 sum_ij T_ij

with n(x) pairs of windows at that distance. As `compact` has it for one window, c is a quadratic form in the values of
D around x. Windows of up to `POINTS` points together are taken as they are, and T is exact. Longer ones are replaced by
shorter ones of the same ratio, extrapolated; for windows of very different lengths the longer one is replaced by
shorter ones, and the ratio extrapolated as a power.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from allanite.statistics.row import FloatArray, IntArray, Statistic, Window
from allanite.terms import NoiseTerm

from .compact import FAR, Structure, averaged, expectation, extrapolation, mean_weights, sampled, white_level
from .lags import lag_nodes

POINTS = 400
"""Points of two windows together up to which they are taken as they are."""

SHORT = 160
"""Points of two windows together that longer ones are reduced to."""

LEAST = {1: 8, 2: 4}
"""By the power of the extrapolation: the least averaging factor of the shorter of two reduced windows."""

BESIDE, AFTER, FARTHEST = 64, 80, 600
"""Distances beyond the last kink where c is taken at every sample, nodes of the smooth rest, and its least end."""

INSIDE = np.array([0.5 - math.sqrt(0.05), 0.5 + math.sqrt(0.05)])
"""Nodes between two kinks, with which the kinks make a cubic."""

Windows = Callable[[int], Window]


class Form(NamedTuple):
    """Two windows: ``c(x)`` is the inner product of ``factor @ D_i(|x + grid|)`` and the like of D_j."""

    factor: FloatArray
    grid: FloatArray
    means: tuple[FloatArray, FloatArray]


@lru_cache(maxsize=512)
def form_of(first: Windows, m: int, second: Windows, k: int) -> Form:
    """The form of ``first(m)`` with ``second(k)``."""
    A, B = ((filters.T * weights) @ filters for weights, filters in (first(m), second(k)))
    p, q = len(A), len(B)
    shape = (p + q - 1, p + q - 1)
    # sum over j, j' of A[j, j'] B[j + h, j' + h'], by FFT
    spectrum = np.conj(np.fft.rfft2(A, shape)) * np.fft.rfft2(B, shape)
    h = np.arange(1 - p, q)
    pairs = np.fft.irfft2(spectrum, shape)[np.ix_(h, h)]
    size, directions = np.linalg.eigh((pairs + pairs.T) / 8)
    kept = size > 1e-13 * size[-1]
    factor = np.ascontiguousarray((directions[:, kept] * np.sqrt(size[kept])).T)
    return Form(
        factor, np.asarray(h - (q - p) / 2, dtype=np.float64), (mean_weights(first, m), mean_weights(second, k))
    )


class Profile(NamedTuple):
    """C(x) of two windows, over the root of the four expectations, at the kinks, between them and beyond."""

    first: float
    last: float
    steps: FloatArray
    beyond: FloatArray
    tail: FloatArray
    power: FloatArray


def profile_of(form: Form, structures: Sequence[Structure], decay: FloatArray, *, between: bool) -> Profile:
    """The profile of a form for terms with these D, whose covariances fall as x^-decay in the end."""
    half = float(form.grid[-1]) + 1
    first = half % 1
    last = half - 1
    kinks = first + np.arange(math.ceil(half - first) + 1.0 + (0 if between else BESIDE))
    beyond = last + np.geomspace(kinks[-1] - last, max(2 * FAR * half, FARTHEST), AFTER)
    inner = (kinks[:-1, None] + np.array([0.0, *INSIDE])).ravel() if between else kinks[:-1]
    x = np.concatenate((inner, beyond))
    distance = np.abs(x[:, None] + form.grid)
    root = [1 / math.sqrt(a * b) if (a := expectation(form.means[0], D)) and (b := expectation(form.means[1], D))
            else 0.0 for D in structures]  # fmt: skip
    C = [s * (D(distance) @ form.factor.T) for s, D in zip(root, structures, strict=True)]
    c = np.array([[np.einsum("xk,xk->x", a, b) for b in C] for a in C])
    return Profile(first, last, c[..., : inner.size], beyond, c[..., inner.size :], decay[:, None] + decay)


def total(profile: Profile, x: FloatArray, weight: FloatArray, *, between: bool) -> FloatArray:
    """``sum weight c(x)`` over distances x >= 0, shape (t, t)."""
    beyond = profile.beyond
    near = x < beyond[0] - 1e-9
    u = np.maximum(x[near] - profile.first, 0.0)
    if between:
        cell = np.minimum(np.floor(u + 1e-12).astype(np.int64), profile.steps.shape[-1] // 3 - 1)
        places, basis = 3 * cell + np.arange(4)[:, None], lagrange(u - cell, np.array([0.0, *INSIDE, 1.0]))
    else:
        places, basis = np.rint(u).astype(np.int64)[None], np.ones((1, u.size))
    inner = _gathered(places, basis * weight[near], profile.steps.shape[-1] + 1)
    T = profile.steps @ inner[:-1] + profile.tail[..., 0] * inner[-1]
    if near.all():
        return np.asarray(T)
    far, after = np.maximum(x[~near], beyond[0]), np.log(beyond - profile.last)
    v = (np.log(np.minimum(far, beyond[-1]) - profile.last) - after[0]) / (after[1] - after[0])
    cell = np.clip(np.floor(v).astype(np.int64) - 1, 0, beyond.size - 4)
    places, basis = cell + np.arange(4)[:, None], lagrange(v - cell, np.arange(4.0))
    for power in np.unique(profile.power):
        outer = _gathered(places, basis * weight[~near] / far**power, beyond.size) * beyond**power
        T = T + np.where(profile.power == power, profile.tail @ outer, 0.0)
    return np.asarray(T)


def lagrange(t: FloatArray, nodes: FloatArray) -> FloatArray:
    """Weights of the values at the nodes in that at t of the polynomial through them, shape (nodes, t)."""
    others = ~np.eye(nodes.size, dtype=bool)
    factors = [[(t - b) / (a - b) for b in nodes[o]] for a, o in zip(nodes, others, strict=True)]
    return np.asarray(np.prod(np.array(factors), axis=1))


def _gathered(places: IntArray, weights: FloatArray, size: int) -> FloatArray:
    return np.asarray(np.bincount(places.ravel(), weights.ravel(), size), dtype=np.float64)


def pair_lattice(half: float, step: float, counts: tuple[float, float], first: float) -> tuple[FloatArray, FloatArray]:
    """Distances x >= 0, in units of 1/step samples, and weights of the sum over all pairs of windows.

    `counts` are the numbers of windows, M1 >= M2; `half` the distance at which the windows no longer overlap, `first`
    the distance nearest to zero. The rule is that of `compact.lattice`.
    """
    M1, M2 = counts
    start = round(2 * first) / 2
    end = (M1 + M2) / 2
    if end <= 3 * half / step or step == 1:
        last = min(end, half + BESIDE + 1) if step == 1 else end
        lag = start + np.arange(max(math.ceil(last - start), 1.0))
        weight = np.ones(lag.size)
        if step == 1 and end > lag[-1] + 1:
            x, w = lag_nodes([float(lag[-1])], end - 1 if (end - 1 - start) % 1 == 0 else end - 0.5)
            lag, weight = np.concatenate((lag, x[1:])), np.concatenate((weight, w[1:]))
    else:
        kinks = (half % 1 + np.arange(math.ceil(half) + 1)) / step
        kinks = np.unique(np.concatenate(([start], kinks[kinks > start], [(M1 - M2) / 2])))
        kinks = kinks[(kinks >= start) & (kinks <= end)]
        between = np.diff(kinks) - 1
        spread = np.sqrt(np.maximum(between**2 - 1, 0) / 12)
        centre = (kinks[1:] + kinks[:-1]) / 2
        x, w = lag_nodes([float(kinks[-1])], max(end - 1, float(kinks[-1])))
        lag = np.concatenate((kinks[:-1], centre - spread, centre + spread, x))
        weight = np.concatenate((np.ones(between.size), between / 2, between / 2, w))
    pairs = np.clip(end - lag, 0.0, M2)
    return lag * step, weight * pairs * np.where(lag > 0, 2.0, 1.0) / (M1 * M2)


class Pair(NamedTuple):
    """Two statistics at an averaging factor each, the first with the shorter windows, and their numbers of windows."""

    rows: tuple[Statistic, Statistic]
    m: tuple[int, int]
    counts: tuple[float, float]

    @property
    def span(self) -> tuple[int, int]:
        """Sample intervals of a window over m."""
        return self.rows[0].span[0], self.rows[1].span[0]

    @property
    def points(self) -> int:
        """Points of the two windows."""
        return sum(row.span[0] * m + row.span[1] + 1 for row, m in zip(self.rows, self.m, strict=True))

    @property
    def power(self) -> int:
        """That of the extrapolation."""
        return min(row.scheme.power for row in self.rows)

    @property
    def sharp(self) -> bool:
        """Whether the windows hold single points of the angle."""
        return any(row.scheme.sharp or (row.differences and not row.summed) for row in self.rows)

    def aside(self, form: Form) -> float:
        """Distance between the middles of all windows of one and of the other: pdev omits a point, except at m = 1."""
        first, second = (row.span[0] * m + row.span[1] + 1 - (means.size + 1) // 2
                         for row, m, means in zip(self.rows, self.m, form.means, strict=True))  # fmt: skip
        return abs(first - second) / 2

    def shortened(self, k: int) -> "Pair":
        """The same with k for the longer window, in a record that is as many times shorter."""
        windows = self.counts[1] * k / self.m[1]
        one = self._replace(m=(self.m[0], k))
        return one._replace(counts=(windows + one._apart(), windows))

    def _apart(self) -> int:
        first, second = (row.span[0] * m + row.span[1] for row, m in zip(self.rows, self.m, strict=True))
        return second - first


@dataclass(frozen=True)
class Pairs:
    """Relative covariances under these terms; `known` are the profiles of the windows that were met."""

    terms: Sequence[NoiseTerm]
    known: dict[tuple[Any, ...], Profile] = field(default_factory=dict)

    def relative(self, rows: tuple[Statistic, Statistic], m: tuple[int, int], size: int) -> FloatArray:
        """T_ij over the root of the terms' four expectations, shape (t, t), in a record without gaps."""
        if rows[0].span[0] * m[0] > rows[1].span[0] * m[1]:
            rows, m = (rows[1], rows[0]), (m[1], m[0])
        counts = [float(row.count(size, np.array([k]))[0]) for row, k in zip(rows, m, strict=True)]
        T = self._within(Pair(rows, m, (counts[0], counts[1])))
        fixed = np.array([term.waveform is not None for term in self.terms])
        T[np.outer(fixed, fixed)] = 0.0
        return T

    def _within(self, pair: Pair) -> FloatArray:
        """As it is, reduced, or extrapolated in the ratio of the windows."""
        if pair.points <= POINTS:
            return self._reduced(pair, pair.m)
        a, b = pair.span
        (m, k), step = pair.m, pair.rows[1].step
        least = LEAST[pair.power]
        widest = (POINTS - a * m) / (b * m) if m <= least else (SHORT / least - a) / b
        if k <= widest * m:
            levels = _levels(pair.rows[0].step, m, SHORT / (a + b * k / m), 3 if pair.power == 1 else 2)
            found = [self._at(pair, level) for level in levels]
            return np.asarray(np.tensordot(extrapolation(levels, m, pair.power), found, 1))
        near = pair.shortened(int(widest * m) // step * step)
        nearer = pair.shortened(near.m[1] // 2 // step * step)
        far, close = (self._within(p) * p.counts[0] for p in (near, nearer))
        ratio = near.m[1] / nearer.m[1]
        # beside a ramp, whose covariance has no end, a random walk's grows with the root of the window
        fixed = np.array([term.waveform is not None for term in self.terms])
        most = np.where(fixed[:, None] | fixed, math.sqrt(ratio), 1.0)
        fall = np.clip(np.divide(far, close, out=np.zeros_like(far), where=close != 0), 0.0, most)
        more = math.log(k / near.m[1]) / math.log(ratio)
        return np.asarray(far * fall**more / pair.counts[0])

    def _at(self, pair: Pair, m: int) -> FloatArray:
        """With m for the shorter window, and between two factors for the longer one."""
        step = pair.rows[1].step
        wanted = pair.m[1] / pair.m[0] * m
        below = int(wanted) // step * step
        if below == wanted:
            return self._reduced(pair, (m, below))
        share = math.log(wanted / below) / math.log1p(step / below)
        return (1 - share) * self._reduced(pair, (m, below)) + share * self._reduced(pair, (m, below + step))

    def _reduced(self, pair: Pair, m: tuple[int, int]) -> FloatArray:
        """With windows of m intervals in place of its own, that last as long."""
        whole = m == pair.m
        step = 1.0 if whole else m[0] / pair.m[0]
        form = form_of(pair.rows[0].window, m[0], pair.rows[1].window, m[1])
        half = float(form.grid[-1]) + 1
        profile = self._profile(pair, m, step, sharp=whole)
        x, weight = pair_lattice(half, step, pair.counts, pair.points % 2 / 2)
        if whole and (aside := pair.aside(form)):
            x, weight = np.abs(np.concatenate((x + aside, x - aside))), np.tile(weight / 2, 2)
        T = total(profile, x, weight, between=not whole)
        white = np.array([white_level(term) > 0 for term in self.terms])
        if whole or not pair.sharp or not white.any():
            return T
        # white angle noise where the points of the windows meet one by one: as in a record that is shorter
        short = self._profile(pair, m, step, sharp=True)
        x, weight = pair_lattice(half, 1.0, (pair.counts[0] * step, pair.counts[1] * step), half % 1)
        own = step * total(short, x, weight, between=False)
        return np.where(white[:, None] | white, own, T)

    def _profile(self, pair: Pair, m: tuple[int, int], step: float, *, sharp: bool) -> Profile:
        alike = all(term.alpha is not None and not term.per_sample for term in self.terms)
        windows = pair.rows[0].window, pair.rows[1].window
        key = (windows, m, None if alike else step, sharp)
        if key not in self.known:
            form = form_of(windows[0], m[0], windows[1], m[1])
            structures = [(sampled if sharp else averaged)(term, step) for term in self.terms]
            far = sum(row.order for row in pair.rows) - 2.0
            decay = np.array([far if term.waveform is None else 0.0 for term in self.terms])
            self.known[key] = profile_of(form, structures, decay, between=not sharp)
        return self.known[key]


def _levels(step: int, m: int, top: float, count: int) -> list[int]:
    """Averaging factors of the shorter window, as even or odd as m, the largest below `top`."""
    step = 2 if step == 1 else step
    found = [max(int(top / 2**i) - (int(top / 2**i) - m) % step, m % step + step) for i in range(count)]
    return sorted(set(found))
