"""Units that the user states or that names of columns define (sensor_msgs, PX4, EuRoC), and what headers say."""

import math
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import NamedTuple

from allanite.core.errors import UsageError
from allanite.core.units import unit_of
from allanite.core.validity import Finding
from allanite.phrases.phrase import join, say, spelled
from allanite.readers.options import KINDS_OF_SENSORS, Options

from . import headers
from .column import FileColumn, lookup, some


class Convention(NamedTuple):
    """Names that define a unit: what defines them, a pattern of names in lower case, and the unit."""

    family: str
    names: re.Pattern[str]
    unit: str


_ABOVE = r"(?:.*[./])?"
CONVENTIONS = (
    Convention("sensor_msgs/Imu", re.compile(_ABOVE + "angular_velocity[./][xyz]"), "rad/s"),
    Convention("sensor_msgs/Imu", re.compile(_ABOVE + "linear_acceleration[./][xyz]"), "m/s^2"),
    Convention("PX4", re.compile(_ABOVE + r"gyro_rad(?:\[[0-2]\]|[._][0-2])"), "rad/s"),
    Convention("PX4", re.compile(_ABOVE + r"accelerometer_m_s2(?:\[[0-2]\]|[._][0-2])"), "m/s^2"),
    Convention("EuRoC", re.compile("w_rs_s_[xyz]"), "rad/s"),
    Convention("EuRoC", re.compile("a_rs_s_[xyz]"), "m/s^2"),
)
"""The units of the definitions of messages and data sets: sensor_msgs/Imu.msg, SensorCombined.msg of PX4, ASL."""

_SHORT = {
    "gyro": Convention("sensor_msgs/Imu", re.compile("angular_velocity_[xyz]"), "rad/s"),
    "accelerometer": Convention("sensor_msgs/Imu", re.compile("linear_acceleration_[xyz]"), "m/s^2"),
}
"""Names of sensor_msgs without dots, which other files may have too: they count only if both sensors have them."""


def convention_of(column: FileColumn) -> Convention | None:
    """The convention that gave a column its unit; None if its header did."""
    every = (*CONVENTIONS, *_SHORT.values())
    return next(
        (convention for convention in every if _names(convention, column) and column.unit == convention.unit), None
    )


def applied(columns: tuple[FileColumn, ...]) -> tuple[FileColumn, ...]:
    """The columns with the units that their names define, where their headers have none."""
    short = all(any(_names(convention, column) for column in columns) for convention in _SHORT.values())
    known = (*CONVENTIONS, *(_SHORT.values() if short else ()))
    united = list[FileColumn]()
    for column in columns:
        named = next((convention for convention in known if _names(convention, column)), None)
        # gyro_rad[0] looks like an angle in rad
        fits = named is not None and not column.kind and not column.text and column.unit in ("", "rad")
        united.append(replace(column, unit=named.unit) if named is not None and fits else column)
    return tuple(united)


def _names(convention: Convention, column: FileColumn) -> bool:
    return bool(convention.names.fullmatch(column.header.strip().lower()))


class Stated(NamedTuple):
    """The options that apply to a column, and whether its unit was given by its own name."""

    options: Options
    named: bool = False


def of_columns(columns: tuple[FileColumn, ...], options: Options) -> Callable[[FileColumn], Stated]:
    """The options of each column: with one unit for all, or with its own."""
    if not options.units:
        return lambda column: Stated(options)
    plain = replace(options, unit=None, units=())
    of_sensors: dict[FileColumn, str] = {}
    of_names: dict[FileColumn, str] = {}
    for name, unit in options.units:
        if name in KINDS_OF_SENSORS.values():
            of_sensors |= dict.fromkeys(_columns_of(columns, name, unit), unit)
        else:
            column = lookup(columns, name)
            column.demand_numbers()
            of_names[column] = unit
    own = {
        column: Stated(replace(plain, unit=unit), column in of_names)
        for column, unit in (of_sensors | of_names).items()
    }
    return lambda column: own.get(column, Stated(plain))


def apart(
    columns: tuple[FileColumn, ...], theirs: tuple[FileColumn, ...], options: Options
) -> tuple[dict[FileColumn, str], Options]:
    """The units that are given for some columns by their names, and the options of the others."""
    sensors = KINDS_OF_SENSORS.values()
    units = {name: lookup(columns, name) for name, _ in options.units if name not in sensors}
    own = {units[name]: unit for name, unit in options.units if units.get(name) in theirs}
    others = tuple((name, unit) for name, unit in options.units if units.get(name) not in own)
    return own, replace(options, units=others) if own else options


def _columns_of(columns: tuple[FileColumn, ...], sensor: str, unit: str) -> list[FileColumn]:
    """The columns of a type of sensor; refused if there are none."""
    types = dict[FileColumn, str]()  # by the unit of each, otherwise by its name
    for column in columns:
        signal = headers.inertial(column.unit)
        other = column.text or headers.is_other(column.name, column.unit) or headers.is_time(column.unit)
        types[column] = "" if other else signal.name if signal else headers.sensor_by_name(column.name)
    members = [column for column, theirs in types.items() if theirs == sensor]
    if members:
        return members
    shown = (f"{c.position}: {c.header or c.name}" + (f" ({theirs})" if theirs else "") for c, theirs in types.items())
    first = next((c.position for c, theirs in types.items() if not theirs and headers.clock_rank(c.name) == 2), 1)
    raise UsageError(
        f"the unit {unit} is given for {sensor} channels, but no column is one by its name or unit; the file has "
        f"{some(list(shown), 30)}; omit it, or give the unit by column: "
        + spelled(f"--unit {first}={unit}", f"unit={{'{first}': '{unit}'}}")
    )


def contradicts(column: FileColumn, unit: str) -> bool:
    """Whether the header of a column states a unit of another size or quantity."""
    theirs = headers.known(column.unit)
    if theirs is None:
        return False
    mine = unit_of(unit)
    return theirs.dimension != mine.dimension or not math.isclose(theirs.factor, mine.factor, rel_tol=1e-9)


def against_headers(used: Iterable[tuple[FileColumn, str]]) -> Iterator[Finding]:
    """A warning for each pair of a unit that is used and another in headers."""
    pairs: dict[tuple[str, str], list[str]] = {}
    for column, unit in used:
        if contradicts(column, unit):
            pairs.setdefault((unit, column.unit), []).append(repr(column.header or column.name))
    for (unit, theirs), names in pairs.items():
        what = say(
            "unit {unit} is used as requested, but according to the file it is {theirs} for {columns}",
            unit=unit, columns=some(names, 12), theirs=theirs,
        )  # fmt: skip
        effect = say("if the file is right, the coefficients are wrong")
        remedy = say("omit {option} if the file is right", option=spelled(f"--unit {unit}", f"unit={unit!r}"))
        ours, other = unit_of(unit), unit_of(theirs)
        apart = (
            say("that is another quantity")
            if ours.dimension != other.dimension
            else say("that is a factor of {factor:.6g}", factor=ours.factor / other.factor)
        )
        yield Finding(say("given unit"), join(": ", (what, apart)), effect, remedy)
