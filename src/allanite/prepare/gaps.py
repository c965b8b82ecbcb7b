"""Missing samples: the remaining ones are joined, and the effect of the joints on each term is computed.

Gaps are cut out, and the transform is taken of the n remaining samples with g joints. White noise and flicker are
hardly affected. Quantization loses the angle that the two samples at a joint would share, as at the ends of a record.
A random walk continues unobserved during the gap, so that the joined record has a step at the joint.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray, IntArray
from allanite.core.record import SHORTEST, Record
from allanite.kernels import cosine
from allanite.phrases.phrase import join, say, spelled, windowing
from allanite.terms import NoiseTerm

EXACT = 64  # number of coefficients for which the positions of the joints matter; above, their average effect is used

FEW = say("too few for noise coefficients (at least {count})", count=SHORTEST)

LEAST = 0.1  # share of the samples that must remain
RATE_BLOCK = 1024  # steps of an angle over which its rate is assumed constant, to be subtracted during a gap
LEAST_SHARE = 0.005  # share of the rate noise in the noise of a step below which it cannot be determined
NEIGHBOURS = 0.1  # share of the remaining samples that must have a neighbour


@dataclass(frozen=True, eq=False)
class Gaps:
    """The gaps among `size` remaining samples: `at` is the first sample after each, `lost` the number missing."""

    size: int
    at: IntArray
    lost: IntArray
    shut: BoolArray  # an angle was accumulated: the sample there is the increment over lost + 1 intervals

    def first(self, size: int) -> "Gaps":
        """The gaps among the first samples."""
        kept = self.at < size
        return Gaps(size, self.at[kept], self.lost[kept], self.shut[kept])

    def row(self, term: NoiseTerm, k: FloatArray) -> FloatArray:
        """Variance of the k-th coefficients under a term, shape of `k`."""
        # With the first samples j after the gaps, the numbers missing l and omega = pi k / n
        #     edge (2/n) sum [cos(2 omega j) + cos(omega)]      is added by an open angle,
        #     1 + (2/n) sum l sin^2(omega j)                    the factor of a random walk,
        #     (1/n) sum [D(l + 1) - D(1)]                       is added by a shut gap, for angle noise,
        # and on average over k the first cosine is 0, the square of the sine 1/2. Noise between these is not changed.
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
        ends = (term.edge + term.ends) * (2 / n) * (both + opened.size * np.cos((np.pi / n) * k))
        D: Callable[[FloatArray], FloatArray] = term.structure if term.slope <= -0.5 else np.ones_like
        longer = float((D(shut) - D(np.ones(1))).sum()) / n
        return np.asarray(values * (1 + steps / n) ** walk + ends + longer)


def whole(size: int) -> Gaps:
    """No gaps among this many samples."""
    none = np.empty(0, np.int64)
    return Gaps(size, none, none, none.astype(np.bool_))


def joined(record: Record) -> tuple[FloatArray, Gaps, IntArray | None]:
    """Rates in the record's unit, joined over the gaps; the gaps; indices of the remaining samples (None: all)."""
    values = record.values
    if record.kind != "angle":
        y, total = cosine.less_constant(values, record.constant)
        if np.isfinite(total):
            return y, whole(y.size), None
    elif record.complete:
        return np.asarray(np.diff(values), dtype=np.float64), whole(values.size - 1), None
    remaining = np.flatnonzero(np.isfinite(values))
    if record.kind == "angle":
        # a short gap is one long step, a long one is cut out: where quantization dominates, small rate noise can be
        # determined only from a continuous angle
        spans, steps = np.diff(remaining), np.diff(values[remaining])
        long = spans > 1
        shut = long & _short(steps, spans)
        # the rate during the gap is subtracted, except for one interval; over whole blocks no angle is open
        starts = np.arange(0, steps.size, RATE_BLOCK)
        rate = np.add.reduceat(steps, starts) / np.add.reduceat(spans, starts)
        steps[shut] -= rate[np.flatnonzero(shut) // RATE_BLOCK] * (spans[shut] - 1)
        kept = ~long | shut
        index = np.cumsum(kept) - 1
        opened = long & ~shut
        # in a gap cut out, all intervals are missing, in a long step all but one; gaps at the ends do not count
        at = np.concatenate((index[opened] + 1, index[shut]))
        lost = np.concatenate((spans[opened], spans[shut] - 1))
        flag = np.concatenate((np.zeros(int(opened.sum()), dtype=np.bool_), np.ones(int(shut.sum()), dtype=np.bool_)))
        return steps[kept], Gaps(int(kept.sum()), at, lost, flag), (remaining[:-1] + (spans - 1) // 2)[kept]
    return np.asarray(values[remaining] - record.constant, dtype=np.float64), gaps_between(remaining), remaining


def gaps_between(left: IntArray) -> Gaps:
    """The gaps between the remaining samples of a rate, by their positions."""
    jumps = np.diff(left)
    at = np.flatnonzero(jumps > 1) + 1
    return Gaps(left.size, at, jumps[at - 1] - 1, np.zeros(at.size, dtype=np.bool_))


def known_rates(record: Record) -> FloatArray:
    """Rates in the record's unit, NaN where unknown; over a short gap of an angle, their mean."""
    values = record.values
    if record.kind != "angle":
        return np.asarray(values, dtype=np.float64)
    remaining = np.flatnonzero(np.isfinite(values))
    spans = np.diff(remaining)
    steps = np.diff(values[remaining])
    known = (spans == 1) | _short(steps, spans)
    rates = np.full(record.size, np.nan)
    rates[remaining[0] : remaining[-1]] = np.repeat(np.where(known, steps / spans, np.nan), spans)
    return rates


def _short(steps: FloatArray, spans: IntArray) -> BoolArray:
    """Spans over which rate noise is at most half of the noise of a step."""
    fast = np.diff(steps[spans == 1])
    if fast.size < SHORTEST:
        return np.zeros(spans.size, dtype=np.bool_)
    # for steps of variance 2 q + w: differences have variance 6 q + 2 w and lag-one covariance -4 q - w
    variance, beside = float(fast @ fast) / fast.size, float(fast[1:] @ fast[:-1]) / fast.size
    w = 2 * variance + 3 * beside
    q = (variance - 2 * w) / 6
    share = max(w / max(2 * q + w, 1e-300), LEAST_SHARE)
    return np.asarray(spans * share <= 0.5)


def refusal(record: Record) -> str:
    """Why no noise can be identified from this record or its remaining samples; empty if it can."""
    if record.size < SHORTEST:
        return say("{count} samples are {too_few}", count=record.size, too_few=FEW)
    if record.out_of_range:
        return record.out_of_range
    if record.complete:
        return ""
    gaps = joined(record)[1]
    count, pieces = gaps.size, gaps.at.size + 1
    lost = say("{lost} of {size} samples are missing", lost=record.size - count, size=record.size)
    reasons = (
        (count < SHORTEST, say("{left} remain, {too_few}", left=count, too_few=FEW)),
        (count < LEAST * record.size,
         say("less than a tenth remains, too little to determine slow noise; choose a window ({choice})",
             choice=windowing())),
        (count - pieces < NEIGHBOURS * count,
         say("of {left} that remain, {followed} are followed by the next one: isolated samples cannot separate "
             "rate noise from angle noise; choose a window ({choice}), or {apart}",
             left=count, followed=count - pieces, choice=windowing(),
             apart=spelled(say("read by themselves the channels that have samples in the same rows (--channels)"),
                           say("make a record of these samples alone, at their rate: values[::2]")))),
    )  # fmt: skip
    return next((join("; ", (lost, reason)) for holds, reason in reasons if holds), "")
