"""Weighted sums of chi-squares: the largest eigenvalues of a statistic, and quantiles by a saddlepoint."""

# Derivation: docs/derivations.md.

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy

from allanite.core.arrays import FloatArray
from allanite.statistics.moments import lagsums
from allanite.statistics.moments.compact import averaged
from allanite.statistics.row import Statistic
from allanite.terms import NoiseTerm

MAX_WINDOWS = 96  # windows of one row each that represent all
MAX_WIDE_WINDOWS = 32  # windows of several rows that represent all
SUBSPACE = 10  # leading eigenvectors of the terms in equal parts that carry those of any mixture
MAX_DIRECTIONS = 32  # directions that a form is reduced to
POWER_STEPS = 5  # power steps to them in a large matrix


class Eigenvalues(NamedTuple):
    """Forms with the sum 1: their `leading` eigenvalues, descending, shape (k, j), and sums of `squares` of all."""

    leading: FloatArray
    squares: FloatArray


def matrices(row: Statistic, terms: Sequence[NoiseTerm], m: int, count: int, size: int) -> FloatArray:
    """The form under each term of size 1, shape (t, w, w)."""
    if row.differences:
        at = _places(count, MAX_WINDOWS)
        apart, steps = np.abs(np.subtract.outer(at, at)), np.arange(at.size)
        # so many places apart, windows lie at one of two lags, which differ by 1, or of three for what rounding does
        least = np.floor(steps * (count / at.size)) - 1
        which = (apart - least[np.abs(np.subtract.outer(steps, steps))]).astype(np.int64)
        lags = np.abs(least + np.arange(3)[:, None]) * (1 if row.overlapped else m)
        C = np.array([lagsums.covariance_of_windows(row, term, m, lags.ravel()) for term in terms])
        return np.asarray(C[:, which * at.size + np.abs(np.subtract.outer(steps, steps))])
    if row.window is None:
        return _folded(terms, m, size)
    short = min(m, row.scheme.leading)
    weights, filters = row.window(short)
    _, sizes, factors = np.linalg.svd(np.sqrt(weights)[:, None] * filters, full_matrices=False)
    factors = (sizes[:, None] * factors)[sizes > 1e-9 * sizes[0]]
    at, short_lags = _places(count, MAX_WIDE_WINDOWS), np.arange(1.0 - filters.shape[1], filters.shape[1])
    apart, where = np.unique(np.subtract.outer(at, at), return_inverse=True)
    lag = np.abs(apart[:, None] * (short / m) + short_lags)
    D = np.array([averaged(term, short / m)(lag) for term in terms])
    # D between the points of two windows, which is a matter of how far these are apart
    D = np.lib.stride_tricks.sliding_window_view(D, filters.shape[1], axis=-1)[..., ::-1]
    each = -0.5 * factors @ D @ factors.T
    C = each[:, where.reshape(at.size, at.size)].swapaxes(2, 3)
    return np.asarray(C.reshape(len(terms), at.size * factors.shape[0], -1))


class ReducedForms(NamedTuple):
    """The form under each term, projected on few vectors, shape (t, b, b); its traces, and inner products, (t, t)."""

    forms: FloatArray
    traces: FloatArray
    products: FloatArray


def reduced(forms: FloatArray) -> ReducedForms:
    """Forms by their projection on vectors that span the leading eigenvectors of every mixture of the terms."""
    # They are those of the terms in equal parts, and what each term makes of these (Rayleigh and Ritz).
    traces, flat = np.trace(forms, axis1=1, axis2=2), forms.reshape(len(forms), -1)
    mean = np.tensordot(np.divide(1.0, traces, out=np.zeros_like(traces), where=traces > 0), forms, axes=1)
    width = len(mean)
    vectors = np.cos(np.pi / width * np.outer(np.arange(width) + 0.5, np.arange(min(SUBSPACE, width))))
    for _ in range(POWER_STEPS):
        vectors = mean @ np.linalg.qr(vectors)[0]
    both = np.concatenate((vectors[None], forms @ vectors))
    basis = np.linalg.qr(both.swapaxes(0, 1).reshape(width, -1))[0]
    basis = basis @ np.linalg.eigh(basis.T @ mean @ basis)[1][:, -MAX_DIRECTIONS:]
    return ReducedForms(basis.T @ forms @ basis, traces, flat @ flat.T)


def spectra(reduced: ReducedForms, powers: FloatArray, leading: int) -> Eigenvalues:
    """Spectra of the form under several models, whose terms have squared coefficients `powers`, shape (k, t)."""
    total = powers @ reduced.traces
    squares = np.einsum("ki,ij,kj->k", powers, reduced.products, powers)
    values = np.linalg.eigvalsh(np.tensordot(powers, reduced.forms, axes=1))
    first = np.maximum(values[:, : -leading - 1 : -1], 0)
    return Eigenvalues(first / total[:, None], squares / total**2)


def is_sharp(row: Statistic, count: int) -> bool:
    """Whether white angle noise cannot be in the matrix: its windows neither average it nor are all there."""
    if row.differences:
        return not row.summed and count > MAX_WINDOWS
    return row.window is not None and row.scheme.sharp is not None


