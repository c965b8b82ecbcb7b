"""What a statistic makes of each power law of noise: its bias and its degrees of freedom, without simulation."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.errors import UsageError
from allanite.core.model import Model
from allanite.core.plain import Value
from allanite.core.units import SIGNALS
from allanite.statistics.confidence.limits import mixtures, unit_term
from allanite.statistics.grids import checked, factors_of, times
from allanite.statistics.moments.expect import expected_at
from allanite.statistics.table import CurvePoints, statistic_named
from allanite.terms import TERMS

SIZE = 7200
"""Samples of the record where no length is given: two hours at 1 Hz."""

JOIN, DIVISOR = 0.2, 30
"""As `deviation` joins hybrids."""


@dataclass(frozen=True, eq=False, repr=False)
class Properties(Value):
    """Expectation and scatter of a statistic for single noise terms.

    Examples
    --------
    >>> found = properties("theo1", m=[100, 1000])
    >>> [f"{x:.3f}" for x in found.ratio[:, found.symbols.index("B")]]
    ['1.837', '1.857']
    """

    statistic: str
    size: int  # samples of the record
    m: IntArray  # shape (k,); averaging factors
    tau: FloatArray  # shape (k,); averaging times in sampling intervals
    symbols: tuple[str, ...]  # terms: the power laws that the statistic does not remove
    # shape (k, s); expected Allan variance over the expected variance of the statistic at the same tau; for a
    # statistic of third differences, expected Hadamard variance
    ratio: FloatArray
    edf: FloatArray  # shape (k, s); equivalent degrees of freedom, 2 E^2 / Var

    def rows(self) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows: one of each averaging factor."""
        headings = ["m", "tau", *(f"ratio {s}" for s in self.symbols), *(f"edf {s}" for s in self.symbols)]
        together = zip(self.m.tolist(), self.tau.tolist(), self.ratio.tolist(), self.edf.tolist(), strict=True)
        return headings, [[m, tau, *ratio, *edf] for m, tau, ratio, edf in together]

    def _summary(self) -> str:
        return f"{self.statistic} of {self.size} samples at {self.m.size} averaging factors"


def properties(
    statistic: str, size: int = SIZE, *, taus: str | Sequence[float] | None = None, m: Sequence[int] | None = None
) -> Properties:
    """Bias against the Allan (or Hadamard) variance, and degrees of freedom, of a statistic."""
    row = statistic_named(statistic)
    if row.extreme or row.power:
        raise UsageError(f"{row.name} is not an estimate of the Allan or Hadamard variance; explain another statistic")
    # the points asked for, or octaves
    if m is not None and taus is None:
        factors = checked(m, row, size, JOIN)
    else:
        factors = checked(factors_of("octave" if taus is None else taus, row, size, 1.0, JOIN), row, size, JOIN)
    points = CurvePoints(row, factors, [(size, 1)], size, 1.0, JOIN)
    symbols = tuple(symbol for symbol, term in TERMS.items() if term.alpha is not None)
    models = [Model((unit_term(symbol, SIGNALS[0]),)) for symbol in symbols]
    tau = times(row, points.m, size, JOIN)
    ratio = []
    for model in models:
        # Allan or Hadamard variance of one term at any averaging times, by differences of the angle's structure
        # function: -sum_k (-1)^k C(2d, d + k) D(k tau) / (d! tau^2) for k = 1 .. d, the order of the differences
        (term,) = model
        D, d = term.sampled(1.0).structure, row.order
        total = -sum((-1) ** k * math.comb(2 * d, d + k) * D(k * tau) for k in range(1, d + 1))
        target = term.power(1.0) * total / (math.factorial(d) * tau**2)
        ratio.append(target / expected_at(row, model, factors, size, 1.0, join=JOIN, divisor=DIVISOR))
    degrees = [mixtures(points, [model])[0] for model in models]
    return Properties(row.name, size, points.m, tau, symbols, np.stack(ratio, axis=1), np.stack(degrees, axis=1))
