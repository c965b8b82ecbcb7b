"""The messages of an ArduPilot log, binary or as text, and the units in which the log says that their fields are.

Source: ArduPilot, libraries/AP_Logger/LogStructure.h and README.md (ArduPilot team, version 4.5).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from allanite.phrases.phrase import Phrase, say
from allanite.readers.sandbox.guard import demand_size

DEFINITION = 128
"""Number of the kind of message that defines the others, FMT."""

_FIELDS = {
    "b": "i1", "B": "u1", "M": "u1", "h": "<i2", "H": "<u2", "c": "<i2", "C": "<u2", "i": "<i4", "I": "<u4",
    "e": "<i4", "E": "<u4", "L": "<i4", "g": "<f2", "f": "<f4", "d": "<f8", "q": "<i8", "Q": "<u8",
    "n": "S4", "N": "S16", "Z": "S64", "a": "32<i2",
}  # fmt: skip
"""Letters of the format of a message: the type of the field."""

_PRINTED = dict.fromkeys("bBMhHiIqQ", "<i8") | dict.fromkeys("cCeELgfd", "<f8") | {n: _FIELDS[n] for n in "nNZ"}
"""The same for numbers that are printed; integers that are hundredths of something are printed as what they mean."""

_SCALED = "cCeEL"
_DEFINED = np.dtype([("type", "u1"), ("length", "u1"), ("name", "S4"), ("format", "S16"), ("columns", "S64")])
_LABELS = {label: label for label in ("s", "deg", "rad", "deg/s", "rad/s", "m", "m/s", "degC", "Pa")}
_LABELS |= {"m/s/s": "m/s^2"}
"""Units of the log: as they are written here."""

_TIMES = {1e-3: "ms", 1e-6: "us", 1e-9: "ns"}

Rows = NDArray[np.void]
Units = Mapping[str, tuple[str, float]]
"""Unit of a field, and the factor on its numbers."""


@dataclass(frozen=True)
class Kind:
    """A kind of message: its number, name, the type of its contents, how many there are, and its format."""

    number: int
    name: str
    dtype: np.dtype[np.void]
    count: int
    letters: str = ""


class Log(Protocol):
    """The messages of a log."""

    @property
    def kinds(self) -> list[Kind]:
        """The kinds of messages in the log whose fields can be read."""

    @property
    def notes(self) -> tuple[Phrase, ...]:
        """What is damaged."""

    @property
    def scaled(self) -> str:
        """Letters of the formats of fields that need no factor."""

    def rows(self, kind: Kind) -> Rows:
        """The contents of all messages of a kind; fewer than its count if some cannot be read."""


def named(log: Log, name: str) -> Kind | None:
    """The kind of this name."""
    return next((kind for kind in log.kinds if kind.name == name), None)


@dataclass(frozen=True, eq=False)
class BinaryLog:
    """A log of which `data`, shape (n,), are the bytes."""

    data: NDArray[np.uint8]
    scaled = ""

    @cached_property
    def _walked(self) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
        """Lengths and numbers of messages of all kinds, and the bytes of none."""
        from allanite.kernels.messages import counted

        lengths = np.zeros(256, np.int64)
        lengths[DEFINITION] = 3 + _DEFINED.itemsize
        counts, lost = counted(self.data, lengths)
        return lengths, counts, int(lost)

    @cached_property
    def kinds(self) -> list[Kind]:
        """The kinds of messages in the log whose fields can be read."""
        lengths, counts, _ = self._walked
        made = dict[int, Kind]()
        for row in self.rows(Kind(DEFINITION, "FMT", _DEFINED, int(counts[DEFINITION]))):
            number, letters = int(row["type"]), word(row["format"])
            dtype = _contents(letters, word(row["columns"]).split(","), _FIELDS)
            if number not in made and counts[number] and dtype.itemsize + 3 == lengths[number]:
                made[number] = Kind(number, word(row["name"]), dtype, int(counts[number]), letters)
        return [kind for kind in made.values() if kind.number != DEFINITION]

    @property
    def notes(self) -> tuple[Phrase, ...]:
        """What is damaged."""
        lost = self._walked[2]
        return (say("the log is damaged: {bytes} bytes belong to no message", bytes=lost),) if lost else ()

    def rows(self, kind: Kind) -> Rows:
        """The contents of all messages of a kind."""
        from allanite.kernels.messages import taken

        rows = np.zeros((kind.count, kind.dtype.itemsize), np.uint8)
        taken(self.data, self._walked[0].copy(), kind.number, rows)
        return rows.view(kind.dtype)[:, 0]


@dataclass(frozen=True, eq=False)
class TextLog:
    """A log as text, one message a line, of the file at `path`."""

    path: str
    data: bytes
    notes: tuple[Phrase, ...] = ()
    scaled = _SCALED

    @cached_property
    def _lines(self) -> dict[str, list[str]]:
        """The lines of each name, without it."""
        found = dict[str, list[str]]()
        for line in self.data.decode("latin-1").splitlines():
            name, comma, rest = line.partition(",")
            if comma:
                found.setdefault(name, []).append(rest)
        return found

    @cached_property
    def kinds(self) -> list[Kind]:
        """The kinds of messages in the log whose fields can be read; arrays have no form as text."""
        made = dict[str, Kind]()
        for line in self._lines.get("FMT", ()):
            number, _, name, letters, *columns = (*map(str.strip, line.split(",")), "", "", "", "")
            dtype = _contents(letters, [column for column in columns if column], _PRINTED)
            lines = self._lines.get(name)
            if lines and dtype.itemsize and number.isdecimal() and name not in ("FMT", *made):
                made[name] = Kind(int(number[:4]), name, dtype, len(lines), letters)
        return list(made.values())

    def rows(self, kind: Kind) -> Rows:
        """The contents of all messages of a kind that can be read."""
        demand_size(kind.count * kind.dtype.itemsize, self.path, f"message {kind.name!r}")
        commas = len(kind.dtype.names or ()) - 1
        lines = [line for line in self._lines[kind.name] if line.count(",") == commas]
        return np.concatenate([np.empty(0, kind.dtype), *_parsed(lines, kind.dtype)])


def _parsed(lines: Sequence[str], dtype: np.dtype[np.void]) -> Iterator[Rows]:
    """The rows of lines, without those that cannot be read, which are looked for by halving."""
    if not lines:
        return
    try:
        yield np.loadtxt(lines, dtype, delimiter=",", comments=None, ndmin=1)
    except ValueError:
        half = len(lines) // 2
        for part in (lines[:half], lines[half:]) if half else ():
            yield from _parsed(part, dtype)


def word(raw: bytes) -> str:
    """A text of a message."""
    return raw.split(b"\0")[0].decode("latin-1").strip()


def _contents(letters: str, names: Sequence[str], types: Mapping[str, str]) -> np.dtype[np.void]:
    """The type of the contents of a defined message; empty if it has fields of unknown types or names."""
    known = len(letters) == len(names) == len(set(names)) and all(letter in types for letter in letters)
    fields = zip(names, letters, strict=True) if known and all(names) else ()
    return np.dtype([(name, types[letter]) for name, letter in fields])


def units(log: Log) -> dict[int, Units]:
    """The units of fields by the number of the kind of message, as far as the log says them by FMTU, UNIT and MULT."""
    about = [named(log, name) for name in ("FMTU", "UNIT", "MULT")]
    needed = ({"FmtType", "UnitIds", "MultIds"}, {"Id", "Label"}, {"Id", "Mult"})
    if any(
        kind is None or not fields <= set(kind.dtype.names or ()) for kind, fields in zip(about, needed, strict=True)
    ):
        return {}
    said, labels, factors = (log.rows(kind) for kind in about if kind is not None)
    label = {chr(int(row["Id"]) % 256): _LABELS.get(word(row["Label"]), "") for row in labels}
    factor = {chr(int(row["Id"]) % 256): float(row["Mult"]) for row in factors}
    kinds, found = {kind.number: kind for kind in log.kinds}, dict[int, Units]()
    for row in said:
        kind = kinds.get(int(row["FmtType"]))
        if kind is not None:
            fields = zip(kind.dtype.names or (), kind.letters, word(row["UnitIds"]), word(row["MultIds"]), strict=False)
            found[kind.number] = {
                name: _scaled(label[unit], 1.0 if letter in log.scaled else factor.get(times, 1.0))
                for name, letter, unit, times in fields
                if label.get(unit)
            }
    return found


def _scaled(unit: str, factor: float) -> tuple[str, float]:
    """A unit and a factor; times remain integers of another unit, and a factor of zero means none."""
    factor = float(f"{factor:.7g}")  # some are stored in single precision
    if unit == "s" and factor in _TIMES:
        return _TIMES[factor], 1.0
    return unit, factor if 0 < factor < float("inf") else 1.0
