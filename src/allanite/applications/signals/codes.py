"""Which codes of a converter occur in a record."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from allanite.extending import Value

FloatArray = NDArray[np.float64]

OFF = 0.05
"""Distance from the grid, in steps, up to which a reading printed with rounding lies on it."""

OFTEN = 20
"""Occurrences of the codes on both sides of one that never occurs, from which it is missing: by chance once in 1e8."""

MOST = 1 << 24
"""Codes between the least and the largest up to which they are counted out."""


@dataclass(frozen=True, repr=False)
class Codes(Value):
    """How many different codes occur, between how many there are, and how many are missing among frequent ones."""

    distinct: int
    span: int
    missing: int


def codes(readings: FloatArray) -> Codes | None:
    """Codes of samples in steps, which may share an offset; None if they lie on no grid of one step.

    Examples
    --------
    >>> codes(np.repeat([0.0, 1.0, 3.0, 4.0], 50) + 0.3)
    <Codes distinct=4 span=5 missing=1>
    >>> codes(np.linspace(0.0, 3.0, 50)) is None
    True
    """
    x = readings[np.isfinite(readings)]
    if not x.size:
        return None
    x = x - x[0]
    grid = np.rint(x)
    if np.mean(np.abs(x - grid) > OFF) > 1e-3 or np.ptp(grid) > MOST:
        return None
    count = np.bincount((grid - grid.min()).astype(np.int64))
    seen = np.flatnonzero(count)
    gaps = np.diff(seen) - 1
    beside = np.minimum(count[seen[:-1]], count[seen[1:]])
    return Codes(seen.size, count.size, int(gaps[beside >= OFTEN].sum()))
