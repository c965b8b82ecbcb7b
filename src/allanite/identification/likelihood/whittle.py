"""From a record to binned powers of its cosine transform.

The DCT-II diagonalizes white noise and a random walk with unknown start exactly: no taper, no differencing, no leakage.
What is left of flicker's correlation is a factor of k alone, and quantization has a closed edge term (`terms.py`).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import BoolArray, FloatArray, IntArray
from allanite.core.errors import DataError, UsageError
from allanite.core.language import say, say_count
from allanite.core.plain import Portable
from allanite.core.record import Record
from allanite.prepare.gaps import Gaps, gaps_between, joined
from allanite.statistics.moments.lags import sum_nodes
from allanite.terms import TERMS, NoiseTerm, ramp_coefficients

from .bins import SINGLE, edges_of
from .decay import decay_coefficients
from .likelihood import Likelihood
from .pieces import apart, pieces

BLOCKS = 4096
"""Blocks of samples in which a warm-up with gaps is taken."""

LOWEST = 8
"""Coefficients that tell of the drift, which is the same in all pieces, and of a ramp."""

FEWEST = 24
"""Bins that a fit needs."""

ROUNDING = (4 * float(np.finfo(np.float64).eps)) ** 2
"""Share of the mean power that rounding leaves in a bin: one of a periodic record without noise may else have none."""

CELLS = 24
"""Cells of equal width in the logarithm of frequency, in which observed and expected power are compared."""


class Parts(Protocol):
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
class Spectrum(Portable):
    """Binned powers of the orthonormal DCT-II of a rate, in the record's own unit.

    Attributes
    ----------
    size, rate : int, float
        Number of samples and sampling rate: coefficient k belongs to the frequency k rate / (2 size).
    first, count : int arrays, shape (bins,)
        First index and number of coefficients of each bin.
    power, peak, peak_at : arrays, shape (bins,)
        Mean and largest squared coefficient, and the index of the largest.
    even, odd : arrays, shape (bins,)
        Sums of the coefficients of even and of odd index.
    ramp : array, shape (at most 64,)
        Coefficients 1, 2, ... of a ramp of one unit per sample.
    slope : float
        A ramp that was subtracted before, in the unit per sample.
    gaps : Gaps
        The gaps; `size` samples remain.
    unit_factor : float
        The record's unit of rate in SI.
    times : array, shape (at most 4096,)
        With gaps, times of remaining samples, in the middles of equal blocks of them, in samples; otherwise empty.
    pieces : Parts, optional
        How pieces are read, between gaps or of a stream, where the whole record holds the low frequencies only.
    """

    size: int
    rate: float
    first: IntArray
    count: IntArray
    power: FloatArray
    peak: FloatArray
    peak_at: IntArray
    even: FloatArray
    odd: FloatArray
    ramp: FloatArray
    slope: float
    gaps: Gaps
    unit_factor: float
    times: FloatArray
    pieces: Parts | None = None

    def frequency(self, k: FloatArray | IntArray) -> FloatArray:
        """Frequency of coefficient k, Hz."""
        return np.asarray(k * (self.rate / (2 * self.size)))

    @cached_property
    def nodes(self) -> tuple[FloatArray, FloatArray, IntArray]:
        """Nodes and weights whose weighted sums are sums over each bin, and where each bin's begin."""
        rules = [sum_nodes(float(a), int(b)) for a, b in zip(self.first, self.count, strict=True)]
        starts = np.cumsum([0, *(len(x) for x, _ in rules[:-1])])
        return np.concatenate([x for x, _ in rules]), np.concatenate([w for _, w in rules]), starts

    @cached_property
    def known(self) -> dict[tuple[str, tuple[float, ...]], FloatArray]:
        """Columns that were made before, by symbol and shape."""
        return {}

    @cached_property
    def told(self) -> FloatArray:
        """Coefficients of each bin that tell something of their own, shape (bins,)."""
        count = self.count.astype(np.float64)
        if self.pieces is not None:
            low = self.pieces.low
            count[LOWEST:low] *= self.pieces.even
            count[low:] = self.pieces.told[low:]
        return count

    def within(self, band: tuple[float, float]) -> BoolArray:
        """Which bins lie in a band of frequencies, Hz, shape (bins,)."""
        low, high = band
        if not 0 <= low < high:
            raise UsageError(f"a band is two frequencies in Hz, low < high, not {low:g},{high:g}")
        inside = (self.frequency(self.first) >= low) & (self.frequency(self.first + self.count - 1) <= high)
        if inside.sum() < FEWEST:
            raise DataError(
                say(
                    "the band {low:g} to {high:g} Hz contains {bins} of the spectrum, fewer than {fewest}; the "
                    "spectrum extends from {least:.3g} to {most:g} Hz",
                    low=low,
                    high=high,
                    bins=say_count(int(inside.sum()), "{count} bin", "{count} bins"),
                    fewest=FEWEST,
                    least=self.rate / (2 * self.size),
                    most=self.rate / 2,
                )
            )
        return np.asarray(inside)


