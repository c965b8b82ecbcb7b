"""Non-negative least squares, and the fit with equal relative weights used by many programs."""

from collections.abc import Sequence

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.curve import Curve
from allanite.core.errors import UsageError
from allanite.core.fit import Fit
from allanite.core.kinds import title_of
from allanite.core.model import Model, Term
from allanite.core.units import SIGNALS, Signal
from allanite.phrases.phrase import say
from allanite.statistics.moments.moments import by_term
from allanite.statistics.table import STATISTICS
from allanite.terms import TERMS

from .reading import early, reported, result, rows_of, signal_of


def nnls(curve: Curve, symbols: Sequence[str]) -> Fit:
    """Non-negative squares of the coefficients that fit the variance with equal relative weights, up to tau = T/10.

    The much larger scatter of points at long tau is not taken into account. Farther out the well determined terms only
    become worse, whichever the statistic (docs/methods.md).
    """
    signal = signal_of(curve, 1)
    which = early(curve, 0.1)
    used = int(which.sum())
    if used < len(symbols):
        raise UsageError(
            f"{used} points at averaging times up to a tenth of the record are too few for {len(symbols)} terms"
        )
    m, variance = curve.m[which], plain(curve)[which]
    names = [row.name for row, used in zip(rows_of(curve), which.tolist(), strict=True) if used]
    X = columns(names, symbols, m.tolist(), curve.size, curve.rate)
    squares = solve(X, variance, np.diag(variance**2))
    notes = [
        say(
            "fitted to {count} points of {statistic} up to {tau:g} s, a tenth of the record",
            count=used,
            statistic=curve.statistic,
            tau=curve.tau[which][-1],
        ),
        *blind(curve.statistic, signal, symbols, X),
    ]
    return result(curve, reported(symbols, squares, X, signal=signal, method="nnls"), "nnls", notes=notes)


def plain(curve: Curve) -> FloatArray:
    """The variance without a correction of its bias, nor the bias ratio of a hybrid, shape of tau."""
    return np.asarray(curve.variance / curve.factor)


def columns(names: Sequence[str], symbols: Sequence[str], m: Sequence[int], size: int, rate: float) -> FloatArray:
    """Expected variance of each term with a coefficient of 1 in SI, shape (k, t); 0 if only rounding remains.

    `names` are the statistics of the points.
    """
    rows = [STATISTICS[name] for name in names]
    X = np.array([by_term(row, unit_model(symbols), k, size, rate) for row, k in zip(rows, m, strict=True)])
    tau = np.array(m) * [row.tau_factor for row in rows] / rate
    lines = np.column_stack([TERMS[s].level * tau ** (2 * TERMS[s].slope) for s in symbols])
    return X * (X / lines > 1e-9)


def unit_model(symbols: Sequence[str]) -> Model:
    """Every term with a coefficient of 1 in SI; the type of sensor does not affect the numbers."""
    return Model(tuple(Term(s, 1.0, SIGNALS[0]) for s in symbols))


def blind(statistic: str, signal: Signal, symbols: Sequence[str], X: FloatArray) -> list[str]:
    """Notes about the terms to which a statistic is insensitive."""
    return [
        say(
            "{symbol}: {statistic} is insensitive to {term}",
            symbol=s,
            statistic=statistic,
            term=title_of(s, signal),
        )
        for s, column in zip(symbols, X.T, strict=True)
        if not column.any()
    ]


def solve(X: FloatArray, variance: FloatArray, covariance: FloatArray) -> FloatArray:
    """Squares theta >= 0 that minimize the quadratic form of the residuals, shape (t,)."""
    from scipy.optimize import nnls as solver

    A, b = whitened(X, variance, covariance)
    size = np.sqrt((A**2).sum(axis=0))
    size[size == 0] = 1.0
    return np.asarray(solver(A / size, b)[0] / size)


def whitened(X: FloatArray, variance: FloatArray, covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Columns and values in units of independent standard errors."""
    from scipy.linalg import cholesky, solve_triangular

    L = cholesky(covariance / np.outer(variance, variance), lower=True)
    A = solve_triangular(L, X / variance[:, None], lower=True)
    return A, solve_triangular(L, np.ones_like(variance), lower=True)
