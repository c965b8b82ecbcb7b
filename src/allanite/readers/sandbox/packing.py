"""Files in files: the content of a .zip, .gz, .bz2 or .xz is unpacked, within limits, and read like any other file."""

import bz2
import gzip
import lzma
import os
import re
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO, Any, NamedTuple

from allanite.core.errors import DataError, UsageError

from .process import UnpackedPath, demand_size, most, worded
from .source import FIRST_BYTES, SEPARATOR, demand_directory, head_of

DEPTH = 3  # maximum number of nested layers

_BLOCK = 1 << 20
_DECODER = 100 << 20  # memory limit of the .xz decoder; xz -9 needs 65 MB, and a file may claim 4 GB

PROSE = re.compile(
    r"(^|/)(\.|__MACOSX/|readme|license|licence|copying|changelog)|"
    r"\.(md|rst|pdf|html?|json|ya?ml|xml|toml|ini|cfg|log|py|m|r|c|h|cpp|png|jpe?g|svg)$",
    re.IGNORECASE,
)
"""Names of files that lie beside recordings and are not recordings, though they may be text."""

Judge = Callable[[bytes, str], bool]  # whether first bytes and suffix are those of a readable file


class Packing(NamedTuple):
    """A packing of a single file: its signature, its suffix, and its opener."""

    magic: re.Pattern[bytes]
    suffix: str
    open: Callable[[IO[bytes]], Any]


class _Streams:
    """Reads a file of one or several packed streams, and nothing else behind them, as bz2 and lzma do not."""

    # `begun` makes the decoder of a stream; `between` may stand between streams
    def __init__(self, file: IO[bytes], begun: Callable[[], Any], between: bytes = b"") -> None:
        self._file, self._begun, self._between = file, begun, between
        self._decoder = begun()

    def read(self, size: int) -> bytes:
        """The next bytes, at most `size`; none at the end."""
        while True:
            fresh = b""
            if self._decoder.eof:
                fresh = self._decoder.unused_data.lstrip(self._between)
                while not fresh and (block := self._file.read(_BLOCK)):
                    fresh = block.lstrip(self._between)
                if not fresh:
                    return b""
                self._decoder = self._begun()
            elif self._decoder.needs_input and not (fresh := self._file.read(_BLOCK)):
                raise EOFError("the end is missing")
            content: bytes = self._decoder.decompress(fresh, size)
            if content:
                return content


PACKINGS = (
    Packing(re.compile(rb"\x1f\x8b\x08"), ".gz", lambda file: gzip.GzipFile(fileobj=file)),
    Packing(re.compile(rb"BZh[1-9](1AY&SY|\x17rE8P\x90)"), ".bz2", lambda file: _Streams(file, bz2.BZ2Decompressor)),
    Packing(  # with bounded memory, and zeros between streams
        re.compile(rb"\xfd7zXZ\0"),
        ".xz",
        lambda file: _Streams(file, lambda: lzma.LZMADecompressor(lzma.FORMAT_XZ, memlimit=_DECODER), b"\0"),
    ),
)

ZIP = Packing(re.compile(rb"PK\x03\x04"), ".zip", zipfile.ZipFile)


@contextmanager
def unpacked(path: str, member: str, judge: Judge, *, only_by_suffix: bool = False) -> Iterator[str]:
    """The path of the unpacked file; `path` itself if it is not packed, or a format of its own."""
    # `member` names a file in an archive (empty: the only one that `judge` finds readable, by first bytes and suffix).
    # With `only_by_suffix`, a file that merely begins like a packed one is left unchanged, as raw numbers may.
    with ExitStack() as stack:
        for _ in range(DEPTH):
            packing = packing_of(path, judge, only_by_suffix)
            if packing is None:
                break
            limit = most(path)
            folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="allanite-", ignore_cleanup_errors=True))
            name = Path(path).name
            if packing is ZIP:
                name, member = _chosen(path, member, judge), ""
            elif name.lower().endswith(packing.suffix):
                name = name[: -len(packing.suffix)]
            what = "the archive" if packing is ZIP else f"the {packing.suffix} packing"
            inner = Path(folder, "file" + re.sub(r"[^.A-Za-z0-9]", "", os.path.splitext(name)[1])[:16])
            with worded(what), Path(path).open("rb") as file, ExitStack() as layer, inner.open("wb") as copy:
                stream = _Limited(_content(packing, file, name, layer), limit, what)
                while block := stream.read(_BLOCK):
                    copy.write(block)
                if not copy.tell():
                    raise DataError("the packed file is empty")
            path = UnpackedPath(str(inner), limit)
        if member:
            raise UsageError(f"{SEPARATOR}{member} names a member of a .zip file, but this is not one")
        yield path


