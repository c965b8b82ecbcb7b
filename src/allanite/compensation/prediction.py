"""What a regression gains on another record: what could be expected, and what came."""

import math

import numpy as np

from allanite.core.errors import DataError
from allanite.core.record import Record, Recording
from allanite.statistics.moments.gls import Covariance

from .gain import Gain
from .regression import Regression

WITHIN = 1.959964
"""Standard errors of 95 % limits."""


def gain_on(regression: Regression, record: Record, along: Recording | None) -> Gain:
    r"""Mean squares of another record about its mean, before and after, and what was to be expected of it.

    With S = X'X of the regressors there (about their means), b the coefficients, V their covariance and C that of the
    noise, the sum of squares falls by 2 y'Xb - b'Sb. Its expectation b'Sb - 2 tr(VS) is without bias, and it scatters
    about that with the variance 4 (b'SVSb + tr(VSVS) + (Xb)'C(Xb)).

    Raises
    ------
    DataError
        The record and its regressors have no readings in common.
    """
    taken = regression.taken
    X = np.column_stack([regression.regressors[i].column(record, along) for i in taken])
    y = record.rate_values
    fine = np.isfinite(y) & np.isfinite(X).all(axis=1)
    count = int(fine.sum())
    if count < 2:
        raise DataError(f"{record.name!r} and its regressors have no readings in common")
    X = np.where(fine[:, None], X - X[fine].mean(axis=0), 0.0)
    y = np.where(fine, y - y[fine].mean(), 0.0)
    b, V = regression.mixture.values[taken], regression.mixture.covariance[np.ix_(taken, taken)]
    S, v = X.T @ X, X @ b
    before, after = float(y @ y), float((y - v) @ (y - v))
    expected = float(b @ S @ b - 2 * np.trace(V @ S))
    noise = Covariance(regression.noise.terms, y.size, record.rate).variance(v)
    spread = WITHIN * math.sqrt(4 * (float(b @ S @ V @ S @ b) + float(np.trace(V @ S @ V @ S)) + noise))
    sums = (before, after, expected, expected - spread, expected + spread)
    return Gain(*(total / count for total in sums))
