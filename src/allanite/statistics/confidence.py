"""The confidence law of a curve: degrees of freedom and limits, worked out when first asked."""

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from allanite.curve import Law
from allanite.model import Model, Term
from allanite.terms import TERMS
from allanite.units import Signal

from .angle import Angle
from .grids import part_of, times
from .moments import RANDOM_RATIO, Runs, edf
from .powerlaw import PowerLaw, identify_power_law
from .row import FloatArray, IntArray, Statistic


class Points(NamedTuple):
    """The points of a curve: averaging factors of a row, in a record of `size` samples at `rate` Hz cut into `runs`."""

    row: Statistic
    m: IntArray
    runs: Runs
    size: int
    rate: float
    join: float

    def at(self, where: IntArray) -> "Points":
        """Some of the points."""
        return self._replace(m=self.m[where])


def law(points: Points, models: Sequence[Model]) -> Law:
    """Chi-square with the exact degrees of freedom, for a model at every point or one for all."""

    @cache
    def degrees() -> FloatArray:
        if len(models) == 1:
            return degrees_of(points, models[0])
        result, names = np.empty(points.m.size), np.array([str(model) for model in models])
        for name in np.unique(names):
            here = np.flatnonzero(names == name)
            result[here] = degrees_of(points.at(here), models[here[0]])
        return result

    def limits(level: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        from scipy.special import gammaincinv

        e = degrees()
        low, high = (e / (2 * gammaincinv(e / 2, p)) for p in ((1 + level) / 2, (1 - level) / 2))
        return e, low, high

    return limits


def automatic(points: Points, angle: Angle, signal: Signal) -> Law:
    """The law under the power law that is found at each averaging time; nothing is computed before it is asked."""

    @cache
    def found() -> Law:
        return law(points, [Model((unit_term(law.symbol, signal),)) for law in power_laws(points, angle)])

    def limits(level: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        return found()(level)

    return limits


def power_laws(points: Points, angle: Angle) -> tuple[PowerLaw, ...]:
    """The power law of the noise at each point."""
    row = points.row.parts[0] if points.row.parts else points.row
    return identify_power_law(angle, row, times(points.row, points.m, points.size, points.join))


def unit_term(symbol: str, signal: Signal) -> Term:
    """A term with the coefficient 1, SI: of a single term no more is needed."""
    assert symbol in TERMS  # noqa: S101 - the identification knows no other
    return Term(symbol, 1.0, signal)


def degrees_of(points: Points, model: Model) -> FloatArray:
    """EDF at averaging factors of any row, hybrids included."""
    row, m, runs, size, rate, join = points
    if not row.parts:
        return edf(row, model, m, runs, rate)
    which, result = part_of(row, m, size, join), np.empty(m.size)
    for i, part in enumerate(row.parts):
        here = which == i
        result[here] = edf(part, model, m[here], runs, rate)
        if i == len(row.parts) - 1:
            share = m[here] / size
            result[here] *= np.select([share < edge for edge, _ in RANDOM_RATIO], [f for _, f in RANDOM_RATIO])
    return np.maximum(result, 1.0)
