"""The classical fits of an Allan variance curve, for comparison; none gives intervals or evidence."""

import math
from collections.abc import Sequence

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.curve import Curve
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.phrases.phrase import say
from allanite.terms import TERMS

from .nonnegative import solve
from .reading import reported, result, signal_of


def least_squares(curve: Curve, symbols: Sequence[str]) -> Fit:
    """Unweighted least squares of the variance by powers of tau, as in much of the literature.

    All points have the same absolute weight, so that the shortest tau dominates: the errors are 2 to 90 times the
    Cramer-Rao bound. A square may come out negative; this is reported.
    """
    signal = signal_of(curve, len(symbols))
    columns = lines(curve, symbols)
    size = np.abs(columns).max(axis=0)
    squares = np.linalg.lstsq(columns / size, curve.variance, rcond=None)[0] / size
    roots = np.copysign(np.sqrt(np.abs(squares)), squares).tolist()
    estimates = [
        Estimate(s, signal, root, None, "reported" if square >= 0 else "negative", None, "ls")
        for s, root, square in zip(symbols, roots, squares, strict=True)
    ]
    notes = [
        say(
            "the least-squares fit gives a negative {symbol}^2, which has no physical meaning and shows that "
            "this fit is unreliable for the other terms, too",
            symbol=e.symbol,
        )
        for e in estimates
        if e.status == "negative"
    ]
    return result(curve, estimates, "ls", notes=notes)


def lines(curve: Curve, symbols: Sequence[str]) -> FloatArray:
    """The textbook's lines of the Allan variance: of each term with a coefficient of 1 in SI, shape (k, t)."""
    return np.column_stack([TERMS[s].level * curve.tau ** (2 * TERMS[s].slope) for s in symbols])


def whole(curve: Curve, symbols: Sequence[str]) -> Fit:
    """Unweighted least squares of all points of the curve as it is drawn, no square below zero.

    The same lines as `least_squares`, at about a hundred averaging times up to the longest of the statistic, where one
    or two degrees of freedom are left. Of a hybrid the variance contains its bias ratio, as in the papers that
    recommend it (Tang, Cheng and Gao, Acta Armamentarii 36, 2015, 1688); the lines are those of the Allan variance.
    """
    signal = signal_of(curve, len(symbols))
    columns = lines(curve, symbols)
    squares = solve(columns, curve.variance, np.eye(curve.tau.size) * curve.variance.mean() ** 2)
    note = say(
        "fitted to all {count} points of {statistic}, {start:g} to {end:g} s",
        count=curve.tau.size, statistic=curve.statistic, start=curve.tau[0], end=curve.tau[-1],
    )  # fmt: skip
    return result(curve, reported(symbols, squares, columns, signal=signal, method="curve"), "curve", notes=[note])


def slopes(curve: Curve, symbols: Sequence[str]) -> Fit:
    """Coefficients from lines of the textbook slopes, each through the point where the local slope is closest."""
    signal = signal_of(curve, 2)
    log_tau, log_sigma = np.log10(curve.tau), np.log10(curve.deviation)
    local = np.diff(log_sigma) / np.diff(log_tau)
    estimates, notes = [], []
    for symbol in symbols:
        row = TERMS[symbol]
        at = int(np.argmin(np.abs(local - row.slope)))
        intercept = log_sigma[at] - row.slope * log_tau[at]
        value = float(10.0**intercept) / math.sqrt(row.level)
        estimates.append(Estimate(symbol, signal, value, None, "reported", None, "slopes"))
        if abs(local[at] - row.slope) > 0.25:
            notes.append(
                say(
                    "{symbol}: no part of the curve has slope {slope:+g}, the nearest is {nearest:+.2f}; the value is "
                    "no evidence of the term",
                    symbol=symbol,
                    slope=row.slope,
                    nearest=local[at],
                )
            )
    return result(curve, estimates, "slopes", notes=notes)
