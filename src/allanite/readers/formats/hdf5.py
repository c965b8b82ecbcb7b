"""HDF5 files, and MATLAB's MAT 7.3, which are HDF5 with every array transposed."""

import os
import re

from allanite.core.errors import DataError, demand_extra
from allanite.core.record import Recording
from allanite.readers.columns.lines import Parts
from allanite.readers.columns.table import KEY, described, keys, with_units
from allanite.readers.options import Options

from .contained import contained, contained_parts

TITLE = "HDF5 .h5 and MATLAB 7.3 .mat (needs h5py)"

SIGNATURE = b"\x89HDF\r\n\x1a\n"
MATLAB = b"MATLAB 7.3"
_PLACES = (0, 512, 1024, 2048, 4096, 8192, 16384, 32768)


def sniff(head: bytes, suffix: str) -> bool:
    """Whether the signature is at one of its places, or the name is that of an HDF5 file."""
    return _signed(head) or head.startswith(MATLAB) or suffix in (".h5", ".hdf5", ".hdf")


def _signed(head: bytes) -> bool:
    return any(head[at : at + 8] == SIGNATURE for at in _PLACES)


def read(path: str, options: Options) -> Recording:
    """The channels of an HDF5 file: datasets of one length and clock, with units and rates from their attributes."""
    return contained("hdf5", path, options, transposed=_head(path).startswith(MATLAB))


def parts(path: str, options: Options) -> Parts | None:
    """The rows of the datasets of one length and clock; None of MATLAB, whose rows are columns."""
    return None if _head(path).startswith(MATLAB) else contained_parts("hdf5", path, options)


def _head(path: str) -> bytes:
    """The first bytes of a file, which must have the signature of HDF5 among them."""
    with open(path, "rb") as file:
        head = file.read(_PLACES[-1] + 8)
    if not _signed(head):
        raise DataError(
            f"the file does not begin like an HDF5 file (it begins with {head[:8]!r}); check that it is complete"
        )
    return head


def write(recording: Recording, path: str) -> None:
    """A dataset for each channel with its unit as an attribute, and the rate as an attribute of the file."""
    demand_extra("hdf5", "h5py")
    import h5py

    try:
        with h5py.File(path, "w", track_order=True) as file:
            file.attrs["rate"] = recording[0].rate
            names = keys(recording)
            for name, record in zip(names, recording, strict=True):
                file.create_dataset(name, data=record.values).attrs["units"] = record.unit
            file[KEY] = described(recording, with_units(names, recording))
    except RuntimeError as error:  # what the system says when the file is closed
        number = re.search(r"errno = (\d+)", str(error))
        if number is None:
            raise
        raise OSError(int(number[1]), os.strerror(int(number[1]))) from None
