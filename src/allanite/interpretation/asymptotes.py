"""Which term dominates at which averaging time, by the straight lines of the Allan deviation in logarithms."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.estimate import Estimate
from allanite.core.model import Term
from allanite.statistics.moments.expect import expected
from allanite.terms import TERMS

DENSE = 1000
"""Points of a decade at which humps are held against lines."""


@dataclass(frozen=True)
class Span:
    """Averaging times, s, at which a term has more part in the Allan deviation than any other."""

    symbol: str
    start: float
    end: float


def straight(estimate: Estimate) -> bool:
    """Whether the asymptote of a term that was found is a straight line: not that of a hump."""
    row = TERMS[estimate.symbol]
    return estimate.claimed and bool(estimate.value) and not row.parameters


def lasting(estimate: Estimate) -> bool:
    """Whether a term has a curve of its own, whatever the record and its rate."""
    row = TERMS[estimate.symbol]
    return row.scatters and not row.per_sample


def height(estimate: Estimate, tau: float) -> float:
    """The asymptote of a term in the Allan deviation at an averaging time, SI."""
    row = TERMS[estimate.symbol]
    return float(abs(estimate.value or 0.0) * math.sqrt(row.level) * tau**row.slope)


def crossing(one: Estimate, other: Estimate) -> float:
    """Averaging time, s, at which the asymptotes of two terms of different slope are equal.

    Examples
    --------
    >>> from allanite import Estimate
    >>> from allanite.core.units import SIGNALS
    >>> N, K = (Estimate(s, SIGNALS[0], v, 0.0, "identified", None, "whittle") for s, v in (("N", 2.0), ("K", 0.1)))
    >>> round(crossing(N, K), 3)  # sqrt(3) N / K
    34.641
    """
    slope = TERMS[other.symbol].slope - TERMS[one.symbol].slope
    return float((height(one, 1.0) / height(other, 1.0)) ** (1 / slope))


def spans(estimates: Sequence[Estimate], start: float, end: float) -> tuple[Span, ...]:
    """Where each of the terms that were found dominates, from `start` to `end`, s.

    Straight asymptotes are as they are; of a term with a hump the Allan deviation itself is taken.
    """
    found = [e for e in estimates if e.claimed and e.value and lasting(e)]
    if not found or not start < end:
        return ()
    tau = np.geomspace(start, end, 2 + math.ceil(DENSE * math.log10(end / start)))
    top = np.argmax([_line(e, tau) for e in found], axis=0)
    edges = np.flatnonzero(np.diff(top)) + 1
    bounds = [start]
    for i in edges:  # where one term takes over from another, between two points of the grid
        one, other = found[top[i - 1]], found[top[i]]
        exact = straight(one) and straight(other)
        bounds.append(crossing(one, other) if exact else float(math.sqrt(tau[i - 1] * tau[i])))
    bounds.append(end)
    firsts = [0, *edges.tolist()]
    return tuple(Span(found[top[i]].symbol, *pair) for i, pair in zip(firsts, pairwise(bounds), strict=True))


def least(estimates: Sequence[Estimate], start: float, end: float) -> tuple[float, float] | None:
    """Averaging time and Allan deviation, SI, at the minimum of all terms together; None at an end of the range."""
    found = [e for e in estimates if e.claimed and e.value and lasting(e)]
    tau = np.geomspace(start, end, 2 + math.ceil(DENSE * math.log10(end / start)))
    variance = np.sum([_line(e, tau) ** 2 for e in found], axis=0) if found else np.zeros(tau.size)
    at = int(np.argmin(variance))
    return (float(tau[at]), math.sqrt(variance[at])) if 0 < at < tau.size - 1 else None


def _line(estimate: Estimate, tau: FloatArray) -> FloatArray:
    row = TERMS[estimate.symbol]
    if straight(estimate):
        return np.asarray(height(estimate, 1.0) * tau**row.slope)
    term = Term(estimate.symbol, abs(estimate.value or 0.0), estimate.signal, estimate.shape)
    return np.sqrt(expected(term, "adev", tau))
