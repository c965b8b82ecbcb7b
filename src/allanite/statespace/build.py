"""From a model whose terms are states to matrices."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import UsageError
from allanite.core.model import Model, Term
from allanite.terms import TERMS
from allanite.terms.block import Block, integrators, joined

from .allan import Steps, allan_variance
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
        if not t.row.substitute or fitted is None:
            terms.append(t)
            continue
        pairs = zip(fitted.sizes.tolist(), fitted.time_constants.tolist(), strict=True)
        terms += [Term(t.row.substitute, t.value * size, t.signal, (T,)) for size, T in pairs if size > 0]
    return Model(tuple(terms))


def blocks_of(model: Model, h: float) -> list[Block]:
    """The terms as states, in the order of `TERMS`.

    Raises
    ------
    UsageError
        A term has no states.
    """
    known = list(TERMS)
    return [_block(t, h) for t in sorted(model, key=lambda t: known.index(t.symbol))]


def _block(t: Term, h: float) -> Block:
    if t.row.block is None:
        able = ", ".join(symbol for symbol, row in TERMS.items() if row.block or row.substitute)
        raise UsageError(
            f"{t.symbol} ({t.row.title}) has no states in a filter, {able} have: leave it out of the model, or put a "
            "term in its place that has the same curve at the averaging times that matter"
        )
    return t.row.block(t.value, t.shape, h)


def states_of(blocks: list[Block], turn_on: float, h: float) -> list[Block]:
    """The blocks that have states, those of continuous time first; with a bias of standard deviation `turn_on`."""
    bias = [block for block in blocks if block.bias]
    bias += [integrators(("bias",), h, start=turn_on)] if turn_on else []
    others = [block for block in blocks if block.names and not block.bias]
    others.sort(key=lambda block: not block.output.any())
    return ([joined(bias)] if bias else []) + others


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
