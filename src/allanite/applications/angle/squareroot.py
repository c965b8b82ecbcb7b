"""Least squares in square-root form: the triangular factor of the information, never a covariance that is updated.

A recursive estimator of constants is a Kalman filter without prediction. Its covariance form loses digits with every
subtraction; the factor R of the information ``P^-1 = R^T R`` is only ever rotated, and rotations lose none.
"""

from dataclasses import dataclass

import numpy as np

from allanite.extending import FloatArray, Value

BLOCK = 4096  # rows that the batch form takes at a time: what they need stays in the cache


@dataclass(frozen=True, eq=False, repr=False)
class SquareRoot(Value):
    """What is known of p constants x from n samples ``z = a x + v``, all divided by the deviation of v."""

    # shape (p, p + 1); upper triangular ``[R | d]``: the estimate solves ``R x = d``, its covariance is ``(R^T
    # R)^-1``
    factor: FloatArray
    squares: float = 0.0  # sum of the squares that are left: of the innovations over their standard deviation
    count: int = 0  # samples absorbed

    @classmethod
    def before(cls, prior: FloatArray) -> "SquareRoot":
        """What is known before the first sample: standard deviations `prior` about 0, shape (p,)."""
        return cls(np.column_stack([np.diag(1 / prior), np.zeros(prior.size)]))

    def absorb(self, rows: FloatArray, values: FloatArray) -> tuple["SquareRoot", FloatArray]:
        """Take in samples one after the other, by Givens rotations."""
        from allanite.kernels.leastsquares import absorb

        factor = self.factor.copy()
        innovations = absorb(factor, np.ascontiguousarray(rows), np.ascontiguousarray(values))
        squares = self.squares + float(innovations @ innovations)
        return SquareRoot(factor, squares, self.count + values.size), innovations

    @property
    def values(self) -> FloatArray:
        """The estimate, shape (p,)."""
        from scipy.linalg import solve_triangular

        return np.asarray(solve_triangular(self.factor[:, :-1], self.factor[:, -1]))

    @property
    def covariance(self) -> FloatArray:
        """Covariance of the estimate, shape (p, p)."""
        inverse = self._inverse
        return inverse @ inverse.T

    @property
    def errors(self) -> FloatArray:
        """Standard errors of the estimate, shape (p,)."""
        return np.asarray(np.linalg.norm(self._inverse, axis=1))

    @property
    def condition(self) -> float:
        """Largest over smallest singular value of the rows, each column scaled to length 1; infinite if singular."""
        values = self.singular[0]
        return float(values[0] / values[-1]) if values[-1] > 0 else np.inf

    @property
    def singular(self) -> tuple[FloatArray, FloatArray]:
        """Singular values of the scaled columns, largest first, and their directions, one a row."""
        triangle = self.factor[:, :-1]
        length = np.linalg.norm(triangle, axis=0)
        _, values, directions = np.linalg.svd(triangle / np.where(length > 0, length, 1.0))
        return values, directions

    def without(self, columns: list[int]) -> "SquareRoot":
        """What would be known if these constants were known to be zero."""
        kept = np.delete(self.factor, columns, axis=1)
        return SquareRoot(_triangle(kept)[: kept.shape[1] - 1], self.squares, self.count)

    @property
    def _inverse(self) -> FloatArray:
        from scipy.linalg.lapack import dtrtri

        inverse, fault = dtrtri(self.factor[:, :-1])
        if fault:
            raise np.linalg.LinAlgError("the information is singular")
        return np.asarray(inverse)


def batch(rows: FloatArray, values: FloatArray, prior: FloatArray | None = None) -> SquareRoot:
    """All samples at once, by Householder reflections of blocks: the twin of `SquareRoot.absorb`."""
    p = rows.shape[1]
    triangle = np.zeros((p + 1, p + 1))
    if prior is not None:
        triangle[:p, :p] = np.diag(1 / prior)
    for start in range(0, values.size, BLOCK):
        block = np.column_stack([rows[start : start + BLOCK], values[start : start + BLOCK]])
        triangle = _triangle(np.vstack([triangle, block]))
    return SquareRoot(triangle[:p], float(triangle[p, p] ** 2), values.size)


def _triangle(rows: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.qr(rows, mode="r"))
