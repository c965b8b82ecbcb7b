"""What to type where a file does not say what its columns are: what their numbers show, or a placeholder."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.errors import COLUMN, RATE, SCALE, UNIT, ColumnRow
from allanite.phrases.phrase import say, spelled
from allanite.readers.clock.clocks import ClockSources, addressed, counts_rows, readings, unit_by_rate

from . import gravity, headers
from .column import FileColumn

MOST, SHOWN = 40, 16  # columns of an overview, and how many of them are printed
SLOW = 0.1  # share of the standard deviation below which steps are those of a slow quantity
FEW = 4  # different whole numbers of a state


class Proposal(NamedTuple):
    """Words to type, why, and what follows: the rate in Hz, 0 if none does, and units by positions of columns."""

    words: str
    why: tuple[str, ...] = ()
    rate: float = 0.0
    units: Mapping[int, str] = MappingProxyType({})


def clock(columns: Sequence[FileColumn], sources: ClockSources) -> Proposal:
    """Words about the sampling rate: of the time stamps, or the first of columns that rise as stamps do."""
    column = sources.stamps or next((column for column in columns if _is_clock(column)), None)
    rates = {} if column is None else dict(readings(column.values))
    if column is None or not rates:
        return Proposal(spelled(f"--rate {RATE}", "rate=..."))
    address, unit = addressed(column), unit_by_rate(column.values)[0]
    words = spelled(f"--time '{address}'", f"time='{address}'")
    if not unit or sources.stamps:
        return Proposal(words, rate=rates.get(unit, 0.0))
    why = say("{column} rises as a clock of {rate:.6g} Hz in {unit} does",
              column=column.label, rate=rates[unit], unit=unit)  # fmt: skip
    return Proposal(words, (why,), rates[unit])


def _is_clock(column: FileColumn) -> bool:
    return not counts_rows(column.values) or bool(unit_by_rate(column.values)[0])


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
    known, times = (gravity.INCREMENTS, rate) if summed else (gravity.RATES, 1.0)
    unit, why = gravity.weighed(of.get("accelerometer", []), known, times, gravity.NAMED)
    # MicroStrain names increments like this, and writes them in rad and g*s
    theta = unit == "g*s" and all("theta" in column.name.lower() for column in of.get("gyro", ()))
    theirs = {"gyro": "rad" if theta else UNIT, "accelerometer": unit or UNIT}
    keys = {"gyro": "gyro", "accelerometer": "accel"}
    words = [f"{keys[name]}={theirs[name]}" for name in keys if name in of]
    words += [f"{column.position}={UNIT}" for three in gravity.triples(of.get("", ())) for column in three]
    stated = ",".join(words)
    made = _stated(stated if len(of) > 1 else theirs[next(iter(of))], why, kind="increment" if summed else "")
    if UNIT in theirs.values() and all(column.values.dtype.kind == "i" for column in sensors):
        option = spelled(f"--scale {SCALE}", f"scale={SCALE!r}")
        made = made._replace(why=(*made.why, say("whole numbers may be counts: then {option} instead", option=option)))
    return made._replace(units={c.position: theirs.get(name, UNIT) for name, members in of.items() for c in members})


def _unnamed(columns: Sequence[FileColumn]) -> Proposal:
    """Words about columns without names of sensors, of which each three may be the axes of one."""
    weighed = [(three, *gravity.weighed(three, gravity.RATES, 1.0, gravity.UNNAMED)) for three in _threes(columns)]
    heavy = [row for row in weighed if row[1]]
    if len(heavy) != 1:
        return _stated(UNIT if len(columns) <= 3 else f"{COLUMN}={UNIT}")
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


def overview(
    columns: Sequence[FileColumn], unsaid: Sequence[FileColumn], clocks: Sequence[FileColumn], known: Mapping[int, str]
) -> tuple[ColumnRow, ...]:
    """What the numbers of each column show, and what it is proposed as; `known` are units by positions."""
    paced = {column.position: _paced(column) for column in clocks}
    stamps = next((column.position for column in clocks if _is_clock(column)), 0)
    units, sensor = dict[int, str](), dict[int, int]()
    likely = {at: words for at, (_, words) in paced.items()}
    for i, three in enumerate((*_threes(unsaid), *gravity.triples(unsaid)), start=1):
        named = all(headers.sensor_by_name(column.name) == "accelerometer" for column in three)
        unit = gravity.weighed(three, gravity.RATES, 1.0, gravity.NAMED if named else gravity.UNNAMED)[0]
        sensor |= {c.position: i for c in three}
        units |= {c.position: unit for c in three if unit}
        likely |= {c.position: say("gravity in {unit}", unit=unit) for c in three if unit}
    units |= {at: unit for at, unit in known.items() if unit != UNIT}
    rows = list[ColumnRow]()
    for c in columns[:MOST]:
        at = c.position
        key, label = c.name if c.name.isdigit() else str(at), f"{at}: {c.name}" if c.header else c.name
        numbers, looks, out = _sized(c)
        signal = at in units or (c in unsaid and (not out or bool(headers.sensor_by_name(c.name))))
        use = ("time", paced[at][0]) if at == stamps else ("signal", units.get(at, "")) if signal else ("", "")
        rows.append(ColumnRow(key, label, *numbers, likely.get(at) or looks, *use, sensor.get(at, 0)))
    return tuple(rows)


def printed(rows: Sequence[ColumnRow]) -> tuple[str, ...]:
    """A line for each column."""
    head = "", say("column"), say("mean"), say("std"), say("step"), say("looks like")
    lines = (head, *rows[:SHOWN])
    return tuple("{1:<16}{2:>11}  {3:>10}  {4:>10}  {5}".format(*line).rstrip() for line in lines)


def _paced(column: FileColumn) -> tuple[str, str]:
    """The likely unit of time stamps, and how they look."""
    rates = dict(readings(column.values))
    unit = column.unit if column.unit in rates else unit_by_rate(column.values)[0]
    if unit not in rates:
        return "", say("a clock or a counter")
    return unit, say("a clock of {rate:.6g} Hz in {unit}", rate=rates[unit], unit=unit)


def _sized(column: FileColumn) -> tuple[tuple[str, str, str], str, bool]:
    with np.errstate(all="ignore"):
        values = np.asarray(column.values, dtype=np.float64)
        steps = np.abs(np.diff(values))
        mean, spread, step = float(np.mean(values)), float(np.std(values)), float(np.median(steps))
    return (f"{mean:.4g}", f"{spread:.3g}", f"{step:.3g}"), *_looks(column, steps, spread)


def _looks(column: FileColumn, steps: FloatArray, spread: float) -> tuple[str, bool]:
    """What numbers that are neither a clock nor gravity look like, and whether that is no inertial signal."""
    whole, largest = column.values.dtype.kind == "i", float(np.abs(column.values).max(initial=0))
    kinds = (
        (not spread, say("constant"), True),
        (bool(np.all(np.diff(column.values) > 0)), say("a clock or a counter"), True),
        (whole and len(np.unique(column.values[:1000])) <= FEW, say("a state or flags"), True),
        (170 < largest <= 180 and steps.max(initial=0) > 180, say("an angle within 180 deg"), True),
        (float(np.quantile(steps, 0.9)) < SLOW * spread, say("slow, such as a temperature"), True),
        (whole, say("whole numbers, such as counts"), False),
    )
    return next(((words, out) for fits, words, out in kinds if fits), ("", False))


def _stated(unit: str, why: str = "", *, kind: str = "") -> Proposal:
    words = spelled("--unit ", "unit=") + f"'{unit}'"
    return Proposal(words + (spelled(f" --kind {kind}", f", kind={kind!r}") if kind else ""), (why,) if why else ())
