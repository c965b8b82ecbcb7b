"""Types of arrays used in annotations, and what is asked of values of any size."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

RATES = (1e-9, 1e15)
"""Sampling rates, Hz: beyond them powers of averaging times are not numbers any more."""

LARGEST = 1e30
"""Size of rates, accelerations and coefficients, SI, to which, and down to whose inverse, eighth powers are numbers."""


def complete(values: NDArray[Any]) -> bool:
    """Whether all values are finite, by their sum, without an array of flags.

    Examples
    --------
    >>> complete(np.array([1.0, np.nan])), complete(np.array([np.inf, -np.inf])), complete(np.arange(3))
    (False, False, True)
    """
    if values.dtype.kind != "f":
        return True
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.isfinite(values.sum(dtype=np.float64)))


def mean_and_deviation(values: FloatArray) -> tuple[float, float]:
    """Mean and standard deviation of the finite values, of any size; NaN if there are none.

    Examples
    --------
    >>> mean_and_deviation(np.array([4e300, np.nan, 0.0]))
    (2e+300, 2e+300)
    """
    there = values[np.isfinite(values)]
    if not there.size:
        return np.nan, np.nan
    scale = float(np.abs(there).max()) or 1.0
    there = there / scale  # whose squares can be represented
    return scale * float(there.mean()), scale * float(there.std())
