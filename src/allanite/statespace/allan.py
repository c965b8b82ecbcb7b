"""The Allan variance of what a state space puts out, exactly, from its matrices alone."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Steps:
    """Some steps together: x' = A x + w, sum of the outputs = c x + n, with the covariances of w and n."""

    A: FloatArray
    c: FloatArray
    Qww: FloatArray
    Qwn: FloatArray
    qnn: float

    def then(self, other: "Steps") -> "Steps":
        """These steps, and then those."""
        A, c = other.A, other.c
        return Steps(
            A=A @ self.A,
            c=self.c + c @ self.A,
            Qww=A @ self.Qww @ A.T + other.Qww,
            Qwn=A @ (self.Qww @ c + self.Qwn) + other.Qwn,
            qnn=float(self.qnn + c @ self.Qww @ c + 2 * c @ self.Qwn + other.qnn),
        )


def allan_variance(one: Steps, P: FloatArray, m: IntArray) -> FloatArray:
    """Allan variance of the output at averaging factors `m`, shape of m.

    With the sums s_1 and s_2 of the outputs over m steps and the m steps after them, it is the variance of s_2 - s_1
    over 2 m^2, where s_2 - s_1 = c (A - 1) x + c w_1 + n_2 - n_1.

    Parameters
    ----------
    one : Steps
        A single step.
    P : array, shape (s, s)
        Covariance of the states before the first step.
    m : int array
    """
    found = []
    for factor in np.asarray(m).tolist():
        steps = _power(one, int(factor))
        start = steps.c @ (steps.A - np.eye(len(P)))
        variance = start @ P @ start + steps.c @ steps.Qww @ steps.c - 2 * steps.c @ steps.Qwn + 2 * steps.qnn
        found.append(variance / (2 * factor**2))
    return np.array(found)


def _power(one: Steps, m: int) -> Steps:
    """So many steps, by doubling."""
    whole, doubled = None, one
    while m:
        if m & 1:
            whole = doubled if whole is None else whole.then(doubled)
        m >>= 1
        doubled = doubled.then(doubled) if m else doubled
    assert whole is not None  # noqa: S101 - m is at least 1
    return whole
