"""Writing files: never over an existing one unless asked to, and never partially."""

import errno
import os
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from allanite.phrases.phrase import spelled

from .errors import UsageError, given

PathLike = str | os.PathLike[str]

DRAFTS = ".allanite-*.part"  # pattern of the names of drafts


def encoded(text: str) -> bytes:
    """Text as UTF-8; what is no character, of a name that was not UTF-8, as its escape."""
    return text.encode("utf-8", "backslashreplace")


@contextmanager
def in_utf8(path: PathLike, mode: str = "rb") -> Iterator[str | IO[Any]]:
    """The path for a library that takes it in UTF-8 alone; where it is not, the open file."""
    name = os.fspath(path)
    if encoded(name) == os.fsencode(name):
        yield name
    else:
        with open(name, mode) as file:
            yield file


def demand_writable(path: PathLike, *, force: bool = False) -> None:
    """Make sure that `path` can be written."""
    target = Path(path)
    try:
        is_folder = stat.S_ISDIR(os.stat(path).st_mode)
    except FileNotFoundError:
        is_folder = os.fspath(path).endswith((os.sep, os.altsep or os.sep))
    except (OSError, ValueError) as error:  # too long, a loop of links, a folder that is a file, a null character
        raise UsageError(f"{given(os.fspath(path))} cannot be written ({reason(error)}); give another path") from None
    if is_folder:
        raise UsageError(f"{os.fspath(path)!r} is a folder; give the name of a file")
    folder = target.parent
    if not folder.is_dir():
        raise UsageError(f"the folder {str(folder)!r} of {target.name!r} does not exist; create it first")
    if target.is_file() and not force:
        raise UsageError(f"{str(target)!r} already exists; give another name, or overwrite it with "
                         f"{spelled('--force', 'force=True')}")  # fmt: skip
    if not os.access(target if _is_device(target) else folder, os.W_OK):
        raise UsageError(f"the folder {str(folder)!r} is not writable; give a path in another folder")


def write(path: PathLike, data: bytes, *, force: bool = False) -> None:
    """Write `data` to `path` atomically: a reader sees the old file or the new one, never a part of it.

    Raises
    ------
    UsageError
        See `demand_writable`; or the disk is full.
    """
    demand_writable(path, force=force)
    target = Path(os.path.realpath(path))
    if not _is_device(target):
        with draft(path, force=force) as part:
            part.write_bytes(data)
        return
    try:
        target.write_bytes(data)
    except OSError as error:
        raise _unwritable(path, error) from None


@contextmanager
def draft(path: PathLike, *, force: bool = False) -> Iterator[Path]:
    """A temporary name beside `path`, which replaces `path` atomically once everything is written."""
    demand_writable(path, force=force)
    # a link stays a link: its target is replaced
    target = Path(os.path.realpath(path))
    part = target.with_name(DRAFTS.replace("*", os.urandom(6).hex()))
    try:
        # unlike tempfile, open gives the file the permissions of the user's umask
        part.open("xb").close()
        yield part
        # on the disk before its name is: otherwise a power failure may leave an empty file
        with part.open("r+b") as file:
            os.fsync(file.fileno())
        os.replace(part, target)
    except OSError as error:
        raise _unwritable(path, error) from None
    finally:
        part.unlink(missing_ok=True)


def _unwritable(path: PathLike, error: OSError) -> UsageError:
    return UsageError(f"{given(os.fspath(path))} cannot be written ({reason(error)}); give another path")


def locked(path: PathLike) -> IO[bytes] | None:
    """A file that one program at a time has open, until it closes it or ends; None if another has it."""
    if os.path.exists(path) and not os.path.isfile(path):  # a pipe would not be opened until somebody else does
        raise FileExistsError(errno.EEXIST, "not a file", os.fspath(path))
    file = open(path, "ab")  # noqa: SIM115 - the caller keeps it open
    try:
        if sys.platform == "win32":
            import msvcrt

            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):  # what Windows says of a file that is locked
        file.close()
        return None
    return file


def reason(error: OSError | ValueError) -> str:
    """Why a path cannot be read or written, in the words of the system."""
    return str(getattr(error, "strerror", None) or error)


def _is_device(target: Path) -> bool:
    """A device or pipe, such as /dev/stdout, which is written to, not replaced."""
    return target.exists() and not target.is_file()
