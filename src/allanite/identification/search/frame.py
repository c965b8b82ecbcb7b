"""One spectrum, and what may explain it: columns, gains and shapes that all states of a search have in common."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any, NamedTuple, TypeVar

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray, IntArray
from allanite.core.plain import Portable
from allanite.identification.likelihood.filters import FILTERS
from allanite.identification.likelihood.likelihood import Likelihood
from allanite.identification.likelihood.spectrum import BinnedSpectrum
from allanite.identification.likelihood.whittle import (
    Pair,
    column,
    directions_of,
    gain_of,
    in_bins,
    likelihood,
    step_coefficients,
    table_column,
    warm_up_direction,
)
from allanite.terms import TERMS, WHITE

from .factors import Splines

POINTS_OVER_QUALITY, MOST_POINTS = 0.11, 16
"""Frequencies in a bin of 1/16 octave at which the power of a resonance is computed, over its quality, and at most."""

LOW = 64  # coefficients of the lowest frequencies, which tell of steps and of a warm-up (`bins.SINGLE`)
MAX_REMEMBERED = 4000  # arrays of one spectrum that are kept, at most: some 20 MB

EDGES_GRID = 0.01
"""Step in the logarithm of a cut-off at which the noise at the edges of a record is computed; it changes as little."""


T = TypeVar("T")


class Common(NamedTuple):
    """A filter in common with other channels: what these tell of it."""

    row: str
    # cutoff, low, high: cycles a sample, of all channels together, with the 95 % limits over all rows
    cutoff: float
    low: float
    high: float
    # at, scores: logarithms of cut-offs, and the summed score of the other channels behind each, over that behind the
    # best one of the best row; empty where only this cut-off is admitted
    at: tuple[float, ...] = ()
    scores: tuple[float, ...] = ()

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and greatest cut-off."""
        return (math.exp(self.at[0]), math.exp(self.at[-1])) if self.at else (self.cutoff, self.cutoff)

    def told(self, cutoff: float) -> tuple[float, float, float]:
        """The score of the other channels at a cut-off, and its first and second derivative by the logarithm."""
        if not self.at:
            return 0.0, 0.0, 0.0
        curve = _curve(self.at, self.scores)
        value, slope, curvature = (float(curve(math.log(cutoff), k)) for k in range(3))
        return value, slope, max(curvature, 0.0)


@lru_cache(256)
def _curve(at: tuple[float, ...], scores: tuple[float, ...]) -> Any:
    from scipy.interpolate import CubicSpline

    return CubicSpline(at, scores)