def packing_of(path: str, judge: Judge, only_by_suffix: bool) -> Packing | None:
    """The packing of a file; an .npz is a .zip, but a format of its own."""
    return _packing(head_of(path), os.path.splitext(path)[1].lower(), judge, only_by_suffix)


class PackedFile:
    """A packed file whose content is read from the beginning, again and again, without a copy on the disk."""

    # arguments are those of `unpacked`, `suffix` is that of the content; an archive within another packing is refused

    def __init__(self, path: str, member: str, judge: Judge, *, only_by_suffix: bool = False) -> None:
        self.path, self.suffix = path, os.path.splitext(path)[1].lower()
        self._limit, self._layers = most(path), list[tuple[Packing, str]]()
        while len(self._layers) < DEPTH:
            packing = _packing(self.head, self.suffix, judge, only_by_suffix)
            if packing is None:
                break
            if packing is ZIP:
                if self._layers:
                    raise UsageError("an archive within another packing is not read in parts")
                member, name = "", _chosen(path, member, judge)
            else:
                stem, last = os.path.splitext(name if self._layers else path)
                name = stem if last.lower() == packing.suffix else f"{stem}{last}"
            self.suffix = os.path.splitext(name)[1].lower()
            self._layers.append((packing, name))
        if member:
            raise UsageError(f"{SEPARATOR}{member} names a member of a .zip file, but this is not one")

    @property
    def head(self) -> bytes:
        """The first bytes of the content."""
        return next(self.chunks(FIRST_BYTES), b"")[:FIRST_BYTES]

    def chunks(self, size: int = _BLOCK) -> Iterator[bytes]:
        """The content, from the beginning."""
        with ExitStack() as stack:
            stream: Any = stack.enter_context(Path(self.path).open("rb"))
            for packing, name in self._layers:
                stream = _Limited(_content(packing, stream, name, stack), self._limit, f"the {packing.suffix} packing")
            while block := stream.read(size):
                yield block


class _Limited:
    """A packed stream, of which no more than `limit` bytes are read."""

    def __init__(self, stream: Any, limit: int, what: str) -> None:
        self._stream, self._limit, self._what, self._size = stream, limit, what, 0

    def read(self, size: int) -> bytes:
        """The next bytes."""
        with worded(self._what):
            block: bytes = self._stream.read(size)
        self._size += len(block)
        if self._size > self._limit:
            raise DataError(
                f"the file unpacks to more than the limit of {self._limit / 1e6:.3g} MB: it is a decompression bomb "
                "or damaged; if it is neither, unpack it and read the contents"
            )
        return block


def _packing(head: bytes, suffix: str, judge: Judge, only_by_suffix: bool) -> Packing | None:
    for packing in (ZIP, *PACKINGS):
        if packing.magic.match(head) and (suffix == packing.suffix or not only_by_suffix):
            return None if packing is ZIP and suffix != ZIP.suffix and judge(head, suffix) else packing
    return None


def _chosen(path: str, member: str, judge: Judge) -> str:
    """The member of an archive that is named, or the only readable one."""
    demand_directory(path)
    with worded("the archive"), Path(path).open("rb") as file, ZIP.open(file) as archive:
        names = [entry.filename for entry in archive.infolist() if not entry.is_dir()]
        if member and member not in names:
            raise UsageError(f"the archive has no member {member!r}; it contains {_listed(names)}")
        if not member:
            if "xl/workbook.xml" in names:
                raise DataError("this is an Excel workbook; give its name the suffix .xlsx")
            readable = list[str]()
            for name in [name for name in names if not PROSE.search(name)][:1000]:
                with _opened(archive, name) as stream:
                    head = stream.read(4096)
                packed = any(packing.magic.match(head) for packing in (ZIP, *PACKINGS))
                if packed or judge(head, os.path.splitext(name)[1].lower()):
                    readable.append(name)
            if not readable:
                raise DataError(f"the archive contains no file of a readable format; it contains {_listed(names)}")
            member = readable[0]
            if len(readable) > 1:
                raise UsageError(f"the archive contains {len(readable)} readable files: {_listed(readable)}; select "
                                 f"one as in {'FILE.zip'}{SEPARATOR}{member}")  # fmt: skip
        demand_size(archive.getinfo(member).file_size, path, f"member {member!r}")
        return member


def _content(packing: Packing, file: Any, name: str, stack: ExitStack) -> Any:
    """The stream of what is packed in a file: of an archive the member `name`."""
    if packing is not ZIP:
        return packing.open(file)
    return stack.enter_context(_opened(stack.enter_context(ZIP.open(file)), name))


def _opened(archive: zipfile.ZipFile, name: str) -> IO[bytes]:
    if archive.getinfo(name).flag_bits & 1:
        raise DataError(f"member {name!r} is encrypted; unpack the archive with its password and read the file itself")
    return archive.open(name)


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - 20} more" if len(names) > 20 else ""
    return (", ".join(names[:20]) or "nothing") + more
