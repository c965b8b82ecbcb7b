"""What a sinusoid adds to the statistics over windows, exactly: the statistic of the sinusoid itself."""

import math

import numpy as np

from allanite.statistics.row import FloatArray, Statistic
from allanite.terms import NoiseTerm


def response(row: Statistic, term: NoiseTerm, m: int, size: int) -> float:
    """Mean over all phases of a row's variance under a sinusoid of amplitude 1, for a unit sample interval.

    A quadratic form of ``cos(wt + phase)`` has as its mean over the phase half the sum of its values at cosine and
    sine; one window is enough, but where the windows depend on the record.
    """
    n = row.span[0] * m + row.span[1] if row.span[0] else size
    w = 2 * math.pi * term.shape[0]
    angle = w * np.arange(n + 1.0)
    factors = np.array([m])
    sums: list[FloatArray] = [row.sums(wave / w, factors) for wave in (np.cos(angle), np.sin(angle))]
    scale = row.norm(factors)[0] * float(m) ** 2 * row.count(n, factors)[0]
    return float((sums[0][0] + sums[1][0]) / 2 / scale)
