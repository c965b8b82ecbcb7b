"""Rows of binary numbers in a file, read one after the other without a map, whose pages would count as memory."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError


@dataclass(frozen=True)
class Rows:
    """Rows of numbers of one type after `offset` bytes; `shape` is (rows,) or (rows, columns).

    With `bycolumn` the columns are stored one after the other. A structured type has a column for each number.
    """

    path: str
    dtype: np.dtype[Any]
    offset: int
    shape: tuple[int, ...]
    bycolumn: bool = False

    def blocks(self, wanted: Sequence[int], rows: int) -> Iterator[list[NDArray[Any]]]:
        """Columns of so many rows at a time."""
        if not self.bycolumn or len(self.shape) == 1:
            for part in self.whole(rows):
                every = columns_of(part)
                yield [every[i] for i in wanted]
            return
        with open(self.path, "rb", buffering=0) as file:
            for begin in range(0, self.shape[0], rows):
                count = min(rows, self.shape[0] - begin)
                yield [self._numbers(file, (i * self.shape[0] + begin, count), (count,)) for i in wanted]

    def whole(self, rows: int) -> Iterator[NDArray[Any]]:
        """So many rows at a time, with all columns."""
        width = math.prod(self.shape[1:])
        with open(self.path, "rb", buffering=0) as file:
            for begin in range(0, self.shape[0], rows):
                count = min(rows, self.shape[0] - begin)
                yield self._numbers(file, (begin * width, count * width), (count, *self.shape[1:]))

    def _numbers(self, file: Any, place: tuple[int, int], shape: tuple[int, ...]) -> NDArray[Any]:
        """So many numbers from a place on."""
        begin, count = place
        found = np.empty(count, self.dtype)
        data, filled = found.view(np.uint8).reshape(-1).data, 0
        file.seek(self.offset + begin * self.dtype.itemsize)
        while filled < len(data) and (more := file.readinto(data[filled:])):
            filled += more
        if filled < len(data):
            raise DataError(f"the file ends in the middle of its numbers, at byte {file.tell()}")
        return found.reshape(shape)


def columns_of(rows: NDArray[Any]) -> list[NDArray[Any]]:
    """The columns of rows, one for each number."""
    if rows.dtype.names:
        return [column for name in rows.dtype.names for column in columns_of(rows[name])]
    return list(rows.reshape(len(rows), -1).T)
