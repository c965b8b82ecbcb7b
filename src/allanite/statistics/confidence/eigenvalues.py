"""The largest eigenvalues of a statistic's quadratic form under a model: what a few degrees of freedom consist of.

They come from few windows spread over the record, and from reduced windows where a window has many points; the degrees
of freedom, known exactly, scale them. White noise of the angle is left to its own where windows meet it point by point.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from allanite.statistics.moments import lagsums
from allanite.statistics.moments.compact import averaged
from allanite.statistics.row import FloatArray, Statistic
from allanite.terms import NoiseTerm

WINDOWS = 96
"""Windows of one row each that stand for all."""

FEW = 32
"""Windows of several rows that stand for all."""

SPACE = 12
"""Leading eigenvectors of one model that carry those of its neighbours."""


class Spectrum(NamedTuple):
    """Of a form with the sum 1: its `leading` eigenvalues, descending, and the sum of `squares` of all."""

    leading: FloatArray
    squares: float


def matrices(row: Statistic, terms: Sequence[NoiseTerm], m: int, count: int, size: int) -> FloatArray:
    """The form under each term of size 1, shape (t, w, w)."""
    if row.differences:
        return _differences(row, terms, m, count)
    return _folded(terms, m, size) if row.window is None else _windows(row, terms, m, count)


def spectra(forms: FloatArray, powers: FloatArray, leading: int) -> list[Spectrum]:
    """Spectra of the form under several models, whose terms have squared coefficients `powers`, shape (k, t).

    Those of one model come from its matrix; of several, which are alike, from the leading eigenvectors of their mean,
    improved by two power steps of each (Rayleigh and Ritz).
    """
    each = np.tensordot(powers, forms, axes=1)
    if len(each) == 1:
        values = np.linalg.eigvalsh(each)
    else:
        vectors = np.linalg.eigh(each.mean(axis=0))[1][:, -SPACE:]
        basis = np.linalg.qr(each @ np.linalg.qr(each @ vectors)[0])[0]
        values = np.linalg.eigvalsh(basis.swapaxes(1, 2) @ each @ basis)
    total, squares = np.trace(each, axis1=1, axis2=2), np.square(each).sum(axis=(1, 2))
    first = np.maximum(values[:, : -leading - 1 : -1], 0)
    return [Spectrum(v / t, float(q / t**2)) for v, t, q in zip(first, total, squares, strict=True)]


def is_sharp(row: Statistic, count: int) -> bool:
    """Whether white noise of the angle cannot be in the matrix: its windows neither average it nor are all there."""
    if row.differences:
        return not row.summed and count > WINDOWS
    return row.window is not None and row.scheme.sharp is not None


def _places(count: int, most: int) -> FloatArray:
    k = min(count, most)
    return np.floor((np.arange(k) + 0.5) * count / k)


def _differences(row: Statistic, terms: Sequence[NoiseTerm], m: int, count: int) -> FloatArray:
    at = _places(count, WINDOWS) * (1 if row.overlapped else m)
    lags, where = np.unique(np.abs(np.subtract.outer(at, at)), return_inverse=True)
    C = np.array([lagsums.covariance_of_windows(row, term, m, lags) for term in terms])
    return np.asarray(C[:, where.ravel()].reshape(-1, at.size, at.size))


def _windows(row: Statistic, terms: Sequence[NoiseTerm], m: int, count: int) -> FloatArray:
    assert row.window is not None  # noqa: S101 - the caller has looked
    short = min(m, row.scheme.leading)
    weights, filters = row.window(short)
    _, sizes, factors = np.linalg.svd(np.sqrt(weights)[:, None] * filters, full_matrices=False)
    factors = (sizes[:, None] * factors)[sizes > 1e-9 * sizes[0]]
    at, points = _places(count, FEW), np.arange(filters.shape[1]) * (m / short)
    place = (at[:, None] + points).ravel()
    lag = np.abs(np.subtract.outer(place, place)) * (short / m)
    D = np.array([averaged(term, short / m)(lag) for term in terms])
    blocks = D.reshape(-1, at.size, points.size, at.size, points.size)
    C = -0.5 * np.einsum("ap,tipjq,bq->tiajb", factors, blocks, factors, optimize=True)
    return np.asarray(C.reshape(len(terms), at.size * factors.shape[0], -1))


def _folded(terms: Sequence[NoiseTerm], m: int, size: int) -> FloatArray:
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
    D = np.array([term.structure(lag) for term in terms])
    blocks = D.reshape(-1, *places.shape, *places.shape)
    return np.asarray(-0.5 * np.einsum("ip,tipjq,jq->tij", weights, blocks, weights, optimize=True))
