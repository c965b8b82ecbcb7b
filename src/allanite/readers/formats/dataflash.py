"""ArduPilot dataflash logs: the gyroscopes and accelerometers of IMU, GYR and ACC messages and of batches.

Source of the format: ArduPilot, libraries/AP_Logger/LogStructure.h and README.md (ArduPilot team, version 4.5).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import product

import numpy as np
from numpy.typing import NDArray

from allanite.core.language import Phrase, say
from allanite.core.record import Recording
from allanite.readers.columns import streams
from allanite.readers.columns.arrays import column
from allanite.readers.columns.column import Column, some
from allanite.readers.columns.table import Table
from allanite.readers.options import Options
from allanite.readers.sandbox.guard import worded

TITLE = "ArduPilot dataflash log .bin"

_MAGIC = b"\xa3\x95\x80"
_DEFINITION = 128
_FIELDS = {
    "b": "i1", "B": "u1", "M": "u1", "h": "<i2", "H": "<u2", "c": "<i2", "C": "<u2", "i": "<i4", "I": "<u4",
    "e": "<i4", "E": "<u4", "L": "<i4", "g": "<f2", "f": "<f4", "d": "<f8", "q": "<i8", "Q": "<u8",
    "n": "S4", "N": "S16", "Z": "S64", "a": "32<i2",
}  # fmt: skip
"""Letters of the format of a message: the type of the field."""

_DEFINED = np.dtype([("type", "u1"), ("length", "u1"), ("name", "S4"), ("format", "S16"), ("columns", "S64")])
_UNITS = {"TimeUS": "us", "SampleUS": "us", "TimeMS": "ms", "T": "degC"}
_UNITS |= {f"{sensor}{axis}": unit for sensor, unit in (("Gyr", "rad/s"), ("Acc", "m/s^2")) for axis in "XYZ"}
_BATCH = (("accel", "m/s^2"), ("gyro", "rad/s"))
"""Names and units of the sensors of batches, by their number there."""

Rows = NDArray[np.void]


def sniff(head: bytes, suffix: str) -> bool:
    """Whether the file begins with the definition of a message."""
    return head.startswith(_MAGIC)


def read(path: str, options: Options) -> Recording:
    """The channels of one kind of message; of several instances each is ``IMU/0``, ``IMU/1``."""
    log = Log(np.asarray(np.memmap(path, np.uint8, mode="r")))
    with worded():
        found = [stream for kind in log.kinds for stream in _streams(log, kind)]
    return streams.recording([*_batches(log), *found], options, log.notes)


@dataclass(frozen=True)
class Kind:
    """A kind of message: its number, name, the type of its contents, and how many there are."""

    number: int
    name: str
    dtype: np.dtype[np.void]
    count: int


@dataclass(frozen=True, eq=False)
class Log:
    """The messages of a log, of which `data`, shape (n,), are the bytes."""

    data: NDArray[np.uint8]

    @cached_property
    def _walked(self) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
        """Lengths and numbers of messages of all kinds, and the bytes of none."""
        from allanite.kernels.messages import counted

        lengths = np.zeros(256, np.int64)
        lengths[_DEFINITION] = 3 + _DEFINED.itemsize
        counts, lost = counted(self.data, lengths)
        return lengths, counts, int(lost)

    @cached_property
    def kinds(self) -> list[Kind]:
        """The kinds of messages in the log whose fields can be read."""
        lengths, counts, _ = self._walked
        made = dict[int, Kind]()
        for row in self.rows(Kind(_DEFINITION, "FMT", _DEFINED, int(counts[_DEFINITION]))):
            number, dtype = int(row["type"]), _contents(row)
            if number not in made and counts[number] and dtype.itemsize + 3 == lengths[number]:
                made[number] = Kind(number, _word(row["name"]), dtype, int(counts[number]))
        return [kind for kind in made.values() if kind.number != _DEFINITION]

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

    def named(self, name: str) -> Kind | None:
        """The kind of this name."""
        return next((kind for kind in self.kinds if kind.name == name), None)


def _word(raw: bytes) -> str:
    return raw.split(b"\0")[0].decode("latin-1")


def _contents(row: np.void) -> np.dtype[np.void]:
    """The type of the contents of a defined message; empty if it has fields of unknown types or names."""
    letters, names = _word(row["format"]), _word(row["columns"]).split(",")
    known = len(letters) == len(names) == len(set(names)) and all(letter in _FIELDS for letter in letters)
    fields = zip(names, letters, strict=True) if known and all(names) else ()
    return np.dtype([(name, _FIELDS[letter]) for name, letter in fields])


def _streams(log: Log, kind: Kind) -> Iterator[streams.Stream]:
    """A stream for each instance of a kind of message."""
    names = tuple(kind.dtype.names or ())
    fits = any(_UNITS.get(name, "") in ("rad/s", "m/s^2") for name in names)
    if not fits:
        if not kind.name.startswith("ISB") and names:
            yield streams.Stream(kind.name, kind.count, names, lambda: _table(log.rows(kind)), None, fits=False)
        return
    rows = log.rows(kind)
    instances = np.unique(rows["I"]) if "I" in names else [None]
    for instance in instances:
        own = rows if instance is None else rows[rows["I"] == instance]
        name = kind.name if instance is None else f"{kind.name}/{instance}"
        yield streams.Stream(name, own.size, names, partial(_table, own), _rate(own))


def _rate(rows: Rows) -> float | None:
    """Mean rate of messages in Hz."""
    stamp = next((name for name in ("TimeUS", "SampleUS", "TimeMS") if name in (rows.dtype.names or ())), None)
    span = 0 if stamp is None or not rows.size else int(rows[stamp][-1]) - int(rows[stamp][0])
    return streams.mean_rate(rows.size, span * (1e-3 if stamp == "TimeMS" else 1e-6))


def _table(rows: Rows) -> Table:
    """The numbers of messages; of those with inertial sensors only these, time stamps and temperature."""
    names = tuple(rows.dtype.names or ())
    known = any(_UNITS.get(name, "") in ("rad/s", "m/s^2") for name in names)
    kept = [name for name in names if rows.dtype[name].kind in "iuf" and (name in _UNITS or not known)]
    left = [name for name in names if name not in kept]
    note = (say("left out, not used of the table: {fields}", fields=some(left)),) if left else ()
    made = (column(name, rows[name], names.index(name) + 1, unit=_UNITS.get(name, "")) for name in kept)
    return Table(tuple(made), notes=note)


def _batches(log: Log) -> Iterator[streams.Stream]:
    """A stream for each sensor that was sampled in batches."""
    heads, parts = log.named("ISBH"), log.named("ISBD")
    needed = {"N", "type", "instance", "mul", "smp_cnt", "SampleUS", "smp_rate"}
    if heads is None or parts is None or not needed <= set(heads.dtype.names or ()):
        return
    if not {"N", "seqno", "x", "y", "z"} <= set(parts.dtype.names or ()):
        return
    said, samples = log.rows(heads), log.rows(parts)
    said = said[np.unique(said["N"], return_index=True)[1]]
    said = said[(said["mul"] > 0) & (said["smp_rate"] > 0)]
    samples = samples[np.isin(samples["N"], said["N"])]
    about = said[np.searchsorted(said["N"], samples["N"])]
    for number, instance in product((0, 1), np.unique(about["instance"])):
        own = (about["type"] == number) & (about["instance"] == instance)
        if own.any():
            sensor, unit = _BATCH[number]
            sizes = about["smp_cnt"][own].astype(np.int64) - 32 * samples["seqno"][own].astype(np.int64)
            yield streams.Stream(
                f"ISBD/{sensor}{instance}",
                int(sizes.clip(0, 32).sum()),
                ("SampleUS", "x", "y", "z"),
                partial(_unrolled, about[own], samples[own], unit),
                float(about["smp_rate"][own][0]),
            )


def _unrolled(about: Rows, parts: Rows, unit: str) -> Table:
    """The samples of batches, of which `parts` are pieces and `about` their headers."""
    order = np.lexsort((parts["seqno"], about["SampleUS"]))
    about, parts = about[order], parts[order]
    place = parts["seqno"].astype(np.int64)[:, np.newaxis] * 32 + np.arange(32)
    used = place < about["smp_cnt"][:, np.newaxis]
    step = 1e9 / about["smp_rate"].astype(np.float64)
    # as integers: the time since the start may have lost its last digits as a float
    stamps = about["SampleUS"].astype(np.int64)[:, np.newaxis] * 1000 + np.rint(place * step[:, np.newaxis]).astype(
        np.int64
    )
    scale = 1 / about["mul"].astype(np.float64)[:, np.newaxis]
    made = [Column((parts[axis] * scale)[used], i, axis, unit, header=axis) for i, axis in enumerate("xyz", 2)]
    number = np.unique(about["SampleUS"]).size
    note = say("{number} batches of up to {most} samples", number=number, most=int(about["smp_cnt"].max(initial=0)))
    return Table((Column(stamps[used], 1, "SampleUS", "ns", header="SampleUS"), *made), notes=(note,))
