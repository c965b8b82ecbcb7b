"""One run at a time writes to a folder of results; the system frees its lock however the run ends."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from allanite.core.errors import UsageError
from allanite.core.files import DRAFTS

NAME = ".lock"
"""The file in the folder of results that is locked; it stays, and is empty."""


@contextmanager
def alone(folder: Path, *inside: str) -> Iterator[None]:
    """Be the only run that writes to a folder and to those `inside`, from which drafts of a killed run are removed.

    Raises
    ------
    UsageError
        Another run writes to it, or the disk cannot be written to.
    """
    try:
        file = open(folder / NAME, "ab")  # noqa: SIM115 - closed below, as long as it is locked
    except OSError as error:
        raise UsageError(f"{str(folder)!r} cannot be written to ({error.strerror}); give another folder") from None
    with file:
        if not _locked(file.fileno()):
            raise UsageError(
                f"another run writes its results to {str(folder)!r}; wait until it has ended, or give another folder"
            )
        for each in (folder, *(folder / name for name in inside)):
            for left in each.glob(DRAFTS):
                left.unlink()
        yield


def _locked(file: int) -> bool:
    """Whether the file could be locked: nobody else has."""
    try:
        if sys.platform == "win32":
            import msvcrt

            msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except PermissionError:  # what Windows says of a file that is locked
        return False
    return True
