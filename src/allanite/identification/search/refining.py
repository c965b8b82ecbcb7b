"""The best shapes near those of a fit, and the terms that a state needs: Fisher scoring, one subset after the other."""

from dataclasses import replace

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray

from .fitting import Fitted, admissible, bounds_of, factor_basis, fitted, place_of, valued, values_of, with_values

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
    if not moving.any():
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
    Z = np.column_stack((f.likelihood.columns[active].T, f._wide(f.slopes)))
    g = (Z / m[:, None]).T @ (h * (power / m - 1))
    if k:
        g[-k:] -= f.v
    through = f.state.filter
    if through is not None:
        g[a + place_of(f.state, through)] -= f.frame.told(through.label, through.shape[0])[1] / 2
    some = np.concatenate((np.ones(a, dtype=bool), moving))
    H, g = H[np.ix_(some, some)], g[some]
    size = np.sqrt(np.maximum(np.diag(H), 1e-300))
    move = np.linalg.solve(H / np.outer(size, size) + damping * np.eye(size.size), g / size) / size
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
    theta, _ = f.trusted.minimise(may, start if (start > 0).any() else None)
    again = valued(f.frame, f.state, may, theta, f.v, f.likelihood, f.error)
    return refined(again, 3) if f.v.size else again


def pruned(f: Fitted) -> Fitted:
    """The subset of the powers with the least score: one after the other is left out."""
    P = len(f.frame.powers)
    best = _dropping(f)
    while best.free[:P].sum() > 1:
        tries = []
        for i in np.flatnonzero(best.free[:P]):
            less = best.free.copy()
            less[i] = False
            if (admissible(f.frame, f.state, less, less.size) == less).all():
                tries.append(resized(best, less))
        if not tries or (least := min(tries, key=lambda t: t.score)).score >= best.score:
            break
        best = _dropping(least)
    return best


def _dropping(f: Fitted) -> Fitted:
    """The same without the terms whose size is zero, which costs nothing."""
    P = len(f.frame.powers)
    free = f.free.copy()
    free[:P] &= f.theta[:P] > 0
    return replace(f, free=admissible(f.frame, f.state, free, free.size))