def spectrum(record: Record, *, detrend: bool) -> Spectrum:
    """Transform a record and bin the powers; takes about three times the record's memory.

    With `detrend` most of a ramp is subtracted first, so that a strong one does not leak into the higher bins; `slope`
    stores it. Missing samples (NaN) are cut out.
    """
    from scipy.fft import dct

    from allanite.kernels.binned import binned

    y, gaps, left = joined(record)
    slope = less_slope(y, left) if detrend else 0.0
    how, above = pieces(y, gaps, edges_of), None
    if how is not None and left is not None:
        y, kept, *above = apart(y, gaps, how)
        left = left[kept]
        gaps = gaps_between(left)
    n = y.size
    ramp = transformed(left) if left is not None else ramp_coefficients(np.arange(1.0, min(SINGLE, n - 1) + 1), n)
    blocks = min(n, BLOCKS)
    middle = ((np.arange(blocks) + 0.5) * (n / blocks)).astype(np.int64)
    times = np.empty(0) if left is None else left[middle].astype(np.float64)
    del left
    c = dct(y, norm="ortho", overwrite_x=True)
    del y
    edges = edges_of(n) if how is None else how.edges
    power, peak, peak_at, even, odd = binned(c, edges)
    if not power.max() > 0:
        raise DataError(say("{channel!r} never changes: there is no noise to identify", channel=record.name))
    if how is not None and above:
        for values, better in zip((power, peak), above, strict=True):
            values[how.low :] = better[how.low :]
    np.maximum(power, ROUNDING * float(power.mean()), out=power)
    first, count, at, factor = edges[:-1], np.diff(edges), peak_at.astype(np.int64), record.rate_factor
    return Spectrum(n, record.rate, first, count, power, peak, at, even, odd, ramp, slope, gaps, factor, times, how)


def likelihood(spectrum: Spectrum, symbols: Sequence[str]) -> Likelihood:
    """The likelihood of a spectrum for the terms `symbols` (keys of `TERMS`); deterministic ones are integrated out."""
    noise = [symbol for symbol in symbols if TERMS[symbol].waveform is None]
    with_ramp = len(noise) < len(symbols)
    UU, Uc = _directions(spectrum, with_ramp)
    edge = np.array([TERMS[symbol].edge + TERMS[symbol].ends for symbol in noise])
    ends = 2 if spectrum.pieces is None else 0
    return Likelihood(
        S=np.column_stack([table_column(symbol, spectrum) for symbol in noise]),
        power=spectrum.power,
        count=spectrum.told,
        UU=UU,
        Uc=Uc,
        W=np.outer(np.arange(UU.shape[1]) < ends, 2 * edge),
        flat=np.arange(UU.shape[1]) >= ends,
    )


def with_warm_up(part: Likelihood, spectrum: Spectrum, used: BoolArray, tau: float) -> Likelihood:
    """A likelihood of the bins `used` with one more loose direction: a warm-up exp(-t / tau) of any size.

    Tau is in samples. The direction stands behind the edges and before the ramp.
    """
    UU, Uc = _directions(spectrum, bool(part.flat.any()), tau)
    at = np.count_nonzero(~part.flat)
    return replace(
        part, UU=UU[used], Uc=Uc[used], W=np.insert(part.W, at, 0.0, axis=0), flat=np.insert(part.flat, at, True)
    )


