r"""The noise of a stream, from the powers of short cosine transforms at every octave and one of the whole.

Segments of 32 cells of 2^k samples are transformed and squared in the octave from 1/16 to 1/8 of the rate of the cells,
those of the samples themselves from 1/16 to 1/2. Below that stand the coefficients of the whole stream, of at most 512
sums over equal times. The expectations of all of them are exact for every term; what is left out is that cells fold the
octave three above on theirs, whose powers are therefore not quite independent (a twentieth, at most).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.errors import DataError
from allanite.core.record import SHORTEST
from allanite.core.validity import Band, demand_band
from allanite.identification.likelihood.bins import SINGLE, edges_of
from allanite.identification.likelihood.spectrum import ROUNDING, BinnedSpectrum, less_slope, transformed
from allanite.identification.methods import symbols_of
from allanite.identification.search.identify import Pending, deterministic, pending_of
from allanite.phrases.phrase import say
from allanite.prepare.gaps import FEW, Gaps, gaps_between
from allanite.statistics.moments.lags import second_difference
from allanite.terms import NoiseTerm, ramp_coefficients

from .lapped import basis

if TYPE_CHECKING:
    from .accumulator import Accumulator

FULL = 0.5
"""Share of its samples that a cell must have."""


def search_in(
    stream: "Accumulator", terms: str = "auto", *, band: Band = "auto", masks: Sequence[tuple[float, float]] = ()
) -> Pending:
    """Search for the noise of a stream; `terms`, `band` and `masks` are those of `identify`.

    Sinusoids are not looked for, and outliers not excluded: both need the samples.
    """
    symbols = symbols_of(terms)
    demand_band(band)
    if stream.size < SHORTEST:
        raise DataError(say("{count} samples are {too_few}", count=stream.size, too_few=FEW))
    seen = spectrum_of(stream, detrend=deterministic(symbols))
    return pending_of(seen, (stream.like.name, stream.like.signal), symbols, band, masks=masks, rival=terms == "auto")


@dataclass(frozen=True, eq=False)
class Ladder:
    """How the bins of a stream are read: `low` of them from cells of `width` samples, the others from segments.

    `level`, `index` and `told`, shape (bins,), are the level of a bin, its coefficient, and how many there are.
    """

    low: int
    width: int
    cells: Gaps
    level: IntArray
    index: IntArray
    told: FloatArray
    even: float = 1.0

    def row(self, term: NoiseTerm, gaps: Gaps, k: FloatArray) -> FloatArray:
        """Variance of the k-th coefficients of the cells under a term."""
        n = self.cells.size
        own, factor = coarser(term, self.width)
        ends = (term.edge + term.ends) * (2 / n) * (1 + np.cos(np.pi / n * k))
        return factor * np.asarray(self.cells.row(own, k) + ends)

    def upper(self, term: NoiseTerm, mean: FloatArray) -> FloatArray:
        """Variance of the coefficients of the segments, shape (bins,)."""
        from scipy.linalg import toeplitz

        found = mean.copy()
        for k in np.unique(self.level[self.low :]):
            own, factor = coarser(term, 1 << int(k))
            here = self.level == k
            here[: self.low] = False
            rows = _rows(int(k))
            C = toeplitz(second_difference(own, rows.shape[1]) / 2)
            found[here] = factor * ((rows @ C) * rows).sum(axis=1)[self.index[here]]
        return found


def _rows(level: int) -> FloatArray:
    from allanite.kernels.ladder import BAND, HOP

    return basis(HOP)[: BAND if level else None]


def coarser(term: NoiseTerm, width: int) -> tuple[NoiseTerm, float]:
    """A term of unit coefficient for sums over `width` samples, and what its powers there are to be multiplied with.

    The sums are divided by the root of the width, so that white noise keeps its variance.
    """
    row = term.shaped(term.shape, 1 / width) if term.shaped else term
    return row, float(width) ** (1 - 2 * term.power)


def spectrum_of(stream: "Accumulator", *, detrend: bool) -> BinnedSpectrum:
    """Binned powers of a stream."""
    from scipy.fft import dct

    from allanite.kernels.binned import binned

    cells = stream.sums.cells
    width, full = cells.size, np.flatnonzero(cells.count >= FULL * cells.size)
    y = cells.total[full] / cells.count[full] * width**0.5
    left = full - full[0]
    slope = less_slope(y, left) if detrend else 0.0
    gaps, n = gaps_between(left), y.size
    wide = float(width) ** 1.5
    ramp = transformed(left) if gaps.at.size else ramp_coefficients(np.arange(1.0, min(SINGLE, n - 1) + 1), n)
    edges, upper = edges_of(n), _upper(stream, n * width, slope / wide)
    if upper.first.size:
        edges = np.append(edges[edges < upper.first[0]], upper.first[0])
    low = edges.size - 1
    power, peak, peak_at, even, odd = binned(dct(y, norm="ortho"), edges)
    none = np.zeros(upper.first.size)
    power = np.concatenate((power, upper.power))
    if not power.max() > 0:
        raise DataError(say("{channel!r} never changes: there is no noise to identify", channel=stream.like.name))
    first, count = (np.concatenate(each) for each in ((edges[:-1], upper.first), (np.diff(edges), upper.count)))
    at = np.zeros(low, np.int64)
    ladder = Ladder(low, width, gaps, np.append(at, upper.level), np.append(at, upper.index),
                    np.append(np.diff(edges).astype(np.float64), upper.told))  # fmt: skip
    whole = Gaps(n * width, gaps.at * width, gaps.lost * width, gaps.shut)
    return BinnedSpectrum(
        size=n * width, rate=stream.like.rate, first=first, count=count,
        power=np.maximum(power, ROUNDING * float(power.mean())), peak=np.append(peak, none),
        peak_at=np.append(peak_at, upper.first).astype(np.int64),
        even=np.append(even, none), odd=np.append(odd, none), ramp=ramp * wide, slope=slope / wide, gaps=whole,
        unit_factor=stream.like.rate_factor, times=(left + 0.5) * width, pieces=ladder,
    )  # fmt: skip


@dataclass(frozen=True)
class Upper:
    """The bins of the segments, ascending: their place in coefficients of the whole stream, and what is in them."""

    first: IntArray
    count: IntArray
    power: FloatArray
    level: IntArray
    index: IntArray
    told: FloatArray


def _upper(stream: "Accumulator", n: int, slope: float) -> Upper:
    """The powers of the segments of a stream of n samples, without the part of a ramp of `slope` per sample."""
    from allanite.kernels.ladder import BAND, UPPER

    state, found = stream.sums.state, []
    for k in reversed(range(int(stream.sums.cells.size).bit_length() - 2)):
        rows, many = _rows(k), int(state.segments[k])
        hop, base = rows.shape[1] // 2, UPPER + BAND * (k - 1) if k else 0
        edges = np.rint((hop // 8 + np.arange(len(rows) + 1)) * (n / (hop << k))).astype(np.int64)
        drift = (slope * 2.0 ** (1.5 * k) * (rows @ np.arange(2.0 * hop))) ** 2
        for j in range(len(rows) if many else 0):
            power = state.powers[base + j] / many / 2.0**k - drift[j]
            found.append((edges[j], edges[j + 1] - edges[j], max(power, 0.0), k, j, many))
    table = np.array(found, dtype=np.float64).reshape(-1, 6).T
    first, count, level, index = (table[i].astype(np.int64) for i in (0, 1, 3, 4))
    return Upper(first, count, table[2], level, index, table[5])
