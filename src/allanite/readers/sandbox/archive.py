"""The directory of a .zip or .npz file, checked before the library holds an object for each entry of it."""

import os
import struct
from pathlib import Path

from allanite.core.errors import DataError

LONGEST = 1 << 20
"""Bytes of a directory: some ten thousand members."""

_END, _TAIL = b"PK\x05\x06", 65_557


def demand_directory(path: str) -> None:
    """Refuse an archive whose directory is longer than that of any set of recordings.

    Raises
    ------
    DataError
        There is no directory, or it is too long.
    """
    with Path(path).open("rb") as file:
        file.seek(max(0, os.path.getsize(path) - _TAIL))
        tail = file.read()
    at = tail.rfind(_END)
    if at < 0 or len(tail) < at + 22:
        raise DataError("the archive was cut off: the directory at its end is missing; copy or download it again")
    (size,) = struct.unpack_from("<I", tail, at + 12)
    if size > LONGEST:
        raise DataError(
            f"the directory of the archive claims {size / 1e6:.3g} MB; no set of recordings has so many files; "
            "unpack it and read one file"
        )
