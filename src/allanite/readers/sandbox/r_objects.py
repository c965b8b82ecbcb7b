"""The objects of R's serialization (XDR, versions 2 and 3), each no longer than the file: data only, no code runs.

Source: R Internals (R Core Team, 4.4), section 1.8. The package rdata makes several objects of Python of each four
bytes of a list, so that a file of 1 MB takes seconds, and expands sequences to any length that a file claims.
"""

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError

from .guard import damaged

MOST, DEEPEST = 200_000, 100
"""Objects in a file, numbers and texts not counted, and lists in lists."""

MOST_TEXTS, NAMES = 3_000_000, 1000
"""Texts in a vector, and those of them that are kept."""

LONGEST = 10_000_000
"""Numbers of a sequence of which the file holds the first and the step only."""

_TEXT_END = -1
_NA = np.int32(-(2**31))
_SYMBOL, _PAIRS, _ENVIRONMENT, _LETTERS, _TEXTS, _LIST, _EXPRESSION = 1, 2, 4, 9, 16, 19, 20
_POINTER, _WEAK, _S4, _ALTERNATIVE, _PACKAGE, _NAMESPACE, _REFERENCE = 22, 23, 25, 238, 248, 249, 255
_LIKE_PAIRS = (_PAIRS, 3, 5, 6, 17)  # closures, promises, calls and dots are stored as pairs
_EMPTY = (0, 241, 242, 250, 251, 252, 253, 254)
_WITHOUT_ATTRIBUTES = (*_EMPTY, _SYMBOL, _REFERENCE, _ENVIRONMENT, _NAMESPACE, _PACKAGE, _ALTERNATIVE)
_NUMBERS = {13: ">i4", 14: ">f8"}
_OTHER_VECTORS = {10: 4, 15: 16, 24: 1}  # logical, complex, bytes: their sizes


_WORD, _TEXT = struct.Struct(">i"), struct.Struct(">ii")


_NONE: "Mapping[str, Object]" = MappingProxyType({})


@dataclass(eq=False, slots=True)
class Object:
    """An object of R: numbers, texts, items of a list, or pairs of name and object; all None or empty if neither."""

    numbers: NDArray[Any] | None = None
    texts: Sequence[str] = ()
    items: "list[Object] | None" = None
    pairs: "Sequence[tuple[str, Object]]" = ()
    attributes: "Mapping[str, Object]" = field(default_factory=lambda: _NONE)

    def words(self, name: str) -> Sequence[str]:
        """The texts of an attribute; none if it has none."""
        return self.attributes[name].texts if name in self.attributes else ()


_NOTHING = Object()
"""One for all: it is never changed."""


def load(data: bytes) -> Object:
    """The object that a file holds; that of an .rda is the pairs of its variables.

    Raises
    ------
    DataError
        The file ends too early, claims more than it has, or holds something that is no data.
    """
    reader = _Reader(data)
    reader.at = data.index(b"X\n") + 2
    version, _, _ = (reader.integer() for _ in range(3))
    if version not in (2, 3):
        raise DataError(f"version {version} of R's files is not read; save it with version=2")
    if version == 3:
        reader.take(reader.integer())  # the encoding of texts
    return reader.item(0)


