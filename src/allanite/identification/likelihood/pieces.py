"""A rate with gaps and strong angle noise: short averaging times are estimated from each piece separately."""

# Derivation: docs/derivations.md.

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from allanite.core.arrays import BoolArray, FloatArray, IntArray
from allanite.core.plain import Portable
from allanite.prepare.gaps import Gaps
from allanite.statistics.moments.lagsums import second_difference
from allanite.terms import WHITE, NoiseTerm

from .likelihood import Likelihood


def rate_weights(L: int, ratio: float) -> tuple[FloatArray, float]:
    """Weights w of the rate of L samples by generalized least squares, and its variance over that of one sample's N."""
    # (I + rho T) x = 1 has the solution 1 - cosh(a (i - c)) / cosh(a c), c = (L + 1) / 2 and 2 cosh(a) = 2 + 1 / rho.
    i = np.arange(1.0, L + 1)
    a = 2 * np.arcsinh(0.5 / np.sqrt(ratio))
    x = np.expm1(-a * i) * np.expm1(-a * (L + 1 - i)) / (1 + np.exp(-a * (L + 1)))  # the same without cancellation
    return np.asarray(x / x.sum()), float(1 / x.sum())


def angle_power(L: int) -> FloatArray:
    """Variance of the coefficients of the sine transform under angle noise, the eigenvalues of T."""
    return np.asarray(4 * np.sin(np.pi / (2 * (L + 1)) * np.arange(1, L + 1)) ** 2)


