"""NumPy's own files: .npy with one array, .npz with several."""

import math
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError
from allanite.core.record import Recording
from allanite.phrases.phrase import say
from allanite.readers.columns.column import RATE_NAMES, FileColumn, column, split, turned, turned_note
from allanite.readers.columns.containers import WIDEST
from allanite.readers.columns.lines import HEAD_ROWS, Parts, Rows
from allanite.readers.columns.table import KEY, FileTable, described, keys, restored
from allanite.readers.options import Options
from allanite.readers.sandbox.process import demand_members, demand_size, demand_start, worded

TITLE = "NumPy .npy and .npz"

NPY, ZIP, PICKLE = b"\x93NUMPY", b"PK\x03\x04", b"\x80"


def sniff(head: bytes, suffix: str) -> bool:
    """Whether the first bytes, or the name, are those of a NumPy file; a .zip may contain one among others."""
    archive = head.startswith(ZIP) and b".npy" in head[:4096] and suffix != ".zip"
    return head.startswith(NPY) or archive or suffix in (".npy", ".npz")


def read(path: str, options: Options) -> Recording:
    """The channels of a .npy or .npz file; pickled objects in it are refused, never loaded."""
    # A one-dimensional array is one channel; a two-dimensional one has one channel per column; the fields of a
    # structured array, and the arrays of a .npz, are named like the headers of a text file, optionally with a unit.
    head = _demand_numbers(path)
    with worded():
        # of a mapped array each column is copied, once
        arrays = _members(path) if head.startswith(ZIP) else [("", np.asarray(_mapped(path)))]
    notes = [note for name, array in arrays if name != KEY for note in _notes(name, array)]
    return _table(arrays, notes).recording(options)


def parts(path: str, options: Options) -> Parts | None:
    """The rows of a .npy file, which are read one after the other; None for an archive."""
    if _demand_numbers(path).startswith(ZIP):
        return None
    with worded():
        mapped = _mapped(path)
    if mapped.ndim not in (1, 2):
        return None
    upright = mapped.T if turned(mapped) else mapped
    first = np.array(upright[:HEAD_ROWS])
    columns = [values for _, values in split("", first)] if first.shape[0] >= first[:1].size else []
    if not columns:
        return None
    head = _table([("", first)], _notes("", mapped))
    source = Rows(path, mapped.dtype, mapped.offset, upright.shape, bycolumn=not upright.flags.c_contiguous)
    return Parts(head, len(upright), source.blocks, options)


def _table(arrays: list[tuple[str, NDArray[Any]]], notes: list[str]) -> FileTable:
    text = next((str(a) for name, a in arrays if name == KEY and a.ndim == 0 and a.dtype.kind == "U"), "")
    arrays = [(name, array) for name, array in arrays if name != KEY]
    columns = list[FileColumn]()
    single = (array for name, array in arrays if name.lower() in RATE_NAMES and array.ndim == 0)
    rate = next((float(array) for array in single if array.dtype.kind in "iuf"), None)
    for name, array in arrays:
        for header, values in split(name, array):
            columns.append(column(header, values, len(columns) + 1))
    if not columns:
        raise DataError("the file contains no array of samples")
    return restored(FileTable(tuple(columns), rate, say("the number stored beside the arrays"), tuple(notes)), text)


def write(recording: Recording, path: str) -> None:
    """An .npz with an array for each channel, and the rate."""
    names = keys(recording)
    content: dict[str, Any] = {name: record.values for name, record in zip(names, recording, strict=True)}
    content |= {"rate": recording[0].rate, KEY: described(recording, names)}
    with Path(path).open("wb") as file, zipfile.ZipFile(file, "w", allowZip64=True) as archive:
        for name, array in content.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asarray(array), allow_pickle=False)


def _demand_numbers(path: str) -> bytes:
    """The first bytes of a file, which must be those of numbers."""
    with Path(path).open("rb") as file:
        head = file.read(1024)
    if head.startswith(PICKLE) or (head.startswith(NPY) and (b"'|O" in head or b"'O'" in head)):
        raise DataError(_objects("the file"))
    demand_start(head, (NPY, ZIP), say("a NumPy file"))
    return head


def _mapped(path: str) -> Any:
    # a memory map checks the size claimed by the header against that of the file before memory is allocated
    mapped = np.load(path, mmap_mode="r", allow_pickle=False)
    demand_size(mapped.size, path, "the array")  # elements of zero width take no room in the file
    return mapped


def _members(path: str) -> list[tuple[str, NDArray[Any]]]:
    """Names and arrays of an archive."""
    # NumPy allocates the memory claimed by the header of a member before reading it
    form: Any = np.lib.format
    members = demand_members(path, "the archive")
    if len(members) > WIDEST:
        raise DataError(f"the archive has {len(members)} arrays, but a recording has at most {WIDEST}; store the "
                        "channels as columns of one array")  # fmt: skip
    with zipfile.ZipFile(path) as archive:
        for member in members:
            claimed = 0
            with archive.open(member) as stream:
                if member.filename.endswith(".npy"):
                    short = form.read_magic(stream) == (1, 0)
                    shape, _, dtype = (form.read_array_header_1_0 if short else form.read_array_header_2_0)(stream)
                    # objects are refused below
                    claimed = 0 if dtype.hasobject else math.prod(shape) * max(1, dtype.itemsize)
            if claimed > member.file_size:
                raise DataError(f"array {member.filename!r} claims {claimed} bytes, but its member of the archive has "
                                f"{member.file_size}: the file is damaged")  # fmt: skip
    # NumPy leaves a file with a damaged archive open if it opened the file itself
    with Path(path).open("rb") as file, np.load(file, allow_pickle=False) as archive:
        arrays = []
        for name in archive.files:
            try:
                array = archive[name]
            except ValueError as error:
                why = _objects(f"array {name!r}") if "pickle" in str(error) else f"array {name!r} is damaged"
                raise DataError(why) from None
            if not isinstance(array, np.ndarray):
                raise DataError(f"{name!r} in the archive is not a NumPy array")
            arrays.append((name, array))
        return arrays


def _objects(what: str) -> str:
    return (
        f"{what} contains pickled Python objects, which are never loaded because they can run code; save plain "
        "numbers: np.save(path, np.asarray(data, dtype=float))"
    )


def _notes(name: str, array: NDArray[Any]) -> list[str]:
    if array.ndim == 0 and not array.dtype.names and name.lower() not in RATE_NAMES:
        return [say("the single value {name!r} was ignored", name=name)]
    return [turned_note(name, array)] if turned(array) else []
