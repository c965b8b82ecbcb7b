"""One spectrum, and what may explain it: columns, gains and shapes of all states of a search; splines of factors."""

import math
from bisect import bisect
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any, NamedTuple, TypeVar

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray, IntArray
from allanite.core.plain import Portable
from allanite.core.splines import basis, cubic
from allanite.identification.likelihood.filters import FILTERS
from allanite.identification.likelihood.likelihood import Likelihood
from allanite.identification.likelihood.spectrum import BinnedSpectrum

from allanite.identification.likelihood.whittle import (  # isort: skip
    Pair, column, directions_of, gain_of, in_bins, likelihood, step_coefficients, table_column, warm_up_direction,
    wave_directions
)  # fmt: skip
from allanite.terms import TERMS, WHITE

# Derivation: docs/derivations.md.


KNOT = 1.0  # distance of the knots, octaves
TOP_KNOTS = (1.0, 0.5, 0.25, 0.1, 0.0)  # knots below half the sampling rate, octaves: there gains have zeros
LENGTH = math.log(2)  # length over which a factor is correlated, in the logarithm of frequency: an octave, a knot
JUMPS = 4.0  # length of the exponential correlation of `step above`, octaves of coefficients: an order that jumps
ADDED_VARIANCE = 1e-12  # what is added to a covariance so that it has a root

SLOWEST_OCTAVE = 6
"""Octave of the coefficient index below which no factor begins: what is slow has noise terms and a time constant."""

KINDS = ("all", "above", "step above", "between")

DIRECTIONS: dict[str, Callable[[BinnedSpectrum, float], Sequence[Pair]]] = {
    "step": lambda spectrum, at: (in_bins(spectrum, step_coefficients(spectrum.size, at)),),
    "warm-up": lambda spectrum, tau: (warm_up_direction(spectrum, tau),),
    "wave": wave_directions,
}
"""Components that change the mean of the coefficients, not their power, and the directions of their shapes."""

Place = tuple[str, float, float]  # kind, and the octaves of the coefficient index between which it stands


@dataclass(frozen=True, eq=False)
class Splines:
    """The splines in the bins whose middle coefficients are `centre`; `top` is the octave of half the sampling rate."""

    centre: FloatArray
    top: float

    @cached_property
    def knots(self) -> FloatArray:
        """With the ends repeated, in octaves."""
        inner = np.concatenate((np.arange(0.0, self.top - 1.5, KNOT), self.top - np.array(TOP_KNOTS)))
        return np.concatenate(([0.0] * 3, inner, [self.top] * 3))

    @cached_property
    def B(self) -> FloatArray:
        """Shape (bins, coefficients)."""
        return basis(self.knots, np.clip(np.log2(self.centre), 0, self.top - 1e-9))

    @cached_property
    def at(self) -> FloatArray:
        """Octave of each coefficient."""
        t = self.knots
        return np.array([t[i + 1 : i + 4].mean() for i in range(t.size - 4)])

    def root(self, place: Place) -> FloatArray:
        """L with L L' = C of a factor of size 1, shape (coefficients, rank)."""
        return _root(place, tuple(self.at.tolist()))

    def basis(self, place: Place) -> FloatArray:
        """B L, shape (bins, rank)."""
        return np.asarray(self.B @ self.root(place))

    @cached_property
    def places(self) -> list[Place]:
        """Everywhere; from every half octave of the upper six on; between whole octaves two to five apart."""
        top, whole = self.top, int(self.top)
        above = np.arange(0.0, min(top - 5.0, 6.6), 0.5)
        places: list[Place] = [("all", 0.0, top)]
        places += [(kind, top - float(k), top) for kind in ("above", "step above") for k in above]
        places += [
            ("between", float(a), float(b))
            for a in range(SLOWEST_OCTAVE, whole)
            for b in range(a + 2, min(a + 5, whole) + 1)
        ]
        return places


@lru_cache(1024)
def _root(place: Place, octaves: tuple[float, ...]) -> FloatArray:
    kind, low, high = place
    at = np.array(octaves)
    apart = np.abs(at[:, None] - at) * math.log(2)

    def matern(length: float) -> FloatArray:
        return np.asarray((1 + apart / length) * np.exp(-apart / length))

    if kind in ("all", "between"):
        size, C = ((at >= low) & (at <= high)).astype(float), matern(LENGTH)
    else:
        size = np.log1p(4.0 ** (at - low))
        C = matern(2 * LENGTH) if kind == "above" else np.exp(-apart / math.log(2) / JUMPS)
    C = C * np.outer(size, size)
    some = np.flatnonzero(np.diag(C) > 1e-10)
    L = np.zeros((at.size, some.size))
    L[some] = np.linalg.cholesky(C[np.ix_(some, some)] + ADDED_VARIANCE * np.eye(some.size))
    return L


POINTS_OVER_QUALITY, MOST_POINTS = 0.11, 16
"""Frequencies in a bin of 1/16 octave at which the power of a resonance is computed, over its quality, and at most."""

LOW = 64  # coefficients of the lowest frequencies, which tell of steps and of a warm-up (`bins.SINGLE`)
FEWEST_ALONE = 8  # coefficients that must stand alone: twice the directions of a ramp, a warm-up and a wave
MAX_REMEMBERED = 4000  # arrays of one spectrum that are kept, at most: some 20 MB

