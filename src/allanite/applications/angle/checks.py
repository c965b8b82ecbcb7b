"""Checks of the input."""

import math

import numpy as np
from numpy.typing import ArrayLike

from allanite.extending import DataError, FloatArray

MIN_MOTION = 0.01
"""Part of the shortest harmonic's period that an angle must move for its harmonics to be estimated at all."""


def column(name: str, values: ArrayLike, size: int | None = None) -> FloatArray:
    """Finite float64 of shape (n,)."""
    array = np.asarray(values)
    if array.ndim != 1 or array.dtype.kind not in "fiu":
        raise DataError(f"{name} must be real numbers of shape (n,), not {array.dtype} of shape {array.shape}")
    if size is not None and array.size != size:
        raise DataError(f"{name} has {array.size} samples instead of {size}, as many as the others")
    bad = ~np.isfinite(array)
    if bad.any():
        first = int(bad.argmax())
        raise DataError(
            f"{int(bad.sum())} of {bad.size} samples of {name} are not finite, the first at sample {first}; omit "
            "those rows: the samples need not be evenly spaced"
        )
    return np.ascontiguousarray(array, dtype=np.float64)


def demand_increasing(time: FloatArray) -> None:
    """Refuse times that are not increasing."""
    steps = np.diff(time)
    if (steps <= 0).any():
        at = int((steps <= 0).argmax())
        how = "decreases" if steps[at] < 0 else "does not increase"
        raise DataError(
            f"time {how} at sample {at + 1} ({time[at + 1]:.9g} s after {time[at]:.9g} s), "
            f"{int((steps <= 0).sum())} such steps in all; sort the rows by time and remove repeated ones"
        )


def demand_motion(name: str, span: float, orders: tuple[int, ...], remedy: str) -> None:
    """Refuse an angle that stands still; `span` is how far it moves, rad."""
    period = 2 * math.pi / max(orders)
    if span < MIN_MOTION * period:
        raise DataError(
            f"{name} stays within {math.degrees(span):.3g} deg, but a period of its harmonic {max(orders)} is "
            f"{math.degrees(period):.3g} deg: the harmonics of an angle that does not move cannot be separated from "
            f"a constant. {remedy}"
        )