def low_powers(L: int, ratio: float, split: float, omega: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Power at frequencies of what a piece gives the joined record below the split, under white noise and under T."""
    w, _ = rate_weights(L, ratio)
    wave = np.exp(1j * np.outer(omega, np.arange(L)))
    coefficients = sine(wave)
    coefficients[:, np.pi / (L + 1) * np.arange(1, L + 1) >= split] = 0.0
    r = sine(coefficients)
    q = r + np.outer((wave - r).sum(axis=1), w)
    step = np.diff(np.pad(q, ((0, 0), (1, 1))), axis=1)
    return (np.abs(q) ** 2).sum(axis=1), (np.abs(step) ** 2).sum(axis=1)


def sine(x: FloatArray) -> FloatArray:
    """The orthonormal DST-I of the last axis, its own inverse."""
    return np.asarray(scipy.fft.dst(x, type=1, norm="ortho"))


SHORT_TRANSFORM = 1 << 16  # points up to which a transform of any size is fast enough
PRIME = 256  # largest prime factor of the size of a transform that takes no more than others, unless it is short
TOGETHER = 1 << 20  # samples of pieces that are transformed at once


def smooth(size: int) -> bool:
    """Whether a size has small prime factors only: the transform of others takes many times the memory and time."""
    return pow(math.factorial(PRIME), size.bit_length(), size) == 0


def sine_variances(c: FloatArray) -> FloatArray:
    """Diagonal of S'CS of the Toeplitz matrix with the first row c."""
    # Sum over lags h of both signs of c(h) ((L - h) cos(omega h) + sin(omega (h + 1)) / sin(omega)) / (L + 1).
    L = c.size
    cosines = scipy.fft.dct(np.append(c * (L - np.arange(L)), [0.0, 0.0]), type=1)[1:-1]
    sines = scipy.fft.dst(c, type=1) / np.sin(np.pi / (L + 1) * np.arange(1, L + 1))
    return np.asarray((cosines + sines - c[0]) / (L + 1))


def toeplitz(c: FloatArray, v: FloatArray) -> FloatArray:
    """Product of the symmetric Toeplitz matrix with first row c with v."""
    size = scipy.fft.next_fast_len(2 * v.size, real=True)
    # a circle of more than twice the lags: none is met from both sides
    circle = np.concatenate((c, np.zeros(size - 2 * c.size + 1), c[:0:-1]))
    return np.asarray(scipy.fft.irfft(scipy.fft.rfft(circle) * scipy.fft.rfft(v, size), size)[: v.size])


WEIGHT = 0.1
"""Power that the joints add to the low coefficients of the joined record, over that of white noise, from which the
pieces are read by themselves."""

SPLIT = 0.5  # frequency between the parts, over that at which white rate and angle noise are alike
HIGHEST_SPLIT = 0.5  # the same, over half the sampling rate, at most
CLEAR = 0.5  # share of a coefficient that the rate of its piece must leave, for it to be called a peak
LENGTHS = 24  # lengths of pieces, at most, for which expectations of slow noise are computed

RESPONSE_GRID = 24
"""Frequencies, evenly in the logarithm and again evenly, at which the lower part's response is computed."""


@dataclass(frozen=True, eq=False)
class PieceReading(Portable):
    """How a record in pieces is read."""

    # length, times: shape (l,); the lengths that pieces have, and how many have each
    length: IntArray
    times: IntArray | FloatArray
    ratio: float  # Q^2 / N^2, angles in units of the sample interval, that the weights suppose
    least: int  # PieceReading that are shorter take no part below `split`: they would add noise only
    split: float  # frequency between the parts, radians a sample
    edges: IntArray  # bounds of the bins, in coefficients of the joined record

    @property
    def size(self) -> int:
        """Samples that are joined."""
        return int((self.length * self.times)[self.length >= self.least].sum())

    @property
    def low(self) -> int:
        """Bins of the lower part."""
        return int(np.searchsorted(self.edges, self.split / np.pi * self.size - 0.5))

    @cached_property
    def bins(self) -> list[IntArray]:
        """The bin of each coefficient of the sine transform, for each length; -1 for those of the lower part."""
        places = []
        for L in self.length.tolist():
            at = np.searchsorted(self.edges, np.arange(1, L + 1) * (self.size / (L + 1)), side="right") - 1
            places.append(np.where(at < self.low, -1, np.minimum(at, self.edges.size - 2)))
        return places

    def pooled(self, each: list[FloatArray]) -> FloatArray:
        """Sums over the bins of what every piece of a length has at its coefficients, shape (bins,)."""
        total = np.zeros(self.edges.size)
        for bins, values, times in zip(self.bins, each, self.times, strict=True):
            total += times * np.bincount(bins + 1, values, total.size)
        return total[1:]

    @cached_property
    def weight(self) -> list[FloatArray]:
        """Weight of each coefficient in its bin, by length: one over its variance under the ratio, except for c."""
        return [1 / (1 + self.ratio * angle_power(int(L))) for L in self.length]

    def mean(self, each: list[FloatArray], nothing: FloatArray) -> FloatArray:
        """Weighted means over the bins, shape (bins,); `nothing` where no coefficient lies."""
        sums = self.pooled([w * x for w, x in zip(self.weight, each, strict=True)])
        return np.divide(sums, self._weights, out=nothing.copy(), where=self._weights > 0)

    @cached_property
    def _weights(self) -> FloatArray:
        return self.pooled(self.weight)

    @cached_property
    def shares(self) -> list[FloatArray]:
        """What the rate of the piece leaves of each coefficient, for each length."""
        both = ((rate_weights(int(L), self.ratio)[1], sine(np.ones(int(L)))) for L in self.length)
        return [1 - u**2 * v * w for (v, u), w in zip(both, self.weight, strict=True)]

    @cached_property
    def told(self) -> FloatArray:
        """Coefficients of the sine transforms in the bins, less what the rates of the pieces take, shape (bins,)."""
        return self.pooled(self.shares)

    def row(self, term: NoiseTerm, gaps: Gaps, k: FloatArray) -> FloatArray:
        """Variance of the k-th coefficients of the lower part under a term, on average over where the joints lie."""
        omega, white, angle = self._lower
        at = np.pi / self.size * k
        if term.edge:
            return np.asarray(term.edge * np.interp(at, omega, angle))
        return np.asarray(gaps.row(term, k) * np.interp(at, omega, white))

    def upper(self, term: NoiseTerm, mean: FloatArray) -> FloatArray:
        """Mean variance under a term in the bins, shape (bins,); that which is given where no coefficient lies."""
        # What is neither white rate nor white angle noise is little here: a few lengths represent all.
        if term.edge or term.slope == WHITE:
            # the same as `_variances` where C is T or 1, so that S'CS is diagonal
            each = []
            for L, (w, u) in zip(self.length.tolist(), self._rates, strict=True):
                diagonal = term.edge * angle_power(L) if term.edge else np.ones(L)
                Sw = sine(w)
                each.append(np.asarray(diagonal - 2 * u * diagonal * Sw + u**2 * float(Sw @ (diagonal * Sw))))
            return self.mean(each, mean)
        some = self._some
        c = second_difference(term, int(some.length.max())) / 2
        return some.mean([some._variances(c, i) for i in range(some.length.size)], mean)

    @cached_property
    def _some(self) -> "PieceReading":
        """The same with few different lengths, each for its neighbours and for as many samples as they."""
        if self.length.size <= LENGTHS:
            return self
        readings = self.length * self.times
        group = (np.cumsum(readings) - readings) * LENGTHS // readings.sum()
        first = np.unique(group, return_index=True)[1]
        middle = self.length[(first + np.append(first[1:], group.size) - 1) // 2]
        return replace(self, length=middle, times=np.add.reduceat(readings, first) / middle)

    @cached_property
    def _rates(self) -> list[tuple[FloatArray, FloatArray]]:
        """The weights w of the rate of a piece, and u = S'1, for each length."""
        return [(rate_weights(int(L), self.ratio)[0], sine(np.ones(int(L)))) for L in self.length]

    def _variances(self, c: FloatArray, i: int) -> FloatArray:
        """Variances of all d of a piece: with u = S'1 and the covariance C, diag(S'CS) - 2 u S'Cw + u^2 w'Cw."""
        # `c` is the first row of C, or of that of a longer piece.
        (w, u), c = self._rates[i], c[: self.length[i]]
        Cw = toeplitz(c, w)
        return np.asarray(sine_variances(c) - 2 * u * sine(Cw) + u**2 * float(w @ Cw))

    @cached_property
    def _lower(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Frequencies, and the power of the lower part there under white rate and angle noise."""
        omega = np.unique(
            np.append(
                np.geomspace(np.pi / self.size, self.split, RESPONSE_GRID), np.linspace(0, self.split, RESPONSE_GRID)
            )
        )
        kept = self.length >= self.least
        powers = np.zeros((2, omega.size))
        for L, times in zip(self.length[kept].tolist(), self.times[kept].tolist(), strict=True):
            powers += times * np.array(low_powers(L, self.ratio, self.split, omega))
        return omega, powers[0] / self.size, powers[1] / self.size

    @cached_property
    def even(self) -> float:
        """Share of the lower part's coefficients that count: less than 1 where the pieces are not equally noisy."""
        kept = self.length >= self.least
        lengths = self.length[kept].tolist()
        both = np.array([low_powers(L, self.ratio, self.split, np.zeros(1)) for L in lengths])[:, :, 0]
        level, weight = (both[:, 0] + self.ratio * both[:, 1]) / lengths, lengths * self.times[kept]
        return float((weight @ level) ** 2 / (weight.sum() * (weight @ level**2)))


FEWEST_FREQUENCIES = 5
"""Different frequencies, an eighth of an octave apart, that pieces need to tell white rate from angle noise beside slow
noise; shorter ones are joined only, which is exact, if less efficient."""

FARTHEST_RATIO = 2.0
"""Root of Q^2 / N^2, over the length of the piece in which a reading lies on average, beyond which N is not seen."""


def pieces(y: FloatArray, gaps: Gaps, edges_of: Callable[[int], IntArray]) -> PieceReading | None:
    """How to read a joined rate; None where the joints do not matter beside white rate noise."""
    if not gaps.at.size or gaps.shut.any():
        return None
    lengths = _each(gaps)[1]
    length, times = np.unique(lengths, return_counts=True)
    ratio = _ratio(y, lengths)
    if ratio is None or ratio * 2 * gaps.at.size / gaps.size < WEIGHT:
        return None
    split = min(SPLIT / np.sqrt(ratio), HIGHEST_SPLIT * np.pi)
    level = [float(a[0] + ratio * b[0]) for a, b in (low_powers(int(L), ratio, split, np.zeros(1)) for L in length)]
    noise, used = np.cumsum((times * level)[::-1])[::-1], np.cumsum((times * length)[::-1])[::-1]
    least = int(length[np.argmin(noise / used.astype(np.float64) ** 2)])
    size = int(used[np.searchsorted(length, least)])
    edges = edges_of(size)
    low = int(np.searchsorted(edges, split / np.pi * size))
    how = PieceReading(length, times, ratio, least, float(edges[low] * np.pi / size), edges)
    # no bin of the upper part is empty: one that would be is part of its neighbour
    filled = low + np.flatnonzero(how.told[low:])
    return replace(how, edges=np.concatenate((edges[: low + 1], edges[filled[1:]], edges[-1:])))


def apart(y: FloatArray, gaps: Gaps, how: PieceReading) -> tuple[FloatArray, BoolArray, FloatArray, FloatArray]:
    """The joined record below the split; which samples it has; power of the bins above, and their peaks."""
    # A peak stands out over what the coefficient has under the ratio.
    starts, lengths = _each(gaps)
    low, kept = np.empty_like(y), np.repeat(lengths >= how.least, lengths)
    squares, peak = [], np.zeros(how.edges.size)
    for L, bins, weight, share in zip(how.length.tolist(), how.bins, how.weight, how.shares, strict=True):
        where = starts[lengths == L][:, None] + np.arange(L)
        each = y[where]
        each = each - (each @ rate_weights(L, how.ratio)[0])[:, None]
        d = scipy.fft.dst(each, type=1, norm="ortho")
        squares.append((d**2).mean(axis=0))
        np.maximum.at(
            peak, bins + 1, np.where(share > CLEAR, weight / np.maximum(share, CLEAR), 0.0) * (d**2).max(axis=0)
        )
        d[:, bins < 0] = 0.0
        low[where] = y[where] - scipy.fft.dst(d, type=1, norm="ortho")
    nothing = np.zeros(how.edges.size - 1)
    level = how.mean([share / weight for share, weight in zip(how.shares, how.weight, strict=True)], nothing)
    return low[kept], kept, how.mean(squares, nothing), peak[1:] * level


def _each(gaps: Gaps) -> tuple[IntArray, IntArray]:
    """Starts and lengths of the pieces; an angle between two gaps leaves no rate, and is none."""
    bounds = np.unique(np.concatenate(([0], gaps.at, [gaps.size])))
    return bounds[:-1], np.diff(bounds)


def _ratio(y: FloatArray, lengths: IntArray) -> float | None:
    """Q^2 / N^2 from the coefficients of the pieces to which a constant rate adds nothing, beside a slow noise."""
    # None where the pieces are too short to tell.
    starts = np.concatenate(([0], np.cumsum(lengths)[:-1]))
    parts = []
    for L in np.unique(lengths[lengths > 1]).tolist():
        here, size = starts[lengths == L], next(k for k in range(L, 0, -1) if k < SHORT_TRANSFORM or smooth(k + 1))
        every, power = np.lib.stride_tricks.sliding_window_view(y, size), np.zeros(size // 2)
        for some in np.array_split(here, min(here.size, -(-here.size * size // TOGETHER))):
            d = sine(every[some])[:, 1::2]
            power += np.einsum("pk,pk->k", d, d)
        parts.append((np.arange(2, size + 1, 2) / (size + 1), power, np.full(size // 2, float(here.size))))
    if not parts:
        return None
    x, power, times = map(np.concatenate, zip(*parts, strict=True))
    most = (FARTHEST_RATIO * float(lengths @ lengths) / float(lengths.sum())) ** 2
    if not power.any():  # each piece is constant
        return most
    octave = np.floor(-8 * np.log2(x)).astype(np.int32)
    octave = (np.cumsum(np.bincount(octave) > 0) - 1)[octave]
    count = np.bincount(octave, times).astype(np.float64)
    if count.size < FEWEST_FREQUENCIES:
        return None
    angle = np.bincount(octave, times * 4 * np.sin(np.pi / 2 * x) ** 2) / count
    S = np.column_stack((angle, np.ones(count.size), np.bincount(octave, times / x**2) / count))
    none = np.zeros((count.size, 0))
    part = Likelihood(
        S, np.bincount(octave, power) / count, count, none[:, :, None], none, np.zeros((0, 3)), np.zeros(0, bool)
    )
    theta, _ = part.minimise(np.ones(3, dtype=bool))
    return float(theta[0] / theta[1]) if theta[0] < most * theta[1] else most