EDGES_GRID = 0.01
"""Step in the logarithm of a cut-off at which the noise at the edges of a record is computed; it changes as little."""


EVENLY = (np.arange(256) + 0.5) / 512  # frequencies over which a mean gain is taken, cycles a sample

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
        at, (a, b, c, d) = self.at, _curve(self.at, self.scores)
        x = math.log(cutoff)
        i = min(max(bisect(at, x) - 1, 0), len(at) - 2)
        x -= at[i]
        value, slope = ((a[i] * x + b[i]) * x + c[i]) * x + d[i], (3 * a[i] * x + 2 * b[i]) * x + c[i]
        return value, slope, max(6 * a[i] * x + 2 * b[i], 0.0)


@lru_cache(256)
def _curve(at: tuple[float, ...], scores: tuple[float, ...]) -> list[list[float]]:
    """Coefficients of the cubics between the cut-offs, the highest power first."""
    coefficients: list[list[float]] = cubic(np.array(at), np.array(scores)).tolist()
    return coefficients


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
    def able_to_step(self) -> bool:
        """Whether steps of the bias can be looked for: the lowest bins are read, no gaps may hide them, no pieces."""
        return bool(self.used[:LOW].all()) and self.spectrum.pieces is None and not self.spectrum.gaps.at.size

    @property
    def able_to_warm_up(self) -> bool:
        """Whether the first bins tell of a warm-up."""
        return bool(self.used[0]) and self.alone >= FEWEST_ALONE

    @property
    def alone(self) -> int:
        """Low coefficients that are known one by one: of pieces those of the whole record."""
        return LOW if self.spectrum.pieces is None else min(self.spectrum.pieces.low, LOW)

    @property
    def plain(self) -> Likelihood:
        """The likelihood of the powers and ramps in the bins that are read."""
        # without the directions of which no bin knows: a ramp, where each piece is read by itself
        return self.remembered("plain", lambda: likelihood(self.spectrum, [*self.powers, *self.ramps]).only(self.used))

    def beside(self, more: tuple[tuple[str, float], ...]) -> Likelihood:
        """The same with more loose directions: steps at a sample, a warm-up, its time constant in samples, a wave."""
        if not more:
            return self.plain
        return self.remembered(("beside", more), lambda: self._beside(more))

    def _beside(self, more: tuple[tuple[str, float], ...]) -> Likelihood:
        pairs = [pair for each in more for pair in self.directions(*each)]
        UU, Uc = directions_of(self.spectrum, bool(self.ramps), pairs)
        plain = likelihood(self.spectrum, [*self.powers, *self.ramps])
        at = np.full(len(pairs), np.count_nonzero(~plain.flat))
        part = replace(plain, UU=UU, Uc=Uc, W=np.insert(plain.W, at, 0.0, axis=0), flat=np.insert(plain.flat, at, True))
        return part.only(self.used)

    def directions(self, name: str, value: float) -> Sequence[Pair]:
        """The loose directions of a part: a wave has two."""
        return DIRECTIONS[name](self.spectrum, value)

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
                self.known.pop(next(iter(self.known)))  # the oldest
            self.known[key] = computed()
        result: T = self.known[key]
        return result

    def table(self, symbol: str) -> FloatArray:
        """Expected power of a term without a shape, shape (bins,)."""
        return table_column(symbol, self.spectrum)[self.used]

    def gain(self, row: str, cutoff: float) -> FloatArray:
        """Mean power that a filter lets pass in each bin, shape (bins,); the cut-off in cycles a sample."""
        return self.remembered(("gain", row, cutoff), lambda: gain_of(row, cutoff, self.spectrum)[self.used])

    def mean_gain(self, row: str, cutoff: float) -> float:
        """Mean gain over all frequencies."""
        return self.remembered(("mean gain", row, cutoff), lambda: float(FILTERS[row].gain(EVENLY, cutoff).mean()))

    def cosines(self, quality: float) -> tuple[FloatArray, FloatArray]:
        """Cosines at the frequencies of a resonance, and at twice these, shape (bins, points)."""
        # The mean over a bin of a peak that is as wide as `POINTS_OVER_QUALITY` says has an error below 0.1 %.
        points = next((k for k in (1, 2, 4, 8) if k > POINTS_OVER_QUALITY * quality), MOST_POINTS)

        def computed() -> tuple[FloatArray, FloatArray]:
            inside = (np.arange(points) + 0.5) / points
            first, count = self.spectrum.first[self.used], self.spectrum.count[self.used]
            cosine = np.cos(np.pi / self.size * (first[:, None] + count[:, None] * inside - 0.5))
            return cosine, 2 * cosine * cosine - 1

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
def edges_of(row: str, step: int) -> tuple[float, float]:
    """Variances behind a filter along the edges of a record, at a step of the cut-off's logarithm; see `edges`."""
    return FILTERS[row].edges(min(math.exp(step * EDGES_GRID), FILTERS[row].widest))


def leak(row: str, cutoff: float) -> tuple[float, float]:
    """The same at a cut-off."""
    return edges_of(row, round(math.log(cutoff) / EDGES_GRID))
