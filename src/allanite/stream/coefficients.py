r"""The curve of a stream with its limits, and its noise from the powers of short cosine transforms.

Segments of 32 cells of 2^k samples are transformed and squared in the octave from 1/16 to 1/8 of the rate of the cells,
those of the samples themselves from 1/16 to 1/2. Below that stand the coefficients of the whole stream, of at most 512
sums over equal times. The expectations of all of them are exact for every term; what is left out is that cells fold the
octave three above on theirs, whose powers are therefore not quite independent (a twentieth, at most).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np
import scipy

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.curve import Curve, DerivedLaw, Law
from allanite.core.errors import DataError
from allanite.core.estimate import Averaged
from allanite.core.fit import Fit
from allanite.core.limits import Remembered
from allanite.core.model import ModelLike, model_of
from allanite.core.ranges import demand_band
from allanite.core.record import SHORTEST
from allanite.core.validity import Band
from allanite.kernels import cosine, ladder

from allanite.identification.likelihood.spectrum import (  # isort: skip
    ROUNDING_SHARE, SINGLE, BinnedSpectrum, edges_of, less_slope, transformed
)  # fmt: skip
from allanite.identification.methods import symbols_of
from allanite.identification.search.identify import Pending, deterministic, pending_of
from allanite.phrases.phrase import say
from allanite.prepare.gaps import FEW, Gaps, gaps_between
from allanite.statistics.confidence.supposed import AveragedLaw, LaterLaw, supposed
from allanite.statistics.moments.lagsums import second_difference
from allanite.statistics.row import Statistic
from allanite.statistics.table import CurvePoints
from allanite.terms import NoiseTerm, ramp_coefficients

from .sums import basis

if TYPE_CHECKING:
    from .accumulator import Accumulator


def grid() -> tuple[IntArray, IntArray]:
    """Averaging factors over the stride of their windows, and the levels: strides are 2^level."""
    first, levels, octave = ladder.FIRST, ladder.LEVELS, ladder.OCTAVE
    q = np.concatenate((np.arange(1, first + 1), np.tile(np.arange(octave, first + 1), levels - 1)))
    level = np.concatenate((np.zeros(first, np.int64), np.repeat(np.arange(1, levels), octave)))
    return q, level


def curve_of(stream: "Accumulator", noise: ModelLike | Fit | None) -> Curve:
    """The statistic of a stream at all averaging times that have a window; see `Accumulator.curve`."""
    row, like, state = stream.row, stream.like, stream.sums.state
    which = np.flatnonzero(state.counts)
    if not which.size:
        raise DataError(say("{size} samples without a gap are too few for {statistic}; wait for more",
                            size=stream.size, statistic=row.name))  # fmt: skip
    q, level = (values[which] for values in grid())
    m, count = q << level, state.counts[which]
    mean = state.sums[which] / count / (row.norm(m) * m.astype(np.float64) ** 2)
    unit = like.factor * (1.0 if like.integrated else like.interval) / like.interval ** (1 - row.power)
    law = None
    if noise is not None:
        law = LaterLaw(Remembered(partial(supposed, noise)), partial(law_of, row, q, level, (count, like.rate)))
    return Curve(
        statistic=row.name, m=m, tau=np.asarray(m * row.tau_factor / like.rate, dtype=np.float64),
        variance=mean * (m * row.tau_factor) ** (2.0 * row.power) * unit**2, count=count, factor=np.ones(m.size),
        unit=like.signal.si[row.power], rate=like.rate, size=stream.stop - stream.start, name=like.name,
        history=(say("stream: windows of m = q 2^k, q = 8 .. 15, start every 2^k samples (stride)"),),
        noise=None if noise is None else model_of(noise), law=law, supposes=law.words if law else None,
    )  # fmt: skip


def law_of(row: Statistic, q: IntArray, level: IntArray, seen: tuple[IntArray, float],
           noise: Averaged | Literal["auto"]) -> DerivedLaw:  # fmt: skip
    """The law of points from their numbers of windows and the sampling rate, under models."""
    # Windows that start every 2^k samples, of an angle that is taken there only, are the windows at every sample of a
    # record with 2^k times the sample interval, for which everything is known exactly.
    assert isinstance(noise, Averaged)  # noqa: S101 - `curve_of` takes models only
    count, rate = seen
    per, fixed = row.span
    size = count + per * q + fixed - 1
    parts: list[Law] = []
    for k, n in dict.fromkeys(zip(level.tolist(), size.tolist(), strict=True)):
        here = q[(level == k) & (size == n)]
        points = CurvePoints(row, here, [(n, 1)], n, rate / 2.0**k)
        parts.append(AveragedLaw(points, noise, np.ones((len(noise), here.size))))
    return DerivedLaw(tuple(parts))


FULL = 0.5  # share of its samples that a cell must have


def search_in(stream: "Accumulator", terms: str = "auto", *, band: Band = "auto",
              masks: Sequence[tuple[float, float]] = ()) -> Pending:  # fmt: skip
    """Search for the noise of a stream; `terms`, `band` and `masks` are those of `identify`."""
    # Sinusoids are not looked for, and outliers not excluded: both need the samples.
    symbols = symbols_of(terms)
    demand_band(band)
    if stream.size < SHORTEST:
        raise DataError(say("{count} samples are {too_few}", count=stream.size, too_few=FEW))
    spectrum = spectrum_of(stream, detrend=deterministic(symbols))
    return pending_of(spectrum, stream.like, symbols, band, masks=masks, rival=terms == "auto")


@dataclass(frozen=True, eq=False)
class Ladder:
    """How the bins of a stream are read: `low` of them from cells of `width` samples, the others from segments."""

    low: int
    width: int
    cells: Gaps
    level: IntArray  # of a bin, its coefficient, and how many there are; shape (bins,)
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
        upper = mean.copy()
        for k in np.unique(self.level[self.low :]):
            own, factor = coarser(term, 1 << int(k))
            here = self.level == k
            here[: self.low] = False
            rows = _rows(int(k))
            C = scipy.linalg.toeplitz(second_difference(own, rows.shape[1]) / 2)
            upper[here] = factor * ((rows @ C) * rows).sum(axis=1)[self.index[here]]
        return upper


def _rows(level: int) -> FloatArray:
    return basis(ladder.HOP)[: ladder.BAND if level else None]


def coarser(term: NoiseTerm, width: int) -> tuple[NoiseTerm, float]:
    """A term of unit coefficient for sums over `width` samples, and what its powers there are to be multiplied with."""
    # The sums are divided by the root of the width, so that white noise keeps its variance.
    row = term.shaped(term.shape, 1 / width) if term.shaped else term
    return row, float(width) ** (1 - 2 * term.power)


def spectrum_of(stream: "Accumulator", *, detrend: bool) -> BinnedSpectrum:
    """Binned powers of a stream."""
    cells = stream.sums.cells
    width, full = cells.size, np.flatnonzero(cells.count >= FULL * cells.size)
    if full.size < 2:
        raise DataError(say("{count} samples are {too_few}", count=int(cells.count[full].sum()), too_few=FEW))
    y = cells.total[full] / cells.count[full] * width**0.5
    places = full - full[0]
    slope = less_slope(y, places) if detrend else 0.0
    gaps, n = gaps_between(places), y.size
    wide = float(width) ** 1.5
    ramp = transformed(places) if gaps.at.size else ramp_coefficients(np.arange(1.0, min(SINGLE, n - 1) + 1), n)
    edges, upper = edges_of(n), _upper(stream, n * width, slope / wide)
    above, number, level, index = upper[[0, 1, 3, 4]].astype(np.int64)
    if above.size:
        edges = np.append(edges[edges < above[0]], above[0])
    low = edges.size - 1
    power, peak, peak_at, even, odd = cosine.binned(scipy.fft.dct(y, norm="ortho"), edges)
    none = np.zeros(above.size)
    power = np.concatenate((power, upper[2]))
    if not power.max() > 0:
        raise DataError(say("{channel!r} never changes: there is no noise to identify", channel=stream.like.name))
    first, count = (np.concatenate(each) for each in ((edges[:-1], above), (np.diff(edges), number)))
    at = np.zeros(low, np.int64)
    segments = np.append(np.diff(edges).astype(np.float64), upper[5])
    whole = Gaps(n * width, gaps.at * width, gaps.lost * width, gaps.shut)
    return BinnedSpectrum(size=n * width, rate=stream.like.rate, first=first, count=count,
                          power=np.maximum(power, ROUNDING_SHARE * float(power.mean())), peak=np.append(peak, none),
                          peak_at=np.append(peak_at, above).astype(np.int64), even=np.append(even, none),
                          odd=np.append(odd, none), ramp=ramp * wide, slope=slope / wide, gaps=whole,
                          unit_factor=stream.like.rate_factor, times=(places + 0.5) * width,
                          pieces=Ladder(low, width, gaps, np.append(at, level), np.append(at, index),
                                        segments))  # fmt: skip


def _upper(stream: "Accumulator", n: int, slope: float) -> FloatArray:
    """The bins of the segments of a stream of n samples, ascending, without a ramp of `slope` per sample."""
    # rows: place in coefficients of the whole stream, their number, power, level, index there, segments
    state, bins = stream.sums.state, []
    for k in reversed(range(int(stream.sums.cells.size).bit_length() - 2)):
        rows, many = _rows(k), int(state.segments[k])
        hop, base = rows.shape[1] // 2, ladder.UPPER + ladder.BAND * (k - 1) if k else 0
        edges = np.rint((hop // 8 + np.arange(len(rows) + 1)) * (n / (hop << k))).astype(np.int64)
        drift = (slope * 2.0 ** (1.5 * k) * (rows @ np.arange(2.0 * hop))) ** 2
        for j in range(len(rows) if many else 0):
            power = state.powers[base + j] / many / 2.0**k - drift[j]
            bins.append((edges[j], edges[j + 1] - edges[j], max(power, 0.0), k, j, many))
    return np.array(bins, dtype=np.float64).reshape(-1, 6).T
