"""The contents of R's .rda, .RData and .rds, read with the parser of the package rdata; started by `worker`.

Source of the format: R Internals (R Core Team, 4.4), section 1.8. The parser belongs to the library, but its bytes are
supplied here, because it accepts fewer bytes than claimed and would read an incomplete file as a shorter one.
"""

import gc
import importlib.util
import struct
import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

_spec = None if "rdata" in sys.modules else importlib.util.find_spec("rdata")
if _spec is not None:
    # the package itself imports pandas and xarray, which takes a second; its parser needs neither
    sys.modules["rdata"] = importlib.util.module_from_spec(_spec)
from rdata.parser import RObjectType as Type  # noqa: E402
from rdata.parser._parser import Parser  # noqa: E402  the door of the parser alone does not let its bytes be checked

if _spec is not None:
    del sys.modules["rdata"]  # any other import of the package gets all of it

MOST_LISTS, NAMES = 100_000, 1000  # maximum number of lists and other objects in a file, and of texts kept of a vector

_CHAR = 9
_SECONDS = {"secs": "s", "mins": "min", "hours": "h"}


class Reader(Parser):  # type: ignore[misc, unused-ignore]
    """The library's parser over bytes (XDR, the form of every .rda) that are never fewer than claimed."""

    def __init__(self, data: bytes) -> None:
        super().__init__()
        self.data, self.at, self.left = memoryview(data), data.index(b"X\n") + 2, MOST_LISTS

    def take(self, size: int) -> memoryview:
        """The next bytes."""
        if not 0 <= size <= len(self.data) - self.at:
            sys.exit(f"at byte {self.at} {size} bytes are claimed, but only {len(self.data) - self.at} are left")
        self.at += size
        return self.data[self.at - size : self.at]

    def parse_int(self) -> int:
        """The next integer."""
        return int(struct.unpack(">i", self.take(4))[0])

    def parse_string(self, length: int) -> bytes:
        """The next text."""
        return bytes(self.take(length))

    def parse_R_object(self, *given: Any, **named: Any) -> Any:
        """The next object."""
        self.left -= 1
        if self.left < 0:
            sys.exit(
                f"too many lists: more than {MOST_LISTS}; save only the numbers: saveRDS(as.matrix(x), 'again.rds')"
            )
        return super().parse_R_object(*given, **named)

    def _parse_array_values(self, dtype: Any, length: int) -> Any:
        kind = np.dtype(dtype)
        return np.frombuffer(self.take(length * kind.itemsize), kind.newbyteorder(">")).astype(kind)

    def _parse_vector_value(self, *given: Any) -> list[Any]:
        """The next list, or vector of texts: of many texts only the first, which may be names, are kept."""
        count = self.parse_int()
        if not 0 <= 4 * count <= len(self.data) - self.at:
            sys.exit(f"a list claims {count} entries, more than the file can hold")
        items = []
        for i in range(count):
            flags, size = struct.unpack_from(">ii", self.data, self.at) if len(self.data) >= self.at + 8 else (0, 0)
            if i < NAMES or flags & 0x2FF != _CHAR:
                items.append(self.parse_R_object(*given))
            else:
                self.take(8 + max(size, 0))
        return items


def opened(path: str, most: int, names: dict[str, Any]) -> tuple[dict[str, Any], Callable[..., Any]]:
    """The vectors, matrices and columns of data frames, with their paths, and a function that sends them."""
    with open(path, "rb") as file:
        data = file.read()
    sys.setrecursionlimit(20_000)  # a list of pairs is recursive in the parser
    gc.disable()  # a million objects and no cycles
    top = Reader(data).parse_all().object
    contents: dict[str, Any] = {"datasets": [], "numbers": {}, "texts": {}, "left": [], "description": ""}
    arrays = {}
    for name, item in _pairs(top) if data.startswith(b"RDX") else [("", top)]:
        for where, leaf, about in _leaves(name, item):
            if leaf.size == 1:
                contents["numbers"][where] = float(leaf[0])
            else:
                dim = _numbers(about["dim"]) if "dim" in about else None
                shape = [leaf.size] if dim is None else [int(side) for side in dim]
                if min(shape, default=-1) < 0 or np.prod(shape, dtype=float) != leaf.size:
                    sys.exit(f"{where!r} claims the dimensions {shape}, but has {leaf.size} numbers")
                arrays[where or "x"] = leaf.reshape(shape, order="F")
                place = {"path": where or "x", "shape": shape, "fields": [["", leaf.dtype.str, ()]]}
                contents["datasets"].append(place | _said(about))
    return contents, lambda where, fields: (arrays[where].nbytes, [np.ascontiguousarray(arrays[where]).data])


def _leaves(path: str, item: Any) -> Iterator[tuple[str, Any, dict[str, Any]]]:
    """The arrays and single numbers in an object, with their paths and attributes."""
    about = dict(_pairs(item.attributes))
    for name, value in about.items():
        if (lone := _numbers(value)) is not None and lone.size == 1:
            yield f"{path}/{name}".lstrip("/"), lone, {}
    numbers = _numbers(item)
    if item.info.type in (Type.VEC, Type.EXPR):
        names = _texts(about.get("names"))
        for i, inner in enumerate(item.value):
            yield from _leaves(f"{path}/{names[i] if i < len(names) else i + 1}".lstrip("/"), inner)
    elif numbers is not None and (numbers.size == 1 or "levels" not in about):
        yield path, numbers, about


def _pairs(item: Any) -> Iterator[tuple[str, Any]]:
    """Names and objects of a list of pairs."""
    while item is not None and item.info.type == Type.LIST:
        symbol = item.tag if item.tag is None or item.tag.referenced_object is None else item.tag.referenced_object
        yield "" if symbol is None else _text(symbol.value), item.value[0]
        item = item.value[1]


def _numbers(item: Any) -> Any:
    """The numbers of a vector, NaN where one is missing; None if it does not hold numbers."""
    if item.info.type not in (Type.INT, Type.REAL):
        return None
    masked = isinstance(item.value, np.ma.MaskedArray)
    return item.value.astype(np.float64).filled(np.nan) if masked else item.value


def _texts(item: Any) -> list[str]:
    """The texts of a vector; empty if it does not hold texts."""
    return [_text(text) for text in item.value] if item is not None and item.info.type == Type.STR else []


def _text(item: Any) -> str:
    return item.value.decode("utf-8", "replace") if item is not None and isinstance(item.value, bytes) else ""


def _said(about: dict[str, Any]) -> dict[str, Any]:
    """Unit, names of columns and rate of an array, from its attributes."""
    unit = next((words[0] for name in ("units", "unit") if (words := _texts(about.get(name)))), "")
    attributes: dict[str, Any] = {"units": _SECONDS.get(unit, unit)}
    if "POSIXct" in _texts(about.get("class")):
        attributes["units"] = "s"
    names = about.get("dimnames")
    if names is not None and names.info.type == Type.VEC and len(names.value) == 2:
        attributes["columns"] = _texts(names.value[1])
    series = _numbers(about["tsp"]) if "tsp" in about else None
    if series is not None and series.size == 3 and series[2] > 0:
        attributes["rate"] = float(series[2])
    return attributes
