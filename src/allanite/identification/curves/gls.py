"""Generalized least squares: the optimal fit of a curve, given its covariance."""

from collections.abc import Sequence
from functools import lru_cache
from math import inf, isfinite, sqrt

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.curve import Curve
from allanite.core.errors import DataError
from allanite.core.estimate import WEAK, Estimate
from allanite.core.fit import Fit
from allanite.core.limits import Remembered
from allanite.core.model import Model, Term
from allanite.core.units import Signal
from allanite.phrases.phrase import join, say
from allanite.statistics.moments.moments import covariance_by_term
from allanite.statistics.table import STATISTICS
from allanite.terms import TERMS

from .inversion import Inverted, RatioLimits
from .leastsquares import Moments, iterated, whitened
from .reading import blind, columns, early, plain, result, rows_of, signal_of, unit_model

LONGEST_SHARE = 0.25
"""Share of the record up to which averaging times are read; half of the longest one where that is more.

There Theo1 has about as many degrees of freedom as the Allan variance at a quarter of the record. Farther out
the limits hold the truth less often, and what is gained are coefficients that remain unknown (docs/methods.md).
"""

INTEGRATED_TERMS = 3  # terms of the longest memory that are integrated over to obtain the limits of each other
CLAIM = 4.0  # likelihood ratio of a term against its absence above which it is claimed


@lru_cache(maxsize=64)
def moments_of(names: tuple[str, ...], symbols: tuple[str, ...], m: tuple[int, ...], size: int, rate: float) -> Moments:
    """Moments of points: the statistic and the averaging factor of each."""
    X = columns(names, symbols, m, size, rate)
    rows = [STATISTICS[name] for name in names]
    return Moments(X, covariance_by_term(rows, unit_model(symbols), np.array(m), size, rate))


def gls(curve: Curve, symbols: Sequence[str]) -> Fit:
    """Generalized least squares of the variance with the covariance of the points under the model itself."""
    # ``min (V - X theta)' C(theta)^-1 (V - X theta)``, theta >= 0 the squares of the coefficients, at octaves up to a
    # quarter of the record, or to half of the longest averaging time of the statistic (3/8 of the record for theo1,
    # theobr and theoh); C is iterated, beginning with relative weights (after Vaccaro and Zaki, IEEE Trans. Instrum.
    # Meas. 61, 2012, 673). Standard errors are the roots of the diagonal of ``(X' C^-1 X)^-1``; limits are the values
    # that the likelihood ratio of `inversion` does not reject.
    signal = signal_of(curve, 1)
    which = octaves(curve)
    if which.size < len(symbols):
        raise DataError(say("{size} octaves up to {percent:g} % of the record are too few for {count} terms",
                            size=which.size, percent=100 * reach(curve), count=len(symbols)))  # fmt: skip
    m, symbols = curve.m[which], tuple(symbols)
    rows = rows_of(curve)
    names = tuple(rows[i].name for i in which.tolist())
    moments = moments_of(names, symbols, tuple(m.tolist()), curve.size, curve.rate)
    complete = np.array([row.count(curve.size, m[None])[0] for row, m in zip(rows, curve.m, strict=True)])
    # points with missing windows scatter more, roughly in proportion
    more = np.sqrt(complete[which] / curve.count[which])
    moments = Moments(moments.columns, moments.products * np.outer(more, more)[:, :, None, None])
    variance = plain(curve)[which]
    theta, covariance = iterated(moments, variance)
    model = Model(tuple(Term(s, sqrt(v), signal) for s, v in zip(symbols, theta.tolist(), strict=True) if v > 0))
    notes = [_read_from(curve, which), *blind(curve.statistic, signal, symbols, moments.columns)]
    if np.any(curve.count < complete):
        notes.append(
            say("the record has gaps: the covariance is that of a complete record, scaled by the missing windows")
        )
    estimates = _estimates(symbols, moments, variance, theta=theta, covariance=covariance, signal=signal)
    notes.append(_goodness(moments.columns, variance, theta, covariance))
    notes += [
        say("{symbol} is given without its sign, which a curve does not determine", symbol=e.symbol)
        for e in estimates
        if TERMS[e.symbol].waveform is not None and e.value
    ]
    return result(curve, estimates, "gls", notes=notes, model=model)


