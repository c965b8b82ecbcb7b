"""Sentences like those of NMEA 0183, ``$VNYMR,...*6B``: one per sample, each with a checksum that is verified.

Source of the names and units: VN-100 User Manual (VectorNav, firmware 2.1), section 5.
"""

import binascii
import re
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import islice
from pathlib import Path

import numpy as np

from allanite.core.errors import DataError
from allanite.core.record import Recording
from allanite.phrases.phrase import Phrase, say, say_count
from allanite.readers.columns import parse
from allanite.readers.columns.containers import Stream, any_inertial, stream_recording
from allanite.readers.columns.layout import Layout, is_number
from allanite.readers.columns.table import FileTable
from allanite.readers.options import Options
from allanite.readers.sandbox.process import worded

from . import text

TITLE = "sentences with checksums: $VNYMR and others of VectorNav"

_SENTENCE = re.compile(rb"([^$]*)\$([A-Z]{4,6}),([^*$]*)\*([0-9A-Fa-f]{4}|[0-9A-Fa-f]{2}|XX)\s*")


def _three(name: str, unit: str) -> tuple[str, ...]:
    return tuple(f"{name}_{axis} [{unit}]" for axis in "xyz")


_ANGLES, _QUATERNION = ("yaw [deg]", "pitch [deg]", "roll [deg]"), ("q0", "q1", "q2", "q3")
_MAG, _ACC, _GYRO = _three("mag", "gauss"), _three("acc", "m/s^2"), _three("gyro", "rad/s")
_FIELDS: dict[str, tuple[str, ...]] = {
    "VNGYR": _GYRO,
    "VNACC": _ACC,
    "VNMAR": (*_MAG, *_ACC, *_GYRO),
    "VNYMR": (*_ANGLES, *_MAG, *_ACC, *_GYRO),
    "VNQMR": (*_QUATERNION, *_MAG, *_ACC, *_GYRO),
    "VNYBA": (*_ANGLES, *_ACC, *_GYRO),
    "VNIMU": (*_MAG, *_ACC, *_GYRO, "temperature [degC]", "pressure [kPa]"),
    "VNDTV": ("step", *_three("delta_theta", "deg"), *_three("delta_velocity", "m/s")),
}
"""Fields of the sentences that hold inertial signals."""


@dataclass
class _Kind:
    """The sentences of one name: what precedes each in its line, and its fields; None for a damaged one."""

    before: list[str] = field(default_factory=list)
    fields: list[str | None] = field(default_factory=list)


def sniff(head: bytes, suffix: str) -> bool:
    """Whether one of the first lines that are no comments is a sentence with a checksum."""
    lines = (line.strip() for line in head[:4096].splitlines())
    first = islice((line for line in lines if line and not line.startswith((b"#", b"%"))), 3)
    return any(line.find(b"$") < 60 and _SENTENCE.fullmatch(line) for line in first)


def read(path: str, options: Options) -> Recording:
    """The channels of the sentences of one name; those with a wrong checksum are gaps."""
    with worded():
        kinds, bad = _sorted(Path(path).read_bytes())
        streams = list[Stream]()
        for name, kind in kinds.items():
            right = [fields for fields in kind.fields if fields is not None]
            widths = [fields.count(",") + 1 for fields in right]
            width = int(np.bincount(widths).argmax()) if max(widths) < 1000 else max(widths)
            names = _FIELDS.get(name, ())
            names = names if len(names) == width else ("",) * width
            load, fits = partial(_table, name, kind, names), any_inertial(names)
            if len(kind.fields) > 1:
                streams.append(Stream(name, len(right), names, load, likely=fits))
    if not streams:
        raise DataError(say("no sentence has a valid checksum; {count} are damaged", count=bad))
    note = say_count(bad, "{count} sentence has a wrong checksum or is incomplete, and is left out",
                     "{count} sentences have a wrong checksum or are incomplete, and are left out")  # fmt: skip
    return stream_recording(streams, options, [note] if bad else [])


def _sorted(data: bytes) -> tuple[dict[str, _Kind], int]:
    """The sentences by name, and the number of damaged ones; a damaged one whose name is lost belongs to the last."""
    kinds, bad = dict[str, _Kind](), 0
    last: _Kind | None = None
    before, fields = "", None
    for line in data.splitlines():
        at = line.find(b"$")
        if at < 0:
            continue
        sentence = _SENTENCE.fullmatch(line)
        if sentence is None or not _right(line[at + 1 : line.rfind(b"*")], sentence[4]):
            before, fields, bad = "", None, bad + 1
            last = kinds.get(line[at + 1 : at + 6].decode("latin-1"), last)
        else:
            before, fields = sentence[1].decode("latin-1").strip(" ,;\t"), sentence[3].decode("latin-1")
            last = kinds.setdefault(sentence[2].decode(), _Kind())
        if last is not None:
            last.before.append(before)
            last.fields.append(fields)
    for kind in kinds.values():  # the logger was stopped within a sentence
        while kind.fields[-1] is None:
            kind.fields.pop()
            kind.before.pop()
    return kinds, bad


def _right(body: bytes, checksum: bytes) -> bool:
    """Whether the exclusive or of the bytes, or their 16-bit CRC, is the checksum; XX means that there is none."""
    if checksum == b"XX":
        return True
    if len(checksum) == 4:
        return binascii.crc_hqx(body, 0) == int(checksum, 16)
    folded, bits = int.from_bytes(body, "big"), 8
    while bits < 8 * len(body):
        bits *= 2
    while bits > 8:
        bits //= 2
        folded ^= folded >> bits
        folded &= (1 << bits) - 1
    return folded == int(checksum, 16)


def _table(name: str, kind: _Kind, names: tuple[str, ...]) -> FileTable:
    """The fields as columns, after the time stamps if the logger wrote any before the sentences."""
    right = [fields is not None and fields.count(",") + 1 == len(names) for fields in kind.fields]
    stamped = all(before for before, fine in zip(kind.before, right, strict=True) if fine)
    notes = list[Phrase]()
    if stamped:  # which shows what is missing
        stamps = [before for before, fine in zip(kind.before, right, strict=True) if fine]
        fields = [fields for fields, fine in zip(kind.fields, right, strict=True) if fine]
        rows = [f"{before.replace(',', ' ')},{each}" for before, each in zip(stamps, fields, strict=True)]
        heads, words = ("time", *names), frozenset(() if is_number(stamps[0]) else (0,))
    else:
        gap, other = "," * (len(names) - 1), right.count(False)
        rows = [fields or "" if fine else gap for fields, fine in zip(kind.fields, right, strict=True)]
        heads, words = names, frozenset[int]()
        gaps = say("{number} damaged sentences of {name} are gaps of one sample each", number=other, name=name)
        notes += [gaps] if other else []
    layout = Layout(",", ".", heads, ("",) * len(heads), words, 0, 1)
    values, _ = parse.columns(("\n".join(rows) + "\n").encode(), layout)
    columns, _, joined = text.of_parsed(values, heads, layout.units)
    made = (replace(c, kind="increment") if c.name.startswith("delta_") else c for c in columns)
    return FileTable(tuple(made), notes=(*notes, *joined))
