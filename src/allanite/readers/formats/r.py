"""R's .rda, .RData and .rds: matrices, data frames, time series and lists of them.

What they are compressed with, `packing` has taken off.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError
from allanite.core.record import Recording
from allanite.readers.columns.dataset import Dataset
from allanite.readers.columns.datasets import rated, recording
from allanite.readers.options import Options
from allanite.readers.sandbox.guard import worded
from allanite.readers.sandbox.r_objects import Object, load

TITLE = "R .rda, .RData and .rds"

_MAGIC = (b"RDX2\nX\n", b"RDX3\nX\n", b"X\n\0\0\0\2", b"X\n\0\0\0\3")
_OTHER = (b"RDA2\n", b"RDA3\n", b"RDB2\n", b"RDB3\n")
_CLOCKS = ("POSIXct",)
_SECONDS = {"secs": "s", "mins": "min", "hours": "h"}


def sniff(head: bytes, suffix: str) -> bool:
    """Whether the first bytes are those of R's serialization."""
    return head.startswith(_MAGIC + _OTHER) or suffix in (".rda", ".rdata", ".rds")


def read(path: str, options: Options) -> Recording:
    """The channels of an R file; names of columns, ``freq`` and units of attributes are used where they are there.

    Raises
    ------
    DataError
        The file is damaged, is not in R's binary form, or holds no numbers.
    UsageError
        It holds several recordings and none is chosen, or something is not said.
    """
    with open(path, "rb") as file:
        data = file.read()
    if not data.startswith(_MAGIC):
        raise DataError(
            f"the file is not in R's binary form (it begins with {data[:8]!r}); write it again with "
            "save(x, file='x.rda') or saveRDS(x, 'x.rds')"
        )
    found, numbers = list[Dataset](), dict[str, float]()
    with worded():
        top = load(data)
        pairs = top.pairs if data.startswith(b"RDX") else [("", top)]
        for name, item in pairs:
            for leaf in _leaves(name, item):
                if isinstance(leaf, Dataset):
                    found.append(leaf)
                else:
                    numbers[leaf[0]] = leaf[1]
    return recording(rated(found, numbers), options)


def _leaves(path: str, item: Object) -> Iterator[Dataset | tuple[str, float]]:
    """The arrays and lone numbers in an object, with their paths."""
    for name, value in item.attributes.items():
        if value.numbers is not None and value.numbers.size == 1:
            yield f"{path}/{name}".lstrip("/"), float(value.numbers[0])
    if item.items is not None:
        names = item.words("names")
        for i, inner in enumerate(item.items):
            yield from _leaves(f"{path}/{names[i] if i < len(names) else i + 1}".lstrip("/"), inner)
    elif item.numbers is not None and item.numbers.size == 1:
        yield path, float(item.numbers[0])
    elif item.numbers is not None and "levels" not in item.attributes:
        yield _dataset(path, item)


def _dataset(path: str, item: Object) -> Dataset:
    array, names = _shaped(path, item), tuple[str, ...]()
    dimnames = item.attributes.get("dimnames")
    if dimnames is not None and dimnames.items is not None and len(dimnames.items) == 2:
        names = tuple(dimnames.items[1].texts)
    unit = next((item.words(name)[0] for name in ("units", "unit") if item.words(name)), "")
    classes = item.words("class")
    if any(name in classes for name in _CLOCKS):
        unit = "s"
    series = item.attributes.get("tsp")
    rate, source = None, ""
    if series is not None and series.numbers is not None and series.numbers.size == 3 and series.numbers[2] > 0:
        rate, source = float(series.numbers[2]), "the frequency of the time series in the file"
    return Dataset(path or "x", array.shape, array.dtype, lambda: array, _SECONDS.get(unit, unit), names, rate, source)


def _shaped(path: str, item: Object) -> NDArray[Any]:
    array, dim = item.numbers, item.attributes.get("dim")
    if array is None or dim is None or dim.numbers is None:
        return np.empty(0) if array is None else array
    shape = [int(side) for side in dim.numbers]
    if min(shape, default=-1) < 0 or np.prod(shape, dtype=float) != array.size:
        raise DataError(f"{path!r} claims the dimensions {shape}, but {array.size} numbers are there")
    return array.reshape(shape, order="F")
