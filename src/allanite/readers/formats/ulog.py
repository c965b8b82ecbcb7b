"""PX4 flight logs: the gyroscopes and accelerometers of the topics of a ULog file.

Source of the topics: PX4 Guide, uORB Message Reference (PX4 development team, v1.15).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.record import Recording
from allanite.phrases.phrase import Phrase, say, say_count
from allanite.readers.columns.column import FileColumn, column, some
from allanite.readers.columns.containers import Stream, mean_rate, stream_recording
from allanite.readers.columns.table import FileTable
from allanite.readers.options import Options
from allanite.readers.sandbox.process import Process, demand_size, worded

TITLE = "PX4 flight log .ulg (needs pyulog)"

_XYZ, _THREE = ("x", "y", "z"), ("[0]", "[1]", "[2]")
_STAMPS = ("timestamp_sample", "timestamp")
_WHOLE = 0.02
"""Relative difference between integration time and time step up to which integrals are those of the whole step."""

Rows = NDArray[Any]


@dataclass(frozen=True)
class _Signal:
    """Fields of a topic that are a sensor's: common stem, endings, unit, and the field of the integration time."""

    stem: str
    ends: tuple[str, ...]
    unit: str
    over: str = ""
    increment: bool = False  # they are integrals over that time, otherwise means over it


_TOPICS: Mapping[str, tuple[_Signal, ...]] = {
    "sensor_gyro": (_Signal("", _XYZ, "rad/s"),),
    "sensor_accel": (_Signal("", _XYZ, "m/s^2"),),
    "sensor_combined": (
        _Signal("gyro_rad", _THREE, "rad/s", "gyro_integral_dt"),
        _Signal("accelerometer_m_s2", _THREE, "m/s^2", "accelerometer_integral_dt"),
    ),
    "vehicle_imu": (
        _Signal("delta_angle", _THREE, "rad", "delta_angle_dt", increment=True),
        _Signal("delta_velocity", _THREE, "m/s", "delta_velocity_dt", increment=True),
    ),
}
_BATCHES: Mapping[str, str] = {"sensor_gyro_fifo": "rad/s", "sensor_accel_fifo": "m/s^2"}
"""Topics with several samples in a message, and the unit of their scale factor."""


def read(path: str, options: Options) -> Recording:
    """The channels of a topic of a PX4 log; with several instances of a topic, each is ``topic/0``, ``topic/1``."""
    with Process("ulog", path, options.progress) as process:
        with worded():
            streams = [_topic(item, process) for item in process.contents["datasets"]]
            # what the log says about its own losses
            drops = [float(milliseconds) for milliseconds in process.contents["dropouts"]]
            lost = say_count(len(drops),
                             "the log reports a dropout of its writer, of {total:.4g} s",
                             "the log reports {count} dropouts of its writer, of {total:.4g} s in all",
                             total=sum(drops) / 1e3)  # fmt: skip
            damaged = say("the log is damaged in places; the messages there are left out")
            notes = [note for note, holds in ((lost, drops), (damaged, process.contents["damaged"])) if holds]
        return stream_recording(streams, options, notes)


def _topic(item: Mapping[str, Any], process: Process) -> Stream:
    name, count = str(item["path"]), int(item["shape"][0])
    kinds = {str(field): np.dtype(str(kind)) for field, kind, _ in item["fields"]}
    topic, batches = name.rpartition("/")[0], "samples" in kinds and "scale" in kinds
    build = _batched if batches and topic in _BATCHES else _plain

    def fetch(fields: list[str]) -> Rows:
        dtype = np.dtype([(field, kinds[field]) for field in fields])
        demand_size(count * dtype.itemsize, process.path, f"topic {name!r}")
        return process.load(name, (count,), dtype)

    span = float(item["span"]) * 1e-6
    rate, fits = mean_rate(count, span), topic in _TOPICS or topic in _BATCHES
    return Stream(name, count, tuple(kinds), lambda: build(topic, list(kinds), fetch), rate, fits)


