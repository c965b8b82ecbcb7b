"""Writing files: never over an existing one unless told to, and never half."""

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import UsageError

PathLike = str | os.PathLike[str]


def demand_writable(path: PathLike, *, force: bool = False) -> None:
    """Make sure that `path` can be written.

    Raises
    ------
    UsageError
        It is a folder, its folder is missing or closed to us, or it exists and `force` is not set.
    """
    target = Path(path)
    if target.is_dir():
        raise UsageError(f"{str(target)!r} is a folder; give the name of a file in it")
    folder = target.parent
    if not folder.is_dir():
        raise UsageError(f"the folder {str(folder)!r} of {target.name!r} does not exist; make it first")
    if target.is_file() and not force:
        raise UsageError(
            f"{str(target)!r} exists already; give another name, or overwrite it with --force (force=True)"
        )
    if not os.access(target if _is_device(target) else folder, os.W_OK):
        raise UsageError(f"the folder {str(folder)!r} cannot be written; give a path in another one")


def write(path: PathLike, data: bytes, *, force: bool = False) -> None:
    """Write `data` to `path` in one step: a reader sees the old file or the new one, never a part.

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
    """A name beside `path` to write to; it takes the place of `path` in one step once all is written.

    Raises
    ------
    UsageError
        See `write`.
    """
    demand_writable(path, force=force)
    # a link stays a link: what it points to is replaced
    target = Path(os.path.realpath(path))
    part = target.with_name(f".allanite-{secrets.token_hex(6)}.part")
    try:
        # made by open, unlike tempfile, the file gets the permissions that the user's umask grants to new files
        part.open("xb").close()
        yield part
        os.replace(part, target)
    except OSError as error:
        raise _unwritable(path, error) from None
    finally:
        part.unlink(missing_ok=True)


def _unwritable(path: PathLike, error: OSError) -> UsageError:
    return UsageError(f"{os.fspath(path)!r} cannot be written ({error.strerror or error}); give another path")


def _is_device(target: Path) -> bool:
    """A device or pipe, such as /dev/stdout: written into, not replaced."""
    return target.exists() and not target.is_file()
