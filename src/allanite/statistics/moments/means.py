"""Differences of means of the remaining samples: curves of records with gaps, using incomplete windows."""

# Derivation: docs/derivations.md.

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray, IntArray
from allanite.kernels import allan
from allanite.statistics.row import Statistic, binomials
from allanite.terms import WHITE, NoiseTerm

Places = Sequence[tuple[int, int]]  # (first sample, samples) of each stretch without gaps of a record

COMPLETE = 0.9  # share of the windows that must be complete for the others to be omitted
QUARTERS = 4  # parts of a mean that are distinguished for slow noise, and windows that start within m
REFERENCES = 64  # windows whose covariances with all others represent those of all
MIN_WINDOWS = 24  # windows, at least, that a long averaging time is given


def takes_means(row: Statistic, m: int | IntArray, places: Places, size: int) -> BoolArray:
    """Whether windows with missing samples count too: where so many are lost that the complete ones are few."""
    m = np.asarray(m)
    if len(places) < 2 or not row.differences or row.summed:
        return np.zeros(m.shape, dtype=np.bool_)
    lengths = np.array([n for _, n in places])
    if not row.overlapped:
        whole = np.sum([row.count(int(n), m) for n in lengths], axis=0)
    else:
        # of the runs that hold a window each has as many as it is longer than that, and one more
        lengths = np.sort(lengths)[::-1]
        per, fixed = row.span
        window = per * m + fixed
        runs = np.searchsorted(-lengths, -window, side="right")
        whole = np.concatenate(([0], np.cumsum(lengths)))[runs] - runs * (window - 1)
    return np.asarray(whole < COMPLETE * row.count(size, m))


@dataclass(frozen=True, eq=False)
class There:
    """Where readings are: the stretches without gaps among so many samples."""

    places: Places
    size: int

    @cached_property
    def stretches(self) -> IntArray:
        """First sample and samples of each stretch, after one without samples, shape (2, stretches + 1)."""
        return np.array([(0, 0), *self.places], np.int64).T

    def before(self, at: IntArray, less: int = 0) -> IntArray:
        """Readings before samples, except for so many at the end of each stretch."""
        begin, length = self.stretches
        length = np.maximum(length - less, 0)
        which = np.searchsorted(begin, at, side="right") - 1
        return np.asarray((np.cumsum(length) - length)[which] + np.minimum(at - begin[which], length[which]))

    def between(self, begin: IntArray, end: IntArray) -> IntArray:
        """Readings in begin .. end - 1; 0 where end is not beyond begin."""
        return self.before(np.maximum(begin, end)) - self.before(begin)

    def steps(self, begin: IntArray, end: IntArray) -> IntArray:
        """Readings there that have the next one too."""
        begin = np.clip(begin, 0, self.size)
        return self.before(np.maximum(begin, end), 1) - self.before(begin, 1)


