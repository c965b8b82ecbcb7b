"""The one table of components: what may be in a record, where it is looked for, and what it costs."""

# Derivation: docs/derivations.md.

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np
import scipy

from allanite.core.arrays import FloatArray
from allanite.identification.likelihood.filters import FILTERS
from allanite.identification.likelihood.whittle import column
from allanite.kernels import whittle
from allanite.terms import TERMS

from .frame import LOWEST_CUTOFF, Frame

ODDS = 2.0  # what a component must gain in 2 L beyond its cost to be claimed: odds of e to 1

CLAIMED = 1 / (1 + math.exp(-ODDS / 2))
"""Weight of the states that hold a component from which it is claimed: at these odds."""

TERM = 0.0228  # rate of false claims of a noise term that is absent: it gains 4 in 2 L in 2.3 % of records

LEAST_MARKOV, QUICKEST_MARKOV = 30.0, 4.0
"""Samples. Below the first, a time constant that was not asked for needs white noise beside it, else it is a filter's,
and costs `QUICK` more; below the second it is that of a filter with white noise behind it: a definition."""

QUICK = 6.0
"""What a quick time constant costs more, in 2 L: odds of e^3 against noise that only a few samples correlate."""

SECOND = 6.0
"""What a second Gauss-Markov noise costs more, in 2 L: two of them are nearly flicker, which is likelier by e^3."""

LONGEST_MARKOV = 0.1  # share of the record up to which a time constant differs from a random walk (`terms.row.LONGEST`)

HIDING = 0.04
"""Cut-off, cycles a sample, below which a filter with noise behind it is Gauss-Markov and white noise: a definition."""

QUALITIES = (2.5, 300.0)
"""Least and greatest quality of a resonance: a broader one is a filter, a narrower one a sinusoid."""

BROAD = 4.0
"""Quality below which a state has one resonance at most: several are as broad as the knots of a factor, and sure of
what it leaves open."""

PERIODS = 32  # periods of a resonance in a record, at least: of fewer its peak is not resolved
HIGHEST_RESONANCE = 3.1  # frequency of a resonance, radians a sample, at most: just below half the sampling rate

EXPONENTS = (0.7, 1.6)
"""Exponents of a power law: between 0.6 and 1.6 its column is exact within 1 %, and a lower one is nearly white."""

SHORTEST_WARM_UP, LONGEST_WARM_UP = 0.001, 0.37
"""Shares of the record from which a warm-up is looked for, and up to which it differs from a ramp with a parabola."""

FEWEST_PERIODS, MOST_PERIODS = 2.0, 8.0
"""Periods of a wave in a record: of fewer it is what a random walk does, of more a sinusoid that stands out alone."""

INSIDE = 1.05  # factor by which what is tried first stays inside its bounds
SIZES = (0.004, 6.0)  # least and greatest size of a factor, RMS of the logarithm of the power


class Part(NamedTuple):
    """One component of a state: the row of `COMPONENTS`, what tells it from others of the row, and its shape."""

    name: str
    label: str
    shape: tuple[float, ...]


@dataclass(frozen=True)
class Component:
    """A row of the table."""

    name: str
    alpha: float  # rate of false claims a record
    places: Callable[[int], float]  # effective number of places in which it is looked for, in a record of n samples
    freedom: float = 1.0  # degrees of freedom of the gain at a known place
    signed: bool = False  # whether its size may be negative
    most: int = 1  # how many of them a record may have
    refined: int = 0  # how many of its shape's values are refined with the sizes
    grain: tuple[float, ...] = ()  # steps in the logarithms of the shape within which two states are the same
    bounds: Callable[[Frame, Part], list[tuple[float, float]]] = lambda frame, part: []
    ending: bool = False  # whether beyond its bounds it is something else, so that no state has it at one of them
    # shape (bins,); expected power for a size of 1, of noise in the sensor or behind its filter; None for other
    # components
    power: Callable[[Frame, Part], FloatArray] | None = None
    # shape (values, bins); derivatives of that by the logarithms of the shape
    slope: Callable[[Frame, Part], FloatArray] | None = None
    inside: bool = False  # whether the filter acts on it
    # whether it is what the filter does not take of white noise: its column is multiplied by 1 - gain, so that the
    # white noise before and behind the filter together is N, as at long averaging times
    behind: bool = False
    gain: Callable[[Frame, Part], FloatArray] | None = None  # shape (bins,); what a filter lets pass

    def price(self, n: int) -> float:
        """What it must gain in 2 L to be claimed."""
        return _price(self.places(n), self.alpha, self.freedom, self.signed)

    def cost(self, n: int) -> float:
        """What it costs in the score."""
        return self.price(n) - ODDS


