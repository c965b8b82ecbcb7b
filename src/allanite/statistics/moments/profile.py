"""How two windows are correlated at any distance, and what a ramp and a noise add to it together."""

# Derivation: docs/derivations.md.

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
import scipy

from allanite.core.arrays import FloatArray, IntArray
from allanite.statistics.row import Statistic, Window
from allanite.terms import NoiseTerm

from .compact import FAR_WINDOWS, averaged, slower
from .lagsums import FAR_LAG as SMOOTH, far_difference, line_of, second_difference

SAMPLES_BEYOND, NODES_BEYOND, MIN_END = 64, 80, 600
"""Distances beyond the last kink where c is taken at every sample, nodes of the smooth rest, and its least end."""

INSIDE = (0.5 - 0.05**0.5, 0.5 + 0.05**0.5)  # nodes between two kinks, with which the kinks make a cubic

Windows = Callable[[int], Window]


class LagProfile(NamedTuple):
    """c(x) of two windows whose centres are x >= 0 apart: at and between the kinks, and beyond; shape (t, t, nodes)."""

    # Over the root of the four expectations `E`, shape (2, t). `sizes` are the samples of the windows; `first` and
    # `last` are kinks, `nodes` the places in the step between two, `power` that of the fall in the end.
    E: FloatArray
    sizes: tuple[int, int]
    first: float
    last: float
    nodes: FloatArray
    steps: FloatArray
    beyond: FloatArray
    tail: FloatArray
    power: float


class WindowForm(NamedTuple):
    """A of one window, ``y'Ay`` for the rates y of its samples; the sums of its diagonals; f if it is ff'."""

    A: FloatArray
    diagonals: FloatArray
    single: FloatArray | None


@lru_cache(maxsize=32)
def form_of(window: Windows, m: int) -> WindowForm:
    """The form of ``window(m)``."""
    weights, filters = window(m)
    rates = -np.cumsum(filters, axis=1)[:, :-1]
    A = (rates.T * weights) @ rates
    p = len(A)
    # with p zeros after each row, and one place less in a row, diagonals become columns
    diagonals = np.pad(A[:, ::-1], ((0, 0), (0, p))).ravel()[:-p].reshape(p, 2 * p - 1).sum(axis=0)
    return WindowForm(A, diagonals, rates[0] * math.sqrt(weights[0]) if weights.size == 1 else None)


def profile_of(
    windows: tuple[Windows, Windows], m: tuple[int, int], terms: Sequence[NoiseTerm], *, order: int, between: bool
) -> LagProfile:
    """The profile of windows that are alike from both ends, under noise."""
    # `order` is that of both differences together; `between` asks for nodes between the samples, not only at these.
    first, second = (form_of(window, k) for window, k in zip(windows, m, strict=True))
    sizes = len(first.A), len(second.A)
    last = sum(sizes) / 2
    nodes = np.array([0.0, *INSIDE]) if between else np.zeros(1)
    kinks = np.arange(last % 1, last + 1.5 + (0 if between else SAMPLES_BEYOND))
    beyond = last + np.geomspace(kinks[-1] - last, max(2 * FAR_WINDOWS * (last + 1), MIN_END), NODES_BEYOND)
    # the first lag of the rates of two windows at these distances
    start = np.append(kinks[:-1, None] + nodes, beyond) - (last - 1)
    C = [_lagged(term, start, sum(sizes) - 1, kinks.size - 1) for term in terms]
    if first.single is not None and second.single is not None:
        c = np.einsum("is,js->ijs", *[np.array(C) @ np.correlate(second.single, first.single, "full")] * 2)
    else:
        # m, shape (len(A) + len(B) - 1,) * 2, by FFT
        A, B = first.A, second.A
        length = scipy.fft.next_fast_len(len(A) + len(B) - 1, real=True)
        a, b = (scipy.fft.fft(scipy.fft.rfft(form, length), length, axis=0, overwrite_x=True) for form in (A, B))
        M = scipy.fft.irfft2(np.conj(a) * b, (length, length))
        h = np.arange(1 - len(A), len(B))
        c = _of_many(C, np.asarray(M[np.ix_(h, h)]), None if between else start, terms)
    E = np.array(
        [
            [float(form.diagonals @ _rates(term, np.abs(np.arange(1.0 - len(form.A), len(form.A))))) for term in terms]
            for form in (first, second)
        ]
    )
    scale = np.sqrt(E.prod(axis=0))
    c /= np.outer(scale, scale)[..., None]
    near = start.size - NODES_BEYOND
    return LagProfile(E, sizes, last % 1, last, nodes, c[..., :near], beyond, c[..., near:], 2.0 * order - 4)


