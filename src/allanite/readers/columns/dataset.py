"""Dataset: an array in a container, before it is loaded."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import headers
from .arrays import split

WIDEST = 1000
"""Columns of a dataset; what has more is an image or a matrix, not a recording."""


@dataclass(frozen=True, eq=False)
class Dataset:
    """An array in a container, before it is loaded.

    Parameters
    ----------
    path : str
        Where it is, as ``"imu0/gyro"``.
    shape, dtype
        As the container declares them.
    load : callable
        Reads it.
    unit, names, rate
        What its attributes say: unit, names of its columns, sampling rate in Hz.
    source : str
        Where the rate is known from.
    """

    path: str
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    load: Callable[[], NDArray[Any]]
    unit: str = ""
    names: tuple[str, ...] = ()
    rate: float | None = None
    source: str = ""

    @property
    def length(self) -> int:
        """Samples: the longer side of a matrix."""
        return max(self.shape)

    @property
    def parent(self) -> str:
        """The path of the group that holds it."""
        return self.path.rpartition("/")[0]

    @property
    def leaf(self) -> str:
        """The last part of the path."""
        return self.path.rpartition("/")[2]

    @property
    def is_series(self) -> bool:
        """Whether it may hold readings: real numbers, one row for each sample."""
        fields = [self.dtype[name] for name in self.dtype.names] if self.dtype.names else [self.dtype]
        flat = all(f.base.kind in "iufMm" and len(self.shape) + len(f.shape) <= 2 for f in fields)
        return flat and len(self.shape) in (1, 2) and self.length > 1 and 0 < len(self.headers) <= WIDEST

    @property
    def headers(self) -> tuple[str, ...]:
        """Names of the columns that it makes; not more than one over `WIDEST`."""
        standin = np.broadcast_to(np.zeros((), self.dtype), self.shape)  # the shape without the memory
        return tuple(header for header, _ in islice(split(self.path, standin, self.names), WIDEST + 1))

    @property
    def is_clock(self) -> bool:
        """Whether it holds stamps, by its unit or its name."""
        return headers.is_time(self.unit) or headers.clock_rank(headers.split(self.leaf)[0]) < 2

    @property
    def is_sensor(self) -> bool:
        """Whether a unit or a name is that of an inertial sensor."""
        said = [headers.split(header) for header in (self.path, *self.headers)]
        units = [self.unit, *(unit for _, unit in said)]
        names = [text for name, _ in said for text in (name, name.rpartition("/")[2])]
        return any(map(headers.inertial, units)) or any(map(headers.sensor_by_name, names))

    def __str__(self) -> str:
        return f"{self.path} ({' x '.join(map(str, self.shape))})"
