"""The error of an angle after a time without aid: of the best predictor, and of one with another noise model.

A filter that knew the angle up to now predicts the angle gained in the time that follows from the rates that it had.
The predictor is linear in these. Its error follows from the structure function D of the noise alone: increments of the
angle between times a, b and c, d have the covariance

    (D(|a - d|) + D(|b - c|) - D(|a - c|) - D(|b - d|)) / 2.

Flicker and random walks, whose rate has no variance, begin with the oldest step of the past: from each increment its
duration times the mean rate of that step is subtracted, which makes of the generalized covariance (Matheron 1973) one.
A predictor with such a term is exact for a constant rate; one of Gauss-Markov noise alone returns to zero.
"""

from dataclasses import dataclass
from functools import lru_cache, reduce
from operator import add

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.model import Model
from allanite.terms import TERMS

PAST = 40
"""Steps of the past, evenly spaced in the logarithm, whose mean rates a predictor is made of."""

FIRST, LAST = 0.25, 10.0
"""The first of them over the shortest time without aid, and their length in all over the longest."""


@dataclass(frozen=True, eq=False)
class Covariances:
    """Covariances of the angles gained: in steps of the past (n, n), in these and without aid (n, k), without (k,).

    Shapes are those of the last axes. `drifts` is whether a rate has no variance.
    """

    past: FloatArray
    cross: FloatArray
    ahead: FloatArray
    drifts: bool

    def __add__(self, other: "Covariances") -> "Covariances":
        drifts = self.drifts or other.drifts
        return Covariances(self.past + other.past, self.cross + other.cross, self.ahead + other.ahead, drifts)

    def __mul__(self, factor: FloatArray | float) -> "Covariances":
        past, cross, ahead = (np.multiply.outer(factor, part) for part in (self.past, self.cross, self.ahead))
        return Covariances(past, cross, ahead, self.drifts)

    def errors(self, weights: FloatArray) -> FloatArray:
        """Variance of the error of predictors with these weights, shape (n, k), by time without aid, shape (k,)."""
        return np.asarray(self.ahead + ((self.past @ weights - 2 * self.cross) * weights).sum(axis=-2))


@dataclass(frozen=True)
class Outages:
    """Times without aid, s."""

    times: tuple[float, ...]

    @property
    def edges(self) -> FloatArray:
        """How long ago the steps of the past began and ended, s."""
        return np.append(0.0, np.geomspace(FIRST * self.times[0], LAST * self.times[-1], PAST))

    def of(self, model: Model) -> Covariances:
        """The covariances under a model."""
        return reduce(add, (_covariances(self, t.symbol, t.shape) * t.value**2 for t in model))

    def weights(self, cov: Covariances) -> FloatArray:
        """The weights of the best predictor under these covariances, shape (n, k)."""
        length, scale = np.diff(self.edges), cov.past.trace(axis1=-2, axis2=-1)[..., None, None] / PAST
        if not cov.drifts:
            return np.asarray(np.linalg.solve(cov.past, cov.cross))
        system = np.zeros((*cov.past.shape[:-2], PAST + 1, PAST + 1))
        system[..., :PAST, :PAST] = cov.past / scale
        system[..., PAST, :PAST] = system[..., :PAST, PAST] = length / length.max()
        rates = np.broadcast_to(np.array(self.times) / length.max(), (*cov.past.shape[:-2], 1, len(self.times)))
        return np.asarray(np.linalg.solve(system, np.concatenate([cov.cross / scale, rates], axis=-2))[..., :PAST, :])


@lru_cache(maxsize=256)  # several axes, of both sensors, have the same times
def _covariances(outages: Outages, symbol: str, shape: tuple[float, ...]) -> Covariances:
    """Under a term of size 1, SI."""
    row, edges, times = TERMS[symbol], outages.edges, np.array(outages.times)
    points = np.concatenate([-edges, times])
    begin = np.append(np.arange(1, PAST + 1), np.zeros(len(times), dtype=np.int64))
    end = np.append(np.arange(PAST), PAST + 1 + np.arange(len(times)))
    structure = (row.shaped(shape, 1.0) if row.shaped else row).structure
    D = np.asarray(structure(np.abs(np.subtract.outer(points, points))))
    between, alike = D[np.ix_(begin, end)], D[np.ix_(begin, begin)] + D[np.ix_(end, end)]
    whole = (between + between.T - alike) / 2
    drifts = row.alpha is not None and row.alpha < 0
    if drifts:
        share = (points[end] - points[begin]) / (edges[-1] - edges[-2])
        oldest = np.outer(share, whole[PAST - 1])
        whole += np.outer(share, share) * whole[PAST - 1, PAST - 1] - oldest - oldest.T
    return Covariances(whole[:PAST, :PAST], whole[:PAST, PAST:], np.diag(whole)[PAST:], drifts)
