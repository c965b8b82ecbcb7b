"""Arrays of numbers as columns: a row of a matrix, a field of a structure, or the array itself."""

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError

from .column import Column, headed
from .table import numbers

RATE_NAMES = (
    "rate", "fs", "sample_rate", "samplerate", "sampling_rate", "rate_hz", "fs_hz", "sampling_frequency", "freq",
    "frequency", "imu_rate", "samplingrate",
)  # fmt: skip
"""Names under which a container keeps its sampling rate in Hz."""

_UNIT = re.compile(r"(\s*[\[(][^\[\]()]*[\])])?$")


def split(name: str, array: NDArray[Any], names: tuple[str, ...] = ()) -> Iterator[tuple[str, NDArray[Any]]]:
    """Headers and one-dimensional arrays; of a matrix, the longer side is time.

    Parameters
    ----------
    name, array
        The array and what its file calls it.
    names : tuple of str
        Names of the columns of a matrix, if the file has them.

    Raises
    ------
    DataError
        The array has more than two dimensions.

    Examples
    --------
    >>> import numpy as np
    >>> [(header, len(values)) for header, values in split("gyro [deg/s]", np.zeros((3, 50)))]
    [('gyro 1 [deg/s]', 50), ('gyro 2 [deg/s]', 50), ('gyro 3 [deg/s]', 50)]
    """
    if array.dtype.names:
        for field in array.dtype.names:
            yield from split(field, array[field])
    elif array.ndim == 1:
        yield name, array
    elif array.ndim == 2:
        upright = array.T if turned(array) else array
        said = names if len(names) == upright.shape[1] else ()
        for i in range(upright.shape[1]):
            numbered = _UNIT.sub(rf" {i + 1}\1", name, count=1) if name else ""
            yield said[i] if said else numbered, upright[:, i]
    elif array.ndim > 2:
        raise DataError(f"array {name!r} has the shape {array.shape}; a column for each channel is expected")


def turned(array: NDArray[Any]) -> bool:
    """Whether the channels of a matrix are its rows."""
    return array.ndim == 2 and not array.dtype.names and array.shape[0] < array.shape[1]


def turned_note(name: str, array: NDArray[Any]) -> str:
    """What was assumed about such a matrix."""
    where = f" in {name!r}" if name else ""
    return f"the {array.shape[0]} rows of {array.shape[1]} values{where} are taken as channels"


def column(header: str, values: NDArray[Any], position: int, *, unit: str = "") -> Column:
    """A column of any type that arrays have; stamps of NumPy become nanoseconds, text and truth values a text."""
    if values.dtype.kind in "Mm":
        stamps = values.astype(f"{values.dtype.kind}8[ns]").astype(np.int64)
        return headed(stamps, position, header or "time", unit="ns")
    if values.dtype.kind in "USb?":
        return headed(np.empty(0), position, header, text=str(values[0]) if len(values) else "text")
    return headed(numbers(values, header or f"column {position}"), position, header, unit=unit)
