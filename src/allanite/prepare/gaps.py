"""Lost readings: what is left is joined, and what the joints do to each term is known.

A lost stretch is cut out, and the transform is taken of what is left, n readings with g joints. White noise and flicker
hardly notice. Quantization loses the angle that the two readings at a joint would share, as at the ends of a record.
What walks goes on walking unseen, so that what is left steps at the joint.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray, IntArray
from allanite.core.record import SHORTEST, Record
from allanite.terms import NoiseTerm

EXACT = 64
"""Coefficients up to which the joints count where they lie; above, on average."""

FEW = f"too few for noise coefficients (at least {SHORTEST})"

LEAST = 0.1
"""Share of the readings that must be left."""

BLOCK = 1024
"""Steps of an angle over which its rate is taken as one, to be taken off during a gap."""

LEAST_SHARE = 0.005
"""Share of the rate's noise in that of a step below which it is not known."""

NEIGHBOURS = 0.1
"""Share of the readings that are left which must have the next one too."""


@dataclass(frozen=True, eq=False)
class Gaps:
    """The gaps among `size` readings that are left: `at` the first reading behind each, so many are `lost` there.

    `shut` are gaps over which an angle was counted on: the reading there is the angle gained over lost + 1 intervals.
    """

    size: int
    at: IntArray
    lost: IntArray
    shut: BoolArray

    def row(self, term: NoiseTerm, k: FloatArray) -> FloatArray:
        """Variance of the k-th coefficients under a term, shape of `k`.

        With the first readings j behind the gaps, the lost l and omega = pi k / n

            edge (2/n) sum [cos(2 omega j) + cos(omega)]      is what an open angle adds,
            1 + (2/n) sum l sin^2(omega j)                    the factor of a random walk,
            (1/n) sum [D(l + 1) - D(1)]                       what a shut gap adds, of the angle's own noise,

        and on average over k the first cosine is 0, the square of the sine 1/2. Noise between these is left alone.
        """
        values = term.dct(k, self.size)
        if not self.at.size:
            return values
        n, walk = self.size, 2 * term.slope if term.slope > 0 else 0.0
        opened, shut = self.at[~self.shut], np.asarray(self.lost[self.shut] + 1.0, dtype=np.float64)
        both = np.full(k.shape, 0.0)
        steps = np.full(k.shape, float(self.lost.sum()))
        low = k <= EXACT
        turn = np.cos((2 * np.pi / n) * np.outer(k[low], self.at))
        both[low], steps[low] = turn[:, ~self.shut].sum(axis=1), (1 - turn) @ self.lost
        ends = term.edge * (2 / n) * (both + opened.size * np.cos((np.pi / n) * k))
        D: Callable[[FloatArray], FloatArray] = term.structure if term.slope <= -0.5 else np.ones_like
        longer = float((D(shut) - D(np.ones(1))).sum()) / n
        return np.asarray(values * (1 + steps / n) ** walk + ends + longer)


def whole(size: int) -> Gaps:
    """No gaps among so many readings."""
    none = np.empty(0, np.int64)
    return Gaps(size, none, none, none.astype(np.bool_))


def joined(record: Record) -> tuple[FloatArray, Gaps, IntArray | None]:
    """Rates in the record's unit, joined over the gaps; the gaps; and which readings are left (None: all)."""
    values = record.values
    if values.dtype.kind != "f" or np.isfinite(values.sum()):
        steps = np.diff(values) if record.kind == "angle" else values - record.constant
        return np.asarray(steps, dtype=np.float64), whole(steps.size), None
    there = np.flatnonzero(np.isfinite(values))
    if record.kind == "angle":
        return _stepped(values[there], there[:-1], np.diff(there))
    return np.asarray(values[there] - record.constant, dtype=np.float64), gaps_between(there), there


def gaps_between(left: IntArray) -> Gaps:
    """The gaps between readings of a rate that are left, by their places."""
    jumps = np.diff(left)
    at = np.flatnonzero(jumps > 1) + 1
    return Gaps(left.size, at, jumps[at - 1] - 1, np.zeros(at.size, dtype=np.bool_))


def _stepped(angle: FloatArray, there: IntArray, spans: IntArray) -> tuple[FloatArray, Gaps, IntArray | None]:
    """Steps of an angle of which points were lost: a short gap is one long step, a long one is cut out.

    Where quantization rules, only an angle that stays shut tells small noise of the rate.
    """
    steps = np.diff(angle)
    long = spans > 1
    shut = long & _short(steps, spans)
    # the rate during the gap is taken off, but for one interval's; over whole blocks no angle is open
    starts = np.arange(0, steps.size, BLOCK)
    rate = np.add.reduceat(steps, starts) / np.add.reduceat(spans, starts)
    steps[shut] -= rate[np.flatnonzero(shut) // BLOCK] * (spans[shut] - 1)
    kept = ~long | shut
    index = np.cumsum(kept) - 1
    opened = long & ~shut
    # of what is cut out every interval is lost, of a long step all but one; leading and trailing ones are no gaps
    at = np.concatenate((index[opened] + 1, index[shut]))
    lost = np.concatenate((spans[opened], spans[shut] - 1))
    flag = np.concatenate((np.zeros(int(opened.sum()), dtype=np.bool_), np.ones(int(shut.sum()), dtype=np.bool_)))
    return steps[kept], Gaps(int(kept.sum()), at, lost, flag), (there + (spans - 1) // 2)[kept]


def known_rates(record: Record) -> FloatArray:
    """Rates in the record's unit, NaN where nothing is known; over a short gap of an angle their mean is."""
    values = record.values
    if record.kind != "angle":
        return np.asarray(values, dtype=np.float64)
    there = np.flatnonzero(np.isfinite(values))
    spans = np.diff(there)
    steps = np.diff(values[there])
    known = (spans == 1) | _short(steps, spans)
    rates = np.full(record.size, np.nan)
    rates[there[0] : there[-1]] = np.repeat(np.where(known, steps / spans, np.nan), spans)
    return rates


def _short(steps: FloatArray, spans: IntArray) -> BoolArray:
    """Spans over which noise of the rate is at most half of what a step has."""
    fast = np.diff(steps[spans == 1])
    if fast.size < SHORTEST:
        return np.zeros(spans.size, dtype=np.bool_)
    # of steps of variance 2 q + w: differences have 6 q + 2 w, and correlate by -4 q - w from one to the next
    variance, beside = float(fast @ fast) / fast.size, float(fast[1:] @ fast[:-1]) / fast.size
    w = 2 * variance + 3 * beside
    q = (variance - 2 * w) / 6
    share = max(w / max(2 * q + w, 1e-300), LEAST_SHARE)
    return np.asarray(spans * share <= 0.5)


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
            left - pieces < NEIGHBOURS * left,
            f"of {left} that are left {left - pieces} have the next one too: single readings cannot tell noise of the "
            "rate from noise of the angle; choose a window (--from, --until); where only every so many readings one "
            "was kept, give the rate of those",
        ),
    )
    return next((f"{lost}; {reason}" for holds, reason in reasons if holds), "")
