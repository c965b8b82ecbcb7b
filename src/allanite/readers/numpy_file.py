"""NumPy's own files: .npy with one array, .npz with several."""

import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.errors import DataError
from allanite.record import Recording

from .column import Column, headed
from .options import Options
from .table import Table, numbers

TITLE = "NumPy .npy and .npz"

NPY, ZIP, PICKLE = b"\x93NUMPY", b"PK\x03\x04", b"\x80"
_UNIT = re.compile(r"(\s*[\[(][^\[\]()]*[\])])?$")
_RATE_NAMES = ("rate", "fs", "sample_rate", "sampling_rate", "rate_hz", "fs_hz", "sampling_frequency")


def sniff(head: bytes, suffix: str) -> bool:
    """Whether the first bytes, or else the name, are those of a NumPy file."""
    return head.startswith(NPY) or (head.startswith(ZIP) and b".npy" in head[:4096]) or suffix in (".npy", ".npz")


def read(path: str, options: Options) -> Recording:
    """The channels of a .npy or .npz file; pickled objects in it are refused, never loaded.

    A one-dimensional array is one channel; a two-dimensional one has a channel in each column; the fields of a
    structured array, and the arrays of a .npz, are named like the headers of a text, with a unit where they carry one.

    Raises
    ------
    DataError
        The file is damaged, holds objects, or its arrays are not real numbers in columns.
    UsageError
        What the file does not say is not given either.
    """
    arrays, notes = _loaded(path), list[str]()
    columns = list[Column]()
    rate = next(
        (float(a) for name, a in arrays if name.lower() in _RATE_NAMES and a.ndim == 0 and a.dtype.kind in "iuf"), None
    )
    for name, array in arrays:
        for header, values in _columns(name, array, notes):
            columns.append(_column(header, values, len(columns) + 1))
    if not columns:
        raise DataError("the file holds no array of readings")
    return Table(tuple(columns), rate, "the number stored beside the arrays", tuple(notes)).recording(options)


def _loaded(path: str) -> list[tuple[str, NDArray[Any]]]:
    """Names and arrays; the name of a lone array is empty."""
    with Path(path).open("rb") as file:
        head = file.read(1024)
    if head.startswith(PICKLE) or (head.startswith(NPY) and (b"'|O" in head or b"'O'" in head)):
        raise DataError(_objects("the file"))
    if not head.startswith((NPY, ZIP)):
        raise DataError(
            f"the file does not begin like a NumPy file (it begins with {head[:8]!r}); check that it is complete"
        )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # numpy warns of headers that Python 2 wrote, and of odd ones
            return _members(path) if head.startswith(ZIP) else [("", _copied(path))]
    except DataError:
        raise
    except Exception as error:  # numpy, zipfile and zlib raise a dozen types for a damaged file
        raise DataError(f"the file is damaged or was cut off: {type(error).__name__}: {str(error)[:200]}") from None


def _copied(path: str) -> NDArray[Any]:
    # a map compares the size that the header claims with that of the file before any memory is taken
    mapped = np.load(path, mmap_mode="r", allow_pickle=False)
    return np.array(mapped)


def _members(path: str) -> list[tuple[str, NDArray[Any]]]:
    # numpy leaves a file open whose archive is damaged, if it opened the file itself
    with Path(path).open("rb") as file, np.load(file, allow_pickle=False) as archive:
        return [(name, _member(archive, name)) for name in archive.files]


def _member(archive: Any, name: str) -> NDArray[Any]:
    try:
        array = archive[name]
    except ValueError as error:
        raise DataError(
            _objects(f"array {name!r}") if "pickle" in str(error) else f"array {name!r} is damaged: {error}"
        ) from None
    if not isinstance(array, np.ndarray):
        raise DataError(f"{name!r} in the archive is no NumPy array")
    return array


def _objects(what: str) -> str:
    return (
        f"{what} holds pickled Python objects, which are never loaded since they can run code; "
        "save plain numbers: np.save(path, np.asarray(data, dtype=float))"
    )


def _columns(name: str, array: NDArray[Any], notes: list[str]) -> Iterator[tuple[str, NDArray[Any]]]:
    """Headers and one-dimensional arrays."""
    if array.dtype.names:
        for field in array.dtype.names:
            yield from _columns(field, array[field], notes)
    elif array.ndim == 1:
        yield name, array
    elif array.ndim == 2:
        if array.shape[0] < array.shape[1]:
            where = f" in {name!r}" if name else ""
            notes.append(f"the {array.shape[0]} rows of {array.shape[1]} values{where} are taken as channels")
            array = array.T
        for i in range(array.shape[1]):
            yield _UNIT.sub(rf" {i + 1}\1", name, count=1) if name else "", array[:, i]
    elif array.ndim > 2:
        raise DataError(f"array {name!r} has the shape {array.shape}; a column for each channel is expected")
    elif name.lower() not in _RATE_NAMES:
        notes.append(f"the single value {name!r} was not used")


def _column(header: str, values: NDArray[Any], position: int) -> Column:
    if values.dtype.kind in "Mm":
        return headed(
            values.astype(f"{values.dtype.kind}8[ns]").astype(np.int64), position, header or "time", unit="ns"
        )
    if values.dtype.kind in "USb?":
        return headed(np.empty(0), position, header, text=str(values[0]) if len(values) else "text")
    return headed(numbers(values, header or f"column {position}"), position, header)
