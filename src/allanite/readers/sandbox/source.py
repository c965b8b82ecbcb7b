"""The file itself: that it is one, its first bytes and its digest, and the directory of an archive."""

import hashlib
import os
import shutil
import stat
import struct
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from allanite.core.errors import DataError, UsageError

SEPARATOR = "::"
"""Stands between an archive and the name of a member."""

STDIN = "-"
"""In place of a path: standard input."""

STDIN_NAME = "standard input"
"""What messages and results call it."""

HEAD = 1 << 16
"""Bytes by which a format is recognised."""

LONGEST = 1 << 20
"""Bytes of a directory: some ten thousand members."""

_END, _LARGE, _TAIL = b"PK\x05\x06", b"PK\x06\x07", 65_557 + 76


def checked(path: Any) -> tuple[str, str]:
    """The path as text, if a file that can be read is there, and the member of an archive that ``::`` names in it."""
    try:
        name = os.fsdecode(path)
    except TypeError:
        raise UsageError(f"a path is expected, not {path!r}") from None
    file, _, member = name.rpartition(SEPARATOR)
    name, member = (file, member) if file and not os.path.exists(name) else (name, "")
    try:
        mode = os.stat(name)
    except FileNotFoundError:
        raise DataError(f"{name}: there is no such file; check the name and the folder") from None
    except (OSError, ValueError) as error:
        raise DataError(f"{name!r}: the file cannot be reached ({error}); check the name and your permission") from None
    if stat.S_ISDIR(mode.st_mode):
        raise DataError(f"{name}: this is a directory; name one file in it")
    if not stat.S_ISREG(mode.st_mode):
        raise DataError(
            f"{name}: this is no regular file (a pipe, device or socket); save its contents to a file first"
        )
    if mode.st_size == 0:
        raise DataError(f"{name}: the file is empty; was the recording saved?")
    return name, member


@contextmanager
def landed(path: Any) -> Iterator[tuple[str, str, str]]:
    """The file, the member of an archive, and the name for messages; standard input is copied to a file first."""
    if path != STDIN:
        file, member = checked(path)
        yield file, member, SEPARATOR.join((file, member)) if member else file
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


def head_of(name: str) -> bytes:
    """The first bytes of a file."""
    with Path(name).open("rb") as file:
        return file.read(HEAD)


def digest_of(name: str) -> str:
    """The sha256 of a file, in hexadecimal digits."""
    with Path(name).open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def demand_directory(path: str) -> None:
    """Refuse an archive whose directory is longer than that of any set of recordings."""
    with Path(path).open("rb") as file:
        file.seek(max(0, os.path.getsize(path) - _TAIL))
        tail = file.read()
    at = tail.rfind(_END)
    if at < 0 or len(tail) < at + 22:
        raise DataError("the archive was cut off: the directory at its end is missing; copy or download it again")
    (size,) = struct.unpack_from("<I", tail, at + 12)
    if at >= 76 and tail[at - 20 : at - 16] == _LARGE:  # the end of a large archive, which goes over the other
        (size,) = struct.unpack_from("<Q", tail, at - 76 + 40)
    if size > LONGEST:
        raise DataError(
            f"the directory of the archive claims {size / 1e6:.3g} MB; no set of recordings has so many files; "
            "unpack it and read one file"
        )
