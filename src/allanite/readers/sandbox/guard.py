"""What a file may not do: claim impossible sizes, break the library that reads it, or need a missing library."""

import errno
import tempfile
import warnings
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager

from allanite.core.errors import AllaniteError, DataError
from allanite.phrases.phrase import say

from .source import demand_directory, size_of

RATIO = 100
"""Bytes of samples per byte of a file: coarse samples compress 30-fold, a decompression bomb 1000-fold."""

ROOM = 32 << 20
"""Bytes that any file may unpack to, whatever its size."""


class UnpackedPath(str):
    """The path of a file that was unpacked: its contents may not exceed the limit of the packing, or bombs multiply."""

    limit: int

    def __new__(cls, path: str, limit: int) -> "UnpackedPath":
        """The path, and the limit in bytes."""
        made = super().__new__(cls, path)
        made.limit = limit
        return made


def most(path: str) -> int:
    """Maximum size in bytes of the contents of a file, and of what is unpacked from it."""
    here = RATIO * size_of(path) + ROOM
    return min(here, path.limit) if isinstance(path, UnpackedPath) else here


def demand_size(size: int, path: str, what: str) -> None:
    """Refuse a claimed size larger than the file can hold (`most`), before memory is allocated."""
    if size > most(path):
        raise DataError(
            f"{what} claims {size / 1e6:.6g} MB, over the {most(path) / 1e6:.3g} MB that a file of this size may "
            f"unpack to ({RATIO} times its size): it is damaged or a decompression bomb; if it is neither, write it "
            "again without compression"
        )


def demand_members(path: str, what: str) -> list[zipfile.ZipInfo]:
    """The members of an archive, whose directory may not claim more than the file can hold."""
    demand_directory(path)
    with zipfile.ZipFile(path) as archive:
        members = archive.infolist()
    demand_size(sum(member.file_size for member in members), path, what)
    return members


DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Errors of a disk that is full, or of a limit that was set."""


@contextmanager
def worded(what: str = "the file") -> Iterator[None]:
    """Any exception of a library about a damaged file becomes a `DataError`."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # odd but harmless properties of the file
            yield
    except (AllaniteError, MemoryError, NameError):  # the last one is a bug of ours, whatever the file
        raise
    except Exception as error:
        if isinstance(error, OSError) and error.errno in DISK:
            reason = error.strerror or str(error)
            raise DataError(
                f"there is no room for {what} in the folder {tempfile.gettempdir()!r} ({reason}): free some, or set "
                "TMPDIR to another folder"
            ) from None
        raise DataError(f"{what} is damaged or was cut off; copy or download it again") from None


def demand_start(head: bytes, starts: tuple[bytes, ...], what: str) -> None:
    """Refuse a file whose first bytes are none of `starts`, which files of a format begin with."""
    if not head.startswith(starts):
        raise DataError(
            say(
                "the file does not begin like {what} (it begins with {head!r}); check that it is complete",
                what=what,
                head=head[:8],
            )
        )
