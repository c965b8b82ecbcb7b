"""The formats that are read and written, as tables: a line of `READERS` is a module with TITLE, sniff and read."""

from collections.abc import Iterator
from typing import Protocol

from allanite.core.errors import DataError, UsageError
from allanite.core.record import Recording
from allanite.readers.options import Options

from . import hdf5, mat, numpy_file, parquet, psins, r, raw, text
from .plugins import plugins


class Reader(Protocol):
    """A format that is read: what it is called, whether bytes and suffix look like it, and how it is read."""

    @property
    def TITLE(self) -> str:
        """What the format is called."""

    def sniff(self, head: bytes, suffix: str, /) -> bool:
        """Whether the first bytes and the suffix of a file look like it."""

    def read(self, path: str, options: Options, /) -> Recording:
        """The channels of a file."""


class Writer(Protocol):
    """A format that is written."""

    def write(self, recording: Recording, path: str, /) -> None:
        """Write a recording whose records have one clock and one length."""


READERS: dict[str, Reader] = {  # asked in this order, plugins before text, which sniffs least
    "numpy": numpy_file,
    "psins": psins,
    "parquet": parquet,
    "hdf5": hdf5,
    "mat": mat,
    "r": r,
    "raw": raw,
    "text": text,
}

WRITERS: dict[str, Writer] = {
    ".csv": text,
    ".npz": numpy_file,
    ".parquet": parquet,
    ".h5": hdf5,
    ".hdf5": hdf5,
    ".mat": mat,
}


def candidates() -> Iterator[Reader]:
    """The readers in the order in which they are asked."""
    yield from (reader for name, reader in READERS.items() if name != "text")
    yield from plugins()
    yield READERS["text"]


def reader_for(head: bytes, suffix: str) -> Reader:
    """The first reader that knows the format by the file's first bytes or its suffix."""
    for reader in candidates():
        if reader.sniff(head, suffix):
            return reader
    titles = "; ".join(reader.TITLE for reader in candidates())
    raise DataError(
        f"the file is of no format that is read (it begins with {head[:8]!r}); what is read: {titles}; and any of "
        "these in a .zip, .gz, .bz2 or .xz"
    )


def readable(head: bytes, suffix: str) -> bool:
    """Whether there is a reader for such a file."""
    return any(reader.sniff(head, suffix) for reader in candidates())


def writer_for(suffix: str) -> Writer:
    """The format that is written to files of that suffix."""
    if suffix not in WRITERS:
        raise UsageError(f"no format is written to files that end in {suffix!r}; those that are: {', '.join(WRITERS)}")
    return WRITERS[suffix]
