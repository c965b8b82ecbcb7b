"""Bins of the coefficients of a transform."""

import numpy as np

from allanite.core.arrays import IntArray

SINGLE = 64
"""Coefficients below and at this index stand in bins of their own."""

PER_OCTAVE = 16
"""Bins per octave above."""


def edges_of(n: int) -> IntArray:
    """Bounds of the bins, from 1 to n."""
    single = np.arange(1, min(SINGLE, n - 1) + 2)
    if n - 1 <= SINGLE:
        return single
    octaves = np.log2((n - 1) / SINGLE)
    above = SINGLE * 2.0 ** (np.arange(1, int(octaves * PER_OCTAVE) + 1) / PER_OCTAVE)
    inner = np.unique(np.rint(above).astype(np.int64)) + 1
    return np.concatenate((single, inner[(inner > SINGLE + 1) & (inner < n)], [n]))
