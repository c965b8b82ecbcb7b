"""Resonances: peaks of the spectrum with their skirts, found one after the other and fitted together with the noise.

The peak of a resonance stands far above the noise and tells nothing of it, but its skirts reach far: a structure of
quality q that is 1000 times as loud as the noise at its peak adds (1000 / q^2) of it to all lower frequencies. What
resonances add is therefore part of the expected power wherever it is a fraction of it; where it is most of the power,
the spectrum is left out.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray

from .band import Portion, Tuned
from .likelihood import Likelihood
from .spectrum import BinnedSpectrum

STANDS_OUT, EXCESS = 5.0, 0.1
"""Standard deviations, and share of the expected power, by which a bin must exceed it."""

FEWEST, PERIODS = 4, 200
"""Coefficients of a bin whose power is known well enough to stand out; periods in the record, at least."""

MOST = 16
"""Resonances, at most."""

QUALITIES = (4.0, 10.0, 25.0, 70.0, 200.0)
"""Qualities that are tried first; the first and the last are the limits of all."""

BROAD = 0.01
"""Share by which a quality must exceed the lowest, to be one."""

POINTS = 16
"""Frequencies in a bin at which the power of a resonance is computed."""

HATS = ((0.0, 0.25), (0.25, 0.25), (0.5, 0.25), (0.75, 0.25), *((float(k), 1.0) for k in range(1, 10)))
"""Octaves below half the sampling rate, and widths, of the hats of which the floor is made."""

EVIDENCE = 15.0
"""What a resonance must gain in 2 L."""

MOVED = 0.1
"""Logarithm of the ratio by which a cut-off may change at a time."""

CLOSE, NEAREST = 0.5, 6
"""Logarithm of the ratio of frequencies up to which resonances are fitted again beside a new one, and how many."""

PEAK = 0.3
"""Power of a resonance over that of its highest bin, from which a bin belongs to its peak."""

TOLERANCE = 0.1
"""Accuracy of a resonance beyond its peak, as a share of its power."""

SHAPES: tuple[Callable[[FloatArray], FloatArray], ...] = (np.ones_like, lambda omega: np.sin(omega) ** 2)
"""Numerators of the power: a structure, which follows slow forces as well, and one that does not."""

Resonance = tuple[int, float, float]
"""Number of its shape, frequency in radians a sample, and quality."""


@dataclass(frozen=True, eq=False)
class Excess:
    """What resonances add: their `power` in each bin, and its share of all; `peaks` are the bins where they stand.

    `found` are their shapes.
    """

    power: FloatArray
    share: FloatArray
    peaks: BoolArray
    found: tuple[Resonance, ...]

    @property
    def lowest(self) -> float:
        """The lowest frequency, radians a sample."""
        return min(omega for _, omega, _ in self.found)

    def trust(self, count: FloatArray) -> FloatArray:
        """Share of the coefficients of a bin that count; `count` of its neighbourhood have an error in common."""
        return np.asarray(1 / (1 + (TOLERANCE * self.share) ** 2 * count / 2))

    @property
    def hidden(self) -> BoolArray:
        """Bins at the peaks of resonances, or in which they have most of the power."""
        return np.asarray(self.peaks | (self.share > 0.5))


@dataclass(frozen=True, eq=False)
class FrequencyGrid:
    """The frequencies at which the power of a resonance is computed, radians a sample, shape (bins, points)."""

    seen: BinnedSpectrum

    @cached_property
    def omega(self) -> FloatArray:
        """Frequencies."""
        inside = (np.arange(POINTS) + 0.5) / POINTS
        return np.asarray(np.pi / self.seen.size * (self.seen.first[:, None] + self.seen.count[:, None] * inside - 0.5))

    @cached_property
    def cosines(self) -> tuple[FloatArray, FloatArray]:
        """Cosines at the frequencies and at twice the frequencies."""
        return np.cos(self.omega), np.cos(2 * self.omega)

    @cached_property
    def numerators(self) -> tuple[FloatArray, ...]:
        """Of each shape."""
        return tuple(shape(self.omega) for shape in SHAPES)

    def power(self, which: Resonance) -> FloatArray:
        """Mean power of a resonance in the bins, its highest 1: white noise through two poles."""
        shape, omega, quality = which
        r = math.exp(-omega / (2 * quality))
        a, b = -2 * r * math.cos(omega), r * r
        one, two = self.cosines
        # at its peak the denominator of a sharp one is a difference of equal numbers
        below = np.maximum(1 + a * a + b * b + 2 * a * (1 + b) * one + 2 * b * two, 1e-15)
        power = self.numerators[shape] / below
        mean = power.mean(axis=1)
        return np.asarray(mean / mean.max())


def excess(part: Portion, *, smooth: bool = False) -> "tuple[Excess, Tuned | None] | None":
    """What resonances add to the noise of a portion; None if there are none, or too many to tell them from noise.

    The floor is that of the terms, behind the filter of the portion, whose cut-off is tuned again beside them and
    returned; or it is any `smooth` one.
    """
    search = Searched(part, smooth)
    found: list[Resonance] = []
    while (at := search.highest(found)) is not None:
        if len(found) == MOST:
            return None
        found.append(search.started(found, at))
        far = [abs(math.log(omega / at)) for _, omega, _ in found]
        near = sorted((i for i in range(len(far)) if far[i] < CLOSE), key=far.__getitem__)[:NEAREST]
        search.refine(found, sorted(near), shapes=())
        if not smooth and min(quality for *_, quality in found) < QUALITIES[0] * (1 + BROAD):
            return None  # nothing narrow: the floor is another one
        search = search.tuned(found)
    search.refine(found, range(len(found)), shapes=range(len(SHAPES)))
    search = search.tuned(found)
    found = search.needed(found)
    if not found:
        return None
    power, share = np.zeros((2, part.used.size))
    power[part.used], share[part.used] = search.power(found)
    at = np.array([search.grid.power(one) for one in found]).max(axis=0) > PEAK
    peaks = at | np.append(at[1:], False) | np.append(False, at[:-1])  # a peak is hardly resolved by the bins
    return Excess(power, share, peaks & part.used, tuple(found)), search.part.filter


@dataclass(frozen=True, eq=False)
class Searched:
    """A portion in which resonances are looked for, above the floor of the terms or any smooth one."""

    part: Portion
    smooth: bool

    @cached_property
    def grid(self) -> FrequencyGrid:
        """Where their power is computed."""
        return FrequencyGrid(self.part.seen)

    @cached_property
    def floor(self) -> Likelihood:
        """The terms; a smooth one has hats of an octave and less, which follow any roll-off."""
        if not self.smooth:
            return self.part.likelihood
        seen = self.part.seen
        octave = np.log2(seen.size / (seen.first + (seen.count - 1) / 2))
        hats = [np.interp(octave, [at - width, at, at + width], [0.0, 1.0, 0.0]) for at, width in HATS]
        each = [(hat * self.part.passed)[self.part.used] for hat in hats]
        return _wider(self.part.likelihood, [hat for hat in each if hat.any()])

    def tuned(self, found: Sequence[Resonance]) -> "Searched":
        """The same behind the filter whose cut-off is best beside the resonances."""
        from scipy.optimize import minimize_scalar

        through, columns = self.part.filter, self.columns(found)
        if through is None:
            return self

        def behind(x: float) -> Portion:
            return self.part.but(filter=replace(through, cutoff=through.cutoff * math.exp(x)))

        def least(x: float) -> float:
            wider = _wider(behind(x).likelihood, columns)
            return wider.minimise(np.ones(wider.S.shape[1], dtype=bool))[1]

        best = minimize_scalar(least, bounds=(-MOVED, MOVED), method="bounded", options={"xatol": 1e-4})
        return replace(self, part=behind(float(best.x)))

    def columns(self, found: Sequence[Resonance]) -> list[FloatArray]:
        """Power of the resonances in the bins that are read."""
        return [self.grid.power(one)[self.part.used] for one in found]

    def minimum(self, found: Sequence[Resonance]) -> tuple[FloatArray, float]:
        """Theta of the floor and the resonances, and L."""
        whole = _wider(self.floor, self.columns(found))
        return whole.minimise(np.ones(whole.S.shape[1], dtype=bool))

    def power(self, found: Sequence[Resonance]) -> tuple[FloatArray, FloatArray]:
        """Power of the resonances in the bins that are read, and its share of all."""
        p, theta = self.floor.S.shape[1], self.minimum(found)[0]
        power = np.column_stack(self.columns(found)) @ theta[p:]
        return power, power / (self.floor.expectation(theta[:p]) + power)

    def highest(self, found: Sequence[Resonance]) -> float | None:
        """The frequency at which the power stands out most, radians a sample."""
        now, seen = self.floor, self.part.seen
        over = now.power / _wider(now, self.columns(found)).expectation(self.minimum(found)[0]) - 1
        able = (now.count >= FEWEST) & (seen.first[self.part.used] >= 2 * PERIODS) & (over > EXCESS)
        deviate = np.where(able, over * np.sqrt(now.count / 2), 0.0)
        at = int(deviate.argmax())
        if deviate[at] <= STANDS_OUT:
            return None
        return float(np.pi / seen.size * (seen.first + (seen.count - 1) / 2)[self.part.used][at])

    def started(self, found: Sequence[Resonance], omega: float) -> Resonance:
        """The best of those at a frequency that are tried first."""
        every = ((shape, omega, quality) for shape in range(len(SHAPES)) for quality in QUALITIES)
        return min(every, key=self._beside(found))

    def _beside(self, found: Sequence[Resonance]) -> Callable[[Resonance], float]:
        """L with one resonance more."""
        theta, columns = self.minimum(found)[0], self.columns(found)
        wider, every = _wider(self.floor, columns), np.ones(theta.size + 1, dtype=bool)
        left, floor = wider.power - wider.expectation(theta), 1e-3 * wider.power

        def least(one: Resonance) -> float:
            column = self.grid.power(one)[self.part.used]
            at = int(column.argmax())
            size = max(left[at], floor[at]) / column[at]
            return wider.with_more(column).minimise(every, np.append(theta, size))[1]

        return least

    def refine(self, found: list[Resonance], which: Iterable[int], shapes: Iterable[int]) -> None:
        """Replace some by those of a frequency, quality and one of the shapes that explain most beside the others.

        Without shapes each keeps its own.
        """
        from scipy.optimize import minimize

        low, high = math.log(QUALITIES[0]), math.log(QUALITIES[-1])
        for i in which:
            own, omega, quality = found[i]
            least = self._beside([*found[:i], *found[i + 1 :]])

            def at(x: FloatArray, shape: int, omega: float = omega) -> Resonance:
                frequency = min(omega * math.exp(float(x[0])), 3.0)
                return shape, frequency, math.exp(float(np.clip(x[1], low, high)))

            start = np.array([0.0, math.log(quality)])
            options = {
                "initial_simplex": start + np.array([[0, 0], [0.5 / quality, 0], [0, 0.5]]),
                "xatol": 1e-3, "fatol": 0.05, "maxfev": 30,
            }  # fmt: skip
            tried = [
                (minimize(lambda x, s=s, least=least: least(at(x, s)), start, method="Nelder-Mead", options=options), s)
                for s in (*shapes,) or (own,)
            ]
            best, shape = min(tried, key=lambda one: float(one[0].fun))
            found[i] = at(best.x, shape)

    def needed(self, found: list[Resonance]) -> list[Resonance]:
        """Those without which the others explain less."""
        whole = self.minimum(found)[1] if found else 0.0
        return [
            one for i, one in enumerate(found)
            if 2 * (self.minimum([*found[:i], *found[i + 1 :]])[1] - whole) > EVIDENCE
        ]  # fmt: skip


def _wider(part: Likelihood, more: Sequence[FloatArray]) -> Likelihood:
    """The likelihood with more columns."""
    for column in more:
        part = part.with_more(column)
    return part
