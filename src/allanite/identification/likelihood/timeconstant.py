"""The search for the shape of one or two terms: the time constant of Gauss-Markov noise, of the rate or the angle.

Its likelihood is linear in the square of the RMS value but not in the time constant T. L is profiled over T on a grid
and then refined; the intervals include the values of T consistent with the record.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.plain import Portable
from allanite.terms import TERMS, Parameter

from .band import Portion
from .likelihood import Likelihood
from .selection import Subset, select, subsets

PER_DECADE = 4
"""Time constants a decade in the first search."""

OPEN = 6.6
"""Time constants that lose less than this in 2 L take part in the limits of the terms (the 99 % point)."""

STARTS = 3
"""Pairs of time constants, or shapes of a grid, from which the best is sought."""

STEP = 0.03
"""Step in the logarithms of several parameters for the curvature of the likelihood, at first."""

NEAR = 3
"""Time constants on either side of the best that take part; of three parameters one less."""

BEYOND = 3.0
"""How far below the least time constant that is looked for its limits may lie."""

Shape = tuple[float, ...]
"""Values of the parameters, in sample intervals."""


@dataclass(frozen=True, eq=False)
class Search(Portable):
    """The likelihood as a function of the shape of a term with one parameter, the last column of it, in samples.

    `may` says which terms may stand beside it, shape (p,), `shortest` is the least time constant, if it is not what the
    term says; `asked` whether it was requested.
    """

    likelihood: Likelihood
    part: Portion
    may: BoolArray
    shortest: float = 0.0
    asked: bool = False

    @property
    def symbols(self) -> tuple[str, ...]:
        """The term, or the terms, whose shape is looked for."""
        return self.part.shapely

    def at(self, shape: Shape) -> Likelihood:
        """The likelihood with a shape."""
        return self.likelihood.with_last(self.part.columns(shape))

    def least(self, shape: Shape, free: BoolArray | None = None, start: FloatArray | None = None) -> Subset:
        """The minimum at a shape, all terms free that may be, sought from `start`."""
        likelihood, free = self.at(shape), self.may if free is None else free
        return Subset(likelihood, free, *likelihood.minimise(free, start), shape)

    @property
    def spans(self) -> list[tuple[float, float]]:
        """The least and the greatest value of each parameter."""
        return [search(self.part.seen.size) for p in self.parameters if (search := p.search) is not None]

    @property
    def parameters(self) -> list[Parameter]:
        """The parameters of all terms with a shape."""
        return [p for symbol in self.symbols for p in TERMS[symbol].parameters]

    @property
    def span(self) -> tuple[float, float]:
        """The least and the greatest time constant."""
        least, greatest = self.spans[0]
        return self.shortest or least, max(greatest, 2 * self.shortest)

    @cached_property
    def grid(self) -> FloatArray:
        """Time constants of the first search."""
        low, high = self.span
        return np.geomspace(low, high, max(2, round(PER_DECADE * math.log10(high / low))))

    @cached_property
    def coarse(self) -> Subset:
        """The best of the grid."""
        return min((self.least((float(T),)) for T in self.grid), key=lambda subset: subset.value)

    def refined(self, near: Shape, free: BoolArray | None = None) -> Subset:
        """The best near a shape of the grid."""
        from scipy.optimize import minimize_scalar

        (around,), step, (low, high) = near, 10 ** (1 / PER_DECADE), self.span
        best = minimize_scalar(
            lambda x: self.least((math.exp(x),), free).value, method="bounded", options={"xatol": 0.01},
            bounds=(math.log(max(low, around / step)), math.log(min(high, around * step))),
        )  # fmt: skip
        return self.least((math.exp(float(best.x)),), free)

    def best(self, penalty: FloatArray) -> Subset | None:
        """The best subset with the term; None if it is not in it."""
        fine = self.refined(self.coarse.constants)
        first = select(subsets(fine.likelihood, must=self.must, may=self.may, constants=fine.constants), penalty)
        found = self.refined(fine.constants, first.free)
        return found if found.theta[self.must].all() else None

    @cached_property
    def must(self) -> BoolArray:
        """The terms with a shape alone."""
        return np.asarray(np.arange(self.may.size) >= self.may.size - len(self.symbols))

    def limits(self, best: Subset, drop: float) -> tuple[tuple[float, float], ...]:
        """For each parameter the values at which 2 L has risen by `drop`, the terms following."""
        from scipy.optimize import brentq

        (T,) = best.constants
        ends = []
        (least, _), longest = self.spans[0], float(self.part.seen.size)
        for end in (min(least / BEYOND, T / 2), max(longest, 2 * T)):

            def excess(x: float) -> float:
                return 2 * (self.least((math.exp(x),), best.free, best.theta).value - best.value) - drop

            open_ = excess(math.log(end)) <= 0
            ends.append(end if open_ else math.exp(brentq(excess, math.log(T), math.log(end), xtol=1e-3)))
        return ((ends[0], ends[1]),)

    def around(self, best: Subset) -> list[Subset]:
        """Subsets with the term at the time constants that the likelihood leaves open; the best one's come last.

        Any other term may be beside it: what was not selected is not zero.
        """
        (T,), ((low, high),) = best.constants, self.limits(best, OPEN)
        # a shorter or longer one is that of another term
        shortest, longest = self.span
        low, high = max(low, min(shortest, T)), min(high, max(longest, T))
        open_ = (*np.geomspace(low, T, NEAR + 1)[:-1], *np.geomspace(high, T, NEAR + 1))
        # evenly likely beforehand in the logarithm
        return self.beside([(float(k),) for k in open_], min(math.log(high / low) / math.log(longest / shortest), 1.0))

    def beside(self, shapes: list[Shape], prior: float) -> list[Subset]:
        """All subsets that hold the term, at each of the shapes."""
        every = (s for k in shapes for s in subsets(self.at(k), must=self.must, constants=k))
        return [replace(s, prior=prior) for s in every]

    def pair(self) -> Subset:
        """The best with two such terms and no flicker."""
        from scipy.optimize import minimize

        free = np.append(self.may, True)

        def least(x: FloatArray) -> Subset:
            first, second = np.exp(x)
            both = self.at((float(first),)).with_more(self.part.columns((float(second),))[:, 0])
            return Subset(both, free, *both.minimise(free), (float(first), float(second)))

        grid = np.log(self.grid)
        pairs = [np.array([a, b]) for i, a in enumerate(grid) for b in grid[i + 1 :]]
        corners = np.array([[0.0, 0.0], [0.3, 0.0], [0.0, 0.3]])
        tries = []
        for start in sorted(pairs, key=lambda x: least(x).value)[:STARTS]:
            options = {"initial_simplex": start + corners, "xatol": 0.02, "fatol": 0.01}
            tries.append(minimize(lambda x: least(x).value, start, method="Nelder-Mead", options=options))
        return least(min(tries, key=lambda found: float(found.fun)).x)


@dataclass(frozen=True, eq=False)
class Shapes(Search):
    """The likelihood as a function of all parameters of the shapes of one or two terms.

    Of two terms of the same kind the second has the longer time constant.
    """

    def least(self, shape: Shape, free: BoolArray | None = None, start: FloatArray | None = None) -> Subset:
        """The minimum at a shape; see `Search.least`."""
        return super().least(tuple(sorted(shape)) if self.alike else shape, free, start)

    @property
    def alike(self) -> bool:
        """Whether there are two terms that differ in their time constants only."""
        return len(self.symbols) > 1 and TERMS[self.symbols[0]].second == self.symbols[1]

    @cached_property
    def shapes(self) -> list[Shape]:
        """Shapes of the first search."""
        axes = [
            np.geomspace(low, high, max(2, round(p.steps * math.log10(high / low)))).tolist()
            for p, (low, high) in zip(self.parameters, self.spans, strict=True)
        ]
        return [shape for shape in product(*axes) if not self.alike or shape[0] < shape[1]]

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
        most = NEAR if x.size < NEAR else NEAR - 1
        steps = [k for k in product(range(-most, most + 1), repeat=x.size) if 0 < np.dot(k, k) <= most**2]
        inside = [tuple(np.exp(np.clip(x + reach @ k / most, low, high)).tolist()) for k in map(np.array, steps)]
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
