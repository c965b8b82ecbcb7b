"""Power laws of the rate's spectrum as structure functions of the angle; the sample interval is 1."""

from types import SimpleNamespace

import numpy as np
from scipy.special import sici

from allanite.terms import TERMS
from tests.reference.dense import moments, quadratic_form


def flicker_of_the_angle(t):
    """2 (gamma + ln 2 pi fh t - Ci(2 pi fh t)) with the sharp cut-off fh = 1/2."""
    u = np.pi * np.where(t > 0, t, 1.0)
    return np.where(t > 0, 2 * (np.euler_gamma + np.log(u) - sici(u)[1]), 0.0)


STRUCTURES = {2: TERMS["Q"].structure, 1: flicker_of_the_angle, 0: TERMS["N"].structure, -1: TERMS["B"].structure,
              -2: TERMS["K"].structure, -3: lambda t: t**4 * np.log(np.where(t > 0, t, 1.0)),
              -4: lambda t: t**5}  # fmt: skip
LAWS = {alpha: SimpleNamespace(structure=D, waveform=None) for alpha, D in STRUCTURES.items()}
"""alpha -> what `dense.moments` takes for a term."""


def exact_edf(row, alpha, m, n):
    """Degrees of freedom 2 E^2 / Var of a statistic under a power law, from full matrices."""
    if row.overlapped:
        return 1 / moments(quadratic_form(row, m, n), [LAWS[alpha]])[1][0, 0]
    weights, filters = row.window(m)
    A = np.zeros((n + 1, n + 1))
    for i in range(0, n - filters.shape[1] + 2, m):
        here = slice(i, i + filters.shape[1])
        A[here, here] += (filters.T * weights) @ filters
    return 1 / moments(A, [LAWS[alpha]])[1][0, 0]
