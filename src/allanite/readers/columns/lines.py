"""A text that is read a block of whole lines at a time, as `text.read` reads it at once."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from allanite.core.errors import DataError

from . import encoding, layout, shapes

BLOCK = 1 << 23
"""Bytes that are read at a time."""

FIRST = 1 << 22
"""Bytes, at least, by which the layout and the meaning of the columns are recognized."""

Chunks = Callable[[], Iterator[bytes]]
"""Reads the bytes of a file from the beginning."""


def chunks_of(path: str) -> Chunks:
    """The bytes of a file."""

    def chunks() -> Iterator[bytes]:
        with Path(path).open("rb", buffering=0) as file:
            while chunk := file.read(BLOCK):
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
        """Blocks of whole lines, and whether it is the last one, which ends as the file does.

        The first one has at least `FIRST` bytes, and the last one more than a line, if the file has.
        """
        held, least, dollar = b"", FIRST, False
        for lines in encoding.whole_lines(self._plain()):
            dollar = dollar or (not held and least == FIRST and lines.lstrip().startswith(b"$"))
            block = shapes.without_checksums(lines) if dollar else lines
            if len(held) >= least and len(block) > BLOCK // 64:
                yield held, False
                held, least = b"", BLOCK // 2
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
                returns = b"\n" not in data[: layout.HEAD]
            size += len(data)
            yield data.replace(b"\r", b"\n") if returns else data
