"""The recording in a file whose contents are listed by a separate process: HDF5, MATLAB, R."""

import math
import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.language import say
from allanite.core.record import Recording
from allanite.readers.columns.arrays import RATE_NAMES
from allanite.readers.columns.column import some
from allanite.readers.columns.datasets import Dataset, rated, recording
from allanite.readers.columns.table import KEY
from allanite.readers.options import Options
from allanite.readers.sandbox.guard import demand_size, worded
from allanite.readers.sandbox.process import Process


def contained(form: str, path: str, options: Options, *, transposed: bool = False) -> Recording:
    """The channels of a file that `sandbox.worker` opens; with `transposed`, its arrays are transposed."""
    with Process(form, path, {"rates": RATE_NAMES, "text": KEY}) as process:
        said = process.said
        with worded():
            found = [_dataset(item, said["texts"], process, transposed=transposed) for item in said["datasets"]]
        left = [str(name) for name in said["left"]]
        notes = [say("left out, not numbers: {names}", names=some(left))] if left else []
        return recording(rated(found, said["numbers"]), options, notes, said["description"])


def _dataset(item: Mapping[str, Any], texts: Mapping[str, Any], process: Process, *, transposed: bool) -> Dataset:
    where, shape = str(item["path"]), tuple(int(side) for side in item["shape"])
    fields = [(str(name), str(kind), tuple(shape)) for name, kind, shape in item["fields"]]
    dtype = np.dtype(fields[0][1] if fields[0][0] == "" else fields)
    turned = _turned(shape) if transposed else shape

    def load() -> NDArray[Any]:
        size, offset = math.prod(shape) * dtype.itemsize, item.get("offset")
        demand_size(size, process.path, f"dataset {where!r}")
        if offset is not None and offset + size <= os.path.getsize(process.path):
            array: NDArray[Any] = np.memmap(process.path, dtype, mode="r", offset=offset, shape=shape)
        else:
            array = process.load(where, shape, dtype)
        return array.T.reshape(turned) if transposed else array

    unit, names = _said(item, texts)
    source = say("the frequency of the time series in the file") if "rate" in item else ""
    return Dataset(where, turned, dtype, load, unit, names, item.get("rate"), source)


def _turned(shape: tuple[int, ...]) -> tuple[int, ...]:
    """The shape of a MATLAB array; for a vector only its length."""
    turned = shape[::-1]
    return (max(turned),) if len(turned) == 2 and min(turned) == 1 else turned


def _said(item: Mapping[str, Any], texts: Mapping[str, Any]) -> tuple[str, tuple[str, ...]]:
    """Unit and names of columns, which may include units."""
    # pandas stores the names separately from the numbers
    beside = texts.get(str(item["path"]).removesuffix("_values") + "_items")
    names = next((item[n] for n in ("columns", "names", "channels", "labels") if isinstance(item.get(n), list)), beside)
    units = item.get("units", item.get("unit"))
    names = [str(name) for name in names] if isinstance(names, list) else []
    if isinstance(units, list) and len(units) == len(names) > 1:
        return "", tuple(f"{name} [{unit}]" if unit else name for name, unit in zip(names, units, strict=True))
    if isinstance(units, list) and len(set(units)) == 1:
        units = units[0]
    return units if isinstance(units, str) else "", tuple(names)
