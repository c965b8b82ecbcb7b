"""From a model whose terms are states to matrices."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from allanite.core.model import Model, Term

from .allan import Steps, allan_variance
from .blocks import Block, angle_noise, markov, oscillator, walk
from .markov import MarkovSum

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Matrices:
    """x' = Phi x + w, reading = H x + v, cov(w) = Qd, var(v) = R, cov(x at start) = P0."""

    Phi: FloatArray
    Qd: FloatArray
    H: FloatArray
    R: FloatArray
    P0: FloatArray

    def allan(self, m: IntArray) -> FloatArray:
        """Allan variance of the readings at averaging factors `m`."""
        h = self.H[0]
        noise = self.Qd @ h
        one = Steps(self.Phi, h @ self.Phi, self.Qd, noise, float(h @ noise + self.R[0, 0]))
        return allan_variance(one, self.P0, m)


def equivalent(model: Model, fitted: MarkovSum | None) -> Model:
    """The model with flicker replaced."""
    terms: list[Term] = []
    for t in model:
        if t.symbol != "B" or fitted is None:
            terms.append(t)
            continue
        pairs = zip(fitted.sizes.tolist(), fitted.time_constants.tolist(), strict=True)
        terms += [Term("GM", t.value * size, t.signal, (T,)) for size, T in pairs if size > 0]
    return Model(tuple(terms))


def states_of(model: Model, turn_on: float, h: float) -> list[Block]:
    """The states: those of continuous time first."""
    size = {t.symbol: t.value for t in model}
    found = []
    if turn_on or "K" in size or "R" in size:
        found.append(walk(size.get("K", 0.0), size.get("R"), turn_on, h))
    found += [markov(t.value, t.shape[0], h) for t in model if t.symbol == "GM"]
    found += [oscillator(t.value, t.shape[0], h) for t in model if t.symbol == "Sine"]
    return found + [angle_noise(t.value, h) for t in model if t.symbol == "Q"]


def sampled(blocks: list[Block], R: FloatArray) -> Matrices:
    """A reading is the rate at the time of the states."""
    from scipy.linalg import block_diag

    Phi, P0 = (block_diag(*(getattr(b, name) for b in blocks)) for name in ("Phi", "P0"))
    Qd = block_diag(*(b.Q[:-1, :-1] for b in blocks))
    return Matrices(Phi, Qd, np.concatenate([b.output for b in blocks])[None, :], R, P0)


def averaged(blocks: list[Block], R: FloatArray) -> Matrices:
    """The mean over the interval is the last state, and the reading."""
    inner = sampled(blocks, R)
    s = len(inner.Phi)
    Phi, Qd, P0 = (np.zeros((s + 1, s + 1)) for _ in range(3))
    Phi[:s, :s], Qd[:s, :s], P0[:s, :s] = inner.Phi, inner.Qd, inner.P0
    Phi[s, :s] = np.concatenate([b.mean for b in blocks])
    Qd[:s, s] = Qd[s, :s] = np.concatenate([b.Q[:-1, -1] for b in blocks])
    Qd[s, s] = sum(b.Q[-1, -1] for b in blocks)
    P0[s, s] = float(Phi[s, :s] @ inner.P0 @ Phi[s, :s] + Qd[s, s])
    return Matrices(Phi, Qd, np.eye(s + 1)[None, -1], R, P0)


@dataclass(frozen=True)
class Measurement:
    """What a reading is taken for, and how the matrices are built."""

    meaning: str
    build: Callable[[list[Block], FloatArray], Matrices]


MEASUREMENTS: dict[str, Measurement] = {
    "mean": Measurement(
        "a reading is the mean rate over the interval that ends at the time of the states; the mean is a state, exact",
        averaged,
    ),
    "sample": Measurement(
        "a reading is the rate at the time of the states, taken for the mean over the interval that ends there", sampled
    ),
}


def continuous(blocks: list[Block]) -> tuple[FloatArray, FloatArray]:
    """F and Qc of the states that exist in continuous time."""
    from scipy.linalg import block_diag

    inner = [b for b in blocks if b.output.any()]
    F, Qc = (block_diag(*(getattr(b, name) for b in inner)) if inner else np.zeros((0, 0)) for name in ("F", "Qc"))
    return F, Qc
