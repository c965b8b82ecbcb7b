"""Raw binary: rows of numbers and nothing else. It has no signature, so it is read only if the user says so."""

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError, UsageError, given
from allanite.core.record import Recording
from allanite.phrases.phrase import spelled
from allanite.readers.columns.column import column
from allanite.readers.columns.lines import HEAD_ROWS, Parts, Rows, columns_of
from allanite.readers.columns.table import FileTable
from allanite.readers.options import Options

TITLE = "raw binary (give its dtype)"


def read(path: str, options: Options) -> Recording:
    """The channels of rows of binary numbers."""
    row, offset, count = _layout(path, options)
    return _table(np.memmap(path, row, mode="r", offset=offset, shape=(count,))).recording(options)


def parts(path: str, options: Options) -> Parts:
    """The rows, which are read one after the other."""
    row, offset, count = _layout(path, options)
    head = _table(np.array(np.memmap(path, row, mode="r", offset=offset, shape=(min(count, HEAD_ROWS),))))
    return Parts(head, count, Rows(path, row.base, offset, (count, *row.shape)).blocks, options)


def _layout(path: str, options: Options) -> tuple[np.dtype[Any], int, int]:
    """The type of a row, the bytes before the first one, and their number."""
    dtype, columns, offset = options.dtype or "", options.columns, options.offset or 0
    try:
        row = np.dtype(dtype)
    except (TypeError, ValueError, SyntaxError, OverflowError):
        row = np.dtype(object)
    if not _real(row) or not row.itemsize:
        raise UsageError(
            f"unknown number type {given(dtype)}; types are written as in NumPy: i1 i2 i4 i8, u1 u2 u4 u8, f4 f8, with "
            "> in front for big-endian, as in '>i2'; 'u4,6i2' for rows of mixed types"
        )
    if columns is not None:
        option = spelled(f"--columns {columns}", f"columns={columns}")
        if row.names:
            raise UsageError(f"the type {dtype!r} describes a whole row; omit {option}")
        try:
            row = np.dtype((row, (columns,)))
        except (ValueError, OverflowError):
            raise UsageError(f"{option} is more than a row can have") from None
    size = os.path.getsize(path) - offset
    if size <= 0:
        raise DataError(f"the file has {size + offset} bytes and ends before the offset of {offset}; check the offset")
    count, over = divmod(size, row.itemsize)
    if over:
        have = f"{size} bytes after the offset of {offset}" if offset else f"{size} bytes"
        raise DataError(
            f"the file has {have}, which is not a multiple of the {row.itemsize} bytes of a row: {count} rows and "
            f"{over} bytes remain; check {spelled('--dtype, --columns and --offset', 'dtype, columns and offset')}"
        )
    return row, offset, count


def _table(rows: NDArray[Any]) -> FileTable:
    return FileTable(tuple(column("", values, i) for i, values in enumerate(columns_of(rows), 1)))


def _real(number: np.dtype[Any]) -> bool:
    if number.names:
        return all(_real(number[name]) for name in number.names)
    return number.base.kind in "iuf"
