"""A fit as one step of scoring knows it: by what the neighbours of a state are judged before they are fitted.

The gain of a direction c of the expected power, from the score b = sum nu/2 c (I/m - 1) / m and its information G with
all sizes and shapes projected out, is b^2 / G in 2 L. It costs one product of matrices for all candidates at a time;
those that could not come within `REACH` of the best state are not fitted. Far from a fit one step is no guide, and the
candidates themselves are fitted.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from allanite.core.arrays import FloatArray

from .components import Part
from .fitting import Fitted, column_of_part
from .state import State

REACH = 8.0  # states up to this above the least score are kept: a weight of e^-4
FAR = 60.0  # gain in 2 L above which one step is no guide
CANDIDATES = 3  # candidates of a row that are fitted, at most
MISFIT_DEVIATE = 6.0  # standard deviations of a bin's power above which a residual is a misfit


@dataclass(frozen=True, eq=False)
class Local:
    """A fit as one step of scoring knows it."""

    f: Fitted

    @cached_property
    def over(self) -> FloatArray:
        """Residuals; those beyond chance count by their logarithm: far from a fit their squares would decide."""
        r = self.f.residual
        return np.where(np.abs(r) * np.sqrt(self.h) > MISFIT_DEVIATE, self.logs, r)

    @cached_property
    def logs(self) -> FloatArray:
        """Logarithms of the power over the expected one."""
        return np.asarray(np.log1p(np.maximum(self.f.residual, -1 + 1e-9)))

    @cached_property
    def h(self) -> FloatArray:
        """Half the counts."""
        return self.f.trusted.count / 2

    @cached_property
    def _own(self) -> tuple[FloatArray, FloatArray]:
        """Directions of the sizes and shapes, relative to m, and the root of their inverse information."""
        f = self.f
        H, active = f.information
        Z = np.column_stack((f.likelihood.S[:, active], f.slopes.T)) / f.m[:, None]
        size = np.sqrt(np.maximum(np.diag(H), 1e-300))
        values, vectors = np.linalg.eigh(H / np.outer(size, size))
        root = vectors / np.sqrt(np.maximum(values, 1e-9)) / size[:, None]
        return Z, root

    def projected(self, C: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Scores and informations of directions, relative to m, shape (k, bins): b (k,), G (k, k) by its rows."""
        Z, root = self._own
        rest = (C * self.h) @ Z @ root
        return C @ (self.h * self.over), rest

    def gains(self, C: FloatArray, *, signed: bool = False) -> FloatArray:
        """Gains of directions, shape (k,)."""
        b, rest = self.projected(C)
        G = np.maximum((C * C) @ self.h - (rest * rest).sum(axis=1), 1e-9 * ((C * C) @ self.h) + 1e-300)
        gain = b * b / G
        return gain if signed else np.where(b > 0, gain, 0.0)

    def loss(self, part: Part) -> float:
        """What the value would rise by without a part whose size is a column, by one step; 0 for others."""
        f = self.f
        which = column_of_part(f.state, f.frame, part)
        if which is None or f.theta[which] <= 0:
            return 0.0
        at = int(np.count_nonzero(f.theta[:which] > 0))
        variance = f.covariance[at, at]
        return float(f.theta[which] ** 2 / max(variance, 1e-300))

    def able(self, gain: float, cost: float) -> bool:
        """Whether a candidate may come within reach of the best state."""
        return gain > cost - REACH


Move = Callable[[Local], Iterator[State | Fitted]]
"""From a fit to the states beside it that are worth fitting, or to their fits where these are known already."""
