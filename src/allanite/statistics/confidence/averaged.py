"""The confidence law of a curve whose noise is not known for certain: an average over models.

Given a model, the truth T behind a variance V lies at T / V = F / X, with X of the model's law of V / E[V], and F the
bias that it removes over the bias that was removed. With the models' weights, flattened, for probabilities X has the
weighted mean of the laws, whose limits hold whichever of the models it is, and F a distribution of its own.

F and 1 / X do not scatter apart: slow noise that is large in a record by chance makes V large, and the models that are
likely as well, whose bias is larger. From their medians on the logarithms of their quantiles are added as deviations
that correlate by `TOGETHER`.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from allanite.core.averaged import Averaged
from allanite.core.plain import Portable
from allanite.statistics.row import FloatArray
from allanite.statistics.table import CurvePoints

from .chisquares import table
from .limits import at_point, stacked

REACH, STEPS = 4.2, 22
"""Normal deviates between which the laws are tabulated, and how many."""

BISECTIONS = 30
"""Steps to a quantile."""

FLATTENED = 0.3
"""Power of the models' weights: those are known from the few coefficients of which V is made, and models under which V
is low by chance have little. As limits of random walk beside quantization need to contain the true value.
"""

TOGETHER = 0.5
"""Correlation of bias and scatter: as Theo1's limits at 0.1 to 0.5 of a record need to contain the true value."""


@dataclass(frozen=True, eq=False)
class AveragedLaw(Portable):
    """The average law of several models."""

    points: CurvePoints
    noise: Averaged
    # shape (models, points); factor of each model over the one that the variance was multiplied with
    bias: FloatArray

    @cached_property
    def weight(self) -> FloatArray:
        """Weights of the models, flattened, shape (models,)."""
        flat = self.noise.weight**FLATTENED
        return np.asarray(flat / flat.sum())

    @cached_property
    def found(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Degrees of freedom, shape (points,); -ln X, rising, and its deviate, shape (deviates, models, points)."""
        k, p = self.noise.weight.size, self.points.m.size
        each = [at_point(self.points, i, self.noise.terms).laws(self.noise.scale) for i in range(p)]
        edf, laws = stacked([each[i][j] for j in range(k) for i in range(p)])
        x, deviate = (part.reshape(-1, k, p)[::-1] for part in table(laws, np.linspace(-REACH, REACH, STEPS)))
        return 1 / (self.weight @ (1 / edf.reshape(k, p))), -np.log(x), -deviate

    def __call__(self, level: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Degrees of freedom and limits over the variance; see `Curve`."""
        return self.found[0], *self.quantiles(np.array([(1 - level) / 2, (1 + level) / 2]))

    def quantiles(self, p: FloatArray) -> FloatArray:
        """T / V at probabilities, shape (probabilities, points)."""
        from scipy.special import ndtr

        p = np.append(p, 0.5)[:, None]
        # -ln X at probabilities, by bisection
        _, logs, deviates = self.found
        shape = (p.size, logs.shape[-1])
        low, high = (np.broadcast_to(x, shape) for x in (logs[0].min(axis=0), logs[-1].max(axis=0)))
        for _ in range(BISECTIONS):
            middle = (low + high) / 2
            below = self.weight @ ndtr(_between(logs, deviates, middle)) < p
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        scatter = np.asarray((low + high) / 2)
        if (self.bias == 1).all():
            return np.asarray(np.exp(scatter[:-1]))
        # logarithm of F at probabilities, between the models by their weights
        order = np.argsort(self.bias, axis=0)
        logs, weight = np.log(np.take_along_axis(self.bias, order, 0)), self.weight[order]
        below = np.cumsum(weight, axis=0) - weight / 2
        bias = np.array([np.interp(p[:, 0], at, values) for at, values in zip(below.T, logs.T, strict=True)]).T
        a, b = (part[:-1] - part[-1] for part in (scatter, bias))
        apart = np.sign(p[:-1] - 0.5) * np.sqrt(a * a + b * b + 2 * TOGETHER * a * b)
        return np.asarray(np.exp(scatter[-1] + bias[-1] + apart))


def _between(logs: FloatArray, deviates: FloatArray, x: FloatArray) -> FloatArray:
    """Deviate of each law at x, shape (probabilities, models, points); straight beyond the ends."""
    x = x[:, None]
    at = np.clip((logs[:, None] < x).sum(axis=0), 1, len(logs) - 1)
    (a, b), (low, high) = ([np.take_along_axis(y, k, 0) for k in (at - 1, at)] for y in (logs, deviates))
    return np.asarray(low + (x - a) / np.maximum(b - a, 1e-300) * (high - low))