def _places(count: int, most: int) -> FloatArray:
    k = min(count, most)
    return np.floor((np.arange(k) + 0.5) * count / k)


def _folded(terms: Sequence[NoiseTerm], m: int, size: int) -> FloatArray:
    """Second differences of the record folded back at its ends, as weights of its own points."""
    middle = 1 + _places(size - 1, MAX_WINDOWS)
    place, weight = [middle], [np.full(middle.size, -2.0)]
    for other in (middle - m, middle + m):
        end = np.where(other < 0, 0.0, np.where(other > size, float(size), other))
        inside = end == other
        place += [end, 2 * end - other]
        weight += [np.where(inside, 1.0, 2.0), np.where(inside, 0.0, -1.0)]
    places, where = np.unique(np.array(place), return_inverse=True)
    lag, parts = (np.abs(np.subtract.outer(places, places)),
                  list(zip(where.reshape(len(place), -1), weight, strict=True)))  # fmt: skip
    D = np.array([term.structure(lag) for term in terms])
    half = sum(w[:, None] * D[:, at] for at, w in parts)
    return np.asarray(-0.5 * sum(w * half[..., at] for at, w in parts))


MIN_DEVIATE = 1e-4  # |t| in standard deviations below which the limit at the mean is taken


BISECTIONS = 36  # steps to a quantile: to 1e-9 of it

NEWTON, STRIDE, START = 2, 4.0, 1e-6
"""Steps from one deviate to the next, the longest of them, and where the first begins."""


class ChiSquareSum(NamedTuple):
    """Weights and degrees of freedom, shape (k, j); mean and weight of the deterministic part, shape (k,)."""

    weight: FloatArray
    dof: FloatArray
    mean: FloatArray
    beside: FloatArray


def quantiles(mixture: ChiSquareSum, p: float) -> FloatArray:
    """The value below which V lies with probability p, shape (k,)."""
    top = _pole(mixture)
    low, high = np.full(top.shape, -40.0), np.full(top.shape, 40.0)
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        # from -infinity to the pole, t = top (1 - exp(-y))
        below = _probability(*_saddle(mixture, -top * np.expm1(-middle))[:3]) < p
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return _saddle(mixture, -top * np.expm1(-(low + high) / 2))[3]


def table(mixture: ChiSquareSum, deviates: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Values of V near normal deviates, which rise, and their exact deviates, shape (deviates, k) each."""
    # The saddlepoint is taken where its root r is the deviate, by Newton's steps from one to the next.
    top, points = _pole(mixture), []
    middle = int(np.abs(deviates).argmin())
    for way in (range(middle, -1, -1), range(middle + 1, deviates.size)):
        y = np.full(top.shape, START)
        for i in way:
            for _ in range(NEWTON):
                t = -top * np.expm1(-y)
                r, v, _, _ = _saddle(mixture, t)
                r = np.where(np.abs(v) < 0.01, v, r)  # where the difference t x - K loses its digits, they are alike
                slope = v**2 / (t * r) * (top - t)  # dr/dy = (t K'' / r) dt/dy, and v = t sqrt(K'')
                y = y + np.clip((deviates[i] - r) / np.maximum(slope, 1e-12), -STRIDE, STRIDE)
                y = np.where(np.abs(y) < START, START, y)
            r, v, skewness, x = _saddle(mixture, -top * np.expm1(-y))
            points.append((i, x, scipy.special.ndtri(_probability(r, v, skewness))))
    points.sort(key=lambda one: one[0])
    return np.array([x for _, x, _ in points]), np.array([z for _, _, z in points])


def _pole(mixture: ChiSquareSum) -> FloatArray:
    return np.asarray(1 / (2 * np.maximum(mixture.weight.max(axis=1), mixture.beside)))


def _probability(r: FloatArray, v: FloatArray, skewness: FloatArray) -> FloatArray:
    """P(V < x) at a saddlepoint."""
    with np.errstate(divide="ignore", invalid="ignore"):
        probability = scipy.special.ndtr(r) + np.exp(-r * r / 2) / math.sqrt(2 * math.pi) * (1 / r - 1 / v)
    return np.where(np.abs(v) < MIN_DEVIATE, 0.5 + skewness / (6 * math.sqrt(2 * math.pi)), probability)


def _saddle(mixture: ChiSquareSum, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    K, x, K2, K3 = cumulants(mixture, t)
    r = np.sign(t) * np.sqrt(np.maximum(2 * (t * x - K), 0))
    return r, t * np.sqrt(K2), K3 / K2**1.5, x


def cumulants(mixture: ChiSquareSum, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """K and its first three derivatives at t, shape (k,) each."""
    weight, dof, c, u = mixture
    pole = 1 - 2 * u * t
    rest = 1 - 2 * weight * t[:, None]
    part = weight / rest
    K = c * t / pole - (dof * np.log(rest)).sum(axis=1) / 2
    K1 = c / pole**2 + (dof * part).sum(axis=1)
    K2 = 4 * c * u / pole**3 + 2 * (dof * part**2).sum(axis=1)
    K3 = 24 * c * u * u / pole**4 + 8 * (dof * part**3).sum(axis=1)
    return K, K1, K2, K3
