"""Which optional columns a regression gains from, by cross-validation over blocks of the record."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from allanite.extending import Likelihood

from .collinearity import information
from .design import SHORTEST, Design
from .restricted import FloatArray


@dataclass(frozen=True, eq=False)
class Products:
    """Products of columns and rates over some stretches: whitened (A, b, q) and plain (S, s, yy)."""

    A: FloatArray
    b: FloatArray
    q: float
    S: FloatArray
    s: FloatArray
    yy: float

    @classmethod
    def of(cls, likelihood: Likelihood, theta: FloatArray) -> "Products":
        """From a likelihood of `restricted`, under the noise theta."""
        flat = np.flatnonzero(likelihood.flat)
        UU, Uc, m = likelihood.UU[:, flat][:, :, flat], likelihood.Uc[:, flat], likelihood.expectation(theta)
        squares = likelihood.count * likelihood.power
        return cls(
            information(likelihood, theta), (1 / m) @ Uc, float((1 / m) @ squares),
            UU.sum(axis=0), Uc.sum(axis=0), float(squares.sum()),
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class HeldBlock:
    """A block that is held back, and the rest of the record."""

    rest: Products
    held: Products

    def coefficients(self, kept: Sequence[int]) -> FloatArray:
        """Generalized least squares of the rest; the shortest ones where columns are alike there."""
        some = list(kept)
        A, b = self.rest.A[np.ix_(some, some)], self.rest.b[some]
        size = np.sqrt(np.maximum(np.diag(A), 1e-300))
        return np.asarray(np.linalg.lstsq(A / np.outer(size, size), b / size, rcond=1e-10)[0] / size)

    def misfit(self, kept: Sequence[int]) -> float:
        """Whitened sum of squares of the held block less what the rest predicts of it."""
        some = list(kept)
        if not some:
            return self.held.q
        beta = self.coefficients(some)
        return float(self.held.q - 2 * beta @ self.held.b[some] + beta @ self.held.A[np.ix_(some, some)] @ beta)

    def squares(self, kept: Sequence[int]) -> float:
        """Sum of squares of the held block, about its mean, less what the rest predicts of it."""
        some = list(kept)
        if not some:
            return self.held.yy
        beta = self.coefficients(some)
        return float(self.held.yy - 2 * beta @ self.held.s[some] + beta @ self.held.S[np.ix_(some, some)] @ beta)


def folds(design: Design, theta: FloatArray, symbols: str, blocks: int) -> list[HeldBlock]:
    """The record in so many blocks of equal length, each held back once; those without enough samples are omitted."""
    first, last = design.stretches[0][0], design.stretches[-1][1]
    edges = np.linspace(first, last, blocks + 1).astype(int)
    found = []
    for a, b in pairwise(edges.tolist()):
        parts = [
            [
                (max(i, c), min(j, d))
                for i, j in design.stretches
                for c, d in windows
                if min(j, d) - max(i, c) >= SHORTEST
            ]
            for windows in ([(first, a), (b, last)], [(a, b)])
        ]
        if all(parts):
            found.append(HeldBlock(*(Products.of(design.likelihood(symbols, parts=p), theta) for p in parts)))
    return found


def choose(design: Design, folds: Sequence[HeldBlock]) -> list[int]:
    """The columns that are kept: all that were requested, and one after the other what held-back blocks gain from.

    An optional column enters if it lowers the whitened misfit of the held-back blocks by more than one standard error
    of that gain over the blocks, a power with those below it. What takes in fewer columns comes first: a square alone
    may do harm where a third power beside it is wanted, too.
    """
    kept = [i for i, optional in enumerate(design.optional) if not optional]
    columns = [(r.channel, r.power) for r in design.regressors]
    while True:
        open_ = [i for i, optional in enumerate(design.optional) if optional and i not in kept]
        steps = [[j for j in open_ if j == i or _below(columns[j], columns[i])] for i in open_]
        base = np.array([fold.misfit(kept) for fold in folds])
        for size in sorted({len(step) for step in steps}):
            some = [step for step in steps if len(step) == size]
            gains = [base - [fold.misfit([*kept, *step]) for fold in folds] for step in some]
            good = [(float(g.mean()), step) for g, step in zip(gains, some, strict=True) if _clear(g)]
            if good:
                kept += max(good)[1]
                break
        else:
            return sorted(kept)


def _below(one: tuple[str, int], other: tuple[str, int]) -> bool:
    """Whether a column is a lower power of the same channel."""
    return one[0] == other[0] and 1 < one[1] < other[1]


def _clear(gains: FloatArray) -> bool:
    return bool(gains.mean() > gains.std(ddof=1) / np.sqrt(gains.size))