@dataclass(frozen=True, eq=False)
class JoinedWindows:
    """Windows of a row at m that have a reading in each part."""

    # `start` are their first samples, shape (w,), `count` the readings of their parts, shape (w, parts).
    row: Statistic
    m: int
    readings: There
    start: IntArray
    count: IntArray

    @property
    def signs(self) -> FloatArray:
        """What each part is multiplied with, b."""
        return binomials(self.row.differences - 1)

    @cached_property
    def h(self) -> FloatArray:
        """Readings that a window is worth, shape (w,)."""
        return np.asarray(1 / (self.signs**2 / self.count).sum(axis=1))

    @property
    def weight(self) -> FloatArray:
        """Weight of each delta^2 in the variance, shape (w,)."""
        return np.asarray(self.h**2 / (self.m * self.h.sum() * norm_of(self.row, self.m)))

    def of(self, which: IntArray) -> "JoinedWindows":
        """Some of them."""
        return JoinedWindows(self.row, self.m, self.readings, self.start[which], self.count[which])

    @property
    def edges(self) -> IntArray:
        """Begin of each part and end of the last, shape (w, parts + 1)."""
        return self.start[:, None] + self.m * np.arange(self.signs.size + 1)

    @cached_property
    def points(self) -> tuple[IntArray, FloatArray]:
        """Delta as a weighted sum of points of the angle: their times, and their weights, shape (w, points) each."""
        parts, quarters = self.signs.size, min(QUARTERS, self.m)
        inner = np.rint(np.arange(parts * quarters + 1) * (self.m / quarters)).astype(np.int64)
        time = self.start[:, None] + inner
        held = self.readings.between(time[:, :-1], time[:, 1:]) / np.diff(inner)
        rate = held * np.repeat(self.signs / self.count, quarters, axis=1)
        return time, -np.diff(np.pad(rate, ((0, 0), (1, 1))), axis=1)

    def variances(self, term: NoiseTerm) -> FloatArray:
        """Variance of the delta under a term of coefficient 1, unit sample interval, shape (w,)."""
        if term.edge:
            step = self.signs / self.count
            own = np.einsum(
                "wp,wp->w", step**2, 2.0 * (self.count - self.readings.steps(self.edges[:, :-1], self.edges[:, 1:] - 1))
            )
            between = sum(step[:, p] * step[:, p + 1] * self._across[:, p] for p in range(self._across.shape[1]))
            return np.asarray(term.edge * (own - 2 * between))
        if term.slope == WHITE:
            return np.asarray(1 / self.h)
        time, v = self.points
        D = structure_at(term, np.abs(time[:, :, None] - time[:, None, :]))
        return np.asarray(-0.5 * np.einsum("wi,wij,wj->w", v, D, v))

    @property
    def _across(self) -> IntArray:
        """Whether a part's last sample and the next part's first are both there."""
        border = self.edges[:, 1:-1]
        return self.readings.steps(border - 1, border)

    def covariances(self, term: NoiseTerm, near: "JoinedWindows") -> FloatArray:
        """Covariance of each delta with those of its own row of `near`, windows w x l, shape (w, l)."""
        w, one = self.start.size, near.signs / near.count
        other = one.reshape(w, -1, self.signs.size)
        if not term.edge and term.slope != WHITE:
            time, v = self.points
            times, others = (x.reshape(w, -1, time.shape[1]) for x in near.points)
            D = structure_at(term, np.abs(times[..., None, :] - time[:, None, :, None]))
            return np.asarray(-0.5 * np.einsum("wk,wlkj,wlj->wl", v, D, others, optimize=True))
        mine, begin, end = self.signs / self.count, self.edges[:, None, :-1], self.edges[:, None, 1:]
        theirs = near.edges.reshape(w, -1, self.signs.size + 1)
        total = np.zeros(other.shape[:2])
        for p in range(self.signs.size):
            a, b, c, d = begin[..., p, None], end[..., p, None], theirs[..., :-1], theirs[..., 1:]
            both = self.readings.between(np.maximum(a, c), np.minimum(b, d))
            if term.edge:
                both = 2 * both - self.readings.steps(np.maximum(a, c - 1), np.minimum(b, d - 1))
                both -= self.readings.steps(np.maximum(c, a - 1), np.minimum(d, b - 1))
            total += (term.edge or 1.0) * mine[:, p, None] * np.einsum("wlq,wlq->wl", other, both)
        return total


def structure_at(term: NoiseTerm, lag: IntArray) -> FloatArray:
    """D at whole lags, each computed once where they are fewer than the places that ask for them."""
    most = int(lag.max(initial=0)) + 1
    if most < lag.size:
        return term.structure(np.arange(float(most)))[lag]
    return term.structure(lag.astype(np.float64))


def windows_of(row: Statistic, m: int, readings: There, stride: int) -> JoinedWindows:
    """Windows that start every so many samples and have a reading in each part."""
    start = np.arange(0, readings.size - row.differences * m + 1, stride)
    edges = readings.before(start[:, None] + m * np.arange(row.differences + 1))
    count = np.diff(edges, axis=1)
    full = (count > 0).all(axis=1)
    return JoinedWindows(row, m, readings, start[full], count[full])


def variance_of(row: Statistic, m: int, readings: There, x: FloatArray) -> tuple[float, int]:
    """V and the number of windows, from sums x of the readings before each sample, shape (size + 1,)."""
    bounds = np.cumsum(readings.stretches[:, 1:], axis=0).T.ravel()
    h, squares, number = allan.of_means(x, bounds, m, row.differences, 1 if row.overlapped else m)
    return (squares / (m * h * norm_of(row, m)), number) if number else (np.nan, 0)


