"""The Allan variance as the standards print it (NIST SP 1065 eqs. 8 and 11), in literal lines, any number type."""

from itertools import pairwise


def phase(y, interval=1):
    """x_0 = 0, x_{k+1} = x_k + tau0 y_k."""
    x = [y[0] * 0]
    for value in y:
        x.append(x[-1] + value * interval)
    return x


def adev(y, m, interval=1):
    """Variance from block means: half the mean squared difference of neighbours."""
    means = [sum(y[i : i + m]) / m for i in range(0, len(y) - m + 1, m)]
    differences = [(b - a) ** 2 for a, b in pairwise(means)]
    return sum(differences) / (2 * len(differences))


def oadev(y, m, interval=1):
    """Variance from every second difference of the phase."""
    x = phase(y, interval)
    squares = [(x[i + 2 * m] - 2 * x[i + m] + x[i]) ** 2 for i in range(len(x) - 2 * m)]
    return sum(squares) / (2 * (m * interval) ** 2 * len(squares))


REFEREES = {"adev": adev, "oadev": oadev}
