"""Moments of the total deviation: a record folded back at its ends, whose differences are not stationary there."""

# Derivation: docs/derivations.md.

from collections.abc import Sequence

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.statistics.row import Statistic
from allanite.terms import NoiseTerm

from .compact import extrapolation, ratios, sampled, white_level
from .lagsums import lag_nodes

ROWS = 256  # intervals of a record whose rows are taken pair by pair as they are
LEVELS = (1, 2, 3)  # multiples of the coarsest record that the extrapolation goes through
CLOSE = 5e-4  # relative deviation of the ratio of m to size, up to which one short record represents the long one
MIDDLE = 16  # length in m from which on a record has a middle that knows of no end


def response(row: Statistic, terms: Sequence[NoiseTerm], m: int, size: int) -> FloatArray:
    """Expected variance of each term for a sample interval of 1, shape (t,)."""
    kinks = {1.0, size - 1.0}
    for k in (m / 2, m, size - m, size - m / 2):
        kinks |= {float(np.floor(k)), float(np.ceil(k))}
    i, weight = lag_nodes(sorted(k for k in kinks if 1 <= k <= size - 1), size - 1.0)
    before, after = i - m, i + m
    beyond = after > size
    points = np.array([i, np.abs(before), 0 * i, np.where(beyond, 2 * size - after, after), 0 * i + size])
    c = np.array([0 * i - 2, np.where(before < 0, -1, 1), 2.0 * (before < 0), np.where(beyond, -1, 1), 2.0 * beyond])
    distance, both = np.abs(points[:, None] - points), c[:, None] * c
    sums = [-0.5 * float(np.sum(both * term.structure(distance), axis=(0, 1)) @ weight) for term in terms]
    return np.array(sums) / (float(row.norm(np.array([m]))[0]) * (size - 1) * float(m) ** 2)


def relative(terms: Sequence[NoiseTerm], m: int, size: int) -> FloatArray:
    """Ratios r_ij of the whole record, shape (t, t); 1/EDF = p r p with p the terms' shares of the expectation."""
    if size <= ROWS or m <= ROWS // MIDDLE:
        return ratios(*_products(terms, m, size, 1.0), terms)
    white = np.array([white_level(term) > 0 for term in terms])
    parts = []
    for m0, size0, weight in _coarse(m, size):
        levels = []
        for k in LEVELS:
            E, T = _products(terms, k * m0, k * size0, k * m0 / m)
            # where m is the whole record points fall together that do not in a longer record
            levels.append(ratios(np.where(white, white_mean(k * m0, k * size0), E), T, terms))
        parts.append(weight * np.tensordot(extrapolation([k * m0 for k in LEVELS], m, 1), levels, 1))
    r = np.sum(parts, axis=0)
    r[np.outer(white, white)] = white_ratio(m, size)
    return np.asarray(r)


def white_ratio(m: int, size: int) -> float:
    """Ratio of white angle noise with itself: whole numbers, polynomials between m = n/2 and 2n/3."""
    # Found by summing over all pairs for n < 90; two or three m at the corners differ by terms of the order of n.
    fold = max(2 * m - size, 0)
    pairs = 70 * size + 32 * m**2 + 112 * m - 122 - 128 * (m % 2)
    pairs += 32 * fold * (fold - 1) + 128 * max(3 * m - 2 * size, 0)
    return pairs / float(white_mean(m, size)) ** 2


def white_mean(m: int, size: float) -> float:
    """Sum of the rows' variances for white angle noise (D = 2)."""
    return 6 * (size - 1) + 8 * (m - m % 2)


def _coarse(m: int, size: int) -> list[tuple[int, float, float]]:
    """(m, size, weight) of short records, m even, between whose ratios of m to size lies that of the long one."""
    longest = ROWS // LEVELS[-1]
    if size > MIDDLE * m:
        even = longest // MIDDLE // 2 * 2
        return [(even, size * (even / m), 1.0)]
    share = m / size
    sizes = np.tile(np.arange(longest // 2, longest + 1), 2)
    factors = 2 * (np.floor(share * sizes / 2) + np.repeat([0, 1], sizes.size // 2)).astype(np.int64)
    sizes, factors = sizes[factors <= sizes], factors[factors <= sizes]
    off = factors / sizes - share
    best = np.array([np.argmax(np.where(off <= 0, off, -np.inf)), np.argmin(np.where(off >= 0, off, np.inf))])
    weight = np.abs(off[best][::-1])
    near = int(np.argmax(weight))
    if weight[1 - near] <= CLOSE * share:
        return [(int(factors[best[near]]), int(sizes[best[near]]), 1.0)]
    return [(int(factors[k]), int(sizes[k]), float(w)) for k, w in zip(best, weight / weight.sum(), strict=True)]


def _products(terms: Sequence[NoiseTerm], m: int, size: float, step: float) -> tuple[FloatArray, FloatArray]:
    """Sums over the rows' variances (t,), over the squares of their covariances (t, t); samples are 1/step apart."""
    length = int(min(size, max(MIDDLE * m, ROWS // 4)))
    # covariances of the rows 1 .. size/2 with the rows 1 .. size - 1: the other half mirrors them
    fields = []
    for term in terms:
        D = sampled(term, step)(np.arange(length + 1.0))
        lags = np.concatenate((D[::-1], D[1:]))
        toeplitz = -0.5 * np.lib.stride_tricks.sliding_window_view(lags, length + 1)[::-1]
        fields.append(_differences(_differences(toeplitz, m)[: length // 2].T, m).T)
    weight = np.full(length // 2, 2.0)
    weight[-1] = 1.0 + length % 2
    E = np.array([weight @ np.diagonal(C) for C in fields])
    weighted = [C * weight[:, None] for C in fields]
    T = np.einsum("ikl,jkl->ij", weighted, fields)  # without the threads of a matrix product, which cost more
    if size > length:
        # the row in the middle with those that know of no end either
        centre, reach = length // 2 - 1, length // 2 - m
        middle = np.array([C[-1, centre - reach : centre + reach + 1] for C in fields])
        E += (size - length) * middle[:, reach]
        T += (size - length) * middle @ middle.T + _distant(terms, m, (length, size), step)
    return E, T


def _differences(x: FloatArray, m: int) -> FloatArray:
    """Second differences over m of the first axis, continued by its own reflection, at all its points but the ends."""
    folded = np.concatenate((2 * x[0] - x[m:0:-1], x, 2 * x[-1] - x[-2 : -m - 2 : -1]))
    return np.asarray((folded[2 * m :] - 2 * folded[m:-m] + folded[: -2 * m])[1:-1])


def _distant(terms: Sequence[NoiseTerm], m: int, sizes: tuple[int, float], step: float) -> FloatArray:
    """What is missing where a long record's middle is counted as many times the middle row of a short one."""
    short, long = sizes
    lag, weight = lag_nodes(sorted({short // 2 - m + 1.0, min(short, long) - 1.0}), long - 1.0)
    pairs = 2 * weight * np.minimum(long - short, long - 1 - lag)
    C = []
    for term in terms:
        series = [c * (m / step) ** k * term.derivative(k, lag / step) for k, c in ((4, 1), (6, 1 / 6), (8, 1 / 80))]
        C.append(-0.5 * np.sum(series, axis=0))
    return np.asarray((np.array(C) * pairs) @ np.array(C).T)
