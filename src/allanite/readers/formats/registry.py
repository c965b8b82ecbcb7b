"""The formats that can be read and written: a line of `READERS` names a module with TITLE, sniff and read.

Readers of other packages are entry points of the group ``allanite.readers``.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint
from typing import Any, Protocol

from allanite.core.errors import AllaniteError, DataError, UsageError
from allanite.core.record import Recording
from allanite.plugins import broken, leave_out, plugins
from allanite.readers.options import FrameLike, Options


class FormatReader(Protocol):
    """A format that can be read: its name, a test of the first bytes and suffix, and its reader."""

    @property
    def TITLE(self) -> str:
        """Name of the format."""

    def sniff(self, head: bytes, suffix: str, /) -> bool:
        """Whether the first bytes and the suffix of a file look like it."""

    def read(self, path: str, options: Options, /) -> Recording:
        """The channels of a file; `DataError` if it is damaged, `UsageError` if required information is missing."""


class Writer(Protocol):
    """A format that can be written."""

    def write(self, recording: Recording, path: str, /) -> None:
        """Write a recording whose records have common sample times and one length."""


READERS: dict[str, str] = {  # tried in this order; plugins come before text, which is the least specific
    "numpy": "numpy_file",
    "ulog": "ulog",
    "dataflash": "dataflash",
    "xlsx": "xlsx",
    "tdms": "tdms",
    "lvm": "lvm",
    "sentences": "sentences",
    "mdf": "mdf",
    "psins": "psins",
    "parquet": "parquet",
    "hdf5": "hdf5",
    "mat": "mat",
    "r": "r",
    "bag": "bag",
    "kfgins": "kfgins",
    "raw": "raw",
    "text": "text",
}
"""Name of a format: its module, which is imported when a file is read."""

TYPES = ("kfgins",)
"""Formats without a signature: each is read if its name is given as the type of raw binary."""

WRITERS: dict[str, str] = {
    ".csv": "text",
    ".npz": "numpy_file",
    ".parquet": "parquet",
    ".h5": "hdf5",
    ".hdf5": "hdf5",
    ".mat": "mat",
}
"""Suffix of a file: the module that writes it."""


@dataclass(frozen=True, eq=False)
class ReaderPlugin:
    """A reader of another package."""

    entry: EntryPoint
    module: Any

    @property
    def TITLE(self) -> str:
        """Name of the format."""
        return str(self.module.TITLE)

    def sniff(self, head: bytes, suffix: str) -> bool:
        """Whether bytes and suffix look like the format; not if it cannot say."""
        try:
            return bool(self.module.sniff(head, suffix))
        except Exception as error:  # noqa: BLE001, RUF100 - a file of another format is read all the same
            leave_out(self.entry, f"sniff failed: {type(error).__name__}: {error}")
            return False

    def read(self, path: str, options: Options) -> Recording:
        """The recording returned by the plugin."""
        try:
            recording = self.module.read(path, options)
        except (AllaniteError, MemoryError):
            raise
        except Exception as error:
            raise DataError(broken(self.entry, f"read failed: {type(error).__name__}: {error}")) from error
        if not isinstance(recording, Recording):
            why = f"read returned a {type(recording).__name__} instead of a Recording"
            raise UsageError(broken(self.entry, why))
        return recording


@cache
def added() -> tuple[ReaderPlugin, ...]:
    """The readers of other packages, by name."""
    readers: dict[str, ReaderPlugin] = {}
    for entry, module in plugins("allanite.readers"):
        missing = [part for part in ("TITLE", "sniff", "read") if not hasattr(module, part)]
        if missing:
            leave_out(entry, f"it has no {', '.join(missing)}")
        elif entry.name in READERS or entry.name in readers:
            leave_out(entry, f"the name {entry.name!r} exists already")
        else:
            readers[entry.name] = ReaderPlugin(entry, module)
    return tuple(readers.values())


def reader_named(name: str) -> FormatReader:
    """The reader of a format of the table."""
    reader: FormatReader = _module(READERS[name])
    return reader


def reader_of_type(dtype: str) -> FormatReader:
    """The reader of raw binary of a type: that of the format of this name, otherwise of rows of numbers."""
    return reader_named(dtype if dtype in TYPES else "raw")


def read_frame(frame: FrameLike, options: Options) -> Recording:
    """The channels of a table in memory."""
    recording: Recording = _module("frame").read(frame, options)
    return recording


def _module(name: str) -> Any:
    return import_module(f"{__package__}.{name}")


def candidates() -> Iterator[FormatReader]:
    """The readers in the order in which they are tried."""
    yield from (reader_named(name) for name in READERS if name != "text")
    yield from added()
    yield reader_named("text")


def reader_for(head: bytes, suffix: str) -> FormatReader:
    """The first reader that recognizes the first bytes or the suffix of the file."""
    for reader in candidates():
        if reader.sniff(head, suffix):
            return reader
    titles = "; ".join(reader.TITLE for reader in candidates())
    raise DataError(
        f"unknown file format (the file begins with {head[:8]!r}); readable formats: {titles}; and any of these in "
        "a .zip, .gz, .bz2 or .xz"
    )


def readable(head: bytes, suffix: str) -> bool:
    """Whether there is a reader for such a file."""
    return any(reader.sniff(head, suffix) for reader in candidates())


def writer_for(suffix: str) -> Writer:
    """The format written to files with that suffix."""
    if suffix not in WRITERS:
        raise UsageError(
            f"no format can be written to files with suffix {suffix!r}; suffixes that can be written: "
            f"{', '.join(WRITERS)}"
        )
    writer: Writer = _module(WRITERS[suffix])
    return writer
