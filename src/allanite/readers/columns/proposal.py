"""What to type where a file does not say what its columns are: what their numbers show, or a placeholder."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from allanite.core.errors import COLUMN, RATE, SCALE, UNIT
from allanite.core.units import unit_of
from allanite.phrases.phrase import say, spelled
from allanite.readers.clock.clocks import ClockSources, addressed, likely_unit, readings

from . import headers
from .column import FileColumn

RATES: tuple[str, ...] = ("g", "m/s^2", "mg", "mm/s^2")
INCREMENTS: tuple[str, ...] = ("g*s", "m/s")  # units in which loggers write accelerations, and velocity increments
COUNTS = (1024, 8192)  # counts per g of common sensors that are near a thousand mg or 9810 mm/s^2

NAMED = 0.25
"""Share by which accelerometers at rest may miss gravity, by their offsets and scale factors: units are ten apart."""

UNNAMED = 0.05  # the same for columns that nothing but their length makes accelerometers


SHOWN = 16  # columns of an overview
SLOW = 0.1  # share of the standard deviation below which steps are those of a slow quantity


class Proposal(NamedTuple):
    """Words to type, why, and the rate in Hz that follows from them, 0 if none does."""

    words: str
    why: tuple[str, ...] = ()
    rate: float = 0.0


def clock(columns: Sequence[FileColumn], sources: ClockSources) -> Proposal:
    """Words about the sampling rate: of the time stamps, or the first of columns that rise as stamps do."""
    column = sources.stamps or next((column for column in columns if not _counts_rows(column)), None)
    rates = {} if column is None else dict(readings(column.values))
    if column is None or not rates:
        return Proposal(spelled(f"--rate {RATE}", "rate=..."))
    address, unit = addressed(column), likely_unit(column)
    words = spelled(f"--time '{address}'", f"time='{address}'")
    if not unit or sources.stamps:
        return Proposal(words, rate=rates.get(unit, 0.0))
    why = say(
        "{column} rises as a clock of {rate:.6g} Hz in {unit} does", column=column.label, rate=rates[unit], unit=unit
    )
    return Proposal(words, (why,), rates[unit])


def _counts_rows(column: FileColumn) -> bool:
    return column.values.dtype.kind == "i" and float(np.median(np.diff(column.values[:1000]))) == 1


def units(columns: Sequence[FileColumn], rate: float) -> Proposal:
    """Words about columns without a unit, at a rate in Hz, 0 if it is unknown."""
    of: dict[str, list[FileColumn]] = {}
    for column in columns:
        of.setdefault(headers.sensor_by_name(column.name), []).append(column)
    raw = [[column for column in members if headers.is_raw(column.header)] for members in of.values()]
    first = next(filter(None, raw), [])
    if first:  # one scale is that of one sensor
        names = ",".join(str(column.position) for column in first)
        chosen = spelled(f"--channels {names} ", f"channels='{names}', ") if len(first) < len(columns) else ""
        return Proposal(chosen + spelled(f"--scale {SCALE}", f"scale={SCALE!r}"))
    sensors = [column for name, members in of.items() if name for column in members]
    if not sensors:
        return _unnamed(columns)
    summed = all(headers.is_increment(column.name) for column in sensors)
    known, times = (INCREMENTS, rate) if summed else (RATES, 1.0)
    unit, why = _weighed(of.get("accelerometer", []), known, times, NAMED)
    # MicroStrain names increments like this, and writes them in rad and g*s
    theta = unit == "g*s" and all("theta" in column.name.lower() for column in of.get("gyro", ()))
    theirs = {"gyro": "rad" if theta else UNIT, "accelerometer": unit or UNIT}
    keys = {"gyro": "gyro", "accelerometer": "accel"}
    stated = ",".join(f"{keys[name]}={theirs[name]}" for name in keys if name in of)
    return _stated(stated if len(of) > 1 else theirs[next(iter(of))], why, kind="increment" if summed else "")


def _unnamed(columns: Sequence[FileColumn]) -> Proposal:
    """Words about columns without names of sensors, of which each three may be the axes of one."""
    weighed = [(three, *_weighed(three, RATES, 1.0, UNNAMED)) for three in _threes(columns)]
    heavy = [row for row in weighed if row[1]]
    if len(heavy) != 1:
        return _stated(UNIT)
    three, unit, why = heavy[0]
    if len(columns) == 3:
        return _stated(unit, why)
    rest = [column for column in columns if column not in three]
    others = [f"{column.position}={UNIT}" for column in rest] if len(rest) <= 3 else [f"{COLUMN}={UNIT}"]
    return _stated(",".join([*(f"{column.position}={unit}" for column in three), *others]), why)


def _threes(columns: Sequence[FileColumn]) -> list[list[FileColumn]]:
    """Each three columns that may be the axes of a sensor: also at rest none of them is constant."""
    noisy = [column for column in columns if (column.values != column.values[:1]).any()]
    return [noisy[i : i + 3] for i in range(0, len(noisy), 3)]


def overview(columns: Sequence[FileColumn], unsaid: Sequence[FileColumn], rising: Sequence[FileColumn]) -> str:
    """A line for each column: its mean, its standard deviation, and what its numbers look like."""
    likely = {column.position: _paced(column) for column in rising}
    for three in _threes(unsaid):
        unit = _weighed(three, RATES, 1.0, UNNAMED)[0]
        likely |= {c.position: f"gravity in {unit}" for c in three if unit}
    head = "column", "mean", "std", "looks like"
    lines = [("", *head), *(("", c.name, *_sized(c, likely.get(c.position, ""))) for c in columns[:SHOWN])]
    return "".join("\n{:2}{:<16}{:>11}  {:>10}  {}".format(*line).rstrip() for line in lines)


def _paced(column: FileColumn) -> str:
    rate = dict(readings(column.values)).get(unit := likely_unit(column))
    return f"a clock of {rate:.6g} Hz in {unit}" if rate else "a clock or a counter"


def _sized(column: FileColumn, likely: str) -> tuple[str, str, str]:
    with np.errstate(all="ignore"):
        values = np.asarray(column.values, dtype=np.float64)
        mean, spread, step = float(np.mean(values)), float(np.std(values)), float(np.std(np.diff(values)))
    slow = "slow, such as a temperature" if step < SLOW * spread else ""
    return f"{mean:.4g}", f"{spread:.3g}", likely or (slow if spread else "constant")


def _stated(unit: str, why: str = "", *, kind: str = "") -> Proposal:
    words = spelled("--unit ", "unit=") + f"'{unit}'"
    return Proposal(words + (spelled(f" --kind {kind}", f", kind={kind!r}") if kind else ""), (why,) if why else ())


def _weighed(columns: Sequence[FileColumn], known: Sequence[str], rate: float, share: float) -> tuple[str, str]:
    """The unit in which the means of three columns, times a rate, have the length of gravity, and why; or none."""
    with np.errstate(all="ignore"):  # of numbers that are no samples
        length = math.hypot(*(float(np.mean(column.values)) for column in columns)) if len(columns) == 3 else 0.0
    if not 0 < length * rate < math.inf:
        return "", ""
    gravity = unit_of("g").factor
    off = {unit: abs(math.log(length * rate * unit_of(unit).factor / gravity)) for unit in known}
    whole = all(column.values.dtype.kind == "i" for column in columns)
    unit = min(off, key=lambda unit: off[unit])
    if off[unit] > math.log1p(share) or (whole and any(abs(length / count - 1) < UNNAMED for count in COUNTS)):
        return "", ""
    return unit, say("the mean has the length of gravity in {unit} ({length:.4g})", unit=unit, length=length * rate)
