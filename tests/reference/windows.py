"""The same statistics a second way: weights on the rate samples of one window, window after window, gaps left out."""

import numpy as np

from tests.reference.terms import mean, require


def _steps(m, *heights):
    """Each height m times."""
    return np.repeat(np.array(heights, dtype=float), m)


def _allan(m):
    return [(1, _steps(m, -1, 1) / m)]


def _hadamard(m):
    return [(1, _steps(m, 1, -2, 1) / m)]


def _modified(m):
    weights = np.zeros(3 * m - 1)
    for k in range(m):
        weights[k : k + 2 * m] += _steps(m, -1, 1) / m**2
    return [(1, weights)]


def _parabolic(m):
    if m == 1:
        return _allan(m)
    weights = np.zeros(2 * m - 1)
    for k in range(m):
        weights[k : k + m] -= (m - 1) / 2 - k
    return [(144, weights / m**3)]


def _theo1(m):
    require(m % 2 == 0, "m is even")
    half = m // 2
    pairs = []
    for d in range(half):
        weights = np.zeros(m)
        weights[: half - d] = -1
        weights[half + d :] = 1
        pairs.append((1 / (half - d), weights / m))
    return pairs


WINDOWS = {
    # name: (factor, rate weights) of each square of a window; their divisor; stride; width in intervals
    "adev": (_allan, 2, lambda m: m, lambda m: 2 * m), "oadev": (_allan, 2, lambda m: 1, lambda m: 2 * m),
    "hdev": (_hadamard, 6, lambda m: m, lambda m: 3 * m), "ohdev": (_hadamard, 6, lambda m: 1, lambda m: 3 * m),
    "mdev": (_modified, 2, lambda m: 1, lambda m: 3 * m - 1), "pdev": (_parabolic, 2, lambda m: 1, lambda m: 2 * m),
    "theo1": (_theo1, 0.75, lambda m: 1, lambda m: m), "haar": (_allan, 4, lambda m: 1, lambda m: 2 * m),
}  # fmt: skip
"""The width says how many windows there are; a parabolic one of 2m intervals has 2m - 1 weights (see `parabolic`)."""


def windowed(y, m, name):
    """Variance and number of windows, of those windows in whose weighted samples no NaN lies.

    A window's samples are all those between the first and the last phase point of its difference.
    """
    squares, divisor, stride, width = WINDOWS[name]
    pairs = squares(m)
    kept = []
    for start in range(0, len(y) - width(m) + 1, stride(m)):
        window = y[start : start + len(pairs[0][1])]
        if np.isnan(window).any():
            continue
        kept.append(sum(factor * np.sum(weights * window) ** 2 for factor, weights in pairs))
    return mean(kept) / divisor, len(kept)
