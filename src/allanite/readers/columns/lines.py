"""A file whose rows are read a part at a time, of text or of binary numbers."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError
from allanite.readers.options import Options

from . import encoding, layout, shapes
from .table import FileTable

BLOCK_BYTES = 1 << 23  # bytes that are read at a time
FIRST = 1 << 22  # bytes, at least, by which the layout and the meaning of the columns are recognized

Chunks = Callable[[], Iterator[bytes]]  # reads the bytes of a file from the beginning


def chunks_of(path: str, begin: Callable[[], int] = int) -> Chunks:
    """The bytes of a file from its beginning, or from the byte that `begin` tells."""

    def chunks() -> Iterator[bytes]:
        with Path(path).open("rb", buffering=0) as file:
            file.seek(begin())
            while chunk := file.read(BLOCK_BYTES):
                yield chunk

    return chunks


def plain(data: bytes, before: int = 0) -> bytes:
    """The text without a byte order mark, or a part of it that so many bytes precede; refused with a zero byte."""
    text = data if before else data.removeprefix(b"\xef\xbb\xbf")
    if b"\x00" in text:
        place = before + text.index(0)
        raise DataError(f"there is a zero byte at byte {place} of the text: the file is damaged or binary")
    return text


@dataclass(frozen=True)
class TextLines:
    """The lines of a file in UTF-8; `codec` and `name` are the encoding of the file, empty if it is UTF-8."""

    chunks: Chunks
    codec: str
    name: str

    def blocks(self) -> Iterator[tuple[bytes, bool]]:
        """Blocks of whole lines, and whether it is the last one, which ends as the file does."""
        # The first one has at least `FIRST` bytes, and the last one more than a line, if the file has.
        held, least, dollar = b"", FIRST, False
        for lines in encoding.whole_lines(self._plain()):
            dollar = dollar or (not held and least == FIRST and lines.lstrip().startswith(b"$"))
            block = shapes.without_checksums(lines) if dollar else lines
            if len(held) >= least and len(block) > BLOCK_BYTES // 64:
                yield held, False
                held, least = b"", BLOCK_BYTES // 2
            held += block
        if held:
            yield held.removesuffix(b"\x1a"), True

    def rows(self, found: layout.Layout) -> Iterator[tuple[bytes, layout.Layout, bool]]:
        """Blocks of rows, with the layout of each, and whether it is the last one."""
        skip, line = found.offset, found.line
        for rows, last in self.blocks():
            yield rows[skip:], replace(found, offset=0, line=line), last
            # a file of carriage returns and newlines has both as ends of lines
            line += len(rows[skip:].splitlines()) if b"\r" in rows else rows.count(b"\n", skip)
            skip = 0

    def _plain(self) -> Iterator[bytes]:
        """The bytes in UTF-8, with line ends that contain a newline."""
        text = encoding.decoded(self.chunks(), self.codec, self.name) if self.codec else self.chunks()
        size, returns = 0, False
        for chunk in text:
            data = plain(chunk, size)
            if not size:
                returns = b"\n" not in data[: layout.LONGEST_HEAD]
            size += len(data)
            yield data.replace(b"\r", b"\n") if returns else data


@dataclass(frozen=True)
class Rows:
    """Rows of numbers of one type after `offset` bytes; a structured type has a column for each number."""

    path: str
    dtype: np.dtype[Any]
    offset: int
    shape: tuple[int, ...]  # (rows,) or (rows, columns)
    bycolumn: bool = False  # the columns are stored one after the other

    def blocks(self, wanted: Sequence[int], rows: int) -> Iterator[list[NDArray[Any]]]:
        """Columns of so many rows at a time."""
        if not self.bycolumn or len(self.shape) == 1:
            for part in self.whole(rows):
                every = columns_of(part)
                yield [every[i] for i in wanted]
            return
        with open(self.path, "rb", buffering=0) as file:
            for begin in range(0, self.shape[0], rows):
                count = min(rows, self.shape[0] - begin)
                yield [self._numbers(file, (i * self.shape[0] + begin, count), (count,)) for i in wanted]

    def whole(self, rows: int) -> Iterator[NDArray[Any]]:
        """So many rows at a time, with all columns."""
        width = math.prod(self.shape[1:])
        with open(self.path, "rb", buffering=0) as file:
            for begin in range(0, self.shape[0], rows):
                count = min(rows, self.shape[0] - begin)
                yield self._numbers(file, (begin * width, count * width), (count, *self.shape[1:]))

    def _numbers(self, file: Any, place: tuple[int, int], shape: tuple[int, ...]) -> NDArray[Any]:
        """So many numbers from a place on."""
        begin, count = place
        part = np.empty(count, self.dtype)
        data, filled = part.view(np.uint8).reshape(-1).data, 0
        file.seek(self.offset + begin * self.dtype.itemsize)
        while filled < len(data) and (more := file.readinto(data[filled:])):
            filled += more
        if filled < len(data):
            raise DataError(f"the file ends in the middle of its numbers, at byte {file.tell()}")
        return part.reshape(shape)


def columns_of(rows: NDArray[Any]) -> list[NDArray[Any]]:
    """The columns of rows, one for each number."""
    if rows.dtype.names:
        return [column for name in rows.dtype.names for column in columns_of(rows[name])]
    return list(rows.reshape(len(rows), -1).T)


HEAD_ROWS = 1 << 18  # rows by which columns, units and the clock are recognized

Blocks = Callable[[Sequence[int], int], Iterator[list[NDArray[Any]]]]
"""Indices of columns, and rows at a time -> arrays of these columns, of at most about that many rows."""


@dataclass(frozen=True, eq=False)
class Parts:
    """A file that can be read in parts."""

    head: FileTable  # of its first rows
    rows: int  # in the whole file
    blocks: Blocks  # reads columns of the head from the beginning
    options: Options  # those of the head, which a container may have narrowed
