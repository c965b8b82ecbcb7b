"""Squares of the time interval errors of the phase x_0 .. x_N. NIST SP 1065 5.2.18; ITU-T G.810."""

import numpy as np

from tests.reference.terms import indices, mean, require


def mtie(x, m, tau0):
    """The largest peak to peak of m + 1 neighbouring points, squared."""
    require(m < len(x), "m + 1 points")
    windows = np.lib.stride_tricks.sliding_window_view(x, m + 1)
    return (windows.max(axis=1) - windows.min(axis=1)).max() ** 2


def tierms(x, m, tau0):
    """mean_i (x_{i+m} - x_i)^2 over all i."""
    i = indices(len(x) - m)
    return mean((x[i + m] - x[i]) ** 2)
