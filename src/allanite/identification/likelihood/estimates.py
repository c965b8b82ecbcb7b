"""Estimates of the terms of a likelihood: values, intervals, and why there are none."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.averaged import Averaged, averaged
from allanite.core.estimate import WEAK, Estimate
from allanite.core.limits import Remembered, Stored, quantile
from allanite.core.model import Model, Term
from allanite.core.units import Signal
from allanite.core.validity import Scope
from allanite.phrases.phrase import say
from allanite.terms import TERMS

from .band import HIDDEN
from .law import Law, RampLimits
from .model_selection import Found
from .selection import Subset
from .timeconstant import Search

Limits = Callable[[float], tuple[float, float]]

TWO_SIDED = 1.96
"""Standard errors from an estimate to its 95 % limits."""

NODES = 12
"""Models along the profile, at most."""

PRIOR = 0.0
"""Power of the coefficient in its prior."""

LEAST = 1e-3
"""Weight of a model, over that of the heaviest, below which it is omitted."""


BEGUN = 0.5
"""Share of the lowest coefficient of a ramp that must be there, where it is not read."""


@dataclass(frozen=True)
class CoefficientScale:
    """From theta, in the record's unit and per sample, to coefficients in SI."""

    signal: Signal
    rate: float
    factor: float
    slope: float

    def terms(self, noise: Sequence[str], subset: Subset) -> tuple[Term, ...]:
        """The terms of a subset; what it has beyond `noise` is one more Gauss-Markov term."""
        return self.powers(noise, subset.theta, subset.constants)

    def powers(self, noise: Sequence[str], theta: FloatArray, constants: tuple[float, ...]) -> tuple[Term, ...]:
        """The terms of some powers, with time constants in samples."""
        left = iter(constants)
        found = []
        for symbol, power in zip((*noise, noise[-1]), theta.tolist(), strict=False):
            shape = self.shape(symbol, tuple(islice(left, len(TERMS[symbol].parameters))))
            if power > 0:
                found.append(Term(symbol, self.coefficient(symbol, power), self.signal, shape))
        return tuple(found)

    def shape(self, symbol: str, values: tuple[float, ...]) -> tuple[float, ...]:
        """Values of a term's parameters, SI, from those in sample intervals."""
        known = zip(values, TERMS[symbol].parameters, strict=False)
        return tuple(value * math.pow(self.rate, -p.time) for value, p in known)

    def coefficient(self, symbol: str, theta: float) -> float:
        """Coefficient of a theta."""
        return self.coefficient_of(symbol, math.sqrt(max(theta, 0.0)))

    def coefficient_of(self, symbol: str, eta: float) -> float:
        """Coefficient of the root of a theta, with its sign."""
        return eta * self.factor * math.pow(self.rate, -TERMS[symbol].power)


@dataclass(frozen=True, eq=False)
class LawLimits:
    """Limits of a noise term, in SI; 0 and infinity where nothing is known.

    They always include the `value`. Limits are averaged over more models than the value is (Akaike's penalty instead of
    Schwarz's), so that without this a value could lie outside where two terms can replace each other.
    """

    symbol: str
    law: Law | None
    scale: CoefficientScale
    value: float | None = None

    def __call__(self, level: float) -> tuple[float, float]:
        """Two-sided limits."""
        ends = self.law.limits(level) if self.law else (0.0, math.inf)
        low, high = (self.scale.coefficient_of(self.symbol, end) for end in ends)
        return (low, high) if self.value is None else (min(low, self.value), max(high, self.value))

    def upper(self, level: float) -> float:
        """One-sided upper limit."""
        return self.scale.coefficient_of(self.symbol, self.law.quantile(level) if self.law else math.inf)


def noise_estimate(symbol: str, which: int, found: Found, scale: CoefficientScale) -> Estimate:
    """Estimate of a noise term, absent unless no other term could take its place."""
    limited, valued = found.laws(which) or (None, None)
    law = LawLimits(symbol, limited, scale)
    limits, upper = Remembered(law), Remembered(law.upper)
    median = scale.coefficient_of(symbol, valued.quantile(0.5)) if valued else None
    claimed = found.chosen.free[which] and found.profile(which).excludes_zero() and limits(0.95)[0] > 0
    if claimed:
        limits = Remembered(replace(law, value=median))
    if not claimed or limited is None or median is None:
        return _absent(symbol, scale, upper, limits, median)
    # the lower limit is not beyond two standard errors
    relative = max(scale.coefficient_of(symbol, limited.spread) / median, (1 - limits(0.95)[0] / median) / TWO_SIDED)
    status = "identified" if relative <= WEAK else "weak"
    plain = Estimate(
        symbol, scale.signal, median, median * relative, status, upper(0.95), "whittle", limits, limits, median
    )
    if not TERMS[symbol].parameters:
        return plain
    # with its shape, and the profile interval of that
    search, constants = found.search, found.chosen.constants
    assert search is not None and constants  # noqa: S101, PT018 - the term was chosen
    before = sum(len(TERMS[s].parameters) for s in found.noise[:which])
    own = slice(before, before + len(TERMS[symbol].parameters))
    shape_limits = Remembered(ConstantLimits(search, constants, scale, symbol, own))
    return replace(plain, shape=scale.shape(symbol, constants[own]), shape_limits=shape_limits)


