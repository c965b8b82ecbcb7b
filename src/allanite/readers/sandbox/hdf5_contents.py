"""The contents of an HDF5 file, read with h5py; started by `worker`.

Attributes and links are followed only within the file.
"""

import math
import os
import sys
from collections.abc import Callable, Iterator
from typing import Any

import h5py
import numpy as np

MOST_OBJECTS, DEEPEST = 10_000, 32
BLOCK, MOST_CHUNKS = 8 << 20, 2000  # of which the library keeps 4 kB each
COST = 400  # finding a chunk takes as long as sending so many bytes
WANTED = ("unit", "units", "columns", "names", "channels", "labels", "matlab_class", "matlab_empty")


def opened(path: str, most: int, names: dict[str, Any]) -> tuple[dict[str, Any], Callable[..., Any]]:
    """Datasets, single numbers and texts with their paths, and a function that sends a dataset; see `worker.main`."""
    file = h5py.File(path, "r", rdcc_nbytes=BLOCK)

    def load(where: str, fields: list[str]) -> tuple[int, Iterator[Any]]:
        dataset = file[where]
        chunks = min(_chunks(dataset), os.path.getsize(path) // 8)  # no more than the file has room for
        return dataset.size * dataset.dtype.itemsize + chunks * COST, _blocks(dataset, fields)

    return Listing(file, most, {*names["rates"], *WANTED}, names["text"]).contents, load


class Listing:
    """The contents of a file: datasets of numbers, single numbers and texts with their paths, and what is ignored."""

    def __init__(self, file: Any, most: int, wanted: set[str], text: str) -> None:
        self.most, self.wanted, self.text = most, wanted, text
        self.seen: set[Any] = set()
        self.contents: dict[str, Any] = {"datasets": [], "numbers": {}, "texts": {}, "left": [], "description": ""}
        self._attributes(file, "")
        self._group(file, "", 0)

    def _group(self, group: Any, path: str, depth: int) -> None:
        for name in group:
            where = f"{path}/{name}".lstrip("/")
            if name in ("#refs#", "#subsystem#"):
                continue
            # other links may refer to any file on this machine
            link = not isinstance(group.get(name, getlink=True), h5py.HardLink)
            if depth > DEEPEST or link:
                self.contents["left"].append(where + " (a link, which is not followed)" * link)
                continue
            item = group[name]
            info = h5py.h5o.get_info(item.id)
            token = (info.fileno, info.addr)
            if token not in self.seen:
                self.seen.add(token)
                if len(self.seen) > MOST_OBJECTS:
                    how = "copy the datasets to a file of their own with h5copy"
                    sys.exit(f"too many objects: more than {MOST_OBJECTS}; {how}")
                if isinstance(item, h5py.Group):
                    self._attributes(item, where)
                    self._group(item, where, depth + 1)
                elif isinstance(item, h5py.Dataset):
                    self._dataset(item, where)

    def _attributes(self, found: Any, path: str) -> dict[str, Any]:
        attributes = {name: _plain(found.attrs[name]) for name in found.attrs if name.lower() in self.wanted}
        for name, value in attributes.items():
            if isinstance(value, float):
                self.contents["numbers"][f"{path}/{name}".lstrip("/")] = value
        return {name.lower(): value for name, value in attributes.items()}

    def _dataset(self, dataset: Any, path: str) -> None:
        attributes = self._attributes(dataset, path)
        kind = dataset.dtype
        other = attributes.get("matlab_class") in ("char", "cell", "struct", "function_handle", "logical")
        if other or "matlab_empty" in attributes or dataset.shape is None or dataset.is_virtual or dataset.external:
            self.contents["left"].append(path)
        elif kind.kind in "iuf" and dataset.size == 1:
            self.contents["numbers"][path] = float(np.asarray(dataset[()]).reshape(-1)[0])
        elif kind.kind in "OS" and dataset.size <= 1000 and dataset.size * kind.itemsize < 1 << 20:
            self._words(dataset, path)
        elif _fields(kind) and kind.itemsize * math.prod(dataset.chunks or ()) > self.most:
            sys.exit(f"the chunks {dataset.chunks} of {path!r} are larger than the file can hold")
        elif _fields(kind):
            place = {"path": path, "shape": dataset.shape, "fields": _fields(kind), "offset": _offset(dataset)}
            self.contents["datasets"].append(attributes | place)
        else:
            self.contents["left"].append(path)

    def _words(self, dataset: Any, path: str) -> None:
        if not h5py.check_string_dtype(dataset.dtype):
            self.contents["left"].append(path)
        elif path == self.text and not dataset.shape:
            self.contents["description"] = str(dataset.asstr()[()])
        else:
            self.contents["texts"][path] = _plain(dataset[()])


def _fields(kind: Any) -> list[list[Any]]:
    """Name, type and shape of the numbers in an element; the name is empty if it is a single number."""
    if kind.names:
        fields = [(name, kind[name].base, kind[name].shape) for name in kind.names]
        return [[name, base.str, shape] for name, base, shape in fields if base.kind in "iuf" and not base.names]
    return [["", kind.str, ()]] if kind.kind in "iuf" else []


def _offset(dataset: Any) -> int | None:
    """Offset of the numbers of a dataset in the file, if they are stored contiguously and as NumPy has them."""
    # Integers of fewer bits than their width, and floats of another layout, have the width of a type of NumPy as well.
    whole = dataset.size * dataset.dtype.itemsize
    if dataset.chunks or dataset.dtype.names or dataset.compression or dataset.id.get_storage_size() != whole:
        return None
    if dataset.id.get_type() != h5py.h5t.py_create(dataset.dtype, logical=True):
        return None
    return None if (offset := dataset.id.get_offset()) is None else int(offset)


def _plain(value: Any) -> Any:
    """A single number, a text, or a list of texts; None for anything else."""
    array = np.asarray(value)
    if array.dtype.kind in "iuf" and array.size == 1:
        return float(array.reshape(-1)[0])
    if array.size > 1000 or not all(isinstance(item, (bytes, str)) for item in array.reshape(-1).tolist()):
        return None
    words = [w.decode("utf-8", "replace") if isinstance(w, bytes) else w for w in array.reshape(-1).tolist()]
    return words if array.ndim else words[0]


def _chunks(dataset: Any) -> int:
    """How many chunks a dataset has, those that were never written included."""
    return math.prod(-(-size // chunk) for size, chunk in zip(dataset.shape, dataset.chunks or (), strict=False))


def _blocks(dataset: Any, fields: list[str]) -> Iterator[Any]:
    """The bytes of a dataset, in blocks of whole chunks so that none is unpacked twice."""
    source = dataset.fields(fields) if fields else dataset
    row = max(1, dataset.size // dataset.shape[0] * dataset.dtype.itemsize)
    tall = dataset.chunks[0] if dataset.chunks else 1
    across = _chunks(dataset) // max(1, dataset.shape[0] // tall)
    step = max(1, min(BLOCK // row // tall, MOST_CHUNKS // max(1, across))) * tall
    for start in range(0, dataset.shape[0], step):
        yield np.ascontiguousarray(source[start : start + step]).data
