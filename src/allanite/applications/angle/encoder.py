"""Harmonic errors of any angle sensor against a reference."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from allanite.extending import (  # isort: skip
    POSITIVE, DataError, Finding, FloatArray, Range, Record, UnitError, UsageError, public, say, spelled,
    unit_of)  # fmt: skip

from .calibration import part, too_large
from .geometry import column, demand_motion
from .harmonics import Harmonics, orders_of, waves
from .missing import missing
from .solve import Solution, System, correlation_of, solve

MAX_SCATTER = 0.5  # phase of the highest harmonic, rad, that the scatter of the two angles may amount to at most


@public
def calibrate(
    measured: Record | ArrayLike, reference: Record | ArrayLike, orders: Sequence[int] = (128, 256), *,
    unit: str = "rad", sigma: Annotated[float | None, POSITIVE] = None, trend: Annotated[int, Range(0, 2)] = 0,
    name: str = "",
) -> Harmonics:  # fmt: skip
    """Estimate the harmonic errors of an angle sensor from its samples and those of a reference.

    Least squares of ``measured - reference``, wrapped into half a turn, on ``sin k a, cos k a`` of the measured angle a
    for each order k, and a constant.

    Parameters
    ----------
    measured, reference : Record of kind "angle", or array of shape (n,)
        Angles at the same instants; both may wrap at a full turn, at any angle.
    orders : sequence of int
        Harmonics of the angle; 1 is the eccentricity.
    unit : str
        Unit of arrays; records have their own.
    sigma : float, optional
        Standard deviation of a difference's white noise, in `unit` (rad for records); by default it is estimated.
    trend : int
        Degree of a polynomial in the sample number that is estimated jointly: 0 a constant, 1 also a drift.
    name : str
        Name of the sensor; by default that of its record.

    Returns
    -------
    Harmonics
        A Correction: ``found.apply(record)``. Its `solution` has the history, tests and findings.

    Raises
    ------
    DataError
        Samples are not finite or too few, the angle does not move, or the orders cannot be separated.
    UnitError
        The unit is not that of an angle, or the numbers contradict it.
    UsageError
        Another choice is impossible.

    Examples
    --------
    >>> angle = np.linspace(0, 6, 2000)
    >>> noise = 1e-6 * np.random.default_rng(1).standard_normal(2000)
    >>> found = calibrate(angle + 2e-5 * np.sin(128 * angle) + noise, angle)
    >>> found.amplitude.round(7).tolist(), found.found(128), found.found(256)
    ([2e-05, 0.0], True, False)
    """
    chosen = orders_of(orders)
    angle, factor = _angle("measured", measured, unit)
    against, _ = _angle("reference", reference, unit)
    if against.size != angle.size:
        raise DataError(f"reference has {against.size} samples instead of {angle.size}, as many as measured")
    steps = np.abs(np.diff(angle))
    torn = np.abs(steps - 360.0) < 5.0  # a jump of 360 in what are said to be radians is a turn in degrees
    if torn.any() and np.median(steps) < 5.0:
        at = int(torn.argmax())
        raise UnitError(f"measured jumps by {steps[at]:.5g} rad at sample {at + 1}: is it in degrees? "
                        f"({spelled('--unit deg', f'unit={unit!r}')})")  # fmt: skip
    # into half a turn about the mean direction, so that an offset near half a turn is not torn
    middle = float(np.angle(np.exp(1j * (angle - against)).mean()))
    z = np.asarray(np.mod(angle - against - middle + math.pi, 2 * math.pi) - math.pi + middle)
    demand_motion("the angle", float(np.ptp(np.unwrap(angle))), chosen, "Turn the sensor")
    if (scatter := float(np.std(z))) * max(chosen) > MAX_SCATTER:
        raise DataError(f"measured and reference differ by {scatter:.3g} rad about their mean, which is not small "
                        f"relative to a period of harmonic {max(chosen)} ({2 * math.pi / max(chosen):.3g} rad): are "
                        "units, signs and columns right?")  # fmt: skip
    names = (*(f"{wave}{k}" for k in chosen for wave in "SC"), *(say("offset"), say("drift"), say("bend"))[: trend + 1])
    number = np.linspace(-1.0, 1.0, angle.size)
    rows = np.column_stack([waves(angle, chosen), *(number**i for i in range(trend + 1))])
    system = System(names, rows, z, np.arange(angle.size, dtype=np.float64))
    solution = solve(system, sigma=None if sigma is None else sigma * factor)
    harmonics = part(solution, name or getattr(measured, "name", ""), chosen, 0)
    more = missing(solution, rows, z, {harmonics.name: (angle, np.ones(angle.size))}, {harmonics.name: chosen})
    findings = (*more, *solution.findings, *_caveats(angle, chosen, solution), *too_large([harmonics]))
    return replace(harmonics, solution=replace(solution, findings=findings))


def _angle(what: str, values: Any, unit: str) -> tuple[FloatArray, float]:
    """Angles in rad, and what a number of `unit` is in rad."""
    if isinstance(values, Record):
        if values.kind != "angle" or values.signal.name != "gyro":
            raise UsageError(f"{what} must be a record of kind 'angle' in rad or deg, not of kind {values.kind!r} in "
                             f"{values.unit}")  # fmt: skip
        return column(what, values.values) * values.factor, 1.0
    size = unit_of(unit)
    if size.dimension != unit_of("rad").dimension:
        raise UnitError(f"{unit!r} is not a unit of an angle; for example rad, deg, arcsec")
    return column(what, values) * size.factor, size.factor


def _caveats(angle: FloatArray, orders: tuple[int, ...], solution: Solution) -> Iterator[Finding]:
    span, period = float(np.ptp(np.unwrap(angle))), 2 * math.pi / min(orders)
    correlation = correlation_of(solution.covariance) - np.eye(len(solution.names))
    i, j = np.unravel_index(int(np.abs(correlation).argmax()), correlation.shape)
    pair = say("{first} correlates with {second} by {correlation:+.3f}", first=solution.names[i],
               second=solution.names[j], correlation=float(correlation[i, j]))  # fmt: skip
    if span < period:
        yield Finding("span",
                      say("the angle moves by {span:.3g} deg, less than one period of harmonic {order} ({period:.3g} "
                          "deg)", span=math.degrees(span), order=min(orders), period=math.degrees(period)),
                      say("the parameters can hardly be separated: {pair}", pair=pair),
                      say("turn further, or omit the lowest orders"))  # fmt: skip
    elif abs(correlation[i, j]) > 0.9:
        what = say("hardly separable: {pairs}", pairs=pair)
        yield Finding("alike", what, say("their errors are large and correlated"), say("turn further"))
