"""The search for a shape of several parameters: frequency and damping of an oscillation."""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray
from allanite.terms import TERMS

from .selection import Subset
from .timeconstant import NEAR, OPEN, Search, Shape

STEP = 0.03
"""Step in the logarithms for the curvature of the likelihood, at first."""

STARTS = 3
"""Shapes of the grid from which the best is sought."""


@dataclass(frozen=True, eq=False)
class Shapes(Search):
    """The likelihood as a function of all parameters of a term's shape."""

    @cached_property
    def shapes(self) -> list[Shape]:
        """Shapes of the first search."""
        parameters = TERMS[self.symbol].parameters
        axes = [
            np.geomspace(low, high, max(2, round(p.steps * math.log10(high / low)))).tolist()
            for p, (low, high) in zip(parameters, self.spans, strict=True)
        ]
        return list(product(*axes))

    @cached_property
    def coarse(self) -> Subset:
        """The best of the grid, and near the best of it."""
        tried = sorted((self.least(shape) for shape in self.shapes), key=lambda subset: subset.value)
        fine = (self.refined(subset.constants) for subset in tried[:STARTS])
        return min(fine, key=lambda subset: subset.value)

    def refined(self, near: Shape, free: BoolArray | None = None) -> Subset:
        """The best near a shape."""
        from scipy.optimize import minimize

        low, high = np.log(np.array(self.spans)).T
        x = np.log(np.array(near))
        corners = np.vstack((x, x + 0.1 * np.eye(x.size)))
        best = minimize(
            lambda x: self.least(tuple(np.exp(np.clip(x, low, high)).tolist()), free).value, x, method="Nelder-Mead",
            options={"initial_simplex": corners, "xatol": 0.003, "fatol": 0.003},
        )  # fmt: skip
        return self.least(tuple(np.exp(np.clip(best.x, low, high)).tolist()), free)

    def limits(self, best: Subset, drop: float) -> tuple[tuple[float, float], ...]:
        """For each parameter the values at which 2 L has risen by `drop`, from its curvature."""
        half = np.sqrt(drop * np.diag(self._covariance(best)))
        ends = zip(best.constants, half.tolist(), self.spans, strict=True)
        return tuple(
            (max(v * math.exp(-h), min(low, v)), min(v * math.exp(h), max(high, v))) for v, h, (low, high) in ends
        )

    def around(self, best: Subset) -> list[Subset]:
        """Subsets with the term at shapes that the likelihood leaves open; those of the best one come last."""
        size, directions = np.linalg.eigh(self._covariance(best))
        (low, high), x = np.log(np.array(self.spans)).T, np.log(np.array(best.constants))
        reach = directions * np.sqrt(OPEN * np.maximum(size, 0))
        far = [x + s * k / NEAR * d for d in reach.T for k in range(1, NEAR + 1) for s in (-1, 1)]
        inside = [tuple(np.exp(np.clip(one, low, high)).tolist()) for one in far]
        area = np.prod(np.minimum(2 * np.abs(reach).max(axis=1) / (high - low), 1.0))
        return self.beside([*inside, best.constants], float(area))

    def pair(self) -> Subset:
        """Two such terms are not looked for: the best with one."""
        return self.coarse

    def _covariance(self, best: Subset) -> FloatArray:
        """Covariance of the logarithms of the parameters: inverse curvature of L at its minimum over the terms."""
        x = np.log(np.array(best.constants))
        steps = np.full(x.size, STEP)

        def excess(move: FloatArray) -> float:
            shape = tuple(np.exp(x + move).tolist())
            return 2 * (self.least(shape, best.free, best.theta).value - best.value)

        for i in range(x.size):  # steps after which 2 L has risen by about 1
            rise = (excess(steps * np.eye(x.size)[i]) + excess(-steps * np.eye(x.size)[i])) / 2
            steps[i] = float(np.clip(STEP / math.sqrt(max(rise, 1e-4)), 1e-4, 0.7))
        H = np.empty((x.size, x.size))
        for i, j in np.ndindex(H.shape):
            a, b = steps[i] * np.eye(x.size)[i], steps[j] * np.eye(x.size)[j]
            both = excess(a + b) - excess(a - b) - excess(b - a) + excess(-a - b)
            H[i, j] = both / (8 * steps[i] * steps[j])  # of L, twice of which is the information
        values, vectors = np.linalg.eigh(H)
        return np.asarray(vectors / np.maximum(values, 1e-3) @ vectors.T)
