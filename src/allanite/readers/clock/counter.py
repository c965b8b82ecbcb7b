"""Counters of samples or packets: they tell what was lost where stamps do not."""

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.readers.columns.column import Column

from .findings import lost_samples
from .grid import Grid, Places
from .stamps import MOST_LOST

_NAME = re.compile(
    r"packet|counter|(^|[^a-z])(cnt|ctr|count|seq|sequence|samples?|index|idx|frame|row|no|id)([^a-z]|$)"
)
_WRAPS = (8, 16, 32, 31)


def find(columns: list[Column], clock: Column | None) -> Column | None:
    """The column that counts samples, by its name, if there are holes in what it counts."""
    named = (column for column in columns if column is not clock and _NAME.search(column.name.strip().lower()))
    return next((column for column in named if places(column) is not None), None)


def unwrapped(values: NDArray[Any]) -> tuple[NDArray[Any], int]:
    """Integers that start again at a power of two, continued; and that power, 0 if they never do.

    Examples
    --------
    >>> unwrapped(np.array([250, 253, 0, 3, 6]))
    (array([250, 253, 256, 259, 262]), 8)
    """
    if not np.issubdtype(values.dtype, np.integer) or len(values) < 2:
        return values, 0
    steps = np.diff(values.astype(np.int64))
    back = steps < 0
    usual = float(np.median(np.abs(steps)))
    for bits in _WRAPS if back.any() else ():
        # a step over the end is as any other once the end is added
        over = steps[back] + 2**bits
        inside = values.min() >= 0 and values.max() < 2**bits
        if inside and over.min() >= 0 and np.median(over) <= 3 * usual and over.max() < 2 ** (bits - 1):
            steps[back] = over
            return np.concatenate(([int(values[0])], int(values[0]) + np.cumsum(steps))), bits
    return values, 0


def places(column: Column) -> Places | None:
    """The places of the rows by a counter; None if it counts no samples, or none is missing."""
    values = column.values
    if values.dtype.kind == "f" and len(values) and np.all(values == np.floor(values)) and np.abs(values).max() < 2**53:
        values = values.astype(np.int64)
    if not np.issubdtype(values.dtype, np.integer) or len(values) < 10:
        return None
    steps = np.diff(unwrapped(values)[0].astype(np.int64))
    if steps.min() < 1 or steps.min() == steps.max():
        return None
    counted = np.concatenate(([0], np.cumsum(steps // np.gcd.reduce(steps))))
    return counted if counted[-1] + 1 - counted.size <= MOST_LOST * counted[-1] else None


def grid(column: Column | None, interval: float) -> Grid | None:
    """The grid that a counter says; None if there is nothing to say."""
    where = None if column is None else places(column)
    if column is None or where is None:
        return None
    return Grid(interval, None, where, (lost_samples(where, interval, f"by the counter {column.label}"),))
