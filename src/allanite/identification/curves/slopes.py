"""Lines of the textbook slopes: through the point with the nearest slope, or through a range of averaging times."""

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.curve import Curve
from allanite.core.errors import UsageError
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.ranges import demand_ranges
from allanite.phrases.phrase import say
from allanite.terms import TERMS

from .reading import early, result, signal_of

NEAR_SLOPE = 0.25
"""Difference between slopes up to which the curve is attributed to a term; slopes of terms differ by 0.5."""


def slopes(curve: Curve, symbols: Sequence[str]) -> Fit:
    """Coefficients from lines of the textbook slopes, each through the point where the local slope is closest."""

    def nearest(symbol: str, slope: float) -> tuple[IntArray, str]:
        local = local_slopes(curve)
        at = int(np.argmin(np.abs(local - slope)))
        far = say("{symbol}: no part of the curve has slope {slope:+g}, the nearest is {nearest:+.2f}; the value is "
                  "no evidence of the term", symbol=symbol, slope=slope, nearest=local[at])  # fmt: skip
        return np.array([at]), far if abs(local[at] - slope) > NEAR_SLOPE else ""

    return _through(curve, symbols, "slopes", nearest)


def piecewise(curve: Curve, symbols: Sequence[str], ranges: Mapping[str, tuple[float, float]] | None = None) -> Fit:
    """Coefficients from lines of the textbook slopes, each over a range of averaging times."""
    # Assumes that no other term contributes there, which is rarely true: the others make every value too large.
    signal_of(curve, 2)
    given = demand_ranges(ranges) if ranges is not None else {}
    if unknown := sorted(set(given) - set(symbols)):
        raise UsageError(f"ranges are given for {', '.join(unknown)}, but the terms are {', '.join(symbols)}")

    def inside(symbol: str, slope: float) -> tuple[IntArray, str]:
        which = within(curve, symbol, *given[symbol]) if symbol in given else stretch(curve, slope)
        if not which.size:
            return which, say("{symbol}: no part of the curve has a slope near {slope:+g}", symbol=symbol, slope=slope)
        start, end = curve.tau[which[0]], curve.tau[which[-1]]
        return which, say("{symbol}: fitted from {start:g} to {end:g} s", symbol=symbol, start=start, end=end)

    return _through(curve, symbols, "piecewise", inside)


def _through(
    curve: Curve, symbols: Sequence[str], method: str, choose: Callable[[str, float], tuple[IntArray, str]]
) -> Fit:
    """The mean of ``log sigma - slope log tau`` over the points that are chosen for each term; absent without any."""
    signal, log_tau, log_sigma = signal_of(curve, 2), np.log(curve.tau), np.log(curve.deviation)
    estimates, notes = [], []
    for symbol in symbols:
        row = TERMS[symbol]
        which, note = choose(symbol, row.slope)
        notes += [note] if note else []
        value, status = None, "absent"
        if which.size:
            line = float(np.mean(log_sigma[which] - row.slope * log_tau[which]))
            value, status = math.exp(line) / math.sqrt(row.level), "reported"
        estimates.append(Estimate(symbol, signal, value, None, status, None, method))
    return result(curve, estimates, method, notes=notes)


def local_slopes(curve: Curve, last: int | None = None) -> FloatArray:
    """Slopes of the deviation between neighbouring points in logarithms, up to a point."""
    return np.asarray(np.diff(np.log(curve.variance[:last])) / np.diff(np.log(curve.tau[:last])) / 2)


def within(curve: Curve, symbol: str, low: float, high: float) -> IntArray:
    """Indices of the points in a range of averaging times, s."""
    which = np.flatnonzero((curve.tau >= low * (1 - 1e-9)) & (curve.tau <= high * (1 + 1e-9)))
    if not which.size:
        raise UsageError(
            f"no point of the curve lies in the range {low:g} to {high:g} s of {symbol}; the points extend "
            f"from {curve.tau[0]:g} to {curve.tau[-1]:g} s"
        )
    return which


def stretch(curve: Curve, slope: float) -> IntArray:
    """Indices of the longest run of points, up to a tenth of the record, between which the curve is so steep."""
    local = local_slopes(curve, int(early(curve, 0.1).sum()))
    near = np.concatenate(([False], np.abs(local - slope) <= NEAR_SLOPE, [False]))
    starts, ends = np.flatnonzero(near[1:] & ~near[:-1]), np.flatnonzero(~near[1:] & near[:-1])
    if not starts.size:
        return np.empty(0, np.int64)
    longest = int(np.argmax(ends - starts))
    return np.arange(starts[longest], ends[longest] + 1)
