r"""The information about a model's parameters in a record, as sums over the coefficients of its cosine transform.

The coefficients (DCT-II, k = 1 .. n-1; k = 0 is the unknown bias) have the covariance

    C = M + U W U',    M_kk = sum_i theta_i S_ik.

M is diagonal for white noise and random walks; flicker and slow Gauss-Markov noise correlate the lowest coefficients of
equal parity a little, and these stand in a block of their own. U are the first and the last sample, which
quantization makes noisier than the others (as halves of even and of odd k, which are orthogonal), and a ramp of unknown
size (W infinite). The information about logarithms of parameters is that of a Gaussian record,

    F_ij = tr(P C_i P C_j) / 2,    C_i = dC / d ln theta_i,    P = C^-1,

which by Woodbury's formula takes sums over k alone, and those are taken at a few hundred nodes, whatever the length.
"""

import math
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.model import Term
from allanite.statistics.moments.lagsums import sum_nodes
from allanite.terms import NoiseTerm

SINGLE = 64
"""Up to this index every coefficient is taken by itself."""

PER_OCTAVE = 8
"""Panels of four nodes in an octave above."""

BLOCK = 32
"""Coefficients whose correlation counts."""


def nodes(n: int) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights of the sum over k = 1 .. n-1, exact up to `SINGLE`.

    Examples
    --------
    >>> k, weight = nodes(1_000_001)
    >>> k.size < 600, round(float(weight.sum())), round(float(weight @ (1 / k)), 9)
    (True, 1000000, 14.392726723)
    """
    last = min(SINGLE, n - 1)
    count = math.ceil(PER_OCTAVE * math.log2((n - 1) / last)) if n - 1 > last else 0
    edges = np.unique(np.rint(np.geomspace(last, n - 1, count + 1)).astype(np.int64))
    panels = [sum_nodes(float(a + 1), int(b - a)) for a, b in pairwise(edges)]
    k = np.concatenate([np.arange(1.0, last + 1), *(np.array(x) for x, _ in panels)])
    return k, np.concatenate([np.ones(last), *(np.array(w) for _, w in panels)])


class CoefficientGrid:
    """Nodes of the sum over k, those above `SINGLE` once for even and once for odd k, and the directions there."""

    def __init__(self, n: int) -> None:
        k, weight = nodes(n)
        many = k > SINGLE
        self.n, self.block = n, min(BLOCK, n - 1)
        self.k = np.concatenate((k, k[many]))
        self.weight = np.concatenate((np.where(many, 0.5, 1.0) * weight, 0.5 * weight[many]))
        odd = np.concatenate((np.where(many, 0.0, np.rint(k) % 2), np.ones(int(many.sum()))))
        half = 0.5 * math.pi / n * self.k
        end = math.sqrt(2 / n) * np.cos(half)
        ramp = end / (2 * np.sin(half) ** 2)
        self.U = np.column_stack([end * (1 - odd), end * odd, ramp * odd])


@cache
def _nodes() -> tuple[FloatArray, FloatArray]:
    """Nodes and weights of Gauss's rule between 0 and 1."""
    v, weight = np.polynomial.legendre.leggauss(200)
    return (v + 1) / 2, weight / 2


def mixing(row: NoiseTerm, block: int, n: int) -> FloatArray:
    """Covariance of the coefficients 1 .. block of n rates, except for its diagonal, shape (block, block).

    With c(h) = D''(h) / 2 the covariance of rates, ``2 n int_0^1 A_kl(u) c(n u) du`` for k, l of equal parity, where

        A_kl(u) = (2 / pi) (k sin(pi k u) - l sin(pi l u)) / (l^2 - k^2)

    is the correlation of the two cosines at the distance u. It is zero for white noise and for random walks.
    """
    v, weight = _nodes()
    u = v**2  # a logarithm at u = 0 becomes smooth
    c = 2 * v * weight * row.derivative(2, n * u)
    k = np.arange(1.0, block + 1)
    waves = k * (np.sin(math.pi * np.outer(u, k)).T @ c)
    both = np.subtract.outer(k, k) % 2 == 0
    np.fill_diagonal(both, False)
    squares = np.where(both, k[None, :] ** 2 - k[:, None] ** 2, 1.0)
    return np.where(both, n * 2 / math.pi * (waves[:, None] - waves[None, :]) / squares, 0.0)


