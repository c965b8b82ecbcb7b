"""ArduPilot dataflash logs: the gyroscopes and accelerometers of IMU, GYR and ACC messages and of batches.

Binary logs, and logs that Mission Planner has written as text.
"""

import re
from collections.abc import Iterator
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np

from allanite.core.record import Recording
from allanite.phrases.phrase import say
from allanite.readers.columns import streams
from allanite.readers.columns.arrays import column
from allanite.readers.columns.column import FileColumn, some
from allanite.readers.columns.table import FileTable
from allanite.readers.options import Options
from allanite.readers.sandbox.guard import worded
from allanite.readers.sandbox.source import head_of

from .dataflash_log import BinaryLog, Kind, Log, Rows, TextLog, Units, named, units

TITLE = "ArduPilot dataflash log .bin, or .log as text"

_MAGIC = b"\xa3\x95\x80"
_TEXT = re.compile(rb"^FMT, *128, *\d+, *FMT,", re.MULTILINE)
_UNITS = {"TimeUS": "us", "SampleUS": "us", "TimeMS": "ms", "T": "degC"}
_UNITS |= {f"{sensor}{axis}": unit for sensor, unit in (("Gyr", "rad/s"), ("Acc", "m/s^2")) for axis in "XYZ"}
"""Units of fields of which the log does not say any."""

_BATCH = (("accel", "m/s^2"), ("gyro", "rad/s"))
"""Names and units of the sensors of batches, by their number there."""


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
        said = units(log)
        found = [stream for kind in log.kinds for stream in _streams(log, kind, said.get(kind.number, {}))]
    return streams.recording([*_batches(log), *found], options, log.notes)


def _streams(log: Log, kind: Kind, said: Units) -> Iterator[streams.Stream]:
    """A stream for each instance of a kind of message."""
    names = tuple(kind.dtype.names or ())
    if not _inertial(names):
        if not kind.name.startswith("ISB") and names:
            yield streams.Stream(kind.name, kind.count, names, lambda: _table(kind, log.rows(kind), said), fits=False)
        return
    rows = log.rows(kind)
    instances = np.unique(rows["I"]) if "I" in names else [None]
    lost = kind.count - rows.size
    for instance in instances:
        own = rows if instance is None else rows[rows["I"] == instance]
        name = kind.name if instance is None else f"{kind.name}/{instance}"
        stamp = next((field for field in ("TimeUS", "SampleUS", "TimeMS") if field in names), None)
        span = 0 if stamp is None or not own.size else int(own[stamp][-1]) - int(own[stamp][0])
        rate = streams.mean_rate(own.size, span * (1e-3 if stamp == "TimeMS" else 1e-6))
        yield streams.Stream(name, own.size, names, partial(_table, kind, own, said, lost), rate)


def _inertial(names: tuple[str, ...]) -> bool:
    return any(_UNITS.get(name, "") in ("rad/s", "m/s^2") for name in names)


def _table(kind: Kind, rows: Rows, said: Units, lost: int = 0) -> FileTable:
    """The numbers of messages; of those with inertial sensors only these, time stamps and temperature."""
    names = tuple(rows.dtype.names or ())
    known = _inertial(names)
    kept = [name for name in names if rows.dtype[name].kind in "iuf" and (name in _UNITS or not known)]
    left = [name for name in names if name not in kept]
    notes = []
    if lost:
        notes.append(say("the log is damaged: {count} lines of {name} cannot be read", count=lost, name=kind.name))
    if said.keys() & kept:
        notes.append(say("units by the definitions in the log"))
    if left:
        notes.append(say("left out, not used of the table: {fields}", fields=some(left)))
    made = []
    for name in kept:
        unit, factor = said.get(name, (_UNITS.get(name, ""), 1.0))
        values = rows[name] if factor == 1 else rows[name].astype(np.float64) * factor
        made.append(column(name, values, names.index(name) + 1, unit=unit))
    return FileTable(tuple(made), notes=tuple(notes))


def _batches(log: Log) -> Iterator[streams.Stream]:
    """A stream for each sensor that was sampled in batches."""
    heads, parts = named(log, "ISBH"), named(log, "ISBD")
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


def _unrolled(about: Rows, parts: Rows, unit: str) -> FileTable:
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
    made = [FileColumn((parts[axis] * scale)[used], i, axis, unit, header=axis) for i, axis in enumerate("xyz", 2)]
    number = np.unique(about["SampleUS"]).size
    note = say("{number} batches of up to {most} samples", number=number, most=int(about["smp_cnt"].max(initial=0)))
    return FileTable((FileColumn(stamps[used], 1, "SampleUS", "ns", header="SampleUS"), *made), notes=(note,))
