"""The largest eigenvalues of a statistic's quadratic form under a model: what a few degrees of freedom consist of.

They come from few windows spread over the record, and from reduced windows where a window has many points; the degrees
of freedom, known exactly, scale them. White angle noise is left to its own where windows meet it point by point.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from allanite.statistics.moments import lagsums
from allanite.statistics.moments.compact import averaged
from allanite.statistics.row import FloatArray, Statistic
from allanite.terms import NoiseTerm

WINDOWS = 96
"""Windows of one row each that represent all."""

FEW = 32
"""Windows of several rows that represent all."""

SPACE = 10
"""Leading eigenvectors of one model that carry those of its neighbours."""

STEPS = 5
"""Power steps to them in a large matrix."""


class Eigenvalues(NamedTuple):
    """A form with the sum 1: its `leading` eigenvalues, descending, and the sum of `squares` of all."""

    leading: FloatArray
    squares: float


def matrices(row: Statistic, terms: Sequence[NoiseTerm], m: int, count: int, size: int) -> FloatArray:
    """The form under each term of size 1, shape (t, w, w)."""
    if row.differences:
        at = _places(count, WINDOWS) * (1 if row.overlapped else m)
        lags, where = np.unique(np.abs(np.subtract.outer(at, at)), return_inverse=True)
        C = np.array([lagsums.covariance_of_windows(row, term, m, lags) for term in terms])
        return np.asarray(C[:, where.ravel()].reshape(-1, at.size, at.size))
    if row.window is None:
        return _folded(terms, m, size)
    short = min(m, row.scheme.leading)
    weights, filters = row.window(short)
    _, sizes, factors = np.linalg.svd(np.sqrt(weights)[:, None] * filters, full_matrices=False)
    factors = (sizes[:, None] * factors)[sizes > 1e-9 * sizes[0]]
    at, short_lags = _places(count, FEW), np.arange(1.0 - filters.shape[1], filters.shape[1])
    apart, where = np.unique(np.subtract.outer(at, at), return_inverse=True)
    lag = np.abs(apart[:, None] * (short / m) + short_lags)
    D = np.array([averaged(term, short / m)(lag) for term in terms])
    # D between the points of two windows, which is a matter of how far these are apart
    D = np.lib.stride_tricks.sliding_window_view(D, filters.shape[1], axis=-1)[..., ::-1]
    each = -0.5 * factors @ D @ factors.T
    C = each[:, where.reshape(at.size, at.size)].swapaxes(2, 3)
    return np.asarray(C.reshape(len(terms), at.size * factors.shape[0], -1))


def spectra(forms: FloatArray, powers: FloatArray, leading: int) -> list[Eigenvalues]:
    """Spectra of the form under several models, whose terms have squared coefficients `powers`, shape (k, t).

    They come from the form's projection on what the leading eigenvectors of the models' mean, and each term of these,
    span (Rayleigh and Ritz).
    """
    total = powers @ np.trace(forms, axis1=1, axis2=2)
    squares = np.einsum("ki,ij,kj->k", powers, np.einsum("iab,jab->ij", forms, forms), powers)
    # orthonormal columns that hold the leading eigenvectors of models near one with these squared coefficients
    mean = np.tensordot((powers / total[:, None]).mean(axis=0), forms, axes=1)
    width = len(mean)
    vectors = np.cos(np.pi / width * np.outer(np.arange(width) + 0.5, np.arange(min(SPACE, width))))
    for _ in range(STEPS):
        vectors = mean @ np.linalg.qr(vectors)[0]
    both = np.concatenate((vectors[None], forms @ vectors))
    basis = np.linalg.qr(both.swapaxes(0, 1).reshape(width, -1))[0]
    values = np.linalg.eigvalsh(np.tensordot(powers, basis.T @ forms @ basis, axes=1))
    first = np.maximum(values[:, : -leading - 1 : -1], 0)
    return [Eigenvalues(v / t, float(q / t**2)) for v, t, q in zip(first, total, squares, strict=True)]


def is_sharp(row: Statistic, count: int) -> bool:
    """Whether white angle noise cannot be in the matrix: its windows neither average it nor are all there."""
    if row.differences:
        return not row.summed and count > WINDOWS
    return row.window is not None and row.scheme.sharp is not None


def _places(count: int, most: int) -> FloatArray:
    k = min(count, most)
    return np.floor((np.arange(k) + 0.5) * count / k)


def _folded(terms: Sequence[NoiseTerm], m: int, size: int) -> FloatArray:
    """Second differences of the record folded back at its ends, as weights of its own points."""
    middle = 1 + _places(size - 1, WINDOWS)
    place, weight = [middle], [np.full(middle.size, -2.0)]
    for other in (middle - m, middle + m):
        end = np.where(other < 0, 0.0, np.where(other > size, float(size), other))
        inside = end == other
        place += [end, 2 * end - other]
        weight += [np.where(inside, 1.0, 2.0), np.where(inside, 0.0, -1.0)]
    places, where = np.unique(np.array(place), return_inverse=True)
    lag, parts = (
        np.abs(np.subtract.outer(places, places)),
        list(zip(where.reshape(len(place), -1), weight, strict=True)),
    )
    D = np.array([term.structure(lag) for term in terms])
    half = sum(w[:, None] * D[:, at] for at, w in parts)
    return np.asarray(-0.5 * sum(w * half[..., at] for at, w in parts))