@dataclass(frozen=True, eq=False)
class Frame(Portable):
    """Bins of one spectrum that are read, and the columns of the terms in them."""

    spectrum: BinnedSpectrum
    powers: tuple[str, ...]  # noise terms without a shape: the first columns of every state
    ramps: tuple[str, ...]  # deterministic terms, which are integrated out
    used: BoolArray  # shape (all bins,); bins that are read: a user's band and masks
    asked: tuple[str, ...] = ()  # noise terms with a shape that a user asked for
    # the only filters, one of which every state has; empty where that is left to the search
    common: tuple[Common, ...] = ()
    known: dict[Any, Any] = field(default_factory=dict, repr=False)

    def __getstate__(self) -> dict[str, Any]:
        return super().__getstate__() | {"known": {}}

    def behind(self, *common: Common) -> "Frame":
        """The same spectrum behind filters of several channels, with what is known of it."""
        return replace(self, common=common)

    def told(self, row: str, cutoff: float) -> tuple[float, float, float]:
        """What other channels tell of a filter; see `Common.told`."""
        common = self.common_row(row)
        return common.told(cutoff) if common else (0.0, 0.0, 0.0)

    def common_row(self, row: str) -> Common | None:
        """The filter in common of a row."""
        return next((each for each in self.common if each.row == row), None)

    @property
    def size(self) -> int:
        """Number of samples."""
        return self.spectrum.size

    @cached_property
    def count(self) -> FloatArray:
        """Coefficients of each bin, shape (bins,)."""
        return self.spectrum.told[self.used]

    @cached_property
    def power(self) -> FloatArray:
        """Mean power of each bin, shape (bins,)."""
        return self.spectrum.power[self.used]

    @cached_property
    def first(self) -> IntArray:
        """First coefficient of each bin, shape (bins,)."""
        return self.spectrum.first[self.used]

    @cached_property
    def centre(self) -> FloatArray:
        """Coefficient in the middle of each bin, shape (bins,)."""
        return np.asarray((self.spectrum.first + (self.spectrum.count - 1) / 2)[self.used])

    @cached_property
    def white(self) -> int | None:
        """Column of the white noise of the rate."""
        return next((i for i, s in enumerate(self.powers) if TERMS[s].slope == WHITE), None)

    @cached_property
    def angle(self) -> BoolArray:
        """Columns of noise of the angle, which rises with frequency, shape (powers,)."""
        return np.array([TERMS[s].edge > 0 for s in self.powers], dtype=bool)

    @cached_property
    def flicker(self) -> int | None:
        """Column of flicker of the rate."""
        return next((i for i, s in enumerate(self.powers) if TERMS[s].substitute), None)

    @cached_property
    def slow(self) -> BoolArray:
        """Columns whose power is at low frequencies, shape (powers,)."""
        return np.array([not TERMS[s].slope <= WHITE for s in self.powers], dtype=bool)

    @property
    def whole_start(self) -> bool:
        """Whether the lowest coefficients are read, which tell of steps and of a warm-up."""
        return bool(self.used[: min(LOW, self.used.size)].all())

    @property
    def able_to_step(self) -> bool:
        """Whether steps of the bias can be looked for: no gaps, which may hide them, and no pieces."""
        return self.whole_start and self.spectrum.pieces is None and not self.spectrum.gaps.at.size

    @property
    def able_to_warm_up(self) -> bool:
        """Whether the first bins tell of a warm-up."""
        pieces = self.spectrum.pieces
        return bool(self.used[0]) and (pieces is None or pieces.low > 0)

    @property
    def plain(self) -> Likelihood:
        """The likelihood of the powers and ramps in the bins that are read."""
        # without the directions of which no bin knows: a ramp, where each piece is read by itself
        return self.remembered("plain", lambda: likelihood(self.spectrum, [*self.powers, *self.ramps]).only(self.used))

    def beside(self, more: tuple[tuple[str, float], ...]) -> Likelihood:
        """The same with more loose directions: ("step", sample) or ("warm-up", time constant in samples)."""
        if not more:
            return self.plain
        return self.remembered(("beside", more), lambda: self._beside(more))

    def _beside(self, more: tuple[tuple[str, float], ...]) -> Likelihood:
        UU, Uc = directions_of(self.spectrum, bool(self.ramps), [self._direction(*each) for each in more])
        plain = likelihood(self.spectrum, [*self.powers, *self.ramps])
        at = np.full(len(more), np.count_nonzero(~plain.flat))
        part = replace(plain, UU=UU, Uc=Uc, W=np.insert(plain.W, at, 0.0, axis=0), flat=np.insert(plain.flat, at, True))
        return part.only(self.used)

    def _direction(self, name: str, value: float) -> Pair:
        if name == "warm-up":
            return warm_up_direction(self.spectrum, value)
        return in_bins(self.spectrum, step_coefficients(self.size, value))

    def column(self, symbol: str, shape: tuple[float, ...]) -> FloatArray:
        """Expected power of a noise term with a shape, in samples, for theta = 1, shape (bins,)."""
        return self.remembered(
            ("column", symbol, shape),
            lambda: column(TERMS[symbol].shaped(shape, 1.0), self.spectrum)[self.used],  # type: ignore[misc]
        )

    def remembered(self, key: Any, computed: Callable[[], T]) -> T:
        """What is computed once, as long as there is not too much of it."""
        if key not in self.known:
            if len(self.known) > MAX_REMEMBERED:
                self.known.clear()
            self.known[key] = computed()
        result: T = self.known[key]
        return result

    def table(self, symbol: str) -> FloatArray:
        """Expected power of a term without a shape, shape (bins,)."""
        return table_column(symbol, self.spectrum)[self.used]

    def gain(self, row: str, cutoff: float) -> FloatArray:
        """Mean power that a filter lets pass in each bin, shape (bins,); the cut-off in cycles a sample."""
        return gain_of(row, cutoff, self.spectrum)[self.used]

    def mean_gain(self, row: str, cutoff: float) -> float:
        """Mean gain over all frequencies."""
        f = (np.arange(256) + 0.5) / 512
        return float(FILTERS[row].gain(f, cutoff).mean())

    def cosines(self, quality: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Cosines at the frequencies of a resonance, at twice these, and squares of the sine, shape (bins, points)."""
        # The mean over a bin of a peak that is as wide as `POINTS_OVER_QUALITY` says has an error below 0.1 %.
        points = next((k for k in (1, 2, 4, 8) if k > POINTS_OVER_QUALITY * quality), MOST_POINTS)

        def computed() -> tuple[FloatArray, FloatArray, FloatArray]:
            inside = (np.arange(points) + 0.5) / points
            first, count = self.spectrum.first[self.used], self.spectrum.count[self.used]
            cosine = np.cos(np.pi / self.size * (first[:, None] + count[:, None] * inside - 0.5))
            return cosine, 2 * cosine * cosine - 1, 1 - cosine * cosine

        return self.remembered(("cosines", points), computed)

    @property
    def splines(self) -> Splines:
        """The splines of what no component describes."""
        return self.remembered("splines", lambda: Splines(self.centre, math.log2(self.size)))

    @property
    def log_gains(self) -> tuple[list[tuple[str, float]], FloatArray]:
        """Rows and cut-offs of filters that are tried first, and the logarithms of their gains, shape (tries, bins)."""
        tries = [(row, float(c)) for row in FILTERS for c in starts_of(row)]
        return tries, self.remembered("log gains", lambda: np.log([self.gain(*each) for each in tries]))


def frame_of(spectrum: BinnedSpectrum, symbols: Sequence[str], used: BoolArray) -> Frame:
    """The frame of a spectrum for the terms that were asked for."""
    noise = [s for s in symbols if TERMS[s].scatters and TERMS[s].waveform is None]
    ramps = tuple(s for s in symbols if TERMS[s].scatters and TERMS[s].waveform is not None)
    powers = tuple(s for s in noise if not TERMS[s].parameters)
    return Frame(spectrum, powers, ramps, used, tuple(s for s in noise if TERMS[s].parameters))


LOWEST_CUTOFF = 0.01  # cycles a sample: a lower cut-off is the time constant of Gauss-Markov noise


@lru_cache(None)
def starts_of(row: str) -> tuple[float, ...]:
    """Cut-offs of a filter that are tried first: moving averages of whole lengths, else ten evenly in the logarithm."""
    starts = FILTERS[row].starts
    if FILTERS[row].whole:
        return tuple(float(c) for c in starts[1:] if c > LOWEST_CUTOFF)
    return tuple(np.geomspace(1.2 * LOWEST_CUTOFF, 0.97 * FILTERS[row].widest, 10).tolist())


@lru_cache(4096)
def edges_of(row: str, step: int) -> float:
    """Variance of white noise behind a filter along the edges of a record, at a step of the cut-off's logarithm."""
    return FILTERS[row].edges(min(math.exp(step * EDGES_GRID), FILTERS[row].widest))


def leak(row: str, cutoff: float) -> float:
    """The same at a cut-off."""
    return edges_of(row, round(math.log(cutoff) / EDGES_GRID))
