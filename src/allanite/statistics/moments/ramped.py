"""What a ramp and a noise together add to the covariance between points of a record, exactly.

A ramp gives every window the same output, so that its product with that of the noise, summed over the windows, is one
weighted sum of the record's rates. With g = A x the weights that one window gives its samples, x the ramp, L windows,

    W_j = sum_i g_j-i = H_j - H_j-L,    H the running sum of g,    T = W_a' C W_b

H ends with the window: in the middle of the record W is zero, and the two ends are all that counts.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from allanite.statistics.row import FloatArray, IntArray, Statistic
from allanite.terms import NoiseTerm

from .compact import averaged, slower
from .lags import far_difference, line_of, second_difference

MOST = 2**19
"""Samples of a window above which all is done in a record of fewer samples that lasts as long."""


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
        found = np.zeros(stop - start)
        inside = self.first[max(start, 0) : max(stop, 0)]
        found[max(-start, 0) :][: inside.size] = inside
        return found

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
    """W_a' C W_b of points a, b for coefficients of 1 and a unit sample interval, shape (k, k, t).

    The variances are those of the rate; windows that remove a ramp have nothing.
    """
    span = np.array([row.span[0] * k for row, k in zip(rows, m.tolist(), strict=True)])
    seen = [i for i in np.argsort(span, kind="stable").tolist() if rows[i].order < 3]
    short = [i for i in seen if span[i] <= MOST]
    ends = {i: ends_of(rows[i], int(m[i]), size) for i in short}
    T = np.zeros((m.size, m.size, len(terms)))
    if len(short) < len(seen):
        coarser = -(-int(span[seen].max()) // MOST)
        step = np.array([row.step for row in rows])
        fewer = np.maximum(np.rint(m / coarser / step).astype(np.int64), 1) * step
        T = crossed(rows, fewer, size // coarser, [slower(term, 1 / coarser, averaged) for term in terms])
        own = np.ones(m.size)
        own[short] = [ends[i].mass / ends_of(rows[i], int(fewer[i]), size // coarser).mass / coarser for i in short]
        T *= np.outer(own, own)[..., None]
    tables = [second_difference(term, min(size, 2 * MOST)) / 2 if short and not line_of(term) else np.empty(0)
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
    kernel = _lagged(term, table, *lags) - _lagged(term, table, lags[0] - L, lags[1] - L)
    from scipy.fft import irfft, next_fast_len, rfft

    length = next_fast_len(kernel.size, real=True)
    return np.asarray(irfft(rfft(kernel, length) * rfft(H, length), length)[H.size - 1 : kernel.size])


def _lagged(term: NoiseTerm, table: FloatArray, start: int, stop: int) -> FloatArray:
    """C at the lags start .. stop - 1."""
    lag = np.abs(np.arange(start, stop))
    beyond = lag >= table.size
    C = table[np.where(beyond, 0, lag)]
    C[beyond] = far_difference(term, lag[beyond].astype(np.float64)) / 2
    return np.asarray(C)
