"""The largest eigenvalues of a statistic's quadratic form under a model: what a few degrees of freedom consist of.

They come from few windows spread over the record, and from reduced windows where a window has many points; the degrees
of freedom, known exactly, scale them. White noise of the angle is left to its own where windows meet it point by point.
"""

import numpy as np

from allanite.statistics.moments import lagsums
from allanite.statistics.moments.compact import averaged
from allanite.statistics.row import FloatArray, Statistic
from allanite.terms import NoiseTerm

WINDOWS = 96
"""Windows of one row each that stand for all."""

FEW = 32
"""Windows of several rows that stand for all."""

Terms = list[tuple[float, NoiseTerm]]
"""Squared coefficients in units of the sample interval, and rows of the table."""


def spectrum_of(row: Statistic, terms: Terms, m: int, count: int, size: int) -> FloatArray:
    """Eigenvalues, descending and of sum 1, of the form under terms with these squared coefficients."""
    if row.differences:
        matrix = _differences(row, terms, m, count)
    elif row.window is None:
        matrix = _folded(terms, m, size)
    else:
        matrix = _windows(row, terms, m, count)
    values = np.maximum(np.linalg.eigvalsh(matrix)[::-1], 0)
    return np.asarray(values / values.sum())


def is_sharp(row: Statistic, count: int) -> bool:
    """Whether white noise of the angle cannot be in the matrix: its windows neither average it nor are all there."""
    if row.differences:
        return not row.summed and count > WINDOWS
    return row.window is not None and row.scheme.sharp is not None


def _places(count: int, most: int) -> FloatArray:
    k = min(count, most)
    return np.floor((np.arange(k) + 0.5) * count / k)


def _differences(row: Statistic, terms: Terms, m: int, count: int) -> FloatArray:
    at = _places(count, WINDOWS) * (1 if row.overlapped else m)
    lags, where = np.unique(np.abs(np.subtract.outer(at, at)), return_inverse=True)
    C = sum(c * lagsums.covariance_of_windows(row, term, m, lags) for c, term in terms)
    return np.asarray(C)[where].reshape(at.size, at.size)


def _windows(row: Statistic, terms: Terms, m: int, count: int) -> FloatArray:
    assert row.window is not None  # noqa: S101 - the caller has looked
    short = min(m, row.scheme.leading)
    weights, filters = row.window(short)
    _, sizes, factors = np.linalg.svd(np.sqrt(weights)[:, None] * filters, full_matrices=False)
    factors = (sizes[:, None] * factors)[sizes > 1e-9 * sizes[0]]
    at, points = _places(count, FEW), np.arange(filters.shape[1]) * (m / short)
    place = (at[:, None] + points).ravel()
    lag = np.abs(np.subtract.outer(place, place)) * (short / m)
    D = np.asarray(sum(c * averaged(term, short / m)(lag) for c, term in terms))
    blocks = D.reshape(at.size, points.size, at.size, points.size)
    C = -0.5 * np.einsum("ap,ipjq,bq->iajb", factors, blocks, factors, optimize=True)
    return np.asarray(C.reshape(at.size * factors.shape[0], -1))


def _folded(terms: Terms, m: int, size: int) -> FloatArray:
    """Second differences of the record folded back at its ends, as weights of its own points."""
    middle = 1 + _places(size - 1, WINDOWS)
    place, weight = [middle], [np.full(middle.size, -2.0)]
    for other in (middle - m, middle + m):
        end = np.where(other < 0, 0.0, np.where(other > size, float(size), other))
        inside = end == other
        place += [end, 2 * end - other]
        weight += [np.where(inside, 1.0, 2.0), np.where(inside, 0.0, -1.0)]
    places, weights = np.stack(place, axis=1), np.stack(weight, axis=1)
    lag = np.abs(np.subtract.outer(places.ravel(), places.ravel()))
    D = np.asarray(sum(c * term.structure(lag) for c, term in terms))
    blocks = D.reshape(*places.shape, *places.shape)
    return np.asarray(-0.5 * np.einsum("ip,ipjq,jq->ij", weights, blocks, weights, optimize=True))
