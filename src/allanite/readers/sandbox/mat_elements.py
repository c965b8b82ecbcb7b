"""The elements of a MATLAB 5 file, each no longer than what it stands in: a size that is claimed is never believed.

Source: MATLAB MAT-File Format (The MathWorks, 2024), chapter 1. scipy.io.loadmat takes the memory that a file claims,
and ends the interpreter on some damaged files; a check of all sizes before it would have to read what is read here.
"""

import math
import mmap
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError

from .guard import damaged, most

MOST_MATRICES, DEEPEST, LONGEST_NAMES = 10_000, 16, 100_000

_INT32, _UINT32 = 5, 6
_MATRIX, _COMPRESSED = 14, 15
_NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_LETTERS = {1: "latin-1", 2: "latin-1", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"}
_STRUCT, _CHAR = 2, 4
_CLASSES = {6: "f8", 7: "f4", 8: "i1", 9: "u1", 10: "i2", 11: "u2", 12: "i4", 13: "u4", 14: "i8", 15: "u8"}
_COMPLEX, _LOGICAL = 0x0800, 0x0200


class Element(NamedTuple):
    """The kind of an element and its bytes."""

    kind: int
    data: memoryview


@dataclass(frozen=True, eq=False)
class Matrix:
    """A variable or field: an Element of numbers, a list of named matrices, or None for what is no number.

    `shape` is that of MATLAB, `dtype` that of its class, `order` the byte order of the file.
    """

    shape: tuple[int, ...]
    dtype: str = ""
    content: Element | list[tuple[str, "Matrix"]] | None = None
    text: str = ""
    order: str = "<"

    @property
    def size(self) -> int:
        """Number of elements."""
        return math.prod(self.shape)

    def array(self) -> NDArray[Any]:
        """The numbers; MATLAB keeps whole numbers in the smallest type that holds them."""
        if not isinstance(self.content, Element):
            raise DataError("no numbers")
        kept = np.frombuffer(self.content.data, self.order + _NUMBERS[self.content.kind])
        return kept[: self.size].reshape(self.shape, order="F").astype(self.dtype, copy=False)


class _Reader:
    """Byte order, and how much may still be unpacked and how many matrices may still come."""

    def __init__(self, order: str, room: int) -> None:
        self.order, self.room, self.matrices = order, room, MOST_MATRICES

    def elements(self, data: memoryview) -> Iterator[Element]:
        """The elements that stand one behind the other in `data`."""
        at = 0
        while len(data) - at >= 8:
            kind, size = struct.unpack_from(f"{self.order}II", data, at)
            if kind >> 16:  # small: kind, size and up to four bytes in eight
                kind, size, start, end = kind & 0xFFFF, kind >> 16, at + 4, at + 8
                fits = size <= 4
            else:
                start = at + 8
                end = start + size + (0 if kind == _COMPRESSED else -size % 8)
                fits = start + size <= len(data)
            if not fits:
                raise damaged(f"an element at byte {at} claims {size} bytes, {len(data) - start} are there")
            yield Element(kind, data[start : start + size])
            at = end

    def matrix(self, data: memoryview, depth: int) -> tuple[str, Matrix]:
        """Name and contents of a matrix."""
        self.matrices -= 1
        if self.matrices < 0 or depth > DEEPEST:
            raise DataError(f"over {MOST_MATRICES} arrays or {DEEPEST} structures in structures are in the file")
        parts = self.elements(data)
        flags = next(parts, None)
        if flags is None or flags.kind != _UINT32 or len(flags.data) < 4:
            return "", Matrix(())  # an empty field, or an object of MATLAB, which only MATLAB can read
        (word,) = struct.unpack_from(f"{self.order}I", flags.data)
        shape = self._shape(next(parts, None))
        title = next(parts, None)
        name = bytes(title.data).decode("latin-1").rstrip("\0") if title else ""
        if shape is None:
            return name, Matrix(())
        return name, self._contents(word, shape, parts, depth)

    def _shape(self, element: Element | None) -> tuple[int, ...] | None:
        if element is None or element.kind != _INT32 or not 8 <= len(element.data) <= 128:
            return None
        shape = np.frombuffer(element.data[: len(element.data) // 4 * 4], f"{self.order}i4").tolist()
        return None if min(shape) < 0 else tuple(shape)

    def _contents(self, word: int, shape: tuple[int, ...], parts: Iterator[Element], depth: int) -> Matrix:
        form = word & 0xFF
        if form == _STRUCT:
            return Matrix(shape, content=self._fields(shape, parts, depth))
        if word & (_COMPLEX | _LOGICAL) or form not in (*_CLASSES, _CHAR):
            return Matrix(shape)
        body = next(parts, None)
        if form == _CHAR:
            return Matrix(shape, text=self._text(body, shape) or "-")
        if body is None or body.kind not in _NUMBERS:
            raise damaged("an array has no numbers")
        have = len(body.data) // np.dtype(_NUMBERS[body.kind]).itemsize
        if math.prod(shape) != have or len(body.data) % np.dtype(_NUMBERS[body.kind]).itemsize:
            raise damaged(f"an array claims the shape {shape}, but {have} numbers are there")
        self._demand(math.prod(shape) * np.dtype(_CLASSES[form]).itemsize)
        return Matrix(shape, _CLASSES[form], body, order=self.order)

    def _text(self, body: Element | None, shape: tuple[int, ...]) -> str:
        if body is None or shape[0] != 1 or body.kind not in _LETTERS:
            return ""
        code = _LETTERS[body.kind]
        wide = "" if code in ("latin-1", "utf-8") else "-le" if self.order == "<" else "-be"
        return bytes(body.data).decode(code + wide, "replace")

    def _fields(self, shape: tuple[int, ...], parts: Iterator[Element], depth: int) -> list[tuple[str, Matrix]]:
        """The fields of all elements of an array of structures: ``name``, or ``1/name``, ``2/name`` of several."""
        width, names = next(parts, None), next(parts, None)
        if width is None or names is None or len(width.data) != 4:
            raise damaged("a structure has no names of fields")
        (size,) = struct.unpack_from(f"{self.order}i", width.data)
        if not 0 < size <= len(names.data):
            return []
        if len(names.data) > LONGEST_NAMES:
            raise damaged(f"the names of the fields of a structure claim {len(names.data)} bytes")
        whole = bytes(names.data)
        fields = [
            whole[at : at + size].split(b"\0")[0].decode("latin-1") for at in range(0, len(whole) - size + 1, size)
        ]
        found = list[tuple[str, Matrix]]()
        for i, part in enumerate(parts):
            if part.kind != _MATRIX:
                raise damaged("a field of a structure is no array")
            before = f"{i // len(fields) + 1}/" if math.prod(shape) > 1 else ""
            found.append((before + fields[i % len(fields)], self.matrix(part.data, depth + 1)[1]))
        return found

    def unpacked(self, data: memoryview) -> memoryview:
        """The contents of a compressed element."""
        plain = zlib.decompressobj()
        whole = plain.decompress(data, max(1, self.room))
        if not plain.eof:
            why = "claims more than the file can hold" if plain.unconsumed_tail else "was cut off"
            raise damaged(f"a compressed variable {why}")
        self._demand(len(whole))
        return memoryview(whole)

    def _demand(self, size: int) -> None:
        self.room -= size
        if self.room < 0:
            raise damaged("the variables claim more than the file can hold")


def matrices(path: str) -> Iterator[tuple[str, Matrix]]:
    """Names and variables of a file; its numbers are read when they are asked for.

    Raises
    ------
    DataError
        A size that is claimed is more than there is.
    """
    with Path(path).open("rb") as file:
        data = memoryview(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ))
    if len(data) < 136:
        raise damaged("the file ends within its header")
    reader = _Reader("<" if bytes(data[126:128]) == b"IM" else ">", most(path))
    for element in reader.elements(data[128:]):
        body = element
        if element.kind == _COMPRESSED:
            body = next(reader.elements(reader.unpacked(element.data)), Element(0, memoryview(b"")))
        if body.kind != _MATRIX:
            raise damaged(f"an element of type {body.kind} stands where a variable is expected")
        name, matrix = reader.matrix(body.data, 0)
        if name:
            yield name, matrix
