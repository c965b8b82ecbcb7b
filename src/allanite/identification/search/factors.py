"""The splines of what no component describes: a factor exp(u) on the power of the terms, u = B v, v ~ N(0, C)."""

# Derivation: docs/derivations.md.

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from allanite.core.arrays import FloatArray

KNOT = 1.0  # distance of the knots, octaves
TOP_KNOTS = (1.0, 0.5, 0.25, 0.1, 0.0)  # knots below half the sampling rate, octaves: there gains have zeros
LENGTH = math.log(2)  # length over which a factor is correlated, in the logarithm of frequency: an octave, a knot
JUMPS = 4.0  # length of the exponential correlation of `step above`, octaves of coefficients: an order that jumps
ADDED_VARIANCE = 1e-12  # what is added to a covariance so that it has a root

SLOWEST_OCTAVE = 6
"""Octave of the coefficient index below which no factor begins: what is slow has noise terms and a time constant."""

KINDS = ("all", "above", "step above", "between")

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
        from scipy.interpolate import BSpline

        x = np.clip(np.log2(self.centre), 0, self.top - 1e-9)
        return np.asarray(BSpline.design_matrix(x, self.knots, 3).toarray())

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
