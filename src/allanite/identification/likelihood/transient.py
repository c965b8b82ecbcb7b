"""The estimate of a warm-up that was asked for: its size with a sign, and its time constant."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.estimate import WEAK, Estimate
from allanite.core.limits import Remembered, quantile
from allanite.core.plain import Portable
from allanite.core.units import Signal

from .estimates import RampLimits
from .warmup import WarmUp

REACH = 12.0
"""Rise of 2 L up to which time constants are looked at."""

NODES = 24
"""Time constants over which the size is averaged."""


@dataclass(frozen=True, eq=False)
class Along(Portable):
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
    along = Along(warm)
    law, value = along.size, -warm.amplitude
    error = math.sqrt(float(law.weight @ (law.spread**2 + (law.centre - value) ** 2)))
    status = "identified" if error <= WEAK * abs(value) else "weak"
    limits = Remembered(law)
    return Estimate(
        symbol, signal, value, error, status, law.upper(0.95), "whittle", limits, limits, value,
        shape=(warm.tau,), shape_limits=Remembered(along),
    )  # fmt: skip
