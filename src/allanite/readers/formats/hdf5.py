"""HDF5 files, and MATLAB's MAT 7.3, which are HDF5 with every array transposed."""

import math
import os
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError
from allanite.core.record import Recording
from allanite.readers.columns.dataset import Dataset
from allanite.readers.columns.datasets import rated, recording
from allanite.readers.columns.description import KEY, described, keys
from allanite.readers.options import Options
from allanite.readers.sandbox.guard import demand_size, library, worded
from allanite.readers.sandbox.hdf5_process import Process

TITLE = "HDF5 .h5 and MATLAB 7.3 .mat (pip install 'allanite[hdf5]')"

SIGNATURE = b"\x89HDF\r\n\x1a\n"
MATLAB = b"MATLAB 7.3"
_PLACES = (0, 512, 1024, 2048, 4096, 8192, 16384, 32768)


def sniff(head: bytes, suffix: str) -> bool:
    """Whether the signature stands at one of its places, or the name is that of an HDF5 file."""
    return _signed(head) or head.startswith(MATLAB) or suffix in (".h5", ".hdf5", ".hdf")


def _signed(head: bytes) -> bool:
    return any(head[at : at + 8] == SIGNATURE for at in _PLACES)


def read(path: str, options: Options) -> Recording:
    """The channels of an HDF5 file: datasets of one length and clock, with units and rates from their attributes.

    Raises
    ------
    DataError
        The file is damaged, claims more than it can hold, or has no dataset of readings.
    UsageError
        It holds several recordings and none is chosen, h5py is not installed, or something is not said.
    """
    with open(path, "rb") as file:
        head = file.read(_PLACES[-1] + 8)
    if not _signed(head):
        raise DataError(
            f"the file does not begin like an HDF5 file (it begins with {head[:8]!r}); check that it is complete"
        )
    with Process(path) as process:
        said, matlab = process.said, head.startswith(MATLAB)
        with worded():
            found = [_dataset(item, said["texts"], path, process, matlab) for item in said["datasets"]]
        notes = [f"left out, no numbers: {', '.join(map(str, said['left'][:20]))}"] if said["left"] else []
        return recording(rated(found, said["numbers"]), options, notes, said["description"])


def write(recording: Recording, path: str) -> None:
    """A dataset for each channel with its unit as attribute, the rate as attribute of the file."""
    h5py = library("h5py", "hdf5")
    with h5py.File(path, "w", track_order=True) as file:
        file.attrs["rate"] = recording[0].rate
        for name, record in zip(keys(recording), recording, strict=True):
            file.create_dataset(name, data=record.values).attrs["units"] = record.unit
        file[KEY] = described(recording)


def _dataset(item: Mapping[str, Any], texts: Mapping[str, Any], path: str, process: Process, matlab: bool) -> Dataset:
    where, shape = str(item["path"]), tuple(int(side) for side in item["shape"])
    dtype = _dtype(item["fields"])
    load = partial(_loaded, process, (where, shape, dtype, item["offset"]), path, matlab)
    unit, names = _said(item, texts)
    return Dataset(where, _turned(shape) if matlab else shape, dtype, load, unit=unit, names=names)


def _dtype(fields: Sequence[Sequence[Any]]) -> np.dtype[Any]:
    named = [(str(name), str(kind), tuple(shape)) for name, kind, shape in fields]
    return np.dtype(named[0][1] if named[0][0] == "" else named)


def _loaded(
    process: Process, what: tuple[str, tuple[int, ...], np.dtype[Any], int | None], path: str, matlab: bool
) -> NDArray[Any]:
    where, shape, dtype, offset = what
    size = math.prod(shape) * dtype.itemsize
    demand_size(size, path, f"dataset {where!r}")
    if offset is not None and offset + size <= os.path.getsize(path):
        array: NDArray[Any] = np.memmap(path, dtype, mode="r", offset=offset, shape=shape)
    else:
        array = process.load(where, shape, dtype)
    return array.T.reshape(_turned(shape)) if matlab else array


def _turned(shape: tuple[int, ...]) -> tuple[int, ...]:
    """The shape of a MATLAB array; of a vector its length alone."""
    turned = shape[::-1]
    return (max(turned),) if len(turned) == 2 and min(turned) == 1 else turned


def _said(item: Mapping[str, Any], texts: Mapping[str, Any]) -> tuple[str, tuple[str, ...]]:
    """Unit and names of columns, which may carry units of their own."""
    # pandas keeps the names beside the numbers
    beside = texts.get(str(item["path"]).removesuffix("_values") + "_items")
    names = next((item[n] for n in ("columns", "names", "channels", "labels") if isinstance(item.get(n), list)), beside)
    units = item.get("units", item.get("unit"))
    names = [str(name) for name in names] if isinstance(names, list) else []
    if isinstance(units, list) and len(units) == 1:
        units = units[0]
    if isinstance(units, list) and len(units) == len(names):
        return "", tuple(f"{name} [{unit}]" if unit else name for name, unit in zip(names, units, strict=True))
    if isinstance(units, list) and len(set(units)) == 1:
        units = units[0]
    return units if isinstance(units, str) else "", tuple(names)
