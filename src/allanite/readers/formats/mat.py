"""MATLAB files of versions 5 to 7.2: numeric arrays and structures of them.

Version 7.3 is HDF5, and an ASCII .mat is text.
"""

from allanite.core.errors import UsageError
from allanite.core.record import Recording
from allanite.readers.columns.table import KEY, described, keys
from allanite.readers.options import Options

from .contained import contained
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
    """The channels of a .mat file: variables and fields of structures of one length."""
    # Cells, objects, functions and sparse matrices are ignored; nothing in the file is executed.
    return contained("mat", path, options)


def write(recording: Recording, path: str) -> None:
    """A column vector for each channel, and the rate."""
    from scipy.io import savemat

    if max(record.values.nbytes for record in recording) > _LARGEST:
        raise UsageError("a channel exceeds the 2 GB limit of a MATLAB 5 variable; write .h5 or .parquet")
    names = keys(recording)
    content = {name: record.values for name, record in zip(names, recording, strict=True)}
    with open(path, "wb") as file:
        savemat(file, content | {"rate": recording[0].rate, KEY: described(recording, names)}, oned_as="column")
