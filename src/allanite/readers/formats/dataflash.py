"""ArduPilot dataflash logs: their messages, binary or as text, and the gyroscopes and accelerometers in them.

Source: ArduPilot, libraries/AP_Logger/LogStructure.h and README.md (ArduPilot team, version 4.5).

Binary logs, and logs that Mission Planner has written as text.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import product
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from allanite.core.record import Recording
from allanite.kernels import passing
from allanite.phrases.phrase import Phrase, say
from allanite.readers.columns.column import FileColumn, column, some
from allanite.readers.columns.containers import Stream, mean_rate, stream_recording
from allanite.readers.columns.table import FileTable
from allanite.readers.options import Options
from allanite.readers.sandbox.process import demand_size, worded
from allanite.readers.sandbox.source import head_of

DEFINITION = 128  # number of the kind of message that defines the others, FMT

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
Units = Mapping[str, tuple[str, float]]  # unit of a field, and the factor on its numbers


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
        lengths = np.zeros(256, np.int64)
        lengths[DEFINITION] = 3 + _DEFINED.itemsize
        counts, lost = passing.counted(self.data, lengths)
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
        rows = np.zeros((kind.count, kind.dtype.itemsize), np.uint8)
        passing.taken(self.data, self._walked[0].copy(), kind.number, rows)
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
        lines = dict[str, list[str]]()
        for line in self.data.decode("latin-1").splitlines():
            name, comma, rest = line.partition(",")
            if comma:
                lines.setdefault(name, []).append(rest)
        return lines

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
    pairs = zip(about, needed, strict=True)
    if any(kind is None or not fields <= set(kind.dtype.names or ()) for kind, fields in pairs):
        return {}
    kinds_of_units, labels, factors = (log.rows(kind) for kind in about if kind is not None)
    label = {chr(int(row["Id"]) % 256): _LABELS.get(word(row["Label"]), "") for row in labels}
    factor = {chr(int(row["Id"]) % 256): float(row["Mult"]) for row in factors}
    kinds, units = {kind.number: kind for kind in log.kinds}, dict[int, Units]()
    for row in kinds_of_units:
        kind = kinds.get(int(row["FmtType"]))
        if kind is not None:
            fields = zip(kind.dtype.names or (), kind.letters, word(row["UnitIds"]), word(row["MultIds"]), strict=False)
            units[kind.number] = {
                name: _scaled(label[unit], 1.0 if letter in log.scaled else factor.get(times, 1.0))
                for name, letter, unit, times in fields
                if label.get(unit)
            }
    return units


def _scaled(unit: str, factor: float) -> tuple[str, float]:
    """A unit and a factor; times remain integers of another unit, and a factor of zero means none."""
    factor = float(f"{factor:.7g}")  # some are stored in single precision
    if unit == "s" and factor in _TIMES:
        return _TIMES[factor], 1.0
    return unit, factor if 0 < factor < float("inf") else 1.0


TITLE = "ArduPilot dataflash log .bin, or .log as text"

_MAGIC = b"\xa3\x95\x80"
_TEXT = re.compile(rb"^FMT, *128, *\d+, *FMT,", re.MULTILINE)
_UNITS = {"TimeUS": "us", "SampleUS": "us", "TimeMS": "ms", "T": "degC"}
_UNITS |= {f"{sensor}{axis}": unit for sensor, unit in (("Gyr", "rad/s"), ("Acc", "m/s^2")) for axis in "XYZ"}
"""Units of fields of which the log does not say any."""

_BATCH = (("accel", "m/s^2"), ("gyro", "rad/s"))  # names and units of the sensors of batches, by their number there


def sniff(head: bytes, suffix: str) -> bool:
    """Whether the file begins with the definition of a message, or has one among its first lines."""
    return head.startswith(_MAGIC) or bool(_TEXT.search(head[:4096]))


def read(path: str, options: Options) -> Recording:
    """The channels of one kind of message; of several instances each is ``IMU/0``, ``IMU/1``."""
    binary = head_of(path).startswith(_MAGIC)
    log: Log = (
        BinaryLog(np.asarray(np.memmap(path, np.uint8, mode="r"))) if binary else TextLog(path, Path(path).read_bytes())
    )
    with worded():
        stated = units(log)
        streams = [stream for kind in log.kinds for stream in _streams(log, kind, stated.get(kind.number, {}))]
    return stream_recording([*_batches(log), *streams], options, log.notes)


def _streams(log: Log, kind: Kind, stated: Units) -> Iterator[Stream]:
    """A stream for each instance of a kind of message."""
    names = tuple(kind.dtype.names or ())
    if not _inertial(names):
        if not kind.name.startswith("ISB") and names:
            yield Stream(kind.name, kind.count, names, lambda: _table(kind, log.rows(kind), stated), likely=False)
        return
    rows = log.rows(kind)
    instances = np.unique(rows["I"]) if "I" in names else [None]
    lost = kind.count - rows.size
    for instance in instances:
        own = rows if instance is None else rows[rows["I"] == instance]
        name = kind.name if instance is None else f"{kind.name}/{instance}"
        stamp = next((field for field in ("TimeUS", "SampleUS", "TimeMS") if field in names), None)
        span = 0 if stamp is None or not own.size else int(own[stamp][-1]) - int(own[stamp][0])
        rate = mean_rate(own.size, span * (1e-3 if stamp == "TimeMS" else 1e-6))
        yield Stream(name, own.size, names, partial(_table, kind, own, stated, lost), rate)


def _inertial(names: tuple[str, ...]) -> bool:
    return any(_UNITS.get(name, "") in ("rad/s", "m/s^2") for name in names)


def _table(kind: Kind, rows: Rows, stated: Units, lost: int = 0) -> FileTable:
    """The numbers of messages; of those with inertial sensors only these, time stamps and temperature."""
    names = tuple(rows.dtype.names or ())
    known = _inertial(names)
    kept = [name for name in names if rows.dtype[name].kind in "iuf" and (name in _UNITS or not known)]
    unused = [name for name in names if name not in kept]
    notes = []
    if lost:
        notes.append(say("the log is damaged: {count} lines of {name} cannot be read", count=lost, name=kind.name))
    if stated.keys() & kept:
        notes.append(say("units by the definitions in the log"))
    if unused:
        notes.append(say("left out, not used of the table: {fields}", fields=some(unused)))
    made = []
    for name in kept:
        unit, factor = stated.get(name, (_UNITS.get(name, ""), 1.0))
        values = rows[name] if factor == 1 else rows[name].astype(np.float64) * factor
        made.append(column(name, values, names.index(name) + 1, unit=unit))
    return FileTable(tuple(made), notes=tuple(notes))


def _batches(log: Log) -> Iterator[Stream]:
    """A stream for each sensor that was sampled in batches."""
    heads, parts = named(log, "ISBH"), named(log, "ISBD")
    needed = {"N", "type", "instance", "mul", "smp_cnt", "SampleUS", "smp_rate"}
    if heads is None or parts is None or not needed <= set(heads.dtype.names or ()):
        return
    if not {"N", "seqno", "x", "y", "z"} <= set(parts.dtype.names or ()):
        return
    headers, samples = log.rows(heads), log.rows(parts)
    headers = headers[np.unique(headers["N"], return_index=True)[1]]
    headers = headers[(headers["mul"] > 0) & (headers["smp_rate"] > 0)]
    samples = samples[np.isin(samples["N"], headers["N"])]
    about = headers[np.searchsorted(headers["N"], samples["N"])]
    for number, instance in product((0, 1), np.unique(about["instance"])):
        own = (about["type"] == number) & (about["instance"] == instance)
        if own.any():
            sensor, unit = _BATCH[number]
            sizes = about["smp_cnt"][own].astype(np.int64) - 32 * samples["seqno"][own].astype(np.int64)
            yield Stream(
                f"ISBD/{sensor}{instance}", int(sizes.clip(0, 32).sum()), ("SampleUS", "x", "y", "z"),
                partial(_unrolled, about[own], samples[own], unit), float(about["smp_rate"][own][0]),
            )  # fmt: skip


def _unrolled(about: Rows, parts: Rows, unit: str) -> FileTable:
    """The samples of batches, of which `parts` are pieces and `about` their headers."""
    order = np.lexsort((parts["seqno"], about["SampleUS"]))
    about, parts = about[order], parts[order]
    place = parts["seqno"].astype(np.int64)[:, np.newaxis] * 32 + np.arange(32)
    used = place < about["smp_cnt"][:, np.newaxis]
    step = 1e9 / about["smp_rate"].astype(np.float64)
    # as integers: the time since the start may have lost its last digits as a float
    stamps = about["SampleUS"].astype(np.int64)[:, np.newaxis] * 1000
    stamps = stamps + np.rint(place * step[:, np.newaxis]).astype(np.int64)
    scale = 1 / about["mul"].astype(np.float64)[:, np.newaxis]
    made = [FileColumn((parts[axis] * scale)[used], i, axis, unit, header=axis) for i, axis in enumerate("xyz", 2)]
    number = np.unique(about["SampleUS"]).size
    note = say("{number} batches of up to {most} samples", number=number, most=int(about["smp_cnt"].max(initial=0)))
    return FileTable((FileColumn(stamps[used], 1, "SampleUS", "ns", header="SampleUS"), *made), notes=(note,))