def _plain(topic: str, fields: list[str], fetch: Callable[[list[str]], Rows]) -> FileTable:
    """The table of a topic with one sample in a message; of an unknown topic all its numbers."""
    signals = _TOPICS.get(topic, ())
    stamps = [field for field in _STAMPS if field in fields]
    units = {f"{signal.stem}{end}": signal.unit for signal in signals for end in signal.ends}
    beside = [signal.over for signal in signals if signal.over in fields]
    kept = [field for field in fields if field in units or field == "temperature" or not signals]
    used = [*stamps, *(field for field in kept if field not in stamps)]
    rows = fetch([*used, *beside])
    units |= dict.fromkeys(stamps, "us") | {"temperature": "degC"}
    columns = {field: column(field, rows[field], fields.index(field) + 1, unit=units.get(field, "")) for field in used}
    notes = list[Phrase]()
    for signal in signals:
        if signal.over in fields:
            integrated, remarks = _integrated(signal, columns, rows)
            columns, notes = columns | integrated, notes + remarks
    unused = [field for field in fields if field not in (*columns, *beside)]
    notes += [say("left out, not used of the table: {fields}", fields=some(unused))] if unused else []
    return FileTable(tuple(columns.values()), notes=tuple(notes))


def _integrated(
    signal: _Signal, columns: Mapping[str, FileColumn], rows: Rows
) -> tuple[dict[str, FileColumn], list[Phrase]]:
    """The columns of a signal that is integrated over a part of the time step, or all of it, and notes on that."""
    stamps = rows[next(field for field in _STAMPS if field in columns)].astype(np.int64)
    over = rows[signal.over].astype(np.float64)
    step = float(np.median(np.diff(stamps))) if stamps.size > 1 else 0.0
    usual = float(np.median(over)) if over.size else 0.0
    share = usual / step if step > 0 else 0.0
    own = {name: made for name, made in columns.items() if name.startswith(signal.stem)}
    notes = []
    if abs(share - 1) > _WHOLE:
        notes.append(say(
            "{stem} covers {over:.4g} ms of the {step:.4g} ms between messages: what the sensor did in the rest of "
            "the time is not in the log",
            stem=signal.stem, over=usual / 1e3, step=step / 1e3,
        ))  # fmt: skip
    if not signal.increment:
        return own, notes
    if not notes:
        return {name: replace(made, kind="increment") for name, made in own.items()}, []
    with np.errstate(all="ignore"):
        seconds = np.where(over > 0, over * 1e-6, np.nan)
        mean = {
            name: replace(made, values=made.values / seconds, unit=f"{signal.unit}/s", kind="rate")
            for name, made in own.items()
        }
    return mean, [*notes, say("{stem} is divided by {over}", stem=signal.stem, over=signal.over)]


def _batched(topic: str, fields: list[str], fetch: Callable[[list[str]], Rows]) -> FileTable:
    """The table of a topic with a batch of samples in a message, the last of them at its time stamp."""
    axes = [[field for field in fields if field.startswith(f"{axis}[")] for axis in _XYZ]
    stamp = next(field for field in _STAMPS if field in fields)
    rows = fetch([stamp, "dt", "scale", "samples", *(field for axis in axes for field in axis)])
    most = min(len(axis) for axis in axes)
    count = np.clip(rows["samples"].astype(np.int64), 0, most)
    used = np.arange(most) < count[:, np.newaxis]
    # steps in ns, as integers: the time since the start of the computer may have lost its last digits as a float
    step = np.rint(np.nan_to_num(rows["dt"].astype(np.float64), nan=0, posinf=0, neginf=0) * 1e3).clip(0, 1e12)
    back = (count[:, np.newaxis] - 1 - np.arange(most)) * step[:, np.newaxis].astype(np.int64)
    stamps = (rows[stamp].astype(np.int64)[:, np.newaxis] * 1000 - back)[used]
    columns = [FileColumn(stamps, 1, stamp, "ns", header=stamp)]
    for place, (axis, names) in enumerate(zip(_XYZ, axes, strict=True), 2):
        counts = np.column_stack([rows[name] for name in names[:most]]).astype(np.float64)
        values = (counts * rows["scale"].astype(np.float64)[:, np.newaxis])[used]
        columns.append(FileColumn(values, place, axis, _BATCHES[topic], header=axis))
    batches = say("{number} messages with up to {most} samples each", number=len(rows), most=int(count.max(initial=0)))
    return FileTable(tuple(columns), notes=(batches,))
