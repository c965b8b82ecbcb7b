"""The numbers of the angle sensors as they are printed: arcseconds, degrees, with the digits that mean something."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from allanite.angle import Calibration, Harmonics, Solution
from allanite.angle.design import NUISANCES
from allanite.angle.solution import quantile
from allanite.core.errors import UsageError
from allanite.core.units import convert, unit_of
from allanite.reporting.digits import digits

ARCSEC = unit_of("arcsec").factor

Result = Harmonics | Calibration


class Constant(NamedTuple):
    """A constant in print: name, value with its standard error, unit, meaning."""

    name: str
    value: str
    error: str
    unit: str
    meaning: str = ""


class Line(NamedTuple):
    """A harmonic in print: its amplitude with limits, or a limit if it was not found."""

    angle: str
    order: int
    sine: Constant
    cosine: Constant
    amplitude: str
    interval: str
    phase: str
    found: bool
    status: str


def parts(result: Result) -> tuple[Harmonics, ...]:
    """The harmonics of each angle."""
    return result.harmonics if isinstance(result, Calibration) else (result,)


def solution_of(result: Result) -> Solution:
    """How they were estimated.

    Raises
    ------
    UsageError
        They were not: known harmonics have no solution.
    """
    if result.solution is None:
        raise UsageError("these harmonics were given, not estimated: there is nothing to report")
    return result.solution


def constant(name: str, value: float, error: float, unit: str = "arcsec", meaning: str = "") -> Constant:
    """Value and standard error with two digits of the error."""
    shown = digits(value, value - error, value + error, signed=True)
    power = f"e{shown.exponent}" if shown.exponent else ""
    return Constant(name, shown.value + power, digits(error, figures=2).plain()[0], unit, meaning)


def lines(result: Result, level: float) -> Iterator[Line]:
    """Every harmonic, in arcsec and degrees."""
    for h in parts(result):
        errors = [math.sqrt(v) / ARCSEC for v in h.covariance.diagonal()]
        for i, order in enumerate(h.orders):
            sine = constant(f"S{order}", float(h.sine[i]) / ARCSEC, errors[2 * i])
            cosine = constant(f"C{order}", float(h.cosine[i]) / ARCSEC, errors[2 * i + 1])
            size = digits(float(h.amplitude[i]) / ARCSEC, *(v / ARCSEC for v in h.interval(order, level)))
            value, interval = size.plain()
            found = h.found(order)
            limit = digits(h.upper(order) / ARCSEC, figures=2).plain()[0]
            phase = f"{math.degrees(float(h.phase[i])):.0f}"
            yield Line(
                h.name or "angle", order, sine, cosine, value if found else f"below {limit}",
                interval if found else "", phase if found else "", found, h.status(order),
            )  # fmt: skip


def others(solution: Solution) -> Iterator[Constant]:
    """What was estimated along with the harmonics."""
    for name, value, error in zip(solution.names, solution.values.tolist(), solution.errors.tolist(), strict=True):
        if name[0] in "SC" and name[1:2].isdigit():
            continue
        row = NUISANCES.get(name)
        unit = "arcsec/h" if row and row.per_time else "arcsec"
        factor = convert(1.0, "rad/s", "arcsec/h") if row and row.per_time else 1 / ARCSEC
        meaning = row.meaning if row else ENCODER[name]
        yield constant(name, value * factor, error * factor, unit, meaning)


ENCODER = {
    "offset": "constant difference of the two angles",
    "drift": "its linear growth over half the record",
    "bend": "its quadratic growth over half the record",
}
"""What is estimated along with the harmonics of an encoder."""


def noise(solution: Solution) -> str:
    """The noise of one reading in words."""
    how = "given" if solution.given else "estimated from what is left over"
    return f"noise of one reading {solution.sigma / ARCSEC:.4g} arcsec, {how}"


def half_width(level: float, freedom: float) -> float:
    """Half width of an interval in standard errors."""
    return quantile(level, freedom)
