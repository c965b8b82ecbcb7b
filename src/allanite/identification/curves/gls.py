"""Generalized least squares: the optimal fit of a curve, given its covariance."""

from collections.abc import Sequence
from dataclasses import dataclass
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
from allanite.statistics.moments.moments import covariance_by_term, relative
from allanite.statistics.table import STATISTICS
from allanite.terms import TERMS

from .inversion import Inverted, RatioLimits
from .nonnegative import blind, columns, plain, solve, unit_model, whitened
from .reading import early, result, rows_of, signal_of

ROUNDS = 8
"""Iterations of the fit and the covariance under it; three to five suffice."""

REACH = 0.25
"""Share of the record up to which averaging times are read; half of the longest one where that is more.

There Theo1 has about as many degrees of freedom as the Allan variance at a quarter of the record. Farther out
the limits hold the truth less often, and what is gained are coefficients that remain unknown (docs/methods.md).
"""

SLOW = 3
"""Terms of the longest memory that are integrated over to obtain the limits of each other."""

CLAIM = 4.0
"""Likelihood ratio of a term against its absence above which it is claimed."""


@dataclass(frozen=True)
class Moments:
    """Moments of the points of a curve under terms with coefficients of 1: `columns`, shape (k, t), is the expectation.

    `products`, shape (k, k, t, t), is what each pair of terms adds to the covariance.
    """

    columns: FloatArray
    products: FloatArray

    def covariance(self, theta: FloatArray) -> FloatArray:
        """Covariance of the points for squares `theta` of the coefficients, shape (k, k)."""
        return np.asarray(np.einsum("ijab,a,b", self.products, theta, theta))


@lru_cache(maxsize=64)
def moments_of(names: tuple[str, ...], symbols: tuple[str, ...], m: tuple[int, ...], size: int, rate: float) -> Moments:
    """Moments of points: the statistic and the averaging factor of each."""
    X = columns(names, symbols, m, size, rate)
    rows = [STATISTICS[name] for name in names]
    return Moments(X, covariance_by_term(rows, unit_model(symbols), np.array(m), size, rate))


def variances(name: str, symbols: Sequence[str], m: Sequence[int], size: int, rate: float) -> FloatArray:
    """The diagonal of `Moments.products`, 2 E_i E_j r_ij, which is 2 E^2 / EDF of a mixture; the rest is 0."""
    X = columns([name] * len(m), symbols, m, size, rate)
    terms = [t.sampled(rate) for t in unit_model(symbols)]
    found = np.zeros((len(m), len(m), len(symbols), len(symbols)))
    for i, k in enumerate(m):
        found[i, i] = 2 * np.outer(X[i], X[i]) * relative(STATISTICS[name], terms, k, [(size, 1)])
    return found


def iterated(moments: Moments, variance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Squares of the coefficients, shape (t,), and the covariance of the points under them, shape (k, k)."""
    X = moments.columns
    theta = solve(X, variance, np.diag(variance**2))
    covariance = _scatter(moments, theta)
    for _ in range(ROUNDS):
        before, theta = theta, solve(X, variance, covariance)
        covariance = _scatter(moments, theta)
        if np.allclose(X * theta, X * before, rtol=1e-6, atol=1e-6 * variance.min()):
            break
    return theta, covariance


def _scatter(moments: Moments, theta: FloatArray) -> FloatArray:
    covariance = moments.covariance(theta)
    if not np.all(np.diag(covariance) > 0):
        raise DataError(say("a ramp alone describes the curve best: without noise its accuracy cannot be determined"))
    return covariance


def gls(curve: Curve, symbols: Sequence[str]) -> Fit:
    """Generalized least squares of the variance with the covariance of the points under the model itself.

    ``min (V - X theta)' C(theta)^-1 (V - X theta)``, theta >= 0 the squares of the coefficients, at octaves up to a
    quarter of the record, or to half of the longest averaging time of the statistic (3/8 of the record for theo1,
    theobr and theoh); C is iterated, beginning with relative weights (after Vaccaro and Zaki, IEEE Trans. Instrum.
    Meas. 61, 2012, 673). Standard errors are the roots of the diagonal of ``(X' C^-1 X)^-1``; limits
    are the values that the likelihood ratio of `inversion` does not reject.
    """
    signal = signal_of(curve, 1)
    which = octaves(curve)
    if which.size < len(symbols):
        raise DataError(
            say(
                "{size} octaves up to {percent:g} % of the record are too few for {count} terms",
                size=which.size,
                percent=100 * reach(curve),
                count=len(symbols),
            )
        )
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
    estimates = _estimates(symbols, moments, variance, (theta, covariance), signal)
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
    return max(REACH, STATISTICS[curve.statistic].longest / 2)


def _read_from(curve: Curve, which: IntArray) -> str:
    left = int(early(curve, reach(curve)).sum()) - which.size
    tau = curve.tau[which]
    read = say("fitted to {count} points of {statistic}, {start:g} to {end:g} s",
               count=which.size, statistic=curve.statistic, start=tau[0], end=tau[-1])  # fmt: skip
    if not left:
        return read
    more = say("{count} more between these octaves would add no information and are omitted", count=left)
    return join("; ", (read, more))


def _goodness(X: FloatArray, variance: FloatArray, theta: FloatArray, covariance: FloatArray) -> str:
    from scipy.special import chdtrc

    freedom = variance.size - np.count_nonzero(theta)
    A, b = whitened(X, variance, covariance)
    square = float(((b - A @ theta) ** 2).sum())
    p = f"p = {chdtrc(freedom, square):.2g}" if freedom else say("no degrees of freedom left for a test")
    return say(
        "goodness of fit: chi-square {square:.1f} with {count} degrees of freedom, {p}",
        square=square,
        count=freedom,
        p=p,
    )


def _estimates(
    symbols: Sequence[str], moments: Moments, variance: FloatArray, found: tuple[FloatArray, FloatArray], signal: Signal
) -> list[Estimate]:
    theta, covariance = found
    error = standard_errors(moments.columns, variance, covariance)
    seen = [i for i in range(len(symbols)) if isfinite(error[i])]
    slow = sorted(seen, key=lambda i: TERMS[symbols[i]].slope)[-SLOW:]
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
    seen = size > 0
    A = A[:, seen] / size[seen]
    error = np.full(size.shape, inf)
    error[seen] = np.sqrt(np.diag(np.linalg.inv(A.T @ A))) / size[seen]
    return error
