"""The error of an angle after a time without aid: of the best predictor, and of one with another noise model.

A filter that knew the angle up to now predicts the angle gained in the time that follows from the rates that it had.
The predictor is linear in these, and exact for a constant rate, whatever it is. Its error follows from the structure
function D of the noise alone: that of increments of the angle between times a, b and c, d has the covariance

    (D(|a - d|) + D(|b - c|) - D(|a - c|) - D(|b - d|)) / 2,

also where D is a generalized one, of flicker or of a random walk, whose rate has no variance (Matheron 1973).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from allanite.core.model import Model
from allanite.statistics.row import FloatArray

PAST = 40
"""Steps of the past, evenly spaced in the logarithm, whose mean rates a predictor is made of."""

FIRST, LAST = 0.25, 10.0
"""The first of them over the shortest time without aid, and their length in all over the longest."""


@dataclass(frozen=True, eq=False)
class Covariances:
    """Covariances of the angles gained: in steps of the past (n, n), in these and without aid (n, k), without (k,)."""

    past: FloatArray
    cross: FloatArray
    ahead: FloatArray

    def __add__(self, other: "Covariances") -> "Covariances":
        return Covariances(self.past + other.past, self.cross + other.cross, self.ahead + other.ahead)

    def __mul__(self, factor: float) -> "Covariances":
        return Covariances(self.past * factor, self.cross * factor, self.ahead * factor)

    def errors(self, weights: FloatArray) -> FloatArray:
        """Variance of the error of predictors with these weights, shape (n, k), by time without aid, shape (k,)."""
        within = np.einsum("ik,ij,jk->k", weights, self.past, weights)
        return np.asarray(self.ahead - 2 * (weights * self.cross).sum(0) + within)


@dataclass(frozen=True, eq=False)
class Outages:
    """Times without aid, s, shape (k,)."""

    times: FloatArray

    @cached_property
    def edges(self) -> FloatArray:
        """How long ago the steps of the past began and ended, s."""
        return np.append(0.0, np.geomspace(FIRST * self.times[0], LAST * self.times[-1], PAST))

    def covariances(self, structure: Callable[[FloatArray], FloatArray]) -> Covariances:
        """The covariances under a structure function."""
        begin = np.concatenate([-self.edges[1:], np.zeros(len(self.times))])
        end = np.concatenate([-self.edges[:-1], self.times])
        between = structure(np.abs(begin[:, None] - end[None, :]))
        alike = structure(np.abs(begin[:, None] - begin[None, :])) + structure(np.abs(end[:, None] - end[None, :]))
        whole = (between + between.T - alike) / 2
        return Covariances(whole[:PAST, :PAST], whole[:PAST, PAST:], np.diag(whole)[PAST:])

    def of(self, model: Model) -> Covariances:
        """The covariances under a model."""
        return self.covariances(model.structure)

    def weights(self, cov: Covariances) -> FloatArray:
        """The weights of the best predictor under these covariances, exact for a constant rate, shape (n, k)."""
        length, scale = np.diff(self.edges), np.trace(cov.past) / PAST
        system = np.zeros((PAST + 1, PAST + 1))
        system[:PAST, :PAST] = cov.past / scale
        system[PAST, :PAST] = system[:PAST, PAST] = length / length.max()
        return np.linalg.solve(system, np.vstack([cov.cross / scale, self.times / length.max()]))[:PAST]