def _of_many(C: list[FloatArray], M: FloatArray, start: FloatArray | None, terms: Sequence[NoiseTerm]) -> FloatArray:
    """c, shape (t, t, s), of the rates' covariances C, shape (s, h) each; `start` where their lags are whole."""
    c = np.zeros((len(C), len(C), len(C[0])))
    straight = None if start is None else _Straight(M, start)
    for j, term in enumerate(terms):
        line = line_of(term)
        Y = straight.times(*line) if straight and line else C[j] @ M
        for i in range(j + 1):
            c[i, j, : len(Y)] = c[j, i, : len(Y)] = np.einsum("sh,sh->s", C[i][: len(Y)], Y)
    return c


class _Straight:
    """Products with M of covariances that are straight lines from lag 2 on: they are zero once all lags are beyond."""

    def __init__(self, M: FloatArray, start: FloatArray) -> None:
        # the place in M of a lag of zero falls by one from each distance to the next, down to one before M
        first = -round(start[0])
        self.rows = np.concatenate((np.zeros((2, len(M))), M[: first + 2]))[::-1]

    @cached_property
    def sums(self) -> FloatArray:
        """Running sums of the running sums of M, before each place."""
        return np.cumsum(np.cumsum(self.rows[::-1], axis=0), axis=0)[::-1]

    def times(self, own: float, beside: float, slope: float) -> FloatArray:
        """C M of the first distances, shape (s, h)."""
        Y = own * self.rows[1:-1]
        if beside:
            Y += beside * (self.rows[2:] + self.rows[:-2])
        if slope:
            Y += 2 * slope * self.sums[2:]
        return Y


def _rates(term: NoiseTerm, lag: FloatArray) -> FloatArray:
    """Covariance of two rates, shape of lag; a constant is left to choice."""
    C = np.empty(lag.shape)
    far = lag >= SMOOTH
    C[far] = far_difference(term, lag[far])
    near, D = lag[~far], term.structure
    C[~far] = D(near + 1) - 2 * D(near) + D(np.abs(near - 1))
    return C / 2


def _lagged(term: NoiseTerm, start: FloatArray, size: int, cells: int) -> FloatArray:
    """Covariance of rates at `size` lags from each start on, shape (start, size)."""
    # The starts are equally spaced in `cells` rows, but for some at the end.
    nodes = (start.size - NODES_BEYOND) // cells
    h = np.arange(size)
    C = np.empty((start.size, size))
    for i in range(nodes):
        table = _rates(term, np.abs(start[i] + np.arange(cells - 1 + size)))
        C[i : nodes * cells : nodes] = np.lib.stride_tricks.sliding_window_view(table, size)
    C[nodes * cells :] = _rates(term, np.abs(start[nodes * cells :, None] + h))
    return C


