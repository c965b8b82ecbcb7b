"""From a record to binned powers of its cosine transform, and cells of neighbouring bins (docs/derivations.md)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol
from weakref import WeakKeyDictionary

import numpy as np
import scipy
from numpy.typing import NDArray

from allanite.core.arrays import BoolArray, FloatArray, IntArray
from allanite.core.errors import DataError, UsageError
from allanite.core.plain import Portable
from allanite.core.record import Record
from allanite.kernels import cosine
from allanite.phrases.phrase import say, say_count
from allanite.prepare.gaps import Gaps, gaps_between, joined
from allanite.prepare.rounding import step_of
from allanite.statistics.moments.lagsums import sum_nodes
from allanite.terms import NoiseTerm, ramp_coefficients

from .pieces import SHORT_TRANSFORM, apart, pieces, smooth

SINGLE = 64  # coefficients below and at this index stand in bins of their own
PER_OCTAVE = 16  # bins per octave above


def edges_of(n: int) -> IntArray:
    """Bounds of the bins, from 1 to n."""
    single = np.arange(1, min(SINGLE, n - 1) + 2)
    if n - 1 <= SINGLE:
        return single
    octaves = np.log2((n - 1) / SINGLE)
    above = SINGLE * 2.0 ** (np.arange(1, int(octaves * PER_OCTAVE) + 1) / PER_OCTAVE)
    inner = np.unique(np.rint(above).astype(np.int64)) + 1
    return np.concatenate((single, inner[(inner > SINGLE + 1) & (inner < n)], [n]))


LONG_RECORD = 1 << 20  # points from which the cache does not hold a transform
UNEVEN = 16  # longest row over the shortest column, or the other way round, for which cutting pays


def cosine_transform(y: FloatArray, slope: float = 0.0) -> FloatArray:
    """The orthonormal DCT-II of y less a ramp that is zero in its middle, shape of y, which is overwritten."""
    rows = _rows(y.size)
    if not rows:
        cosine.less_ramp(y, slope)
        return np.asarray(scipy.fft.dct(y, norm="ortho", overwrite_x=True))
    v = np.empty(y.size)
    cosine.even_then_odd(y, slope, v)
    z = scipy.fft.fft(v.view(np.complex128).reshape(rows, -1), axis=0, overwrite_x=True)
    cosine.twiddle(z.view(np.float64))
    z = scipy.fft.fft(z, axis=1, overwrite_x=True)
    cosine.coefficients(z.view(np.float64), y)
    return y


def easy_size(n: int) -> int:
    """The largest size up to n whose transform is fast: a few points less than n, at most some dozens."""

    # A prime size takes more than ten times as long, and as much more memory.
    def easy(size: int) -> bool:
        return bool(_rows(size)) if size >= LONG_RECORD else smooth(size)

    return n if n < SHORT_TRANSFORM else next(size for size in range(n, 0, -1) if easy(size))


def _rows(n: int) -> int:
    """Rows of the matrix of n / 2 complex numbers, about as many as columns; 0 where there is no such matrix."""
    half = n // 2
    if n % 2 or n < LONG_RECORD:
        return 0
    least = math.isqrt(half // UNEVEN)
    return next((P for P in range(math.isqrt(half), least, -1) if half % P == 0), 0)


WARM_UP_BLOCKS = 4096  # blocks of samples in which a warm-up with gaps is taken
DRIFT_COEFFICIENTS = 8  # coefficients that tell of the drift, which is the same in all pieces, and of a ramp
FEWEST_BINS = 24  # bins that a fit needs
LONG_GAP, MAX_LONG_GAPS = 0.05, 8  # share of the samples that a long gap lost at least; number of long gaps, at most

ROUNDING_SHARE = (4 * float(np.finfo(np.float64).eps)) ** 2
"""Share of the mean power that rounding leaves in a bin: one of a periodic record without noise may else have none."""


class PieceBins(Protocol):
    """How a spectrum is read whose lowest bins are of the whole record, and the others of short pieces of it."""

    @property
    def low(self) -> int:
        """Number of bins of the whole record."""

    @property
    def even(self) -> float:
        """Share of their coefficients that counts."""

    @property
    def told(self) -> FloatArray:
        """Coefficients in the bins of the pieces, shape (bins,)."""

    def row(self, term: NoiseTerm, gaps: Gaps, k: FloatArray) -> FloatArray:
        """Variance of the k-th coefficients of the lowest bins under a term."""

    def upper(self, term: NoiseTerm, mean: FloatArray) -> FloatArray:
        """Mean variance in the bins of the pieces, shape (bins,); `mean` elsewhere."""


@dataclass(frozen=True, eq=False)
class BinnedSpectrum(Portable):
    """Binned powers of the orthonormal DCT-II of a rate, in the record's own unit."""

    # size, rate: number of samples and sampling rate: coefficient k belongs to the frequency k rate / (2 size)
    size: int
    rate: float
    # first, count: shape (bins,); first index and number of coefficients of each bin
    first: IntArray
    count: IntArray
    # power, peak, peak_at: shape (bins,); mean and largest squared coefficient, and the index of the largest
    power: FloatArray
    peak: FloatArray
    peak_at: IntArray
    # even, odd: shape (bins,); sums of the coefficients of even and of odd index
    even: FloatArray
    odd: FloatArray
    ramp: FloatArray  # shape (at most 64,); coefficients 1, 2, ... of a ramp of one unit per sample.
    slope: float  # a ramp that was subtracted before, in the unit per sample
    gaps: Gaps  # the gaps; `size` samples remain
    unit_factor: float  # the record's unit of rate in SI
    # shape (at most 4096,); with gaps, times of remaining samples, in the middles of equal blocks of them, in
    # samples; otherwise empty
    times: FloatArray
    # how pieces are read, between gaps or of a stream, where the whole record holds the low frequencies only
    pieces: PieceBins | None = None
    rounding: float = 0.0  # power of the rounding of a rate to a known step, 0 if there is none
    detrended: bool = False  # whether a ramp is looked for, and with it the steps of a slow noise during long gaps
    cut: float = 0.0  # time of the first sample in the recording, s

    def frequency(self, k: FloatArray | IntArray) -> FloatArray:
        """Frequency of coefficient k, Hz."""
        return np.asarray(k * (self.rate / (2 * self.size)))

    @property
    def _long(self) -> BoolArray:
        """Which gaps are so long that what a slow noise does during them is a step by itself."""
        # Where pieces are read, too few low coefficients are left to tell steps apart.
        return np.asarray((self.detrended and self.pieces is None) & (self.gaps.lost >= LONG_GAP * self.size))

    @property
    def steps(self) -> IntArray:
        """First samples after long gaps."""
        return self.gaps.at[self._long][:MAX_LONG_GAPS]

    @cached_property
    def joints(self) -> Gaps:
        """The gaps as the terms see them: during a long one a slow noise does nothing, as its step is loose."""
        loose = self._long & (np.cumsum(self._long) <= MAX_LONG_GAPS)
        return replace(self.gaps, lost=np.where(loose, 0, self.gaps.lost))

    @cached_property
    def nodes(self) -> tuple[FloatArray, FloatArray, IntArray]:
        """Nodes and weights whose weighted sums are sums over each bin, and where each bin's begin."""
        return sum_nodes(self.first.astype(np.float64), self.count)

    @cached_property
    def known(self) -> dict[str, FloatArray]:
        """Columns that were made before, by symbol."""
        return {}

    @cached_property
    def told(self) -> FloatArray:
        """Coefficients of each bin that tell something of their own, shape (bins,)."""
        count = self.count.astype(np.float64)
        if self.pieces is not None:
            low = self.pieces.low
            count[DRIFT_COEFFICIENTS:low] *= self.pieces.even
            count[low:] = self.pieces.told[low:]
        return count

    def near_one(self) -> "BinnedSpectrum":
        """The same in a unit in which its mean power is near 1: a power of two of the record's, so that it is exact."""
        unit = 2.0 ** round(np.log2(float(self.power.mean())) / 2)
        return replace(
            self, power=self.power / unit**2, peak=self.peak / unit**2, even=self.even / unit, odd=self.odd / unit,
            slope=self.slope / unit, rounding=self.rounding / unit**2, unit_factor=self.unit_factor * unit,
        )  # fmt: skip

    def read(self, band: tuple[float, float] | None, masks: Sequence[tuple[float, float]]) -> BoolArray:
        """Which bins lie in a band and in none of the masks, shape (bins,)."""
        used = np.ones(self.first.size, dtype=bool) if band is None else self.within(band)
        for low, high in masks:
            above, below = self.frequency(self.first + self.count - 1) > low, self.frequency(self.first) < high
            used &= ~(above & below)
        if used.sum() < FEWEST_BINS:
            raise DataError(
                say(
                    "the masks leave {bins} of the spectrum, fewer than {fewest}: leave out less",
                    bins=say_count(int(used.sum()), "{count} bin", "{count} bins"), fewest=FEWEST_BINS,
                )
            )  # fmt: skip
        return used

    def within(self, band: tuple[float, float]) -> BoolArray:
        """Which bins lie in a band of frequencies, Hz, shape (bins,)."""
        low, high = band
        if not 0 <= low < high:
            raise UsageError(f"a band is two frequencies in Hz, low < high, not {low:g},{high:g}", choice="band")
        inside = (self.frequency(self.first) >= low) & (self.frequency(self.first + self.count - 1) <= high)
        if inside.sum() < FEWEST_BINS:
            raise DataError(say("the band {low:g} to {high:g} Hz contains {bins} of the spectrum, fewer than "
                                "{fewest}; the spectrum extends from {least:.3g} to {most:g} Hz",
                                low=low, high=high, bins=say_count(int(inside.sum()), "{count} bin", "{count} bins"),
                                fewest=FEWEST_BINS, least=self.rate / (2 * self.size), most=self.rate / 2))  # fmt: skip
        return np.asarray(inside)


