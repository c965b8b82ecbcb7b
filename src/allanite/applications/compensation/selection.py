"""Which columns of a regression can be separated, and from which it gains, by cross-validation."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from allanite.extending import FloatArray, Likelihood, join, say, spelled

from .design import MIN_STRETCH, Design

CONDITION = 30.0  # scaled condition number above which coefficients cannot be separated (Belsley, Kuh, Welsch 1980)
TRENDING = 0.5  # share of a ramp explained by the regressors from which on they are confounded with it
BEYOND_DOUBT = 3.0  # standard errors from which on an effect is beyond doubt


class Collinearity(NamedTuple):
    """Scaled condition number, variance inflation of each column, and warnings."""

    condition: float
    inflation: FloatArray
    notes: tuple[str, ...]


def collinearity(design: Design, likelihood: Likelihood, theta: FloatArray, symbols: str) -> Collinearity:
    """Collinearity of the columns of a design under the noise theta of some terms."""
    A = information(likelihood, theta)
    size = np.sqrt(np.diag(A))
    values = np.linalg.eigvalsh(A / np.outer(size, size))
    inflation = np.diag(np.linalg.inv(A / np.outer(size, size))).copy()
    condition = float(np.sqrt(values[-1] / max(values[0], 1e-300)))
    notes = []
    if condition > CONDITION:
        factors = zip(design.labels, inflation, strict=True)
        worst = join(", ", [join("", (label, f" ({factor:.3g})")) for label, factor in factors if factor > 10])
        notes.append(say("the regressors can hardly be separated: scaled condition number {condition:.3g}, above "
                         "{limit:g}; variance inflation {worst}. Their sum may be accurate although none of them is",
                         condition=condition, limit=CONDITION, worst=worst or say("spread over all")))  # fmt: skip
    if design.trend:
        return Collinearity(condition, inflation, tuple(notes))
    # the share of a ramp that the columns explain, whitened, and the ramp beside them over its standard error
    ramp = np.linspace(-1.0, 1.0, design.y.size)
    wider = replace(design, X=np.column_stack((design.X, ramp))).likelihood(symbols)
    eta, V, _ = wider.directions(theta)
    share, t = 1 - 1 / float(V[-1, -1] * information(wider, theta)[-1, -1]), float(eta[-1] / np.sqrt(V[-1, -1]))
    why = None
    if share > TRENDING:
        why = say("the regressors have a trend: they explain {percent:.3g} % of a linear drift, so that a rate ramp R "
                  "would be taken for their effect", percent=100 * share)  # fmt: skip
    elif abs(t) > BEYOND_DOUBT:
        why = say("the record shows a rate ramp R beside the regressors ({t:.3g} standard errors): part of it is taken "
                  "for their effect", t=abs(t))  # fmt: skip
    if why:
        notes.append(join("; ", (why, say("omit {option}", option=spelled("--no-trend", "trend=False")))))
    return Collinearity(condition, inflation, tuple(notes))


def information(likelihood: Likelihood, theta: FloatArray) -> FloatArray:
    """X' C^-1 X of the flat directions, shape (p, p), the edges known."""
    flat = np.flatnonzero(likelihood.flat)
    return np.asarray(np.einsum("bij,b->ij", likelihood.UU[:, flat][:, :, flat], 1 / likelihood.expectation(theta)))


class Products(NamedTuple):
    """Products of columns and rates over some stretches: X'X, X'y and y'y."""

    A: FloatArray
    b: FloatArray
    squares: float

    def misfit(self, beta: FloatArray, kept: list[int]) -> float:
        """Sum of squares of the rates less the columns `kept` with these coefficients."""
        return float(self.squares - 2 * beta @ self.b[kept] + beta @ self.A[np.ix_(kept, kept)] @ beta)


def products(likelihood: Likelihood, theta: FloatArray) -> tuple[Products, Products]:
    """From a likelihood of `restricted`: whitened under the noise theta, and plain."""
    flat = np.flatnonzero(likelihood.flat)
    UU, Uc, m = likelihood.UU[:, flat][:, :, flat], likelihood.Uc[:, flat], likelihood.expectation(theta)
    squares = likelihood.count * likelihood.power
    whitened = Products(information(likelihood, theta), (1 / m) @ Uc, float((1 / m) @ squares))
    return whitened, Products(UU.sum(axis=0), Uc.sum(axis=0), float(squares.sum()))


@dataclass(frozen=True, eq=False)
class HeldBlock:
    """A block that is held back, whitened and plain, and the rest of the record, whitened."""

    rest: Products
    whitened: Products
    plain: Products

    def coefficients(self, kept: list[int]) -> FloatArray:
        """Generalized least squares of the rest; the shortest ones where columns are alike there."""
        A, b = self.rest.A[np.ix_(kept, kept)], self.rest.b[kept]
        size = np.sqrt(np.maximum(np.diag(A), 1e-300))
        return np.asarray(np.linalg.lstsq(A / np.outer(size, size), b / size, rcond=1e-10)[0] / size)

    def misfit(self, kept: list[int]) -> float:
        """Whitened sum of squares of the held block less what the rest predicts of it."""
        return self.whitened.misfit(self.coefficients(kept), kept) if kept else self.whitened.squares

    def squares(self, kept: list[int]) -> float:
        """Sum of squares of the held block, about its mean, less what the rest predicts of it."""
        return self.plain.misfit(self.coefficients(kept), kept) if kept else self.plain.squares


def folds(design: Design, theta: FloatArray, symbols: str, blocks: int) -> list[HeldBlock]:
    """The record in so many blocks of equal length, each held back once; those without enough samples are omitted."""
    first, last = design.stretches[0][0], design.stretches[-1][1]
    edges = np.linspace(first, last, blocks + 1).astype(int)
    held = []
    for a, b in pairwise(edges.tolist()):
        parts = [
            [
                (max(i, c), min(j, d))
                for i, j in design.stretches
                for c, d in windows
                if min(j, d) - max(i, c) >= MIN_STRETCH
            ]
            for windows in ([(first, a), (b, last)], [(a, b)])
        ]
        if all(parts):
            (rest, _), block = (products(design.likelihood(symbols, parts=p), theta) for p in parts)
            held.append(HeldBlock(rest, *block))
    return held


def choose(design: Design, folds: Sequence[HeldBlock]) -> list[int]:
    """The columns that are kept: all that were requested, and one after the other what held-back blocks gain from."""
    # An optional column enters if it lowers the whitened misfit of the held-back blocks by more than one standard error
    # of that gain over the blocks, a power with those below it. What takes in fewer columns comes first: a square alone
    # may do harm where a third power beside it is wanted, too.
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