def norm_of(row: Statistic, m: int) -> float:
    """What a statistic divides squared differences by, over the sum of the squared signs of their parts."""
    return float(row.norm(np.array([m]))[0]) / float((binomials(row.differences - 1) ** 2).sum())


class TermMoments(NamedTuple):
    """Moments of V under a term of coefficient 1, unit sample interval: windows spread over the record are for all."""

    windows: int  # of which V is made
    E: float  # expectation of V
    # covariances of each of few windows with those near it, times the root of the weights, shape (w, l); of each with
    # all of the few, which is the quadratic form of V, shape (w, w)
    near: FloatArray
    form: FloatArray
    fixed: bool  # whether it is a waveform


def relative(terms: Sequence[TermMoments]) -> FloatArray:
    """r_ij, shape (t, t): half the relative covariance that terms i and j give the variance."""
    C, E = np.array([term.near.ravel() for term in terms]), np.array([term.E for term in terms])
    fixed = np.array([term.fixed for term in terms])
    T = np.where(np.outer(fixed, fixed), 0.0, C @ C.T)
    scale = np.outer(E, E)
    return np.asarray(np.divide(T, scale, out=np.zeros_like(T), where=scale != 0))


@dataclass(frozen=True, eq=False)
class MeanMoments:
    """Moments of V under terms: windows that start every quarter of m, or less, represent all."""

    windows: JoinedWindows

    def expectation(self, terms: Sequence[NoiseTerm]) -> FloatArray:
        """Expected variance of each term, unit sample interval, shape (t,)."""
        some = self.windows.of(_spread(self.windows.start.size, 8 * REFERENCES))
        return np.array([some.weight @ some.variances(term) for term in terms])

    def under(self, term: NoiseTerm) -> TermMoments:
        """All moments under a term."""
        few, near, each, weight = self._near
        form = few.covariances(term, each) * np.sqrt(np.outer(few.weight, few.weight))
        E, fixed = float(self.expectation([term])[0]), term.waveform is not None
        return TermMoments(self.windows.start.size, E, few.covariances(term, near) * weight, form, fixed)

    @cached_property
    def _near(self) -> tuple[JoinedWindows, JoinedWindows, JoinedWindows, FloatArray]:
        """Few windows, those near each of them and all of them for each; the root of the weights of those near."""
        every, at = self.windows, _spread(self.windows.start.size, REFERENCES)
        few, size = every.of(at), every.start.size
        # lags, in windows, at which windows may have to do with each other
        lags = np.arange(1 - size, size)
        if size > REFERENCES:
            most = 2 * every.row.differences * every.m // int(np.diff(every.start).min())
            lags = np.arange(-most, most + 1)
        index = at[:, None] + lags
        inside = (index >= 0) & (index < every.start.size)
        near = every.of(np.where(inside, index, at[:, None]).ravel())
        weight = every.weight[np.where(inside, index, 0)] * inside
        share = few.weight * (every.weight.sum() / few.weight.sum() if at.size else 1.0)
        return few, near, few.of(np.tile(np.arange(at.size), at.size)), np.sqrt(weight * share[:, None])


def mean_moments(row: Statistic, m: int, places: Places, size: int) -> MeanMoments:
    """Moments of the variance at m from means of the readings there."""
    most, readings = int(row.count(size, np.array([m]))[0]), There(places, size)
    stride = max(1, min(m // QUARTERS, most // MIN_WINDOWS)) if row.overlapped else m
    windows = windows_of(row, m, readings, stride)
    while row.overlapped and stride > 1 and windows.start.size < MIN_WINDOWS:  # those with readings are close together
        stride //= 2
        windows = windows_of(row, m, readings, stride)
    return MeanMoments(windows)


def _spread(count: int, most: int) -> IntArray:
    """Places of at most so many of a number, evenly."""
    k = min(count, most)
    return np.asarray(np.floor((np.arange(k) + 0.5) * count / max(k, 1)), dtype=np.int64)
