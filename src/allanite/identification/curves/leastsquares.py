"""Least squares of a curve's variance: as papers do, of Allan and Hadamard variance together, and generalized.

Both variances together separate a ramp from a rate random walk; the generalized fit is optimal given the covariance.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import inf, isfinite, sqrt

import numpy as np
import scipy

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.curve import Curve
from allanite.core.errors import DataError, UsageError
from allanite.core.estimate import WEAK, Estimate
from allanite.core.fit import Fit
from allanite.core.limits import Remembered
from allanite.core.model import Model, Term
from allanite.core.record import Record
from allanite.core.units import Signal
from allanite.phrases.phrase import join, say
from allanite.statistics import deviation
from allanite.statistics.moments.moments import covariance_by_term, relative
from allanite.statistics.table import STATISTICS
from allanite.terms import TERMS

from .inversion import Inverted, RatioLimits
from .reading import blind, columns, early, plain, reported, result, rows_of, signal_of, textbook, unit_model

PAIR = ("oadev", "ohdev")

WALK_RATIO = 0.5  # hadamard over Allan variance of a rate random walk; only a ramp gives less
MAX_REWEIGHTINGS = 8  # iterations of the fit and the covariance under it; three to five suffice


def solve(X: FloatArray, variance: FloatArray, covariance: FloatArray) -> FloatArray:
    """Squares theta >= 0 that minimize the quadratic form of the residuals, shape (t,)."""
    A, b = whitened(X, variance, covariance)
    size = np.sqrt((A**2).sum(axis=0))
    size[size == 0] = 1.0
    return np.asarray(scipy.optimize.nnls(A / size, b)[0] / size)


def whitened(X: FloatArray, variance: FloatArray, covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Columns and values in units of independent standard errors."""
    L = scipy.linalg.cholesky(covariance / np.outer(variance, variance), lower=True)
    A = scipy.linalg.solve_triangular(L, X / variance[:, None], lower=True)
    return A, scipy.linalg.solve_triangular(L, np.ones_like(variance), lower=True)


def unbounded(X: FloatArray, variance: FloatArray) -> FloatArray:
    """Squares of either sign with the least squares of the residuals, shape (t,)."""
    size = np.abs(X).max(axis=0)
    return np.asarray(np.linalg.lstsq(X / size, variance, rcond=None)[0] / size)


def drawn(curve: Curve, symbols: Sequence[str]) -> tuple[FloatArray, FloatArray, str]:
    """All points as they are drawn, by the textbook's lines: of a hybrid the variance contains its bias ratio."""
    note = say("fitted to all {count} points of {statistic}, {start:g} to {end:g} s", count=curve.tau.size,
               statistic=curve.statistic, start=curve.tau[0], end=curve.tau[-1])  # fmt: skip
    return curve.variance, textbook(symbols, curve.tau), note


def first_tenth(curve: Curve, symbols: Sequence[str]) -> tuple[FloatArray, FloatArray, str]:
    """Points up to a tenth of the record, beyond which well determined terms only become worse (docs/methods.md)."""
    which = early(curve, 0.1)
    count = int(which.sum())
    if count < len(symbols):
        raise UsageError(
            f"{count} points at averaging times up to a tenth of the record are too few for {len(symbols)} terms"
        )
    names = [row.name for row, used in zip(rows_of(curve), which.tolist(), strict=True) if used]
    note = say("fitted to {count} points of {statistic} up to {tau:g} s, a tenth of the record",
               count=count, statistic=curve.statistic, tau=curve.tau[which][-1])  # fmt: skip
    return plain(curve)[which], columns(names, symbols, curve.m[which].tolist(), curve.size, curve.rate), note


@dataclass(frozen=True)
class LeastSquares:
    """A method: its name, which points are read and what each term makes of them, and how the squares follow."""

    method: str
    read: Callable[[Curve, Sequence[str]], tuple[FloatArray, FloatArray, str]]
    squares: Callable[[FloatArray, FloatArray], FloatArray]
    noted: bool = True  # whether a note names the points that were read
    many: bool = True  # whether as many points as terms are needed before any is read

    def __call__(self, curve: Curve, symbols: Sequence[str]) -> Fit:
        """The fit of a curve."""
        signal = signal_of(curve, len(symbols) if self.many else 1)
        variance, X, note = self.read(curve, symbols)
        estimates = reported(symbols, self.squares(X, variance), X, signal=signal, method=self.method)
        negative = [
            say("the least-squares fit gives a negative {symbol}^2, which has no physical meaning and shows that "
                "this fit is unreliable for the other terms, too", symbol=e.symbol)
            for e in estimates if e.status == "negative"
        ]  # fmt: skip
        notes = [note] * self.noted + blind(curve.statistic, signal, symbols, X) + negative
        return result(curve, estimates, self.method, notes=notes)


# as in much of the literature: the shortest tau dominates, so that errors are 2 to 90 times the Cramer-Rao bound
least_squares = LeastSquares("ls", drawn, unbounded, noted=False)
# the same lines up to averaging times where one or two degrees of freedom are left (Tang, Cheng and Gao, Acta
# Armamentarii 36, 2015, 1688)
whole = LeastSquares("curve", drawn, lambda X, variance: solve(X, variance, np.eye(len(X)) * variance.mean() ** 2))
# as many programs do: the much larger scatter of points at long tau is not taken into account
nnls = LeastSquares("nnls", first_tenth, lambda X, variance: solve(X, variance, np.diag(variance**2)), many=False)


