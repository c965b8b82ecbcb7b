"""The best shapes near those of a fit by Fisher scoring, and what one step of it says of a state's neighbours."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray

from .components import Part

from .fitting import (  # isort: skip
    Fitted, admissible, bounds_of, column_of_part, factor_basis, fitted, place_of, valued, values_of, with_values
)  # fmt: skip
from .state import State

REACH = 8.0  # states up to this above the least score are kept: a weight of e^-4
FAR = 60.0  # gain in 2 L above which one step is no guide
MISSED = 40.0
"""Rise of the value by one step, beyond the cost, above which a part or power is not left out, or its numerator
exchanged: what is refined beside it makes up for less."""

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
        H, _ = f.information
        Z = (f.directions[:, : f.m.size] / f.m).T
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
        which = column_of_part(self.f.state, self.f.frame, part)
        return 0.0 if which is None else self.f.loss(which)

    def able(self, gain: float, cost: float) -> bool:
        """Whether a candidate may come within reach of the best state."""
        return gain > cost - REACH


Move = Callable[[Local], Iterator[State | Fitted]]
"""From a fit to the states beside it that are worth fitting, or to their fits where these are known already."""


FARTHEST = 0.5  # step in the logarithm of a shape, at most: a factor of 1.6

HALVINGS, ROUNDS, SETTLED = 4, 8, 0.03
"""Times that a step is cut to a third; rounds of scoring, at most; gain in 2 L that ends them."""

AT_END = 1e-6  # distance from the end of its range, in the logarithm, within which a shape that tends outwards stays
DAMPING = 1e-3  # share of its information that is added to a shape's, at first


def refined(f: Fitted, rounds: int = ROUNDS, *, held: BoolArray | None = None, settled: float = SETTLED) -> Fitted:
    """The best shapes near those of a fit: Fisher scoring of sizes and shapes together, with step halving."""
    # `held` shapes stay as they are, shape (values,).
    x = values_of(f.state)
    moving = np.ones(x.size + f.v.size, dtype=bool)
    if held is not None:
        moving[: x.size] &= ~held
    low, high = bounds_of(f.frame, f.state)
    moving[: x.size] &= low < high
    if not moving.any() or not math.isfinite(f.value):  # what leaves nothing where the record has power has no slope
        return f
    damping = DAMPING
    for _ in range(rounds):
        dx, dv = _step(f, moving, damping)
        stuck = ((x < low + AT_END) & (dx < 0)) | ((x > high - AT_END) & (dx > 0))
        if stuck.any():  # the others as if these stayed, which they do
            dx, dv = _step(f, np.concatenate((moving[: x.size] & ~stuck, moving[x.size :])), damping)
        better = None
        for _ in range(HALVINGS):
            state = with_values(f.state, np.clip(x + dx, low, high))
            tried = fitted(f.frame, state, f.free, f, f.v + dv)
            if tried.value < f.value:
                better = tried
                break
            dx, dv, damping = dx / 3, dv / 3, min(damping * 4, 1.0)
        if better is None:
            break
        gain, f, x = f.value - better.value, better, values_of(better.state)
        damping = max(damping / 4, 1e-6)
        if gain < settled:
            break
    return f


def _step(f: Fitted, moving: BoolArray, damping: float) -> tuple[FloatArray, FloatArray]:
    """Step of Fisher scoring of the shapes and v, the active sizes following."""
    H, active = f.information
    a, k = int(active.sum()), f.v.size
    power, m, h = f.completed
    g = f.directions @ (h * (power / m - 1) / m)
    if k:
        g[-k:] -= f.v
    through = f.state.filter
    if through is not None:
        g[a + place_of(f.state, through)] -= f.frame.told(through.label, through.shape[0])[1] / 2
    if not moving.all():
        some = np.concatenate((np.ones(a, dtype=bool), moving))
        H, g = H[some][:, some], g[some]
    size = np.sqrt(np.maximum(H.diagonal(), 1e-300))
    damped = H / (size[:, None] * size)
    damped.flat[:: size.size + 1] += damping
    move = np.linalg.solve(damped, g / size) / size
    full = np.zeros(moving.size)
    full[moving] = move[a:]
    x = moving.size - k
    largest = max(float(np.abs(full[:x]).max(initial=0.0)) / FARTHEST, 1e-12)
    if k:
        largest = max(largest, float(np.abs(factor_basis(f.frame, f.state) @ full[x:]).max()) / 2.0)
    full = full / max(largest, 1.0)
    return full[:x], full[x:]


def resized(f: Fitted, free: BoolArray) -> Fitted:
    """The same state and shapes with other terms free."""
    may = admissible(f.frame, f.state, free, f.theta.size)
    start = np.where(may, np.maximum(f.theta, 0.0), 0.0)
    first = start if (start > 0).any() else None
    if f.trust is not None:
        first, _ = f.trusted.minimise(may, first)
    again = valued(f.frame, f.state, may, first, f.v, f.likelihood, known=True)
    return refined(again, 3) if f.v.size else again


def pruned(f: Fitted) -> Fitted:
    """The subset of the powers with the least score: one after the other is left out."""
    P = len(f.frame.powers)
    best = _dropping(f)
    while best.free[:P].sum() > 1:
        tries = []
        for i in np.flatnonzero(best.free[:P]).tolist():
            if best.loss(i) > MISSED:
                continue
            less = best.free.copy()
            less[i] = False
            if (admissible(f.frame, f.state, less, less.size) == less).all():
                tries.append(resized(best, less))
        least = min(tries, key=lambda t: t.score, default=best)
        if best.score <= least.score < best.score + REACH:  # shapes that made room for it move back
            least = refined(least)
        if least.score >= best.score:
            break
        best = _dropping(least)
    return best


def _dropping(f: Fitted) -> Fitted:
    """The same without the terms whose size is zero, which costs nothing."""
    P = len(f.frame.powers)
    free = f.free.copy()
    free[:P] &= f.theta[:P] > 0
    free = admissible(f.frame, f.state, free, free.size)
    return f if (free == f.free).all() else replace(f, free=free)
