"""Lost readings: what is left is joined, and what the joints do to each term is known.

A lost stretch is cut out, and the transform is taken of what is left, n readings with g joints. White noise and flicker
hardly notice. Quantization loses the angle that the two readings at a joint would share, as at the ends of a record.
What walks goes on walking unseen, so that what is left steps at the joint.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .record import SHORTEST, Record
from .terms import NoiseTerm

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

EXACT = 64
"""Coefficients up to which the joints count where they lie; above, on average."""

FEW = f"too few for noise coefficients (at least {SHORTEST})"

LEAST = 0.1
"""Share of the readings that must be left."""

SHORTEST_RUN = 4.0
"""Readings between two joints that must be left on average."""


@dataclass(frozen=True, eq=False)
class Gaps:
    """The joints of `size` readings.

    Attributes
    ----------
    size : int
        Readings that are left.
    at, lost : int arrays, shape (g,)
        Index of the first reading behind each joint, and how many were lost there.
    """

    size: int
    at: IntArray
    lost: IntArray

    def row(self, term: NoiseTerm, k: FloatArray) -> FloatArray:
        """Variance of the k-th coefficients under a term, shape of `k`.

        With the joints j, the lost readings l and omega = pi k / n

            edge (2/n) sum [cos(2 omega j) + cos(omega)]      is what an open angle adds,
            1 + (2/n) sum l sin^2(omega j)                    the factor of a random walk,

        and on average over k the cosine is 0, the square of the sine 1/2.
        """
        values = term.dct(k, self.size)
        if not self.at.size:
            return values
        n, walk = self.size, 2 * term.slope if term.slope > 0 else 0.0
        both = np.full(k.shape, 0.0)
        steps = np.full(k.shape, float(self.lost.sum()))
        low = k <= EXACT
        turn = np.cos((2 * np.pi / n) * np.outer(k[low], self.at))
        both[low], steps[low] = turn.sum(axis=1), (1 - turn) @ self.lost
        opened = term.edge * (2 / n) * (both + self.at.size * np.cos((np.pi / n) * k))
        return np.asarray(values * (1 + steps / n) ** walk + opened)


def joined(record: Record) -> tuple[FloatArray, Gaps, IntArray | None]:
    """Rates in the record's unit, joined over the gaps; the gaps; and which readings are left (None: all)."""
    steps = np.diff(record.values) if record.kind == "angle" else record.values - record.constant
    none = np.empty(0, np.int64)
    if steps.dtype.kind != "f" or np.isfinite(steps.sum()):
        return np.asarray(steps, dtype=np.float64), Gaps(steps.size, none, none), None
    there = np.flatnonzero(np.isfinite(steps))
    jumps = np.diff(there)
    at = np.flatnonzero(jumps > 1) + 1
    return np.asarray(steps[there], dtype=np.float64), Gaps(there.size, at, jumps[at - 1] - 1), there


def refusal(record: Record) -> str:
    """Why nothing can be identified in a record of this length, or in what is left of it; empty if it can.

    Examples
    --------
    >>> y = np.full(1000, np.nan)
    >>> y[:150] = np.arange(150) % 7
    >>> refusal(Record(y, rate=1.0, unit="deg/s"))
    '850 of 1000 readings are lost; 150 are left, too few for noise coefficients (at least 200)'
    """
    if record.size < SHORTEST:
        return f"{record.size} readings are {FEW}"
    if record.values.dtype.kind != "f" or np.isfinite(record.values.sum(dtype=np.float64)):
        return ""
    infinite = np.isinf(record.values)
    if infinite.any():
        return (
            f"{infinite.sum()} of {infinite.size} readings are infinite, the first at sample {int(infinite.argmax())}; "
            "if they are lost, put NaN in their place"
        )
    gaps = joined(record)[1]
    left, pieces = gaps.size, gaps.at.size + 1
    lost = f"{record.size - left} of {record.size} readings are lost"
    reasons = (
        (left < SHORTEST, f"{left} are left, {FEW}"),
        (
            left < LEAST * record.size,
            "less than a tenth is left, too little to tell slow noise; choose a window (--from, --until)",
        ),
        (
            left < SHORTEST_RUN * pieces,
            f"pieces of {left / pieces:.2g} readings cannot tell noise of the rate from noise of the angle; choose a "
            "window (--from, --until); where only every so many readings one was kept, give the rate of those",
        ),
    )
    return next((f"{lost}; {reason}" for holds, reason in reasons if holds), "")
