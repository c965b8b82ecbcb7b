"""An exponential warm-up, exp(-t / tau), in a record.

A settling bias resembles a random walk or a ramp: all three add power at the lowest frequencies. In the likelihood it
is one direction of any size, like a ramp, whose time constant is searched for.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.estimate import WEAK, Estimate
from allanite.core.finding import Finding
from allanite.core.limits import Remembered, quantile
from allanite.core.model import Term
from allanite.core.plain import Portable
from allanite.core.units import Signal, convert
from allanite.phrases.phrase import say
from allanite.phrases.wording import spelled

from .law import RampLimits
from .model_selection import Found, fitted
from .selection import PENALTY, Subset, subsets
from .whittle import with_warm_up

SHORTEST, LONGEST, STEPS = 1 / 30, 0.37, 9
"""Time constants of the first search, shares of the record: a longer one is a ramp and a parabola, and mimics noise."""

LOWER = 4
"""Steps below the shortest of these to which the best is looked for: a shorter one is found by them, but not fitted."""

EVIDENCE = 15.0
"""What a warm-up must gain in 2 L over the best of the terms; a weak random walk gains as much in 1 of 100 records."""

HARMLESS = 2.0
"""Standard errors to which the warm-up has fallen where a window can begin."""

USABLE = 0.75
"""Share of the record that may be cut off."""

REACH = 12.0
"""Rise of 2 L up to which time constants are looked at."""

NODES = 24
"""Time constants over which the size is averaged."""


@dataclass(frozen=True, eq=False)
class WarmUp(Portable):
    """A warm-up that was found: amplitude exp(-t / tau), SI and seconds.

    `error` is the standard error of the amplitude, `gain` what the warm-up gains in 2 L, `duration` that of the record;
    `found` and `base` are what it was found in, and what stands beside it.
    """

    signal: Signal
    amplitude: float
    error: float
    tau: float
    gain: float
    duration: float
    found: Found
    base: Subset

    @property
    def term(self) -> Term:
        """It as a term of a model."""
        return Term("W", -self.amplitude, self.signal, (self.tau,))

    @property
    def until(self) -> float:
        """Seconds after which the remaining warm-up is negligible, rounded up to two digits."""
        needed = self.tau * math.log(max(abs(self.amplitude) / (HARMLESS * self.error), 1.1))
        step = 10.0 ** (math.floor(math.log10(needed)) - 1)
        return float(f"{math.ceil(needed / step) * step:.3g}")

    def at(self, tau: float) -> tuple[float, float, float]:
        """2 L, amplitude and its standard error with another time constant, s."""
        beside = _beside(self.found, self.base, tau * self.found.seen.rate)
        eta, V, _ = beside.likelihood.directions(beside.theta)
        which, factor = _direction(beside), self.found.seen.unit_factor
        return beside.profiled, float(eta[which]) * factor, math.sqrt(float(V[which, which])) * factor

    @property
    def finding(self) -> Finding:
        """The finding about the warm-up."""
        unit = self.signal.sheet[0]
        size, error = (convert(value, self.signal.unit, unit) for value in (self.amplitude, self.error))
        usable, cut = self.until <= USABLE * self.duration, self.found.seen.cut
        remedy = (
            say(
                "cut it off ({option})",
                option=spelled(f"--from {cut + self.until:g}", f"prepare.trim(recording, {cut + self.until:g})"),
            )
            if usable
            else (
                say(
                    "record again, starting at least {seconds:.3g} s after switching on: too little would remain if it "
                    "were cut off",
                    seconds=self.until,
                )
            )
        )
        return Finding(
            "warm-up",
            say(
                "the sensor warms up: its bias starts {size:+.3g} ± {error:.2g} {unit} from where it settles, with "
                "a time constant of {tau:.3g} s",
                size=size,
                error=error,
                unit=unit,
                tau=self.tau,
            ),
            say("the coefficients are those of the noise without it; K and R are less certain"),
            remedy,
            (cut, cut + min(self.until, self.duration)),
        )


def without_warm_up(found: Found, signal: Signal) -> tuple[WarmUp | None, Found]:
    """The warm-up of a record and the noise besides it; None and the same noise if there is none.

    The best model with a warm-up, in which a random walk may be gone, is compared with the best one without.
    """
    from scipy.optimize import minimize_scalar

    seen = found.seen
    if not found.used[0] or (seen.pieces is not None and not seen.pieces.low):  # no bin that tells of it
        return None, found
    slope = seen.slope if found.chosen.likelihood.flat.any() else None
    bare = min(_score(subset, slope) for subset in (*found.every, found.plain, found.markov or found.chosen))
    grid = np.geomspace(SHORTEST, LONGEST, STEPS) * seen.size
    tried = [(base, float(tau), _beside(found, base, float(tau)).profiled) for base in _bases(found) for tau in grid]
    base, tau, least = min(tried, key=lambda one: one[2])
    if bare - least - PENALTY < EVIDENCE:  # one term at least is there
        return None, found
    # the best time constant near that of the grid, in samples
    step, n = (LONGEST / SHORTEST) ** (1 / (STEPS - 1)), seen.size
    near = minimize_scalar(
        lambda x: _beside(found, base, math.exp(x)).profiled, method="bounded", options={"xatol": 0.02},
        bounds=(math.log(tau / (step if tau > SHORTEST * n else step**LOWER)), math.log(min(tau * step, LONGEST * n))),
    )  # fmt: skip
    tau = math.exp(float(near.x))
    part = with_warm_up(base.likelihood, seen, found.used, tau)
    best = min(subsets(part, may=base.free, constants=base.constants), key=lambda subset: _score(subset, slope))
    gain = bare - _score(best, slope)
    if gain < EVIDENCE:
        return None, found
    eta, V, _ = best.likelihood.directions(best.theta)
    at = _direction(best)
    amplitude, error = float(eta[at]) * seen.unit_factor, math.sqrt(float(V[at, at])) * seen.unit_factor
    duration = (seen.size + int(seen.gaps.lost.sum())) / seen.rate
    warm = WarmUp(signal, amplitude, error, tau / seen.rate, gain, duration, found, replace(base, free=best.free))
    rival = found.search is not None and not found.search.asked
    return warm, fitted(replace(found.base, warm=tau), rival=rival)


def _direction(subset: Subset) -> int:
    """Place of the warm-up among the loose directions."""
    return int(np.count_nonzero(~subset.likelihood.flat))


def _bases(found: Found) -> list[Subset]:
    """What stands beside a warm-up, all of it free: the terms; these and Gauss-Markov noise too where that is there."""
    bases = [replace(found.chosen, free=found.search.may)] if found.search and found.chosen.constants else []
    if not found.plain.constants:
        free = np.ones(found.plain.free.size, dtype=bool) if found.search is None else ~found.search.must
        bases.append(replace(found.plain, free=free))
    return bases


def _beside(found: Found, base: Subset, tau: float) -> Subset:
    """The least of L with a warm-up beside what is free in `base`."""
    part = with_warm_up(base.likelihood, found.seen, found.used, tau)
    return Subset(part, base.free, *part.minimise(base.free, base.theta), base.constants)


def _score(subset: Subset, slope: float | None) -> float:
    """The same and the penalties of the terms, of which a time constant counts as two.

    A ramp, the last direction, of which `slope` was removed before, costs no more than leaving it out would.
    """
    score = subset.profiled + PENALTY * (float(subset.free.sum()) + 2 * len(subset.constants))
    if slope is None:
        return score
    eta, V, _ = subset.likelihood.directions(subset.theta)
    return score + min(PENALTY, float((eta[-1] + slope) ** 2 / V[-1, -1]))


@dataclass(frozen=True, eq=False)
class WarmUpProfile(Portable):
    """The profile of the likelihood over the time constant of a warm-up."""

    warm: WarmUp

    def ends(self, drop: float) -> tuple[float, float]:
        """Time constants, s, at which 2 L has risen by `drop`; at most from a thousandth to all of the record."""
        from scipy.optimize import brentq

        middle, least = math.log(self.warm.tau), self.warm.at(self.warm.tau)[0]
        found = []
        for end in (math.log(self.warm.duration / 1000), math.log(self.warm.duration)):

            def excess(x: float) -> float:
                return self.warm.at(math.exp(x))[0] - least - drop

            near = next((x for x in middle + (end - middle) * 2.0 ** np.arange(-9.0, 1.0) if excess(x) > 0), None)
            found.append(math.exp(end if near is None else brentq(excess, middle, near, xtol=1e-4)))
        return found[0], found[1]

    def __call__(self, level: float) -> tuple[tuple[float, float], ...]:
        """Two-sided limits of the time constant, s."""
        return (self.ends(quantile((1 + level) / 2) ** 2),)

    @cached_property
    def size(self) -> RampLimits:
        """The law of the size: normal at a time constant, averaged over these."""
        low, high = self.ends(REACH)
        nodes = [self.warm.at(tau) for tau in np.geomspace(low, high, NODES).tolist()]
        excess, amplitude, error = np.array(nodes).T
        weight: FloatArray = np.exp(-0.5 * (excess - excess.min()))
        return RampLimits(-amplitude, error, weight / weight.sum())


def warm_up_estimate(symbol: str, warm: WarmUp | None, signal: Signal) -> Estimate:
    """The change of the rate from the start of the record to where it settles; absent without a warm-up."""
    if warm is None:
        return Estimate(symbol, signal, None, None, "absent", None, "whittle")
    along = WarmUpProfile(warm)
    law, value = along.size, -warm.amplitude
    error = math.sqrt(float(law.weight @ (law.spread**2 + (law.centre - value) ** 2)))
    status = "identified" if error <= WEAK * abs(value) else "weak"
    limits = Remembered(law)
    return Estimate(
        symbol, signal, value, error, status, law.upper(0.95), "whittle", limits, limits, value,
        shape=(warm.tau,), shape_limits=Remembered(along),
    )  # fmt: skip
