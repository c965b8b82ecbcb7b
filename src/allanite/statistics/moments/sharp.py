"""White angle noise where the points of a window meet it one by one.

Theo1 and the Hadamard total deviation hold single points of the angle: white angle noise is correlated only
where a point of one window falls on a point of the other, which no coarser window shows by itself. Its ratios fall as
1/(m scale(m)) at an equal number of windows over m.
"""

from collections.abc import Sequence

import numpy as np

from allanite.statistics.row import FloatArray, Sharp, Statistic
from allanite.terms import NoiseTerm

from .compact import Compact, compact, expectation, extrapolation, lattice, sampled


def sharp_ratios(row: Statistic, rule: Sharp, terms: Sequence[NoiseTerm], m: int, count: int) -> FloatArray:
    """Ratios of white angle noise with every term, shape (t,).

    Over the lags the product of its covariance with another is smooth except for peaks at the first and the last, where
    the ends of one window meet those of the other: smooth part and peaks are extrapolated for themselves.
    """
    first, last, smooth = [], [], []
    levels = [k + m % 2 for k in rule.levels]
    for level in levels:
        window = compact(row.window, row.order, level)
        r = rule.scale(level) * _lag_ratios(window, terms, level / m)
        first.append(r[:, 0] - (2 * r[:, 1] - r[:, 2]))
        last.append(r[:, -1] - (2 * r[:, -2] - r[:, -3]))
        r[:, 0] -= first[-1]
        r[:, -1] -= last[-1]
        lag, weight = lattice(window.points, level / m, count)
        smooth.append([np.interp(lag, np.arange(window.points), k, right=0.0) @ weight * level for k in r])
    weights = extrapolation(levels, m, 1)
    ends = weights @ first / count + 2 * max(count - row.span[0] * m, 0) / count**2 * (weights @ last)
    return np.asarray((ends + weights @ smooth / m) / rule.scale(m))


def _lag_ratios(window: Compact, terms: Sequence[NoiseTerm], step: float) -> FloatArray:
    """Covariances of white angle noise times those of each term over both expectations, shape (t, lags)."""
    distance = np.abs(np.arange(window.points)[:, None] + np.arange(1.0 - window.points, window.points))
    white = -2 * window.mean[window.points - 1]
    r = np.zeros((len(terms), window.points))
    for i, term in enumerate(terms):
        D = sampled(term, step)
        E = expectation(window.mean, D)
        if E:
            r[i] = np.sum(window.white * D(distance), axis=1) / (white * E)
    return r
