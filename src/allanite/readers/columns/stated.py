"""Units that the user states by sensor or by column, and what headers say against them."""

import math
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
    units = (of_sensors | of_names).items()
    own = {column: Stated(replace(plain, unit=unit), column in of_names) for column, unit in units}
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
        what = say("unit {unit} is used as requested, but according to the file it is {theirs} for {columns}",
                   unit=unit, columns=some(names, 12), theirs=theirs)  # fmt: skip
        effect = say("if the file is right, the coefficients are wrong")
        remedy = say("omit {option} if the file is right", option=spelled(f"--unit {unit}", f"unit={unit!r}"))
        ours, other = unit_of(unit), unit_of(theirs)
        apart = say("that is a factor of {factor:.6g}", factor=ours.factor / other.factor)
        apart = apart if ours.dimension == other.dimension else say("that is another quantity")
        yield Finding(say("given unit"), join(": ", (what, apart)), effect, remedy)
