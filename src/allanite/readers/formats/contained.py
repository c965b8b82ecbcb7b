"""The recording in a file whose contents are listed by a separate process: HDF5, MATLAB, R."""

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.record import Recording
from allanite.phrases.phrase import say
from allanite.readers.columns.column import RATE_NAMES, some
from allanite.readers.columns.containers import Dataset, arranged_datasets, rated
from allanite.readers.columns.lines import HEAD_ROWS, Parts, Rows, columns_of
from allanite.readers.columns.table import KEY
from allanite.readers.options import Options
from allanite.readers.sandbox.process import Process, demand_size, worded

NAMES: dict[str, Any] = {"rates": RATE_NAMES, "text": KEY}  # what a process looks for in the file


def contained(form: str, path: str, options: Options, *, transposed: bool = False) -> Recording:
    """The channels of a file that `sandbox.worker` opens; with `transposed`, its arrays are transposed."""
    with Process(form, path, options.progress, NAMES) as process:
        datasets = _listed(process, transposed=transposed)
        numbers, text = process.contents["numbers"], process.contents["description"]
        table, options, _ = arranged_datasets(rated(datasets, numbers), options, _left(process), text)
        return table.recording(options)


def contained_parts(form: str, path: str, options: Options) -> Parts | None:
    """The rows of datasets that are read side by side; None if they have no rows in common."""
    with Process(form, path, names=NAMES) as process:
        places = {str(item["path"]): item.get("offset") for item in process.contents["datasets"]}
        datasets = _listed(process)
        numbers, notes, text = process.contents["numbers"], _left(process), process.contents["description"]

    def source(dataset: Dataset, rows: int, stack: ExitStack) -> Iterator[NDArray[Any]]:
        # the rows of the file itself, or sent by a process of its own
        demand_size(math.prod(dataset.shape) * dataset.dtype.itemsize, path, f"dataset {dataset.path!r}")
        if (offset := places[dataset.path]) is not None:
            return Rows(path, dataset.dtype, offset, dataset.shape).whole(rows)
        process = stack.enter_context(Process(form, path, names=NAMES))
        return process.parts(dataset.path, dataset.shape, dataset.dtype, rows)

    def first_rows(dataset: Dataset) -> NDArray[Any]:
        with ExitStack() as stack:
            return next(source(dataset, HEAD_ROWS, stack))

    datasets = [replace(dataset, load=partial(first_rows, dataset)) for dataset in datasets]
    table, options, family = arranged_datasets(rated(datasets, numbers), options, notes, text)
    shapes = {dataset.shape[0] for dataset in family}
    if len(shapes) > 1 or any(len(d.shape) == 2 and d.shape[0] < d.shape[1] for d in family):
        return None
    owners = [(i, j) for i, dataset in enumerate(family) for j in range(len(dataset.headers))]

    def blocks(wanted: Sequence[int], rows: int) -> Iterator[list[NDArray[Any]]]:
        used = sorted({owners[k][0] for k in wanted})
        with ExitStack() as stack:
            sources = [source(family[i], rows, stack) for i in used]
            for rows_of_each in zip(*sources, strict=True):
                columns = dict(zip(used, map(columns_of, rows_of_each), strict=True))
                yield [columns[owners[k][0]][owners[k][1]] for k in wanted]

    return Parts(table, shapes.pop(), blocks, options)


def _listed(process: Process, *, transposed: bool = False) -> list[Dataset]:
    with worded():
        return [
            _dataset(item, process.contents["texts"], process, transposed=transposed)
            for item in process.contents["datasets"]
        ]


def _left(process: Process) -> list[str]:
    names = [str(name) for name in process.contents["left"]]
    return [say("left out, not numbers: {names}", names=some(names))] if names else []


def _dataset(item: Mapping[str, Any], texts: Mapping[str, Any], process: Process, *, transposed: bool) -> Dataset:
    where, shape = str(item["path"]), tuple(int(side) for side in item["shape"])
    fields = [(str(name), str(kind), tuple(shape)) for name, kind, shape in item["fields"]]
    dtype = np.dtype(fields[0][1] if fields[0][0] == "" else fields)
    turned = shape[::-1] if transposed else shape
    if transposed and len(turned) == 2 and min(turned) == 1:  # a vector of MATLAB
        turned = (max(turned),)

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