@lru_cache(4096)
def _price(places: float, alpha: float, freedom: float, signed: bool) -> float:
    return float(scipy.special.chdtri(freedom, min((1 if signed else 2) * alpha / places, 1.0)))


AT_BOUND = 0.01  # distance from a bound, in the logarithm of a shape, within which it is at that bound


def at_bound(part: Part, frame: Frame) -> bool:
    """Whether the shape of a part that was not asked for stands where it would be something else."""
    row = COMPONENTS[part.name]
    if not row.ending or part.label in frame.asked:
        return False
    ends = zip(part.shape, row.bounds(frame, part), strict=False)
    return any(min(abs(math.log(x / low)), abs(math.log(x / high))) < AT_BOUND for x, (low, high) in ends)


STEP = 1e-5
"""Step in the logarithm of a shape for a derivative: what sizes cannot make up for is often a hundredth of it."""


def _noise_bounds(frame: Frame, part: Part) -> list[tuple[float, float]]:
    """Those of its row for a term that was asked for, else those of drift."""
    if part.label in frame.asked:
        return [p.search(frame.size) for p in TERMS[part.label].parameters if p.search is not None]
    return [(QUICKEST_MARKOV, max(LONGEST_MARKOV * frame.size, 2 * LEAST_MARKOV))]


def _noise_slope(frame: Frame, part: Part) -> FloatArray:
    own, rows = frame.column(part.label, part.shape), []
    for i, value in enumerate(part.shape):
        moved = (*part.shape[:i], value * math.exp(STEP), *part.shape[i + 1 :])
        rows.append((frame.column(part.label, moved) - own) / STEP)
    return np.array(rows)


def power_law(frame: Frame, part: Part) -> FloatArray:
    """Power of noise of density f^-a behind the averaging over each sample."""
    assert frame.flicker is not None  # noqa: S101 - the part stands in its place
    row = replace(TERMS[frame.powers[frame.flicker]], dct=partial(_power_law, a=part.shape[0]))
    return frame.remembered(("exponent", part.shape), lambda: column(row, frame.spectrum)[frame.used])


def _power_law(k: FloatArray, n: int, a: float) -> FloatArray:
    """Variance of the DCT coefficients of the mean rates over each sample of noise of density f^-a, f in 1/sample."""
    # The last factor is what is lost to other coefficients, for exponents from 0.6 to 1.6 within 1 %, and 3 % at k = 1.
    x = k / (2.0 * n)
    aliases = scipy.special.zeta(2 + a, x) + scipy.special.zeta(2 + a, 1 - x)
    return np.asarray(np.sin(math.pi * x) ** 2 / math.pi**2 * aliases * (1 - 0.2 / k))


def _power_law_slope(frame: Frame, part: Part) -> FloatArray:
    moved = part._replace(shape=(part.shape[0] * math.exp(STEP),))
    return (power_law(frame, moved) - power_law(frame, part))[None] / STEP


def resonance(frame: Frame, part: Part) -> FloatArray:
    """Mean power of a resonance in the bins, its highest 1: white noise through two poles."""
    return np.asarray(_resonance(frame, part)[0])


def _resonance(frame: Frame, part: Part) -> FloatArray:
    """Its power, and the derivatives by the logarithms of frequency and quality up to a share of itself: (3, bins)."""

    def computed() -> FloatArray:
        omega, quality = part.shape
        slow = omega / (2 * quality)  # -ln r
        r = math.exp(-slow)
        a, b = -2 * r * math.cos(omega), r * r  # coefficients of the poles
        power, by_a, by_b = whittle.resonance(*frame.cosines(quality), a, b, part.label == "high-pass")
        level, change = power.max(), 2 * slow * b
        by_omega = by_a * (2 * r * omega * math.sin(omega) - slow * a) - by_b * change
        return np.asarray(np.array((power, by_omega, by_a * (slow * a) + by_b * change)) / level)

    return frame.remembered(part, computed)


