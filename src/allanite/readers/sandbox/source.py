"""The file itself: its existence, first bytes and digest, and the directory of an archive."""

import hashlib
import os
import re
import shutil
import stat
import struct
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from allanite.core.errors import DataError, UsageError, given
from allanite.core.files import reason

SEPARATOR = "::"  # separates an archive and the name of a member
STDIN = "-"  # in place of a path: standard input
STDIN_NAME = "standard input"  # what messages and results call it
FIRST_BYTES = 1 << 16  # number of bytes used to detect a format
LARGEST_DIRECTORY = 1 << 20  # maximum size of a directory in bytes: some ten thousand members
METADATA = "metadata.yaml"  # the file that makes a folder a recording of ROS 2
_STEP, _NEXT = 1 << 20, 1 << 26  # bytes that are hashed at a time, and that are fetched from the disk before they are

_STORAGE = re.compile(r"\.(db3|mcap)(\.zstd)?$")
_END, _LARGE, _TAIL = b"PK\x05\x06", b"PK\x06\x07", 65_557 + 76


def checked(path: Any) -> tuple[str, str]:
    """The path as text, if it is a readable file, and the member of an archive named in it after ``::``."""
    try:
        name = os.fsdecode(path)
    except TypeError:
        raise UsageError(f"expected a path, not {path!r}") from None
    file, _, member = name.rpartition(SEPARATOR)
    name, member = (file, member) if file and not os.path.exists(name) else (name, "")
    try:
        mode = os.stat(name)
    except FileNotFoundError:
        remote = re.match(r"\w+://", name)
        advice = "this is an address: download it first" if remote else "no such file; check the name and the folder"
        raise DataError(f"{name}: {advice}") from None
    except (OSError, ValueError) as error:
        raise DataError(
            f"{given(name)}: the file cannot be accessed ({reason(error)}); check the name and your permissions"
        ) from None
    if stat.S_ISDIR(mode.st_mode):
        if not parts(name):
            raise DataError(f"{name}: this is a directory; give the name of a file, or the folder of a ROS 2 bag")
        return name, member
    if not stat.S_ISREG(mode.st_mode):
        raise DataError(
            f"{name}: this is not a regular file (but a pipe, device or socket); save its contents to a file first"
        )
    if mode.st_size == 0:
        raise DataError(f"{name}: the file is empty; was the recording saved?")
    return name, member


@dataclass(frozen=True)
class NamedPath:
    """A file that messages and results call by another name."""

    path: str
    source_name: str

    def __fspath__(self) -> str:
        return self.path


def named(path: Any, name: str) -> str:
    """What messages call a file of this name: of a spool that of its source."""
    return str(getattr(path, "source_name", name))


@contextmanager
def landed(path: Any) -> Iterator[tuple[str, str, str]]:
    """The file, the member of an archive, and the name for messages; standard input is copied to a file first."""
    if path != STDIN:
        file, member = checked(path)
        yield file, member, named(path, SEPARATOR.join((file, member)) if member else file)
        return
    with tempfile.NamedTemporaryFile(prefix="allanite-") as copy:
        try:
            shutil.copyfileobj(sys.stdin.buffer, copy)
            copy.flush()
        except OSError as error:
            why = error.strerror or error
            raise DataError(f"{STDIN_NAME}: it cannot be read ({why}); save it to a file first") from None
        if not copy.tell():
            raise DataError(f"{STDIN_NAME}: nothing came; pipe a recording into the command")
        yield copy.name, "", STDIN_NAME


def parts(name: str) -> list[str]:
    """The file itself, or the files of messages in a folder that ROS 2 has recorded; none in any other folder."""
    if not os.path.isdir(name):
        return [name]
    if not os.path.isfile(os.path.join(name, METADATA)):
        return []
    return sorted(str(file) for file in Path(name).iterdir() if _STORAGE.search(file.name) and file.is_file())


def is_recording(name: str | os.PathLike[str]) -> bool:
    """Whether this may be read: a file, or the folder of a ROS 2 bag."""
    return os.path.isfile(name) or (os.path.isdir(name) and bool(parts(os.fspath(name))))


def size_of(name: str) -> int:
    """The size of a file, or of the files of a folder, in bytes."""
    return sum(os.path.getsize(part) for part in parts(name))


def head_of(name: str) -> bytes:
    """The first bytes of a file, or of the first file of a folder."""
    with Path(parts(name)[0]).open("rb") as file:
        return file.read(FIRST_BYTES)


def digest_of(name: str) -> str:
    """The sha256 of a file, or of the files of a folder one after the other, in hexadecimal digits."""
    digest = hashlib.sha256()
    for part in parts(name):
        with Path(part).open("rb", buffering=0) as file:
            # the system reads the next bytes from the disk meanwhile, for whoever reads the file, too
            buffer, at = memoryview(bytearray(_STEP)), 0
            _fetch(file, 0, _NEXT)
            while count := file.readinto(buffer):
                _fetch(file, at + _NEXT, count)
                digest.update(buffer[:count])
                at += count
    return digest.hexdigest()


def _fetch(file: Any, at: int, size: int) -> None:
    """Ask the system to read a part of a file soon, where it can be asked."""
    if hasattr(os, "posix_fadvise"):
        os.posix_fadvise(file.fileno(), at, size, os.POSIX_FADV_WILLNEED)


def demand_directory(path: str) -> None:
    """Refuse an archive whose directory is longer than that of any set of recordings."""
    with Path(path).open("rb") as file:
        file.seek(max(0, os.path.getsize(path) - _TAIL))
        tail = file.read()
    at = tail.rfind(_END)
    if at < 0 or len(tail) < at + 22:
        raise DataError("the archive is incomplete: the directory at its end is missing; copy or download it again")
    (size,) = struct.unpack_from("<I", tail, at + 12)
    if at >= 76 and tail[at - 20 : at - 16] == _LARGE:  # the ZIP64 end record of a large archive
        (size,) = struct.unpack_from("<Q", tail, at - 76 + 40)
    if size > LARGEST_DIRECTORY:
        raise DataError(f"the directory of the archive claims {size / 1e6:.3g} MB, too much for any set of recordings; "
                        "unpack it and read one file")  # fmt: skip