@dataclass(frozen=True, eq=False)
class ConstantLimits:
    """Limits of a time constant, or of what else a term's shape has, whose best values are known in samples.

    `own` is the place of the shape of the term `symbol` among those of all terms.
    """

    search: Search
    constants: tuple[float, ...]
    scale: CoefficientScale
    symbol: str
    own: slice

    def __call__(self, level: float) -> tuple[tuple[float, float], ...]:
        """Two-sided limits."""
        # with every other term free: one that was not selected could make another time constant possible
        every = self.search.refined(self.constants, np.ones_like(self.search.may))
        low, high = zip(*self.search.limits(every, quantile((1 + level) / 2) ** 2)[self.own], strict=True)
        return tuple(zip(self.scale.shape(self.symbol, low), self.scale.shape(self.symbol, high), strict=True))


def _absent(
    symbol: str, scale: CoefficientScale, upper: Callable[[float], float], limits: Limits, median: float | None = None
) -> Estimate:
    highest = upper(0.95) if math.isfinite(upper(0.95)) else None
    return Estimate(symbol, scale.signal, None, None, "absent", highest, "whittle", limits, limits, median)


def observable(symbol: str, estimate: Estimate | None, found: Found, scope: Scope, scale: CoefficientScale) -> Estimate:
    """The estimate, or why the term is not observable with the data used."""
    edge, visible = TERMS[symbol].edge, False
    if estimate is not None and symbol in found.noise:
        # whether it makes most of the power at the highest frequency that is read
        which, chosen = found.noise.index(symbol), found.chosen
        share = chosen.likelihood.S[-1] * chosen.theta
        visible = bool(share[which] > 0.5 * share.sum())
    limited = bool(edge) and (bool(scope.filter) or scope.band[1] < HIDDEN * found.seen.rate / 2)
    reason = "" if limited and visible else _unseen(estimate, scope, limited=limited)
    if estimate is None and not edge:  # another term with a shape took its place
        return _absent(symbol, scale, Stored(math.inf), Stored((0.0, math.inf)))
    if reason or estimate is None:
        return Estimate(symbol, scale.signal, None, None, "not observable", None, "whittle", reason=reason)
    if edge and not visible and estimate.claimed and found.part.misfit:
        return estimate.invalid(say("the noise rises near half the sampling rate, but not as angle noise does"))
    return estimate


def _unseen(estimate: Estimate | None, scope: Scope, *, limited: bool) -> str:
    """What keeps a term from being seen: for angle noise beyond a `limited` band its end, else where it begins."""
    low, high = scope.band
    if limited and scope.filter:
        return say("the filter hides the frequencies where it would be visible")
    if limited:
        return say(
            "the band, which ends at {frequency:.3g} Hz, excludes the frequencies where it would be visible",
            frequency=high,
        )
    if low > 0 and estimate is not None and not estimate.claimed and estimate.upper in (None, 0.0, math.inf):
        return say(
            "the band begins at {frequency:.3g} Hz, above the frequencies where it would be visible", frequency=low
        )
    return ""


def ramp_estimate(symbol: str, found: Found, scale: CoefficientScale) -> Estimate:
    """The signed ramp: normal for given noise, averaged over the possible noise of the longest memory.

    That noise is what hides a ramp, and is known from a few coefficients only: averaging gives the wide tails of
    Student's t, and holds where the noise was not seen at all.
    """
    part = found.everything.likelihood
    if not part.flat.any():  # the band excludes the frequencies of a ramp
        return _absent(symbol, scale, Stored(math.inf), Stored((-math.inf, math.inf)))
    thetas, weight = found.profile(found.slowest).weighted()
    along = [part.directions(theta)[:2] for theta in thetas]
    size = scale.coefficient_of(symbol, 1.0)
    centre = size * (np.array([eta[-1] for eta, _ in along]) + scale.slope)
    spread = size * np.sqrt([V[-1, -1] for _, V in along])
    value = float(weight @ centre)
    error = math.sqrt(float(weight @ (spread**2 + (centre - value) ** 2)))
    ramp = RampLimits(centre, spread, weight)
    limits, upper = Remembered(ramp), Remembered(ramp.upper)
    low, high = limits(0.95)
    if low <= 0 <= high:
        return _absent(symbol, scale, upper, limits, value)
    if not _begins(found, value / size):
        return _absent(symbol, scale, Stored(math.inf), Stored((-math.inf, math.inf)))
    status = "identified" if error <= WEAK * abs(value) else "weak"
    return Estimate(symbol, scale.signal, value, error, status, upper(0.95), "whittle", limits, limits, value)


def _begins(found: Found, slope: float) -> bool:
    """Whether the lowest coefficient, which has 98 % of the power of a ramp, is read, or is half of that of the ramp.

    Else it is what leaks from a cycle or another motion slower than what is read.
    """
    seen = found.seen
    lowest = seen.even[0] + seen.odd[0] + seen.slope * seen.ramp[0]
    return bool(found.used[0] or lowest / (slope * seen.ramp[0]) > BEGUN)


def nodes(found: Found, scale: CoefficientScale, beside: tuple[Term, ...]) -> Averaged:
    """Models along the profile of the noise of the longest memory, all terms free, with what stands `beside` it.

    That noise dominates the long averaging times and is known from a few coefficients only: terms that were not
    selected may be present. The weights are those of its likelihood times a flat prior of its coefficient.
    """
    thetas, weight = found.profile(found.slowest).weighted(NODES, PRIOR)
    constants = found.everything.constants
    each = [scale.powers(found.noise, theta, constants) for theta in thetas]
    kept = [
        (Model((*terms, *beside)), float(w)) for terms, w in zip(each, weight, strict=True) if w > LEAST * weight.max()
    ]
    return averaged([model for model, _ in kept], [w for _, w in kept])
