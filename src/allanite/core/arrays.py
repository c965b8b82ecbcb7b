"""Types of arrays used in annotations, and the samples of a record, made exactly from what is given."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.phrases.phrase import say

from .errors import DataError
from .kinds import KINDS
from .ranges import POSITIVE

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

LARGEST = POSITIVE.high
"""Size of rates, accelerations and coefficients, SI, to which, and down to whose inverse, eighth powers are numbers."""


def complete(values: NDArray[Any]) -> bool:
    """Whether all values are finite, by their sum, without an array of flags."""
    if values.dtype.kind != "f":
        return True
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.isfinite(values.sum(dtype=np.float64)))


def stretches(mask: BoolArray) -> NDArray[np.intp]:
    """First index and index after the last of every run of True, shape (runs, 2)."""
    return np.flatnonzero(np.diff(mask, prepend=False, append=False)).reshape(-1, 2)


def mean_and_deviation(values: FloatArray) -> tuple[float, float]:
    """Mean and standard deviation of the finite values, of any size; NaN if there are none."""
    finite = values if complete(values) else values[np.isfinite(values)]
    if not finite.size:
        return np.nan, np.nan
    scale = max(abs(float(finite.min())), abs(float(finite.max()))) or 1.0
    finite = finite / scale  # whose squares can be represented
    mean = float(finite.mean())
    finite -= mean
    return scale * mean, scale * math.sqrt(finite @ finite / finite.size)


def unmasked(values: Any) -> NDArray[Any]:
    """The values as an array, in which what a masked array of NumPy hides is NaN."""
    hidden = hasattr(values, "filled") and values.dtype.kind in "fiub" and np.any(values.mask)
    return np.asarray(values.astype(np.float64).filled(np.nan) if hidden else values)


def samples(values: Any, unit: str, kind: str, name: str) -> NDArray[Any]:
    """Contiguous float64, or int64 if the samples are integers or the kind is "count"."""
    # They are given as an array, a quantity of pint or astropy, which is converted to `unit`, or a column of pandas or
    # polars.
    if hasattr(values, "to") and (hasattr(values, "magnitude") or hasattr(values, "to_value")):
        quantity = values.to(unit)
        values = quantity.magnitude if hasattr(quantity, "magnitude") else quantity.to_value()
    array = unmasked(values.to_numpy() if hasattr(values, "to_numpy") else values)
    if array.dtype.kind == "O" and hasattr(values, "isna"):  # numbers of pandas, some of which are missing
        array = np.where(values.isna(), np.nan, array)
        array = array.astype(np.float64) if all(isinstance(v, (int, float, np.number)) for v in array) else array
    if array.ndim != 1:
        raise DataError(say("a record is one channel of shape (n,), not {shape}; make a Record of each column ({name})",
                            shape=array.shape, name=name))  # fmt: skip
    if array.dtype.kind not in "fiub":
        raise DataError(say("the samples of {name!r} are of type {dtype}, not real numbers", name=name,
                            dtype=array.dtype))  # fmt: skip
    if len(array) - KINDS[kind][1] < 2:
        raise DataError(say("{name!r} has {count} samples: too few for any statistic", name=name, count=len(array)))
    if kind == "count" or array.dtype.kind in "iu":
        _demand_integers(array, name)
        return np.ascontiguousarray(array, dtype=np.int64)
    return np.ascontiguousarray(array, dtype=np.float64)


def _demand_integers(values: NDArray[Any], name: str) -> None:
    """Refuse counts that are not exactly 64-bit integers."""
    if values.dtype.kind == "f":
        if not np.all(np.abs(values) < 2.0**63):
            raise DataError(say("counts of {name!r} are not all finite 64-bit integers", name=name))
        broken = values != np.floor(values)
        if broken.any():
            first = int(np.argmax(broken))
            raise DataError(say("counts must be integers, but sample {first} of {name!r} is {value:g}; use "
                                "kind='increment'", first=first, name=name, value=values[first]))  # fmt: skip
    elif values.dtype == np.uint64 and values.max() > np.iinfo(np.int64).max:
        raise DataError(say("counts of {name!r} exceed the range of 64-bit integers", name=name))