_made: WeakKeyDictionary[Record, dict[bool, BinnedSpectrum]] = WeakKeyDictionary()
"""The spectra of records that are still there: other terms, and a comparison, begin with the same."""


def spectrum(record: Record, *, detrend: bool) -> BinnedSpectrum:
    """Transform a record and bin the powers, once; takes about three times the record's memory.

    With `detrend` most of a ramp is subtracted first, so that a strong one does not leak into the higher bins; `slope`
    stores it. Missing samples (NaN) are cut out.
    """
    known = _made.setdefault(record, {})
    if detrend not in known:
        known[detrend] = _spectrum(record, detrend)
    return known[detrend]


def _spectrum(record: Record, detrend: bool) -> BinnedSpectrum:
    y, gaps, places = joined(record)
    y, gaps = y[: (fast := easy_size(y.size))], gaps.first(fast)
    places = None if places is None else places[:fast]
    most = float(np.abs(y).max(initial=0.0))
    slope = slope_of(y, places) if detrend else 0.0
    if places is not None:
        y -= slope * (places - places.mean())
    how, above = pieces(y, gaps, edges_of), None
    if how is not None and places is not None:
        y, kept, *above = apart(y, gaps, how)
        places = places[kept]
        gaps = gaps_between(places)
    n = y.size
    ramp = transformed(places) if places is not None else ramp_coefficients(np.arange(1.0, min(SINGLE, n - 1) + 1), n)
    blocks = min(n, WARM_UP_BLOCKS)
    middle = ((np.arange(blocks) + 0.5) * (n / blocks)).astype(np.int64)
    times = np.empty(0) if places is None else places[middle].astype(np.float64)
    c = cosine_transform(y, 0.0 if places is not None else slope)
    del places, y
    edges = edges_of(n) if how is None else how.edges
    power, peak, peak_at, even, odd = cosine.binned(c, edges)
    if not power.max() > 0:
        raise DataError(say("{channel!r} never changes: there is no noise to identify", channel=record.name))
    if slope and power.mean() < ROUNDING_SHARE * most**2:
        raise DataError(say("{channel!r} is a straight line: there is no noise to identify", channel=record.name))
    if how is not None and above:
        for values, better in zip((power, peak), above, strict=True):
            values[how.low :] = better[how.low :]
    np.maximum(power, ROUNDING_SHARE * float(power.mean()), out=power)
    first, count, at, factor = edges[:-1], np.diff(edges), peak_at.astype(np.int64), record.rate_factor
    return BinnedSpectrum(
        n, record.rate, first, count, power, peak, at, even, odd, ramp, slope, gaps, factor, times, how,
        rounding=_rounding(record), detrended=detrend, cut=record.cut,
    )  # fmt: skip


