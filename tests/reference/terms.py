"""What every referee shares: it is defined where at least one of its terms exists, and nowhere else."""

import numpy as np


class UndefinedError(ValueError):
    """The statistic has no term at this averaging factor."""


def require(condition, words):
    if not condition:
        raise UndefinedError(words)


def mean(values):
    """The mean of one term at least."""
    require(len(values) > 0, "no term")
    return np.sum(values) / len(values)


def indices(count):
    """0, 1, ..., count - 1; none if the count is not positive."""
    return np.arange(max(count, 0))


def rate(x, tau0):
    """y_k = (x_{k+1} - x_k) / tau0, the mean rate over each interval."""
    return (x[1:] - x[:-1]) / tau0


def phase(y, tau0=1):
    """x_0 = 0, x_{k+1} = x_k + tau0 y_k."""
    x = [y[0] * 0]
    for value in y:
        x.append(x[-1] + value * tau0)
    return np.array(x)
