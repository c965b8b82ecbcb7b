"""Program that opens one HDF5 file in a process of its own: on damaged files the library crashes, hangs or runs wild.

It prints a line of JSON with what the file holds; then, for each line with the JSON of a request, the bytes of a
dataset. Attributes and links are only followed inside the file; nothing in it is executed or unpickled. The process
stands alone: it is started by its path and imports nothing of this package.
"""

import json
import os
import sys
from typing import Any

import h5py
import numpy as np

MOST_OBJECTS, DEEPEST = 10_000, 32
BLOCK = 8 << 20
SECONDS, SPEED = 1, 20e6  # what opening may take, and the bytes that are read in a second at the least
WANTED = ("unit", "units", "columns", "names", "channels", "labels", "matlab_class", "matlab_empty")


def main() -> None:
    """Serve one file: path, bytes that it may unpack to, and the names of a rate are the arguments."""
    path, most, rates, text = sys.argv[1], int(sys.argv[2]), sys.argv[3].split(","), sys.argv[4]
    _limit_memory(most + (64 << 20))
    _allow(0)
    with h5py.File(path, "r", rdcc_nbytes=BLOCK) as file:
        _put(Listing(file, most, {*rates, *WANTED}, text).said)
        for line in sys.stdin:
            request = json.loads(line)
            dataset = file[request["path"]]
            _allow(dataset.size * dataset.dtype.itemsize)
            _send(dataset, request["fields"])


class Listing:
    """What a file holds: datasets of numbers, lone numbers and texts with their paths, and what is left out."""

    def __init__(self, file: Any, most: int, wanted: set[str], text: str) -> None:
        self.most, self.wanted, self.text = most, wanted, text
        self.seen: set[Any] = set()
        self.said: dict[str, Any] = {"datasets": [], "numbers": {}, "texts": {}, "left": [], "description": ""}
        self._attributes(file, "")
        self._group(file, "", 0)

    def _group(self, group: Any, path: str, depth: int) -> None:
        for name in group:
            where = f"{path}/{name}".lstrip("/")
            if name in ("#refs#", "#subsystem#"):
                continue
            # other links may name any file of this machine
            if depth > DEEPEST or not isinstance(group.get(name, getlink=True), h5py.HardLink):
                self.said["left"].append(where)
                continue
            self._object(group[name], where, depth)

    def _object(self, found: Any, path: str, depth: int) -> None:
        info = h5py.h5o.get_info(found.id)
        token = (info.fileno, info.addr)
        if token in self.seen:
            return
        self.seen.add(token)
        if len(self.seen) > MOST_OBJECTS:
            sys.exit(f"the file holds more than {MOST_OBJECTS} objects")
        if isinstance(found, h5py.Group):
            self._attributes(found, path)
            self._group(found, path, depth + 1)
        elif isinstance(found, h5py.Dataset):
            self._dataset(found, path)

    def _attributes(self, found: Any, path: str) -> dict[str, Any]:
        said = {name: _plain(found.attrs[name]) for name in found.attrs if name.lower() in self.wanted}
        for name, value in said.items():
            if isinstance(value, float):
                self.said["numbers"][f"{path}/{name}".lstrip("/")] = value
        return {name.lower(): value for name, value in said.items()}

    def _dataset(self, dataset: Any, path: str) -> None:
        said = self._attributes(dataset, path)
        kind = dataset.dtype
        if (
            dataset.shape is None
            or dataset.is_virtual
            or dataset.external
            or "matlab_empty" in said
            or said.get("matlab_class") in ("char", "cell", "struct", "function_handle", "logical")
        ):
            self.said["left"].append(path)
        elif kind.kind in "iuf" and dataset.size == 1:
            self.said["numbers"][path] = float(np.asarray(dataset[()]).reshape(-1)[0])
        elif kind.kind in "OS" and dataset.size <= 1000 and dataset.size * kind.itemsize < 1 << 20:
            self._words(dataset, path)
        elif _fields(kind) and not self._chunks_fit(dataset):
            sys.exit(f"the chunks {dataset.chunks} of {path!r} are larger than the file can hold")
        elif _fields(kind):
            place = {"path": path, "shape": dataset.shape, "fields": _fields(kind), "offset": _offset(dataset)}
            self.said["datasets"].append(said | place)
        else:
            self.said["left"].append(path)

    def _chunks_fit(self, dataset: Any) -> bool:
        chunk = float(dataset.dtype.itemsize)
        for side in dataset.chunks or ():
            chunk *= side
        return chunk <= self.most

    def _words(self, dataset: Any, path: str) -> None:
        if not h5py.check_string_dtype(dataset.dtype):
            self.said["left"].append(path)
        elif path == self.text and not dataset.shape:
            self.said["description"] = str(dataset.asstr()[()])
        else:
            self.said["texts"][path] = _plain(dataset[()])


def _fields(kind: Any) -> list[list[Any]]:
    """Name, type and shape of the numbers in an element; the name is empty where it is one number."""
    if kind.names:
        fields = [(name, kind[name].base, kind[name].shape) for name in kind.names]
        return [[name, base.str, shape] for name, base, shape in fields if base.kind in "iuf" and not base.names]
    return [["", kind.str, ()]] if kind.kind in "iuf" else []


def _offset(dataset: Any) -> int | None:
    """Where the numbers of a dataset stand in the file, if they stand there as they are and in one piece."""
    whole = dataset.size * dataset.dtype.itemsize
    if dataset.chunks or dataset.dtype.names or dataset.compression or dataset.id.get_storage_size() != whole:
        return None
    return None if (offset := dataset.id.get_offset()) is None else int(offset)


def _plain(value: Any) -> Any:
    """A lone number, a text, or a list of texts; None for anything else."""
    array = np.asarray(value)
    if array.dtype.kind in "iuf" and array.size == 1:
        return float(array.reshape(-1)[0])
    if array.size > 1000 or not all(isinstance(item, (bytes, str)) for item in array.reshape(-1).tolist()):
        return None
    words = [w.decode("utf-8", "replace") if isinstance(w, bytes) else w for w in array.reshape(-1).tolist()]
    return words if array.ndim else words[0]


def _send(dataset: Any, fields: list[str]) -> None:
    """The bytes of a dataset, in blocks that hold whole chunks so that none is unpacked twice."""
    source = dataset.fields(fields) if fields else dataset
    row = max(1, dataset.size // dataset.shape[0] * dataset.dtype.itemsize)
    tall = dataset.chunks[0] if dataset.chunks else 1
    step = max(1, BLOCK // row // tall) * tall
    for start in range(0, dataset.shape[0], step):
        sys.stdout.buffer.write(np.ascontiguousarray(source[start : start + step]).data)
    sys.stdout.buffer.flush()


def _put(said: dict[str, Any]) -> None:
    sys.stdout.buffer.write(json.dumps(said).encode() + b"\n")
    sys.stdout.buffer.flush()


def _limit_memory(size: int) -> None:
    """Bound what the process may take from here on, where the system can."""
    try:
        import resource

        with open("/proc/self/statm") as file:
            now = int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
        resource.setrlimit(resource.RLIMIT_AS, (now + size, now + size))
    except (ImportError, OSError, ValueError):
        pass  # the parent bounds what it asks for, on every system


def _allow(size: int) -> None:
    """Bound the processor time until the next call, where the system can."""
    try:
        import resource
    except ImportError:
        return
    used = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
    hard = resource.getrlimit(resource.RLIMIT_CPU)[1]
    resource.setrlimit(resource.RLIMIT_CPU, (int(used + SECONDS + size / SPEED), hard))


if __name__ == "__main__":
    main()