class _Reader:
    """A place in the data, the objects that may be named again, and how many may still come."""

    def __init__(self, data: bytes) -> None:
        self.data, self.at, self.left = memoryview(data), 0, MOST
        self.named: list[str] = []

    def take(self, size: int) -> memoryview:
        if size < 0 or size > len(self.data) - self.at:
            raise damaged(f"at byte {self.at} {size} bytes are claimed, {len(self.data) - self.at} are there")
        self.at += size
        return self.data[self.at - size : self.at]

    def integer(self) -> int:
        return int(_WORD.unpack(self.take(4))[0])

    def length(self) -> int:
        size = self.integer()
        return size if size != -1 else (self.integer() << 32) + (self.integer() & 0xFFFFFFFF)

    def item(self, depth: int) -> Object:
        """The object at this place."""
        self._count(depth)
        flags = self.integer()
        kind = flags & 0xFF
        if kind in _LIKE_PAIRS:
            return self._pairs(flags, depth)
        made = self._value(kind, flags, depth)
        if flags & 0x200 and kind not in _WITHOUT_ATTRIBUTES:
            made.attributes = {**made.attributes, **dict(self.item(depth + 1).pairs)}
        return made

    def _count(self, depth: int) -> None:
        self.left -= 1
        if self.left < 0 or depth > DEEPEST:
            raise DataError(f"over {MOST} lists, or {DEEPEST} lists in lists, are in the file; save the numbers alone")

    def _value(self, kind: int, flags: int, depth: int) -> Object:
        if kind in _EMPTY:
            return _NOTHING
        if kind in _NUMBERS:
            return Object(numbers=self._numbers(kind))
        if kind in _OTHER_VECTORS:
            self.take(self.length() * _OTHER_VECTORS[kind])
            return Object()
        if kind in (_TEXTS, _LIST, _EXPRESSION):
            return self._several(kind, depth)
        if kind == _ALTERNATIVE:
            return self._alternative(depth)
        return self._named(kind, flags, depth)

    def _named(self, kind: int, flags: int, depth: int) -> Object:
        """What can be named again later, and its later mentions."""
        if kind == _LETTERS:
            size = self.integer()
            return Object(texts=["" if size == _TEXT_END else bytes(self.take(size)).decode("utf-8", "replace")])
        if kind == _REFERENCE:
            index = flags >> 8 or self.integer()
            if not 0 < index <= len(self.named):
                raise damaged(f"object {index} is named, but {len(self.named)} are there")
            return Object(texts=[self.named[index - 1]])
        self.named.append("")
        if kind == _SYMBOL:
            at = len(self.named) - 1
            made = self.item(depth + 1)
            self.named[at] = made.texts[0] if made.texts else ""
            return made
        parts = {_POINTER: 2, _WEAK: 0, _ENVIRONMENT: 4, _NAMESPACE: 0, _PACKAGE: 0}
        if kind == _S4:
            self.named.pop()
            return Object()
        if kind not in parts:
            raise DataError(f"the file holds R code or another object that is no data (type {kind}); save numbers")
        if kind in (_ENVIRONMENT, _NAMESPACE, _PACKAGE):
            self.integer()  # locked, or a place that is always 0
        for _ in range(parts[kind]):
            self.item(depth + 1)
        if kind in (_NAMESPACE, _PACKAGE):
            self._several(_TEXTS, depth)
        return Object()

    def _pairs(self, flags: int, depth: int) -> Object:
        """A list of pairs, one behind the other; the last one ends with something that is no pair."""
        made, pairs = Object(), list[tuple[str, Object]]()
        made.pairs = pairs
        while flags & 0xFF in _LIKE_PAIRS:
            self._count(depth)
            if flags & 0x200:
                made.attributes = dict(self.item(depth + 1).pairs)
            tag = self.item(depth + 1).texts if flags & 0x400 else ()
            pairs.append((tag[0] if tag else "", self.item(depth + 1)))
            flags = self.integer()
        self._value(flags & 0xFF, flags, depth)
        return made

    def _several(self, kind: int, depth: int) -> Object:
        count = self.length()
        if not 0 <= count * 4 <= len(self.data) - self.at:
            raise damaged(f"a list claims {count} entries, which the file is too short for")
        if kind == _TEXTS:
            return Object(texts=self._texts(count))
        return Object(items=[self.item(depth + 1) for _ in range(count)])

    def _texts(self, count: int) -> list[str]:
        """The first texts of a vector, which may be names; of a column of them the rest is passed over."""
        if count > MOST_TEXTS:
            raise DataError(f"over {MOST_TEXTS} texts are in a vector; save the numbers alone")
        words = list[str]()
        for _ in range(count):
            flags, size = _TEXT.unpack_from(self.data, self.at)
            if flags & 0x2FF != _LETTERS:
                raise damaged(f"at byte {self.at} is something else than the text that is expected")
            self.at += _TEXT.size
            if len(words) < NAMES:
                words.append(bytes(self.take(max(size, 0))).decode("utf-8", "replace"))
            else:
                self.at += max(size, 0)
        self.take(0)
        return words

    def _numbers(self, kind: int) -> NDArray[Any]:
        array = np.frombuffer(self.take(self.length() * int(_NUMBERS[kind][-1])), _NUMBERS[kind])
        if kind == 13 and len(array) and array.min() == _NA:
            return np.where(array == _NA, np.nan, array)
        return array

    def _alternative(self, depth: int) -> Object:
        """A sequence or a vector that R keeps in a form of its own."""
        about, state, attributes = (self.item(depth + 1) for _ in range(3))
        made, name = Object(), about.pairs[0][1].texts if about.pairs else ()
        if name and name[0].startswith("compact_") and state.numbers is not None and state.numbers.size == 3:
            made.numbers = self._sequence(*state.numbers.tolist())
        elif name and name[0].startswith("wrap_"):
            wrapped = state.items or [pair[1] for pair in state.pairs]
            made = replace(wrapped[0]) if wrapped else made
        made.attributes = {**made.attributes, **dict(attributes.pairs)}
        return made

    def _sequence(self, count: float, start: float, step: float) -> NDArray[Any]:
        if not 0 <= count <= min(LONGEST, 4 * len(self.data) + LONGEST / 100):
            raise damaged(f"a sequence claims {count:g} numbers, more than the file can stand for")
        return start + step * np.arange(int(count))
