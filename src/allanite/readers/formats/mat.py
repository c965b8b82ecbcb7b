"""MATLAB files of versions 5 to 7.2: numeric arrays and structures of them.

Version 7.3 is HDF5, and an ASCII .mat is text.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import UsageError
from allanite.core.record import Recording
from allanite.readers.columns.dataset import Dataset
from allanite.readers.columns.datasets import rated, recording
from allanite.readers.columns.description import KEY, described, keys
from allanite.readers.options import Options
from allanite.readers.sandbox.guard import worded
from allanite.readers.sandbox.mat_elements import Element, Matrix, matrices

from .hdf5 import MATLAB

TITLE = "MATLAB 5 to 7.2 .mat"

_FIRST_WORDS, _MARKS = b"MATLAB 5.0", (b"IM", b"MI")
_LARGEST = 2**31 - 2**16


def sniff(head: bytes, suffix: str) -> bool:
    """Whether the header is that of MATLAB 5; an ASCII .mat is text."""
    if head.startswith(MATLAB):
        return False
    return head.startswith(_FIRST_WORDS) or (suffix == ".mat" and head[126:128] in _MARKS and b"\0" in head[:128])


def read(path: str, options: Options) -> Recording:
    """The channels of a .mat file: variables and fields of structures of one length.

    Cells, objects, functions and sparse matrices are left out; nothing in the file can run.

    Raises
    ------
    DataError
        The file is damaged, claims more than it can hold, or has no array of readings.
    UsageError
        It holds several recordings and none is chosen, or something is not said.
    """
    found, numbers, left, text = list[Dataset](), dict[str, float](), list[str](), ""
    with worded():
        for name, matrix in matrices(path):
            for where, leaf in _leaves(name, matrix):
                if leaf.text:
                    text = leaf.text if where == KEY else text
                elif not isinstance(leaf.content, Element):
                    left.append(where)
                elif leaf.size == 1:
                    numbers[where] = float(leaf.array().reshape(-1)[0])
                else:
                    found.append(_dataset(where, leaf))
    notes = [f"left out, no numbers: {', '.join(left[:20])}"] if left else []
    return recording(rated(found, numbers), options, notes, text)


def write(recording: Recording, path: str) -> None:
    """A column vector for each channel, and the rate."""
    from scipy.io import savemat

    if max(record.values.nbytes for record in recording) > _LARGEST:
        raise UsageError("a channel is over the 2 GB that a MATLAB 5 variable may have; write .h5 or .parquet")
    content = {name: record.values for name, record in zip(keys(recording), recording, strict=True)}
    with open(path, "wb") as file:
        savemat(file, content | {"rate": recording[0].rate, KEY: described(recording)}, oned_as="column")


def _leaves(path: str, matrix: Matrix) -> Iterator[tuple[str, Matrix]]:
    """The matrices in a structure, each with its path."""
    if not isinstance(matrix.content, list):
        yield path, matrix
        return
    for name, inner in matrix.content:
        yield from _leaves(f"{path}/{name}", inner)


def _dataset(path: str, matrix: Matrix) -> Dataset:
    shape = matrix.shape
    if len(shape) == 2 and min(shape) == 1:
        shape = (max(shape),)

    def load() -> NDArray[Any]:
        return matrix.array().reshape(shape)

    return Dataset(path, shape, np.dtype(matrix.dtype), load)
