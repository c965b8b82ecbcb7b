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

from .guard import UnpackedPath, demand_size, most, worded
from .source import HEAD, SEPARATOR, demand_directory, head_of

DEPTH = 3
"""Maximum number of nested layers."""

_BLOCK = 1 << 20
_DECODER = 100 << 20
"""Memory limit of the .xz decoder; xz -9 needs 65 MB, and a file may claim 4 GB."""

PROSE = re.compile(
    r"(^|/)(\.|__MACOSX/|readme|license|licence|copying|changelog)|"
    r"\.(md|rst|pdf|html?|json|ya?ml|xml|toml|ini|cfg|log|py|m|r|c|h|cpp|png|jpe?g|svg)$",
    re.IGNORECASE,
)
"""Names of files that lie beside recordings and are not recordings, though they may be text."""

Judge = Callable[[bytes, str], bool]
"""Whether first bytes and suffix are those of a readable file."""


class Packing(NamedTuple):
    """A packing of a single file: its signature, its suffix, and its opener."""

    magic: re.Pattern[bytes]
    suffix: str
    open: Callable[[IO[bytes]], Any]


class _Streams:
    """Reads a file of one or several packed streams, and nothing else behind them, as bz2 and lzma do not.

    `begun` makes the decoder of a stream; `between` may stand between streams.
    """

    def __init__(self, file: IO[bytes], begun: Callable[[], Any], between: bytes = b"") -> None:
        self._file, self._begun, self._between = file, begun, between
        self._decoder = begun()

    def read(self, size: int) -> bytes:
        """The next bytes, at most `size`; none at the end."""
        while True:
            fresh = b""
            if self._decoder.eof:
                fresh = self._rest(self._decoder.unused_data)
                while not fresh and (block := self._file.read(_BLOCK)):
                    fresh = self._rest(block)
                if not fresh:
                    return b""
                self._decoder = self._begun()
            elif self._decoder.needs_input and not (fresh := self._file.read(_BLOCK)):
                raise EOFError("the end is missing")
            found: bytes = self._decoder.decompress(fresh, size)
            if found:
                return found

    def _rest(self, data: bytes) -> bytes:
        return data.lstrip(self._between) if self._between else data


def _xz(file: IO[bytes]) -> _Streams:
    """With bounded memory, and zeros between streams."""
    return _Streams(file, lambda: lzma.LZMADecompressor(lzma.FORMAT_XZ, memlimit=_DECODER), b"\0")


PACKINGS = (
    Packing(re.compile(rb"\x1f\x8b\x08"), ".gz", lambda file: gzip.GzipFile(fileobj=file)),
    Packing(re.compile(rb"BZh[1-9](1AY&SY|\x17rE8P\x90)"), ".bz2", lambda file: _Streams(file, bz2.BZ2Decompressor)),
    Packing(re.compile(rb"\xfd7zXZ\0"), ".xz", _xz),
)

ZIP = Packing(re.compile(rb"PK\x03\x04"), ".zip", zipfile.ZipFile)


@contextmanager
def unpacked(path: str, member: str, judge: Judge, *, only_by_suffix: bool = False) -> Iterator[str]:
    """The path of the unpacked file; `path` itself if it is not packed, or a format of its own.

    `member` names a file in an archive (empty: the only one that `judge` finds readable, by first bytes and
    suffix). With `only_by_suffix`, a file that merely begins like a packed one is left unchanged, as raw numbers may.
    """
    with ExitStack() as stack:
        for _ in range(DEPTH):
            packing = packing_of(path, judge, only_by_suffix)
            if packing is None:
                break
            limit = most(path)
            folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="allanite-", ignore_cleanup_errors=True))
            if packing is ZIP:
                inner, member = _member(path, member, judge, folder), ""
            else:
                inner = _lone(path, packing, folder)
            path = UnpackedPath(inner, limit)
        if member:
            raise UsageError(f"{SEPARATOR}{member} names a member of a .zip file, but this is not one")
        yield path


def packing_of(path: str, judge: Judge, only_by_suffix: bool) -> Packing | None:
    """The packing of a file; an .npz is a .zip, but a format of its own."""
    return _packing(head_of(path), os.path.splitext(path)[1].lower(), judge, only_by_suffix)


