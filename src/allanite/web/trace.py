"""The trace of a channel at any magnification: least and largest sample of stretches, in steps of 16."""

import json
import math
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import stretches
from allanite.core.errors import DataError, UsageError
from allanite.core.files import write
from allanite.core.record import Record, Recording
from allanite.core.units import convert
from allanite.prepare.outliers import outliers
from allanite.reporting.digits import printed_unit

from . import schema

FACTOR = 16  # samples of a stretch, and stretches of the next longer one
MIN_STRETCHES = 1024  # stretches of the coarsest level at least

MAX_SAMPLE_BYTES = 4 * (1 + 2 / (FACTOR - 1))
"""Bytes of a sample in the trace at most: a number of 32 bits, and two of them for each stretch of each level."""

MAX_LISTED = 2000  # gaps and outliers that are listed

MAX_POINTS = 20_000

USUAL, ROOM = (0.02, 0.98), 1.0
"""Shares of the stretches whose extremes are the usual range, and what is shown beyond it, in widths of that."""

Array = NDArray[Any]


def build(folder: Path, recording: Recording, key: str, raw: Sequence[str] = (), *,
          room: float = math.inf) -> float | None:  # fmt: skip
    """Write the trace of a recording, and give the bytes left of `room`; None, and nothing, where they are too few."""
    place = folder / "trace"
    if _meta(place).get("key") == key:
        return room
    room += sum(path.stat().st_size for path in place.glob("*"))
    room -= sum(MAX_SAMPLE_BYTES * record.size for record in recording)
    if room < 0:
        shutil.rmtree(place, ignore_errors=True)
        return None
    draft = folder / "trace.part"
    shutil.rmtree(draft, ignore_errors=True)
    try:
        draft.mkdir(mode=0o700)
        channels = [_write(draft, i, record, raw) for i, record in enumerate(recording)]
        meta = json.dumps({"key": key, "channels": channels}, ensure_ascii=False)
        write(draft / "meta.json", meta.encode("utf-8", "replace"))
    except (OSError, UsageError):
        shutil.rmtree(draft, ignore_errors=True)
        raise
    shutil.rmtree(place, ignore_errors=True)
    draft.rename(place)
    return room


def _write(folder: Path, i: int, record: Record, raw: Sequence[str]) -> dict[str, Any]:
    plain = not {"unit", "kind"}.isdisjoint(raw)
    unit = record.unit if plain else record.signal.sheet[0]
    values = record.rate_values
    values *= convert(1.0, record.signal.si[0], unit)
    finite = np.isfinite(values)
    offset = float(np.median(values[:: max(1, values.size // 1001)][finite[:: max(1, values.size // 1001)]])
                   if finite.any() else 0.0)  # fmt: skip
    low = high = (values - offset).astype(np.float32)
    np.save(folder / f"{i}.0.npy", low)
    levels = 0
    while low.size >= FACTOR * MIN_STRETCHES:
        starts = np.arange(0, low.size, FACTOR)
        low, high = np.fmin.reduceat(low, starts), np.fmax.reduceat(high, starts)
        levels += 1
        np.save(folder / f"{i}.{levels}.npy", np.stack((low, high)))
    gaps = (stretches(~finite) / record.rate).tolist()
    far = outliers(record).at
    return {
        "name": record.name, "rate": record.rate, "size": record.size, "offset": offset,
        "unit": "" if plain else unit, "raw": list(raw),
        "levels": levels, "gaps": gaps[:MAX_LISTED], "gap_count": len(gaps),
        "outliers": (far[:MAX_LISTED] / record.rate).tolist(), "outlier_count": int(far.size),
    }  # fmt: skip


def window(folder: Path, channel: str, start: float | None, end: float | None, points: int) -> dict[str, Any]:
    """The part of a trace between two times, s, as at most so many stretches."""
    meta = _meta(folder / "trace")
    if not meta:
        raise UsageError(
            "there is no trace of this file: it was not read yet, or only in parts, or the quota has no room for it"
        )
    names = [stored["name"] for stored in meta["channels"]]
    if channel and channel not in names:
        raise UsageError(f"no channel {channel!r}; channels: {', '.join(names)}")
    i = names.index(channel) if channel else 0
    stored, points = meta["channels"][i], min(max(points, 2), MAX_POINTS)
    most = stored["size"]
    first = int(min(max(0.0, (start or 0.0) * stored["rate"]), most - 1))
    last = int(np.ceil(most if end is None else min(max(first + 1, end * stored["rate"]), most)))
    level = 0
    while level < stored["levels"] and (last - first) >= points * FACTOR ** (level + 1):
        level += 1
    try:
        times, low, high = _part(folder / "trace" / f"{i}.{level}.npy", (first, last, FACTOR**level), points)
    except Exception as error:  # whatever the reader of arrays says of a header that is damaged
        shutil.rmtree(folder / "trace", ignore_errors=True)
        raise DataError(f"the trace of the file is damaged ({error}): analyze the file again") from None
    return {
        "channel": stored["name"], "channels": names, "unit": printed_unit(stored["unit"]), "rate": stored["rate"],
        "duration": stored["size"] / stored["rate"], "t": (times / stored["rate"]).tolist(),
        "low": _listed(low + stored["offset"]), "high": _listed(high + stored["offset"]), "raw": stored["raw"],
        "range": _range(low + stored["offset"], high + stored["offset"]),
        "gaps": [gap for gap in stored["gaps"] if gap[1] > first / stored["rate"] and gap[0] < last / stored["rate"]],
        "outliers": [at for at in stored["outliers"] if first / stored["rate"] <= at < last / stored["rate"]],
        "gap_count": stored["gap_count"], "outlier_count": stored["outlier_count"],
    }  # fmt: skip


def _part(path: Path, where: tuple[int, int, int], points: int) -> tuple[Array, Array, Array]:
    """Times in samples, least and largest values of stretches."""
    first, last, size = where
    stored = np.load(path, mmap_mode="r")
    begin, end = first // size, -(-last // size)
    low, high = (stored[0], stored[1]) if stored.ndim == 2 else (stored, stored)
    low, high = (np.asarray(part[begin:end], dtype=np.float64) for part in (low, high))
    if low.size <= points:
        return (begin + np.arange(low.size) + (0.5 if size > 1 else 0.0)) * size, low, high
    starts = np.linspace(0, low.size, points, endpoint=False).astype(np.int64)
    middle = (starts + np.append(starts[1:], low.size)) / 2
    return (begin + middle) * size, np.fmin.reduceat(low, starts), np.fmax.reduceat(high, starts)


def _range(low: Array, high: Array) -> list[float] | None:
    """What is shown where a few stretches reach so far that the others would be a line; None if all are shown."""
    if not np.isfinite(low).any():
        return None
    bottom, top = float(np.nanquantile(low, USUAL[0])), float(np.nanquantile(high, USUAL[1]))
    room = ROOM * (top - bottom)
    inside = np.nanmin(low) >= bottom - room and np.nanmax(high) <= top + room
    return None if inside or not room else [bottom - room / 4, top + room / 4]


def _listed(values: Array) -> list[float | None]:
    return [float(f"{v:.9g}") if math.isfinite(v) else None for v in values.tolist()]


def _meta(place: Path) -> dict[str, Any]:
    meta: dict[str, Any] | None = schema.kept(place / "meta.json", schema.Trace)
    return meta or {}