def _directions(spectrum: Spectrum, with_ramp: bool, tau: float | None = None) -> tuple[FloatArray, FloatArray]:
    """Products of the loose directions: the even and the odd half of the first sample, a warm-up, and the ramp.

    The first sample has the coefficients a_k = sqrt(2/n) cos(pi k / 2n), the last one (-1)^k a_k; their even and odd
    halves are what is orthogonal. Within a bin a_k hardly changes. The ramp needs the lowest bins only, one
    coefficient each; without gaps only the odd ones are not zero.
    """
    centre = spectrum.first + (spectrum.count - 1) / 2
    odd = (spectrum.first + spectrum.count) // 2 - spectrum.first // 2
    a = np.sqrt(2 / spectrum.size) * np.cos(np.pi / (2 * spectrum.size) * centre)
    pairs = [(a, 0 * a), (0 * a, a)] if spectrum.pieces is None else []
    if tau is not None:
        pairs.append(_warm_up(spectrum, tau, centre))
    if with_ramp:
        pairs.append(_in_bins(spectrum, spectrum.ramp))
    D = np.array(pairs).reshape(-1, 2, centre.size)  # shape (directions, 2, bins)
    trust = spectrum.told / spectrum.count
    count, sums = trust * np.stack((spectrum.count - odd, odd)), trust * np.stack((spectrum.even, spectrum.odd))
    return np.einsum("ipb,jpb,pb->bij", D, D, count), np.einsum("ipb,pb->bi", D, sums)


def _in_bins(spectrum: Spectrum, lowest: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The lowest coefficients of a direction in the bins, those of even and those of odd index."""
    d = np.zeros(spectrum.first.size)
    lowest = lowest[: spectrum.pieces.low] if spectrum.pieces else lowest
    d[: lowest.size] = lowest
    return d * (spectrum.first % 2 == 0), d * (spectrum.first % 2)


def _warm_up(spectrum: Spectrum, tau: float, centre: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Coefficients of exp(-t / tau) in the bins, of even and of odd index; with gaps of the lowest bins only."""
    if spectrum.times.size:
        return _in_bins(spectrum, _blocked(np.exp(-spectrum.times / tau), spectrum.size))
    left = math.exp(-spectrum.size / tau)
    smooth = decay_coefficients(centre, spectrum.size, tau)
    return smooth * (1 - left), smooth * (1 + left)


def _blocked(values: FloatArray, n: int) -> FloatArray:
    """The lowest coefficients of what is smooth, from its values in the middles of equal blocks of n samples."""
    from scipy.fft import dct

    return np.asarray(dct(values, norm="ortho")[1 : SINGLE + 1]) * math.sqrt(n / values.size)


def transformed(left: IntArray) -> FloatArray:
    """The lowest coefficients of a ramp with gaps."""
    from scipy.fft import dct

    return np.asarray(dct(left - left.mean(), norm="ortho", overwrite_x=True)[1 : SINGLE + 1])


def less_slope(y: FloatArray, left: IntArray | None) -> float:
    """Take a ramp out of y and return its slope, that between the means of the first and last thirds.

    Near enough that a strong ramp does not leak upwards.
    """
    from allanite.kernels.binned import less_ramp

    third = y.size // 3
    apart = y.size - third if left is None else float(left[-third:].mean() - left[:third].mean())
    slope = float(y[-third:].mean() - y[:third].mean()) / apart
    if left is None:
        less_ramp(y, slope)
    else:
        y -= slope * (left - left.mean())
    return slope


def column(row: NoiseTerm, spectrum: Spectrum) -> FloatArray:
    """Mean of a term's row over each bin, shape (bins,)."""
    nodes, weights, starts = spectrum.nodes
    how = spectrum.pieces
    each = spectrum.gaps.row(row, nodes) if how is None else how.row(row, spectrum.gaps, nodes)
    mean = np.add.reduceat(weights * each, starts) / spectrum.count
    if how is not None:
        mean[how.low :] = how.upper(row, mean)[how.low :]
    return np.asarray(mean)


def table_column(symbol: str, spectrum: Spectrum, shape: tuple[float, ...] = ()) -> FloatArray:
    """The same of a row of `TERMS`, in its own shape (in samples) or another one; it is made once."""
    if (symbol, shape) not in spectrum.known:
        row = TERMS[symbol]
        spectrum.known[symbol, shape] = column(row.shaped(shape, 1.0) if shape and row.shaped else row, spectrum)
    return spectrum.known[symbol, shape]


def surroundings(values: NDArray[Any]) -> NDArray[Any]:
    """Nine neighbouring bins around each, at the ends the nine nearest, shape (bins, 9)."""
    windows = np.lib.stride_tricks.sliding_window_view(values, 9)
    return windows[np.clip(np.arange(values.size) - 4, 0, len(windows) - 1)]


def cell_of(spectrum: Spectrum, used: BoolArray) -> IntArray:
    """Cell of each bin, those that are not used included, shape (bins,)."""
    bounds = spectrum.first[used][[0, -1]]
    edges = np.geomspace(bounds[0], bounds[1] + 1, CELLS + 1)
    return np.asarray(np.clip(np.searchsorted(edges, spectrum.first, side="right") - 1, 0, CELLS - 1))