class PackedFile:
    """A packed file whose content is read from the beginning, again and again, without a copy on the disk.

    Arguments are those of `unpacked`; `suffix` is that of the content. An archive within another packing is refused.
    """

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
        return next(self.chunks(HEAD), b"")[:HEAD]

    def chunks(self, size: int = _BLOCK) -> Iterator[bytes]:
        """The content, from the beginning."""
        with ExitStack() as stack:
            stream: Any = stack.enter_context(Path(self.path).open("rb"))
            for packing, name in self._layers:
                if packing is ZIP:
                    archive = stack.enter_context(ZIP.open(stream))
                    stream = stack.enter_context(_opened(archive, name))
                else:
                    stream = packing.open(stream)
                stream = _Limited(stream, self._limit, f"the {packing.suffix} packing")
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
            raise DataError(_bomb(self._limit))
        return block


def _packing(head: bytes, suffix: str, judge: Judge, only_by_suffix: bool) -> Packing | None:
    for packing in (ZIP, *PACKINGS):
        if packing.magic.match(head) and (suffix == packing.suffix or not only_by_suffix):
            return None if packing is ZIP and suffix != ZIP.suffix and judge(head, suffix) else packing
    return None


def _lone(path: str, packing: Packing, folder: str) -> str:
    """The file in a packing of a single file."""
    name = Path(path).name
    stem = name[: -len(packing.suffix)] if name.lower().endswith(packing.suffix) else name
    with worded(f"the {packing.suffix} packing"), Path(path).open("rb") as file:
        return _copied(packing.open(file), folder, stem, most(path))


def _member(path: str, member: str, judge: Judge, folder: str) -> str:
    name = _chosen(path, member, judge)
    with (
        worded("the archive"),
        Path(path).open("rb") as file,
        ZIP.open(file) as archive,
        _opened(archive, name) as stream,
    ):
        return _copied(stream, folder, name, most(path))


def _chosen(path: str, member: str, judge: Judge) -> str:
    """The member of an archive that is wanted."""
    demand_directory(path)
    with worded("the archive"), Path(path).open("rb") as file, ZIP.open(file) as archive:
        names = [entry.filename for entry in archive.infolist() if not entry.is_dir()]
        if member and member not in names:
            raise UsageError(f"the archive has no member {member!r}; it contains {_listed(names)}")
        name = member or _only(archive, names, judge)
        demand_size(archive.getinfo(name).file_size, path, f"member {name!r}")
        return name


def _only(archive: zipfile.ZipFile, names: list[str], judge: Judge) -> str:
    """The only readable member."""
    if "xl/workbook.xml" in names:
        raise DataError("this is an Excel workbook; give its name the suffix .xlsx")
    likely = [name for name in names if not PROSE.search(name)][:1000]
    readable = [name for name in likely if _readable(archive, name, judge)]
    if len(readable) == 1:
        return readable[0]
    if not readable:
        raise DataError(f"the archive contains no file of a readable format; it contains {_listed(names)}")
    raise UsageError(
        f"the archive contains {len(readable)} readable files: {_listed(readable)}; select one as in "
        f"{'FILE.zip'}{SEPARATOR}{readable[0]}"
    )


def _readable(archive: zipfile.ZipFile, name: str, judge: Judge) -> bool:
    with _opened(archive, name) as stream:
        head = stream.read(4096)
    packed = any(packing.magic.match(head) for packing in (ZIP, *PACKINGS))
    return packed or judge(head, os.path.splitext(name)[1].lower())


def _opened(archive: zipfile.ZipFile, name: str) -> IO[bytes]:
    if archive.getinfo(name).flag_bits & 1:
        raise DataError(f"member {name!r} is encrypted; unpack the archive with its password and read the file itself")
    return archive.open(name)


def _copied(stream: IO[bytes], folder: str, name: str, limit: int) -> str:
    """The contents of `stream` in `folder`, under the last part of `name`."""
    suffix = re.sub(r"[^.A-Za-z0-9]", "", os.path.splitext(name)[1])[:16]
    target, size = Path(folder, f"file{suffix}"), 0
    with target.open("wb") as file:
        while block := stream.read(_BLOCK):
            size += len(block)
            if size > limit:
                raise DataError(_bomb(limit))
            file.write(block)
    if not size:
        raise DataError("the packed file is empty")
    return str(target)


def _bomb(limit: int) -> str:
    return (
        f"the file unpacks to more than the limit of {limit / 1e6:.3g} MB: it is a decompression bomb "
        "or damaged; if it is neither, unpack it and read the contents"
    )


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - 20} more" if len(names) > 20 else ""
    return (", ".join(names[:20]) or "nothing") + more
