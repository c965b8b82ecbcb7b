"""What a Recording says beyond its numbers, as one line of JSON that each format which is written keeps somewhere."""

import json
from dataclasses import replace
from typing import Any

import numpy as np

from allanite.core.errors import AllaniteError
from allanite.core.record import KINDS, Recording
from allanite.core.units import signal_with, unit_of

from .arrays import RATE_NAMES
from .column import Column
from .table import Table

KEY = "allanite"
"""The name under which a format keeps it."""

SOURCE = "the description in the file"


def described(recording: Recording) -> str:
    """Rate, start and what each channel is, in ASCII."""
    channels = [
        {name: getattr(record, name) for name in ("name", "unit", "kind", "scale")}
        | {"integers": record.values.dtype.kind == "i", "history": list(record.history)}
        for record in recording
    ]
    said = {KEY: 1, "type": "Recording", "rate": recording[0].rate, "start": recording[0].start, "channels": channels}
    return json.dumps(said)


def keys(recording: Recording) -> list[str]:
    """A name for each channel that any format takes: ASCII letters, digits and _, none twice."""
    taken = {KEY, *RATE_NAMES}
    result = []
    for record in recording:
        letters = "".join(c if c.isascii() and c.isalnum() else "_" for c in record.name).strip("_")[:24]
        name = letters if letters[:1].isalpha() else f"channel_{letters}".rstrip("_")
        key, again = name, 2
        while key.lower() in taken:
            key, again = f"{name}_{again}", again + 1
        taken.add(key.lower())
        result.append(key)
    return result


def restored(table: Table, text: str | bytes) -> Table:
    """The columns with what a description says of them; one that does not fit them is not used, with a note."""
    if not text:
        return table
    try:
        return _restored(table, json.loads(text))
    except (AllaniteError, ValueError, TypeError, KeyError, OverflowError, RecursionError):
        note = f"{SOURCE} does not fit its columns (were they changed since it was written?) and is not used"
        return replace(table, notes=(*table.notes, note))


def _restored(table: Table, said: dict[str, Any]) -> Table:
    pairs = zip(table.columns, said["channels"], strict=True)
    columns = tuple(_named(column, channel) for column, channel in pairs)
    start = None if said["start"] is None else float(said["start"])
    return replace(table, columns=columns, rate=_positive(said["rate"]), rate_source=SOURCE, start=start)


def _named(column: Column, said: dict[str, Any]) -> Column:
    kind, unit, scale = str(said["kind"]), str(said["unit"]), said["scale"]
    if signal_with(unit_of(unit).dimension, KINDS[kind][0]) is None or column.text:
        raise ValueError(unit)
    return replace(
        column,
        # text has no floats, only numbers: 1.0 is read as an integer
        values=column.values if said["integers"] else column.values.astype(np.float64),
        name=str(said["name"]),
        unit=unit,
        kind=kind,
        scale=None if scale is None else _positive(scale),
        history=tuple(str(line) for line in said["history"]),
    )


def _positive(number: Any) -> float:
    if isinstance(number, bool) or not 0 < number < float("inf"):
        raise ValueError(number)
    return float(number)