def _rounding(record: Record) -> float:
    """Variance of the rounding error of a rate, in the record's unit squared; 0 if there is no grid."""
    if record.kind == "angle":
        return 0.0
    return step_of(record) ** 2 / 12


def transformed(places: IntArray) -> FloatArray:
    """The lowest coefficients of a ramp with gaps."""
    return cosine_transform(places - places.mean())[1 : SINGLE + 1]


def slope_of(y: FloatArray, places: IntArray | None) -> float:
    """The slope of y between the means of its first and last thirds, in the unit per sample."""
    # Near enough that a strong ramp, less this one, does not leak upwards.
    third = y.size // 3
    apart = y.size - third if places is None else float(places[-third:].mean() - places[:third].mean())
    return float(y[-third:].mean() - y[:third].mean()) / apart


def less_slope(y: FloatArray, places: IntArray) -> float:
    """Take the ramp of `slope_of` out of y, and return its slope."""
    slope = slope_of(y, places)
    y -= slope * (places - places.mean())
    return slope


CELLS = 24  # cells of equal width in the logarithm of frequency, in which observed and expected power are compared
WELL_KNOWN = 50  # coefficients of a bin, or of a cell, whose power needs no smoothing


def surroundings(values: NDArray[Any]) -> NDArray[Any]:
    """Nine neighbouring bins around each, at the ends the nine nearest, shape (bins, 9)."""
    windows = np.lib.stride_tricks.sliding_window_view(values, 9)
    return windows[np.clip(np.arange(values.size) - 4, 0, len(windows) - 1)]


def cell_of(spectrum: BinnedSpectrum, used: BoolArray) -> IntArray:
    """Cell of each bin, those that are not used included, shape (bins,)."""
    bounds = spectrum.first[used][[0, -1]]
    edges = np.geomspace(bounds[0], bounds[1] + 1, CELLS + 1)
    return np.asarray(np.clip(np.searchsorted(edges, spectrum.first, side="right") - 1, 0, CELLS - 1))
