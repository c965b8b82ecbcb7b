"""Lines of the textbook slopes, each through a range of averaging times."""

from collections.abc import Mapping, Sequence

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

NEAR = 0.25
"""Difference between slopes up to which the curve is attributed to a term; slopes of terms differ by 0.5."""


def piecewise(curve: Curve, symbols: Sequence[str], ranges: Mapping[str, tuple[float, float]] | None = None) -> Fit:
    """Coefficients from the mean of ``log sigma - slope log tau`` over a range of averaging times for each term.

    Assumes that no other term contributes there, which is rarely true: the others make every value too large.
    """
    signal = signal_of(curve, 2)
    given = demand_ranges(ranges) if ranges is not None else {}
    if unknown := sorted(set(given) - set(symbols)):
        raise UsageError(f"ranges are given for {', '.join(unknown)}, but the terms are {', '.join(symbols)}")
    log_tau, log_sigma = np.log(curve.tau), np.log(curve.deviation)
    estimates, notes = [], []
    for symbol in symbols:
        row = TERMS[symbol]
        if symbol in given:
            low, high = given[symbol]
            which = np.flatnonzero((curve.tau >= low * (1 - 1e-9)) & (curve.tau <= high * (1 + 1e-9)))
            if not which.size:
                raise UsageError(
                    f"no point of the curve lies in the range {low:g} to {high:g} s of {symbol}; the points extend "
                    f"from {curve.tau[0]:g} to {curve.tau[-1]:g} s"
                )
        else:
            which = stretch(curve, row.slope)
        if not which.size:
            estimates.append(Estimate(symbol, signal, None, None, "absent", None, "piecewise"))
            notes.append(
                say("{symbol}: no part of the curve has a slope near {slope:+g}", symbol=symbol, slope=row.slope)
            )
            continue
        line = float(np.mean(log_sigma[which] - row.slope * log_tau[which]))
        value = float(np.exp(line)) / np.sqrt(row.level)
        estimates.append(Estimate(symbol, signal, float(value), None, "reported", None, "piecewise"))
        notes.append(
            say(
                "{symbol}: fitted from {start:g} to {end:g} s",
                symbol=symbol,
                start=curve.tau[which[0]],
                end=curve.tau[which[-1]],
            )
        )
    return result(curve, estimates, "piecewise", notes=notes)


def stretch(curve: Curve, slope: float) -> IntArray:
    """Indices of the longest run of points, up to a tenth of the record, between which the curve is so steep."""
    last = int(early(curve, 0.1).sum())
    local: FloatArray = np.diff(np.log(curve.variance[:last])) / np.diff(np.log(curve.tau[:last])) / 2
    near = np.concatenate(([False], np.abs(local - slope) <= NEAR, [False]))
    starts, ends = np.flatnonzero(near[1:] & ~near[:-1]), np.flatnonzero(~near[1:] & near[:-1])
    if not starts.size:
        return np.empty(0, np.int64)
    longest = int(np.argmax(ends - starts))
    return np.arange(starts[longest], ends[longest] + 1)