@dataclass(frozen=True, eq=False)
class InformationPart:
    """dC / d ln theta of one parameter.

    `power`, shape (nodes,), is that of the variances, `edge` that of the variance of each half of the ends; `block`,
    shape (block, block), that of the covariance of the lowest coefficients, their variances included.
    """

    power: FloatArray
    block: FloatArray
    edge: float

    @classmethod
    def of(cls, t: Term, rate: float, grid: CoefficientGrid) -> "InformationPart":
        """A term's own part."""
        row, power = t.sampled(rate), t.power(rate)
        variance = power * row.dct(grid.k, grid.n)
        block = np.diag(variance[: grid.block]) + power * mixing(row, grid.block, grid.n)
        return cls(variance, block, 2 * power * (row.edge + row.ends))

    def __add__(self, other: "InformationPart") -> "InformationPart":
        return InformationPart(self.power + other.power, self.block + other.block, self.edge + other.edge)

    def __mul__(self, factor: float) -> "InformationPart":
        return InformationPart(factor * self.power, factor * self.block, factor * self.edge)


def shape_parts(t: Term, rate: float, grid: CoefficientGrid) -> list[InformationPart]:
    """Change with the logarithm of each parameter of a term's shape.

    Halved: the other parts are of squares of coefficients, whose errors are halved.
    """

    def at(which: int, factor: float) -> InformationPart:
        return InformationPart.of(
            replace(t, shape=tuple(value * factor if i == which else value for i, value in enumerate(t.shape))),
            rate,
            grid,
        )

    step = 1.001
    changes = (at(i, step) + at(i, 1 / step) * -1.0 for i in range(len(t.row.parameters)))
    return [change * (1 / (4 * math.log(step))) for change in changes]


class Information:
    """tr(P C_i P C_j) / 2 for parts of a covariance whose whole is `whole`; with a `ramp`, its size is unknown."""

    def __init__(self, grid: CoefficientGrid, whole: InformationPart, *, ramp: bool) -> None:
        W = np.array([whole.edge, whole.edge, math.inf if ramp else 0.0])
        there = W > 0
        self.grid, self.free, self.U = grid, np.isinf(W[there]), grid.U[:, there]
        self.m, self.inverse = whole.power[grid.block :], np.linalg.inv(whole.block)
        self.weight = grid.weight[grid.block :]
        self.G = self._solved(self.U)
        self.A = self._product(self.U, self.G)
        self.V = np.linalg.inv(np.diag(np.where(self.free, 0.0, 1 / np.where(self.free, 1.0, W[there]))) + self.A)

    def _solved(self, Z: FloatArray) -> FloatArray:
        """M^-1 Z."""
        block = self.grid.block
        return np.concatenate((self.inverse @ Z[:block], Z[block:] / self.m[:, None]))

    def _product(self, Y: FloatArray, Z: FloatArray) -> FloatArray:
        """Y'Z."""
        return np.asarray((Y * self.grid.weight[:, None]).T @ Z)

    @property
    def ramp(self) -> float:
        """Standard error of the ramp, per sample; infinite where there is none to be found."""
        return math.sqrt(self.V[-1, -1]) if self.free.any() else math.inf

    def matrix(self, parts: list[InformationPart]) -> FloatArray:
        """Information about the parts, shape (p, p)."""
        V, block = self.V, self.grid.block
        rest = np.eye(len(V)) - V @ self.A
        C = self.A @ rest
        X = [part.power[block:] / self.m for part in parts]
        L = [self.inverse @ part.block for part in parts]
        H = [np.concatenate((part.block @ self.G[:block], part.power[block:, None] * self.G[block:])) for part in parts]
        Y = [self._product(self.G, h) for h in H]
        W = [np.diag(np.where(self.free, 0.0, part.edge)) for part in parts]
        F = np.empty((len(parts), len(parts)))
        for i, j in np.ndindex(F.shape):
            F[i, j] = self.weight @ (X[i] * X[j]) + np.sum(L[i] * L[j].T)
            F[i, j] -= 2 * np.sum(V * self._product(H[i], self._solved(H[j])))
            F[i, j] += np.trace(V @ Y[i] @ V @ Y[j]) + np.trace(W[i] @ C @ W[j] @ C)
            F[i, j] += np.trace(rest.T @ (Y[i] @ rest @ W[j] + Y[j] @ rest @ W[i]))
        return F / 2