def total(profile: LagProfile, x: FloatArray, weight: FloatArray) -> FloatArray:
    """``sum weight c(x)`` over distances x >= 0, shape (t, t)."""
    beyond, size = profile.beyond, profile.nodes.size
    near = x < beyond[0] - 1e-9
    u = np.maximum(x[near] - profile.first, 0.0)
    if size > 1:
        cell = np.minimum(np.floor(u + 1e-12).astype(np.int64), profile.steps.shape[-1] // size - 1)
        places, basis = size * cell + np.arange(size + 1)[:, None], lagrange(u - cell, np.append(profile.nodes, 1.0))
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
    outer = _gathered(places, basis * weight[~near] / far**profile.power, beyond.size) * beyond**profile.power
    return np.asarray(T + profile.tail @ outer)


def lagrange(t: FloatArray, nodes: FloatArray) -> FloatArray:
    """Weights of the values at the nodes in that at t of the polynomial through them, shape (nodes, t)."""
    others = ~np.eye(nodes.size, dtype=bool)
    factors = [[(t - b) / (a - b) for b in nodes[o]] for a, o in zip(nodes, others, strict=True)]
    return np.asarray(np.prod(np.array(factors), axis=1))


def _gathered(places: IntArray, weights: FloatArray, size: int) -> FloatArray:
    return np.asarray(np.bincount(places.ravel(), weights.ravel(), size), dtype=np.float64)


MAX_SAMPLES = 2**19  # samples of a window above which all is done in a record of fewer samples that lasts as long


@dataclass(frozen=True, eq=False)
class Ends:
    """W of a point: the running sums H of a window's weights, and the number of windows."""

    first: FloatArray
    windows: int

    @cached_property
    def sums(self) -> tuple[FloatArray, FloatArray]:
        """Running sums of H, and of these before each sample."""
        once = np.cumsum(self.first)
        return once, np.concatenate(([0.0], np.cumsum(once)))

    @property
    def mass(self) -> float:
        """Sum of W at the record's begin, which that at its end takes back."""
        return float(self.sums[0][-1])

    def at(self, start: int, stop: int) -> FloatArray:
        """W at the samples start .. stop - 1."""
        return self._cut(start, stop) - self._cut(start - self.windows, stop - self.windows)

    def _cut(self, start: int, stop: int) -> FloatArray:
        piece = np.zeros(stop - start)
        inside = self.first[max(start, 0) : max(stop, 0)]
        piece[max(-start, 0) :][: inside.size] = inside
        return piece

    def twice(self, start: int, stop: int) -> FloatArray:
        """The running sum of the running sum of W before these samples."""
        return self._twice(start, stop) - self._twice(start - self.windows, stop - self.windows)

    def _twice(self, start: int, stop: int) -> FloatArray:
        place, size = np.arange(start, stop), self.first.size
        return np.asarray(self.sums[1][np.clip(place, 0, size)] + self.mass * np.maximum(place - size, 0))


def ends_of(row: Statistic, m: int, size: int) -> Ends:
    """W of a point, over the norm of its variance."""
    windows = int(row.count(size, np.array([m]))[0])
    # weights of a window for the ramp x_j = j^2/2, but for a line
    if row.scheme.ramp is not None:
        g = row.scheme.ramp(m)
    elif row.window is None:
        raise TypeError(f"{row.name} has no window")
    else:
        weights, filters = row.window(m)
        place = np.arange(filters.shape[1]) - (filters.shape[1] - 1) / 2
        g = (weights * (filters @ (place**2 / 2))) @ filters
    first = -np.cumsum(np.cumsum(g)[:-1])
    return Ends(first / (windows * float(row.norm(np.array([m]))[0]) * float(m) ** 2), windows)


def crossed(rows: Sequence[Statistic], m: IntArray, size: int, terms: Sequence[NoiseTerm]) -> FloatArray:
    """W_a' C W_b of points a, b for coefficients of 1 and a unit sample interval, shape (k, k, t)."""
    # The variances are those of the rate; windows that remove a ramp have nothing.
    span = np.array([row.span[0] * k for row, k in zip(rows, m.tolist(), strict=True)])
    free = [i for i in np.argsort(span, kind="stable").tolist() if rows[i].order < 3]
    short = [i for i in free if span[i] <= MAX_SAMPLES]
    ends = {i: ends_of(rows[i], int(m[i]), size) for i in short}
    T = np.zeros((m.size, m.size, len(terms)))
    if len(short) < len(free):
        coarser = -(-int(span[free].max()) // MAX_SAMPLES)
        step = np.array([row.step for row in rows])
        fewer = np.maximum(np.rint(m / coarser / step).astype(np.int64), 1) * step
        T = crossed(rows, fewer, size // coarser, [slower(term, 1 / coarser, averaged) for term in terms])
        own = np.ones(m.size)
        own[short] = [ends[i].mass / ends_of(rows[i], int(fewer[i]), size // coarser).mass / coarser for i in short]
        T *= np.outer(own, own)[..., None]
    tables = [second_difference(term, min(size, 2 * MAX_SAMPLES)) / 2 if short and not line_of(term) else np.empty(0)
              for term in terms]  # fmt: skip
    for n, b in enumerate(short, 1):
        T[short[:n], b] = T[b, short[:n]] = _with(ends[b], [ends[a] for a in short[:n]], terms, tables)
    return T


def _with(b: Ends, others: list[Ends], terms: Sequence[NoiseTerm], tables: list[FloatArray]) -> FloatArray:
    """W_a' C W_b of one point with others, shape (a, t)."""
    places = np.array([[0, a.first.size, a.windows, a.windows + a.first.size] for a in others])
    if np.any(places[:, 1] > places[:, 2]):
        places = places[:, [0, 3]]
    T = np.zeros((len(others), len(terms)))
    for which in np.split(places, places.shape[1] // 2, axis=1):
        start, stop = int(which[:, 0].min()), int(which[:, 1].max())
        Q = [_times(b, (start, stop), term, table) for term, table in zip(terms, tables, strict=True)]
        for i, (a, (first, last)) in enumerate(zip(others, which.tolist(), strict=True)):
            T[i] += [a.at(first, last) @ q[first - start : last - start] for q in Q]
    return T


def _times(b: Ends, places: tuple[int, int], term: NoiseTerm, table: FloatArray) -> FloatArray:
    """C W at these samples, but for a constant."""
    start, stop = places
    if line := line_of(term):
        own, beside, slope = line
        W = b.at(start - 1, stop + 1)
        return np.asarray(own * W[1:-1] + beside * (W[2:] + W[:-2]) + 2 * slope * b.twice(start, stop))
    H, L = b.first, b.windows
    lags = start - H.size + 1, stop
    kernel = _covariances_at(term, table, *lags) - _covariances_at(term, table, lags[0] - L, lags[1] - L)
    length = scipy.fft.next_fast_len(kernel.size, real=True)
    product = scipy.fft.rfft(kernel, length) * scipy.fft.rfft(H, length)
    return np.asarray(scipy.fft.irfft(product, length)[H.size - 1 : kernel.size])


def _covariances_at(term: NoiseTerm, table: FloatArray, start: int, stop: int) -> FloatArray:
    """C at the lags start .. stop - 1."""
    lag = np.abs(np.arange(start, stop))
    beyond = lag >= table.size
    C = table[np.where(beyond, 0, lag)]
    C[beyond] = far_difference(term, lag[beyond].astype(np.float64)) / 2
    return np.asarray(C)
