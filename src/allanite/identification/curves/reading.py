"""What the methods that fit a curve have in common: its points, what terms are expected to make of them, the fit."""

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray, IntArray
from allanite.core.curve import Curve
from allanite.core.errors import DataError, UsageError
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.kinds import title_of
from allanite.core.model import Model, Term
from allanite.core.ranges import demand_ranges
from allanite.core.units import SIGNALS, Signal
from allanite.phrases.phrase import join, say
from allanite.statistics.moments.moments import by_term
from allanite.statistics.row import Statistic
from allanite.statistics.table import STATISTICS
from allanite.terms import TERMS

VISIBLE = 1e-9  # expectation over that of the textbook's line above which a statistic shows a term: less is rounding


def signal_of(curve: Curve, points: int) -> Signal:
    """The signal of a curve."""
    if curve.tau.size < points or not np.all(curve.variance > 0):
        raise DataError(say("this method needs at least {points} points, none of them zero; there are {size}",
                            points=points, size=curve.tau.size))  # fmt: skip
    for signal in SIGNALS:
        if signal.unit == curve.unit:
            return signal
    raise UsageError(f"this method needs a curve in SI, not in {curve.unit}; omit .to()")


def rows_of(curve: Curve) -> tuple[Statistic, ...]:
    """The statistic that makes each point: of theoh oadev up to the joint and Theo1 beyond, of others the same."""
    row = STATISTICS[curve.statistic]
    parts = row.parts or (row,)
    factor = curve.tau * curve.rate / curve.m
    nearest = np.abs(factor[:, None] - [part.tau_factor for part in parts]).argmin(axis=1)
    return tuple(parts[i] for i in nearest.tolist())


def early(curve: Curve, share: float) -> BoolArray:
    """Which points average over at most this share of the record, shape of tau."""
    if not curve.size:
        raise UsageError("this method needs the length of the record, but the curve's size is 0")
    return np.asarray(curve.tau <= share * curve.size / curve.rate * (1 + 1e-9))


def plain(curve: Curve) -> FloatArray:
    """The variance without a correction of its bias, nor the bias ratio of a hybrid, shape of tau."""
    return np.asarray(curve.variance / curve.factor)


def columns(names: Sequence[str], symbols: Sequence[str], m: Sequence[int], size: int, rate: float) -> FloatArray:
    """Expected variance of each term with a coefficient of 1 in SI, shape (k, t); 0 if only rounding remains."""
    # `names` are the statistics of the points.
    rows = [STATISTICS[name] for name in names]
    X = np.array([by_term(row, unit_model(symbols), k, size, rate) for row, k in zip(rows, m, strict=True)])
    tau = np.array(m) * [row.tau_factor for row in rows] / rate
    return X * (X / textbook(symbols, tau) > VISIBLE)


def textbook(symbols: Sequence[str], tau: FloatArray) -> FloatArray:
    """The textbook's lines of the Allan variance: of each term with a coefficient of 1 in SI, shape (k, t)."""
    return np.column_stack([TERMS[s].level * tau ** (2 * TERMS[s].slope) for s in symbols])


def unit_model(symbols: Sequence[str]) -> Model:
    """Every term with a coefficient of 1 in SI; the type of sensor does not affect the numbers."""
    return Model(tuple(Term(s, 1.0, SIGNALS[0]) for s in symbols))


def blind(statistic: str, signal: Signal, symbols: Sequence[str], X: FloatArray) -> list[str]:
    """Notes about the terms to which a statistic is insensitive."""
    return [
        say("{symbol}: {statistic} is insensitive to {term}", symbol=s, statistic=statistic, term=title_of(s, signal))
        for s, column in zip(symbols, X.T, strict=True)
        if not column.any()
    ]


def reported(
    symbols: Sequence[str], squares: FloatArray, columns: FloatArray, *, signal: Signal, method: str
) -> list[Estimate]:
    """Roots of squares, with the sign of these, without evidence for any term; one whose column is empty is absent."""
    roots = np.copysign(np.sqrt(np.abs(squares)), squares).tolist()
    return [
        Estimate(s, signal, root, None, "reported" if root >= 0 else "negative", None, method)
        if shown
        else Estimate(s, signal, None, None, "absent", None, method)
        for s, root, shown in zip(symbols, roots, np.abs(columns).max(axis=0) > 0, strict=True)
    ]


def result(
    curve: Curve, estimates: Sequence[Estimate], method: str, *, notes: Sequence[str], model: Model | None = None
) -> Fit:
    """The fit; its model, unless given, contains the terms estimated above zero."""
    signal = estimates[0].signal
    terms = tuple(Term(e.symbol, e.value, signal) for e in estimates if e.value is not None and e.value > 0)
    if model is None and not terms:
        raise DataError(
            say("method {method!r} finds none of the terms: {reasons}", method=method, reasons=join("; ", notes))
        )
    return Fit(
        tuple(estimates), method, signal, model or Model(terms), name=curve.name, curve=curve, notes=tuple(notes)
    )


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
