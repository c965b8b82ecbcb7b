"""Formulas of the papers as they are printed, on the samples of a file."""

import math

import numpy as np

import allanite as al


def values(name):
    return al.read(name).records[0].values


def averages(x, m):
    return np.convolve(x, np.full(m, 1 / m), "valid")


def allan(name, m):
    """Eq. 2 of 000 and eq. 3 of 001."""
    x = values(name)
    return math.sqrt(0.5 * np.mean(np.diff(x[: x.size // m * m].reshape(-1, m).mean(axis=1)) ** 2))


def overlapping(name, m):
    """Eq. 8 of 000, with the sequence that starts at zero."""
    y = np.concatenate(([0.0], np.cumsum(values(name))))
    return math.sqrt(np.mean((y[2 * m :] - 2 * y[m:-m] + y[: -2 * m]) ** 2) / (2 * m * m))


def hadamard(name, m):
    """Eq. 12 of 000, with the averages that it means."""
    y = averages(values(name), m)
    return math.sqrt(np.mean((y[2 * m :] - 2 * y[m:-m] + y[: -2 * m]) ** 2) / 6)


def theo1(name, m):
    """Eq. 6 of 001 as the double sum that it is."""
    x = np.concatenate(([0.0], np.cumsum(values(name))))
    i = np.arange(x.size - m)
    total = np.zeros(i.size)
    for d in range(m // 2):
        ahead = x[i] - x[i - d + m // 2] + x[i + m] - x[i + d + m // 2]
        total += ahead**2 / (m // 2 - d)
    return math.sqrt(total.sum() / (0.75 * (x.size - m) * m**2))


def stability(name, m):
    return np.std(values(name).reshape(-1, m).mean(axis=1), ddof=1)


def kf(name):
    """Eq. 9 of 001: the mean ratio of Allan to Theo1 at the same times, as a factor of the deviation."""
    last = math.floor(0.1 * (values(name).size + 1) / 3 - 3)
    ratios = [(overlapping(name, 9 + 3 * i) / theo1(name, 12 + 4 * i)) ** 2 for i in range(last + 1)]
    return math.sqrt(np.mean(ratios))
