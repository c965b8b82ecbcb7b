"""What a file may not do: claim sizes that it cannot have, break the library that reads it, or need one unnamed."""

import importlib.util
import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from allanite.core.errors import AllaniteError, DataError, UsageError

RATIO = 100
"""Bytes of readings that one byte of a file may stand for: coarse readings pack 30-fold, a bomb 1000-fold."""

ROOM = 32 << 20
"""Bytes that any file may unpack to, whatever its size."""


_outer: ContextVar[int | None] = ContextVar("outer", default=None)


def most(path: str) -> int:
    """Bytes that the contents of a file may take; of a file that was packed in another, what the other one may."""
    here = RATIO * os.path.getsize(path) + ROOM
    outer = _outer.get()
    return here if outer is None else min(here, outer)


@contextmanager
def within(path: str) -> Iterator[None]:
    """Whatever is unpacked inside may not take more than the contents of `path`: bombs do not multiply."""
    token = _outer.set(most(path))
    try:
        yield
    finally:
        _outer.reset(token)


def demand_size(size: int, path: str, what: str) -> None:
    """Refuse what claims to be larger than its file can hold (`most`), before memory is taken."""
    if size > most(path):
        raise DataError(
            f"{what} claims {size / 1e6:.6g} MB, over the {most(path) / 1e6:.3g} MB that a file of this size may "
            f"unpack to ({RATIO} times its size): it is damaged or a decompression bomb; if it is neither, write it "
            "again without compression"
        )


@contextmanager
def worded(what: str = "the file") -> Iterator[None]:
    """Whatever a library raises over a damaged file becomes a `DataError`; the dozens of types are its own affair."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what is odd about the file and harmless
            yield
    except (AllaniteError, MemoryError, NameError):  # the last is a defect of ours, whatever the file
        raise
    except Exception as error:
        said = " ".join(str(error).split())[:200]
        raise DataError(f"{what} is damaged or was cut off: {type(error).__name__}: {said}") from None


def demand_library(name: str, extra: str) -> None:
    """Refuse a format whose library is not installed, and say how to install it."""
    if importlib.util.find_spec(name) is None:
        raise UsageError(f"this format is read by {name}, which is not installed: pip install 'allanite[{extra}]'")