def _resonance_bounds(frame: Frame, part: Part) -> list[tuple[float, float]]:
    quality = (QUALITIES[0], BROAD) if part.shape[1] < BROAD else (BROAD, QUALITIES[1])
    return [(2 * np.pi * PERIODS / frame.size, HIGHEST_RESONANCE), quality]


def most_periods(frame: Frame) -> float:
    """Periods that a wave may have: its coefficients, twice as many, stand alone."""
    return min(MOST_PERIODS, frame.alone / 2 - 1)


def _filter_bounds(frame: Frame, part: Part) -> list[tuple[float, float]]:
    """Those of its row, or of the filter in common."""
    common = frame.common_row(part.label)
    return [common.bounds if common else (LOWEST_CUTOFF, FILTERS[part.label].widest)]


COMPONENTS: dict[str, Component] = {
    row.name: row
    for row in (
        Component("term", TERM, lambda n: 1),
        Component(
            "noise", 0.005, lambda n: 1.8 * math.log10(max(n / 300, 10.0)), most=2, refined=1, grain=(0.25, 0.25),
            bounds=_noise_bounds, ending=True, power=lambda frame, part: frame.column(part.label, part.shape),
            slope=_noise_slope, inside=True,
        ),
        Component(
            "exponent", 0.002, lambda n: 4, signed=True, refined=1, grain=(0.05,),
            bounds=lambda frame, part: [EXPONENTS], ending=True, power=power_law, slope=_power_law_slope, inside=True,
        ),
        Component(
            "filter", 0.003, lambda n: 3, signed=True, refined=1, grain=(0.03,),
            bounds=_filter_bounds,
            gain=lambda frame, part: frame.gain(part.label, part.shape[0]),
        ),
        Component(
            "floor", 0.00012, lambda n: 1, power=lambda frame, part: np.ones(frame.count.size),
            slope=lambda frame, part: np.zeros((0, frame.count.size)), behind=True,
        ),
        Component(
            "resonance", 0.003, lambda n: 60 * math.log2(max(n / 1024, 2.0)), most=12, refined=2, grain=(0.05, 0.7),
            bounds=_resonance_bounds, power=resonance, slope=lambda frame, part: _resonance(frame, part)[1:],
        ),
        Component("factor", 0.05, lambda n: 1, signed=True, most=3, grain=(0.5, 0.5, 0.5)),
        Component("step", 0.003, lambda n: 400, signed=True, most=10, grain=(0.01,)),
        Component(
            "warm-up", 0.002, lambda n: 24, signed=True, grain=(0.3,),
            bounds=lambda frame, part: [(SHORTEST_WARM_UP * frame.size, LONGEST_WARM_UP * frame.size)], ending=True,
        ),
        Component(
            "wave", 0.003, lambda n: 40, freedom=2.0, signed=True, grain=(0.1,),
            bounds=lambda frame, part: [(FEWEST_PERIODS, most_periods(frame))], ending=True,
        ),
        Component("sinusoid", 0.01, lambda n: n / 2, freedom=2.0, signed=True, most=12),
    )
}  # fmt: skip
"""Every component by its name."""

FACTORS = {"all": 4.0, "above": 5.0, "step above": 5.0, "between": 10.0}
"""Prices of the kinds of a factor. The determinant of its information pays for most of the search
(`benchmarks/prices.py`)."""

ANGLE, BEHIND = 2.0, 4.0
"""What angle noise costs beyond another term: it is clearly visible or of no weight, as it dominates a fixed share of
all coefficients; and what it costs instead behind a filter or beside resonances, whose shapes it gains from (gains
above 4 in 17 %, above 8 in 2 % of records without it). Behind a cut-off below `HIDING` it is white: a definition."""


def cost_of(part: Part, frame: Frame) -> float:
    """What a part costs in the score."""
    if part.name == "factor":
        return FACTORS[part.label] - ODDS
    if part.name == "filter" and frame.common:  # the price is paid once for all channels
        return 0.0 if frame.common_row(part.label) else math.inf
    row = COMPONENTS[part.name]
    if part.name == "noise" and len(part.shape) > 1:  # each further value is looked for in some fifty places
        return _price(row.places(frame.size) * 50.0 ** (len(part.shape) - 1), row.alpha, 1.0, False) - ODDS
    quick = part.name == "noise" and part.label not in frame.asked and part.shape[0] < LEAST_MARKOV
    return row.cost(frame.size) + (QUICK if quick else 0.0)
