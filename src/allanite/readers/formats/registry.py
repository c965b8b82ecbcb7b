"""The formats that can be read and written: a line of `READERS` names a module with TITLE and read.

Readers of other packages are entry points of the group ``allanite.readers``.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from allanite.core.errors import AllaniteError, DataError, UsageError
from allanite.core.record import Recording
from allanite.phrases.phrase import say
from allanite.plugins import FAILURES, broken, leave_out, plugins, told
from allanite.readers.options import Options
from allanite.readers.sandbox.process import demand_start

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


class FormatReader(Protocol):
    """A format that can be read: its name, and its reader; and of a plugin a test of the first bytes and suffix."""

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


ZSTD = b"\x28\xb5\x2f\xfd"  # first bytes of what zstd has packed, which of a bag are its parts

R_BINARY = (b"RDX2\nX\n", b"RDX3\nX\n", b"X\n\0\0\0\2", b"X\n\0\0\0\3")
"""First bytes of the only form of R that is read."""


class Format(NamedTuple):
    """A format of this package, and how its files are recognized."""

    module: str  # imported when a file is read
    starts: tuple[bytes, ...] = ()  # first bytes
    suffixes: tuple[str, ...] = ()  # of files that may begin with other bytes
    what: str = ""  # what a file must begin like, whatever its suffix; empty where the reader says it
    looks: bool = False  # whether the `sniff` of its module looks at more than that

    @property
    def TITLE(self) -> str:
        """Name of the format."""
        return str(_module(self.module).TITLE)

    def sniff(self, head: bytes, suffix: str) -> bool:
        """Whether the first bytes and the suffix of a file look like it."""
        if head.startswith(self.starts) or suffix in self.suffixes:
            return True
        return self.looks and bool(_module(self.module).sniff(head, suffix))

    def reader(self, head: bytes) -> FormatReader:
        """The reader of a file that begins like this."""
        if self.what:
            demand_start(head, self.starts, self.what)
        reader: FormatReader = _module(self.module)
        return reader


READERS: dict[str, Format] = {  # tried in this order; plugins come before text, which is the least specific
    "numpy": Format("numpy_file", looks=True),
    "ulog": Format("ulog", (b"ULog\x01\x12\x35",), (".ulg",), say("a PX4 log")),
    "dataflash": Format("dataflash", looks=True),
    "xlsx": Format("xlsx", looks=True),
    "tdms": Format("tdms", (b"TDSm",), (".tdms",), say("a TDMS file")),
    "lvm": Format("lvm", (b"LabVIEW Measurement", b"\xef\xbb\xbfLabVIEW Measurement")),
    "sentences": Format("sentences", looks=True),
    "mdf": Format("mdf", (b"MDF     ", b"UnFinMF "), (".mf4", ".mdf"), say("an MDF file")),
    "psins": Format("psins", looks=True),
    "parquet": Format("parquet", (b"PAR1",), (".parquet", ".pq")),
    "hdf5": Format("hdf5", looks=True),
    "mat": Format("mat", looks=True),
    "r": Format("r", (*R_BINARY, b"RDA2\n", b"RDA3\n", b"RDB2\n", b"RDB3\n"), (".rda", ".rdata", ".rds")),
    "bag": Format(
        "bag", (b"#ROSBAG V", b"\x89MCAP0\r\n", b"SQLite format 3\0", ZSTD), (".bag", ".db3", ".mcap"), say("a ROS bag")
    ),
    "kfgins": Format("kfgins", looks=True),
    "raw": Format("raw"),  # any bytes may be numbers
    "text": Format("text", looks=True),
}
"""The formats by name."""

TYPES = ("kfgins",)  # formats without a signature: each is read if its name is given as the type of raw binary

WRITERS: dict[str, str] = {
    ".csv": "text", ".npz": "numpy_file", ".parquet": "parquet", ".h5": "hdf5", ".hdf5": "hdf5", ".mat": "mat",
}  # fmt: skip
"""Suffix of a file: the module that writes it."""


@dataclass(frozen=True, eq=False)
class ReaderPlugin:
    """A reader of another package."""

    entry: "EntryPoint"
    module: Any

    @property
    def TITLE(self) -> str:
        """Name of the format."""
        return str(self.module.TITLE)

    def sniff(self, head: bytes, suffix: str) -> bool:
        """Whether bytes and suffix look like the format; not if it cannot say."""
        try:
            return bool(self.module.sniff(head, suffix))
        except FAILURES as error:  # a file of another format is read all the same
            leave_out(self.entry, f"sniff failed: {told(error)}")
            return False

    def reader(self, head: bytes) -> FormatReader:
        """Itself; `read` reports what its module does wrong."""
        return self

    def read(self, path: str, options: Options) -> Recording:
        """The recording returned by the plugin."""
        try:
            recording = self.module.read(path, options)
        except (AllaniteError, MemoryError):
            raise
        except Exception as error:
            raise DataError(broken(self.entry, f"read failed: {told(error)}")) from error
        except SystemExit as error:
            if isinstance(error.code, int) and error.code > SIGNALLED:
                raise
            recording = error  # no context of what follows, which would end the program
        if not isinstance(recording, Recording):
            why = f"read returned a {type(recording).__name__} instead of a Recording"
            raise UsageError(broken(self.entry, why))
        return recording


PARTS: dict[str, Any] = {"TITLE": str, "sniff": Callable, "read": Callable}
"""What the module of a reader has."""

SIGNALLED = 128
"""Exit codes above this one are those of signals, by the habit of shells."""


@cache
def added() -> tuple[ReaderPlugin, ...]:
    """The readers of other packages, by name."""
    readers: dict[str, ReaderPlugin] = {}
    for entry, module in plugins("allanite.readers"):
        try:
            missing = [part for part, kind in PARTS.items() if not isinstance(getattr(module, part, None), kind)]
            why = f"it has no {', '.join(missing)}" if missing else ""
        except FAILURES as error:
            why = told(error)
        if why:
            leave_out(entry, why)
        elif entry.name in READERS or entry.name in readers:
            leave_out(entry, f"the name {entry.name!r} exists already")
        else:
            readers[entry.name] = ReaderPlugin(entry, module)
    return tuple(readers.values())


def reader_named(name: str) -> FormatReader:
    """The reader of a format of the table."""
    reader: FormatReader = _module(READERS[name].module)
    return reader


def reader_of_type(dtype: str) -> FormatReader:
    """The reader of raw binary of a type: that of the format of this name, otherwise of rows of numbers."""
    return reader_named(dtype if dtype in TYPES else "raw")


def _module(name: str) -> Any:
    return import_module(f"{__package__}.{name}")


def candidates() -> Iterator[Format | ReaderPlugin]:
    """The formats in the order in which they are tried."""
    yield from (row for name, row in READERS.items() if name != "text")
    yield from added()
    yield READERS["text"]


FOREIGN = {
    b"%PDF": "a PDF", b"\x89PNG": "a picture", b"\xff\xd8\xff": "a picture", b"GIF8": "a picture",
    b"application/vnd.oasis": "an OpenDocument sheet (save it as .xlsx or CSV)", b"<!DOCTYPE": "a web page",
    b"<html": "a web page", b"\x7fELF": "a program",
}  # fmt: skip
"""Files that are given by mistake, by how they begin."""


def reader_for(head: bytes, suffix: str) -> FormatReader:
    """The first reader that recognizes the first bytes or the suffix of the file."""
    what = next((words for start, words in FOREIGN.items() if head.startswith(start)), "")
    for candidate in () if what else candidates():
        if candidate.sniff(head, suffix):
            return candidate.reader(head)
    first = f"{what}, not a recording" if what else f"unknown file format (the file begins with {head[:8]!r})"
    if head.isspace():
        first = f"the first {len(head)} bytes of the file are blank lines"
    others = "".join(f"{candidate.TITLE}, " for candidate in added())
    raise DataError(f"{first}; readable are text or CSV with a column for each channel, {others}.npy, .mat, .h5, "
                    ".parquet, .bag, .mcap, .ulg, .bin and others (see docs/files.md)")  # fmt: skip


def readable(head: bytes, suffix: str) -> bool:
    """Whether there is a reader for such a file."""
    return any(candidate.sniff(head, suffix) for candidate in candidates())


def writer_for(suffix: str) -> Writer:
    """The format written to files with that suffix."""
    if suffix not in WRITERS:
        raise UsageError(f"no format can be written to files with suffix {suffix!r}; suffixes that can be written: "
                         f"{', '.join(WRITERS)}")  # fmt: skip
    writer: Writer = _module(WRITERS[suffix])
    return writer