def octaves(curve: Curve) -> IntArray:
    """Indices of the points nearest to octaves of the first tau, as far as averaging times are read."""
    log_tau = np.log2(curve.tau[early(curve, reach(curve))] / curve.tau[0])
    if not log_tau.size:
        return np.empty(0, np.int64)
    wanted = np.arange(round(log_tau[-1]) + 1)
    return np.unique(np.abs(log_tau[:, None] - wanted).argmin(axis=0))


def reach(curve: Curve) -> float:
    """Share of the record up to which averaging times are read."""
    return max(LONGEST_SHARE, STATISTICS[curve.statistic].longest / 2)


def _read_from(curve: Curve, which: IntArray) -> str:
    omitted = int(early(curve, reach(curve)).sum()) - which.size
    tau = curve.tau[which]
    read = say("fitted to {count} points of {statistic}, {start:g} to {end:g} s",
               count=which.size, statistic=curve.statistic, start=tau[0], end=tau[-1])  # fmt: skip
    if not omitted:
        return read
    more = say("{count} more between these octaves would add no information and are omitted", count=omitted)
    return join("; ", (read, more))


def _goodness(X: FloatArray, variance: FloatArray, theta: FloatArray, covariance: FloatArray) -> str:
    from scipy.special import chdtrc

    freedom = variance.size - np.count_nonzero(theta)
    A, b = whitened(X, variance, covariance)
    square = float(((b - A @ theta) ** 2).sum())
    p = f"p = {chdtrc(freedom, square):.2g}" if freedom else say("no degrees of freedom left for a test")
    return say("goodness of fit: chi-square {square:.1f} with {count} degrees of freedom, {p}",
               square=square, count=freedom, p=p)  # fmt: skip


def _estimates(
    symbols: Sequence[str], moments: Moments, variance: FloatArray, *, theta: FloatArray, covariance: FloatArray,
    signal: Signal,
) -> list[Estimate]:  # fmt: skip
    error = standard_errors(moments.columns, variance, covariance)
    observed = [i for i in range(len(symbols)) if isfinite(error[i])]
    slow = sorted(observed, key=lambda i: TERMS[symbols[i]].slope)[-INTEGRATED_TERMS:]
    ratios = RatioLimits(moments.columns, moments.products, variance, theta, error, tuple(slow))
    estimates = []
    for i, (symbol, square, spread) in enumerate(zip(symbols, theta.tolist(), error.tolist(), strict=True)):
        limits = Inverted(ratios, i)
        upper, both = Remembered(limits.upper), Remembered(limits)
        highest = upper(0.95) if isfinite(spread) else None
        if not square or limits.evidence <= CLAIM:
            estimates.append(Estimate(symbol, signal, None, None, "absent", highest, "gls", both, both))
            continue
        value = sqrt(square)
        status = "identified" if spread <= 2 * square * WEAK else "weak"
        estimates.append(Estimate(symbol, signal, value, spread / (2 * value), status, highest, "gls", both, both))
    return estimates


def standard_errors(X: FloatArray, variance: FloatArray, covariance: FloatArray) -> FloatArray:
    """Standard errors of the squares, with every term free, shape (t,); infinite for a term that is not observed."""
    A, _ = whitened(X, variance, covariance)
    size = np.sqrt((A**2).sum(axis=0))
    observed = size > 0
    A = A[:, observed] / size[observed]
    error = np.full(size.shape, inf)
    error[observed] = np.sqrt(np.diag(np.linalg.inv(A.T @ A))) / size[observed]
    return error
