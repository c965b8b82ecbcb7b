"""The low-pass filter of the samples: selected by likelihood, with the range of cut-offs consistent with the record."""

import math
from dataclasses import dataclass

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.terms import TERMS

from .band import Portion, Tuned
from .filters import FILTERS, NARROWEST

EVIDENCE = 15.0
"""What a filter must gain in 2 L: for its cut-off, and for being one of several that are tried."""

SAME = 4.0
"""Filters that lose less than this in 2 L describe the record as well as the best one."""

OPEN = 6.6
"""Cut-offs that lose less than this in 2 L take part in the limits of the terms (the 99 % point)."""

NEAR = 3
"""Cut-offs on either side of the best that take part."""

ALIKE = 1e-3
"""Cut-offs that differ by less than this in 2 L are alike."""


@dataclass(frozen=True)
class Tuning:
    """Filters by what they gain in 2 L, the best first, each with its best cut-off."""

    filters: tuple[Tuned, ...]
    gains: tuple[float, ...]

    @property
    def believed(self) -> bool:
        """Whether the best one gains enough."""
        return self.gains[0] > EVIDENCE

    @property
    def likely(self) -> tuple[Tuned, ...]:
        """The best, and the others that describe the record as well."""
        return tuple(f for f, gain in zip(self.filters, self.gains, strict=True) if gain > self.gains[0] - SAME)


def least(part: Portion, through: Tuned | None, start: FloatArray | None = None) -> tuple[float, FloatArray]:
    """2 L with all terms free behind a filter, and their thetas; Gauss-Markov noise only with a shape that is known."""
    behind = part.but(filter=through).known(part.shape)
    free = np.array([not TERMS[symbol].parameters for symbol in part.noise])
    if part.shape or not free.any():
        free[:] = True
    theta, value = behind.minimise(free, start)
    return 2 * value, theta


def rolls_off(part: Portion) -> bool:
    """Whether a low-pass of first order gains as much as a filter must: quickly told, and true behind any of them."""
    without, _ = least(part, None)
    return any(without - least(part, Tuned("rc", c))[0] > EVIDENCE for c in FILTERS["rc"].starts.tolist())


def tuning(part: Portion) -> Tuning:
    """All filters of the table, each with the cut-off of the least L."""
    without, _ = least(part, None)
    found = [(_tuned(part, row), row) for row in FILTERS]
    found.sort(key=lambda one: one[0][0])
    return Tuning(tuple(Tuned(row, c) for (_, c), row in found), tuple(without - value for (value, _), _ in found))


def _tuned(part: Portion, row: str) -> tuple[float, float]:
    """The least 2 L of a filter, and its cut-off."""
    from scipy.optimize import minimize_scalar

    start: FloatArray | None = None

    def value(x: float) -> float:
        nonlocal start
        found, start = least(part, Tuned(row, math.exp(x)), start)
        return found

    grid = np.log(FILTERS[row].starts)
    values = np.array([value(x) for x in grid])
    at = int(np.flatnonzero(values <= values.min() + ALIKE)[-1])  # wide ones all let everything pass
    ends = grid[min(at + 1, len(grid) - 1)], grid[max(at - 1, 0)]
    best = minimize_scalar(value, method="bounded", bounds=ends, options={"xatol": 5e-3})
    return min((float(best.fun), math.exp(float(best.x))), (float(values[at]), math.exp(grid[at])))


def limits(part: Portion, best: Tuned, drop: float) -> tuple[float, float]:
    """Cut-offs, cycles per sample, at which 2 L has risen by `drop`, all terms following."""
    from scipy.optimize import brentq

    (lowest, start), x = least(part, best), math.log(best.cutoff)

    def excess(at: float) -> float:
        return least(part, Tuned(best.row, math.exp(at)), start)[0] - lowest - drop

    def end(step: float, bound: float) -> float:
        at = x + step
        while excess(at) < 0:
            step *= 2
            at = x + step
            if (at - bound) * step > 0:
                return bound
        return float(brentq(excess, x, at, xtol=1e-4))

    return math.exp(end(-0.01, math.log(NARROWEST))), math.exp(end(0.01, math.log(FILTERS[best.row].widest)))


def left_open(part: Portion, best: Tuned) -> list[Tuned]:
    """The filter with the cut-offs that the likelihood leaves open, except for the best itself."""
    low, high = limits(part, best, OPEN)
    cutoffs = (*np.geomspace(low, best.cutoff, NEAR + 1)[:-1], *np.geomspace(high, best.cutoff, NEAR + 1)[:-1])
    return [Tuned(best.row, float(c)) for c in cutoffs]
