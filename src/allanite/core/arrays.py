"""Types of arrays used in annotations, and whether an array has a value everywhere."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


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