@dataclass(frozen=True)
class Moments:
    """Moments of the points of a curve under terms with coefficients of 1: `columns`, shape (k, t), are expectations.

    `products`, shape (k, k, t, t), is what each pair of terms adds to the covariance.
    """

    columns: FloatArray
    products: FloatArray

    def covariance(self, theta: FloatArray) -> FloatArray:
        """Covariance of the points for squares `theta` of the coefficients, shape (k, k)."""
        return np.asarray(np.einsum("ijab,a,b", self.products, theta, theta))


def diagonal_moments(names: Sequence[str], symbols: Sequence[str], m: Sequence[int], size: int, rate: float) -> Moments:
    """Moments with the variances alone, 2 E_i E_j r_ij, which is 2 E^2 / EDF of a mixture; the rest is 0."""
    X, terms = columns(names, symbols, m, size, rate), [t.sampled(rate) for t in unit_model(symbols)]
    products = np.zeros((len(m), len(m), len(symbols), len(symbols)))
    for i, (name, k) in enumerate(zip(names, m, strict=True)):
        products[i, i] = 2 * np.outer(X[i], X[i]) * relative(STATISTICS[name], terms, np.array([k]), [[(size, 1)]])[0]
    return Moments(X, products)


def iterated(moments: Moments, variance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Squares of the coefficients, shape (t,), and the covariance of the points under them, shape (k, k)."""
    X = moments.columns
    theta = solve(X, variance, np.diag(variance**2))
    covariance = _scatter(moments, theta)
    for _ in range(MAX_REWEIGHTINGS):
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


def joint(record: Record, symbols: Sequence[str]) -> Fit:
    """Non-negative squares of the coefficients that fit both variances at once, at octaves up to T/4."""
    # Each point is weighted by its degrees of freedom under the fit. The points are not independent, so there are no
    # standard errors.
    curves = [deviation(record, name, gaps="complete") for name in PAIR]
    signal = signal_of(curves[0], 1)
    which = [early(curve, 0.25) for curve in curves]
    variance = np.concatenate([c.variance[own] for c, own in zip(curves, which, strict=True)])
    if variance.size < len(symbols) or not np.all(variance > 0):
        nonzero = np.count_nonzero(variance > 0)
        raise DataError(say("{nonzero} of {size} points are nonzero; {terms} terms need as many, all nonzero",
                            nonzero=nonzero, size=variance.size, terms=len(symbols)))  # fmt: skip
    names = [name for name, own in zip(PAIR, which, strict=True) for _ in range(int(own.sum()))]
    m = np.concatenate([c.m[own] for c, own in zip(curves, which, strict=True)]).tolist()
    moments = diagonal_moments(names, symbols, m, record.size, record.rate)
    theta, _ = iterated(moments, variance)
    ramp = any(TERMS[s].waveform is not None and v > 0 for s, v in zip(symbols, theta.tolist(), strict=True))
    notes = [
        say("fitted to {count} points of {first} and {second}", count=variance.size, first=PAIR[0], second=PAIR[1]),
        *drift(*curves, fitted=ramp),
    ]
    estimates = reported(symbols, theta, moments.columns, signal=signal, method="joint")
    return result(curves[0], estimates, "joint", notes=notes)


def drift(allan: Curve, hadamard: Curve, *, fitted: bool) -> list[str]:
    """What the two curves say about a ramp, at the largest octave below a tenth of the record."""
    both = np.intersect1d(allan.m[early(allan, 0.1)], hadamard.m[early(hadamard, 0.1)])[-1]
    a, h = (float(curve.variance[curve.m == both][0]) for curve in (allan, hadamard))
    tau = float(both) / allan.rate
    ratio = say("at {tau:g} s the Hadamard deviation is {ratio:.3f} of the Allan deviation",
                tau=tau, ratio=np.sqrt(h / a))  # fmt: skip
    if h < WALK_RATIO * a:
        return [
            say("{found}, below the 0.707 of a random walk: a ramp of about {size:.3g} {unit}/s if there is only a "
                "random walk besides it; a single record can be that low by chance",
                found=ratio, size=np.sqrt(2 * (a - 2 * h)) / tau, unit=allan.unit)
        ]  # fmt: skip
    conclusion = say("a Hadamard deviation below the Allan deviation is no proof of a drift (a random walk alone "
                     "gives 0.707, flicker 0.90), only a ratio below 0.707 requires a ramp")  # fmt: skip
    if fitted:
        conclusion = say("{said}, and the R of the fit is no evidence of a ramp", said=conclusion)
    negative = say("2 (AVAR - 2 HVAR) / tau^2 is negative, so that R there is 0")
    return [say("{ratio}; {negative}: {conclusion}", ratio=ratio, negative=negative, conclusion=conclusion)]


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
    freedom = variance.size - np.count_nonzero(theta)
    A, b = whitened(X, variance, covariance)
    square = float(((b - A @ theta) ** 2).sum())
    p = f"p = {scipy.special.chdtrc(freedom, square):.2g}" if freedom else say("no degrees of freedom left for a test")
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
