"""The temperature polynomials of a compensation as parameters of an autopilot."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import comb

import numpy as np

from allanite.applications.compensation.compensating import Compensated, CompensationStudy
from allanite.applications.compensation.regression import Regression
from allanite.applications.compensation.regressor import Regressor
from allanite.applications.compensation.settings import CompensationSettings
from allanite.core.aliases import public
from allanite.core.arrays import FloatArray
from allanite.core.errors import DataError, UsageError
from allanite.core.names import row_of
from allanite.core.units import signal_named, unit_of
from allanite.core.version import __version__
from allanite.phrases.phrase import say, spelled

from .choice import placed
from .content import Content, Entry
from .export import Export
from .exports import TEMPERATURE
from .target import GYRO, ThermalTarget

AXES = "xyz"

NARROW = 10.0  # range below which the record is too short of temperatures, degC: the least that ArduPilot learns from


def thermal_target(name: str, instance: int | None = None) -> ThermalTarget:
    """The row of an autopilot."""
    row = row_of("autopilot", name, TEMPERATURE)
    row.prefix(GYRO, instance)
    return row


def demand_settings(row: ThermalTarget, settings: CompensationSettings) -> None:
    """Refuse, before any work, what would give no polynomial in one temperature; errors as those of `row.demand`."""
    asked = [Regressor(name, "") for name in settings.regressors]
    asked += [Regressor(name, "", power=settings.degree) for name in settings.regressors]
    asked += [Regressor(name, "", smooth=settings.fit.smooth) for name in settings.derivative_of]
    asked += [Regressor(name, "", lag=lag) for name in settings.regressors for lag in settings.lags]
    row.demand(asked)


@public
def temperature_parameters(study: CompensationStudy, target: str, *, instance: int | None = None) -> Export:
    """Convert the temperature polynomials of a compensation to the parameters of an autopilot.

    The polynomials are those of the regressions, expanded about the autopilot's reference temperature; a linear drift
    over time is not among them. The correction is zero at the mean temperature of the record. The range is that of
    the record: beyond it the autopilot keeps the correction of the limit. A channel that shows no effect, or that the
    correction harms in cross-validation, is written as zeros, as is an axis without a record.

    Parameters
    ----------
    study : CompensationStudy
        Of one IMU: at most three gyros and three accelerometers.
    target : {"px4", "ardupilot"}
        TC_* parameters of PX4, or INS_TCAL* parameters of ArduPilot.
    instance : int, optional
        Number of the sensor: 0 to 3 for PX4, 1 to 5 for ArduPilot; by default the first.

    Returns
    -------
    Export

    Raises
    ------
    UsageError
        There is no such autopilot or instance; the regressors are not powers of one temperature in degC, or a power
        is too high; it is not known which axis a channel is.
    DataError
        No channel of a gyro or an accelerometer shows an effect.
    """
    row = thermal_target(target, instance)
    axes = [axis for sensor in row.letters for axis in _axes(study, sensor)]
    for axis in axes:
        _demand(row, axis.regression)
    used = [axis for axis in axes if axis.regression.useful]
    if not used:
        names = ", ".join(axis.name for axis in axes) or "the channels"
        raise DataError(f"{row.program} gets no parameters: no effect of the temperature is shown for {names}")
    entries: dict[str, Entry] = {}
    for sensor in row.letters if row.together else dict.fromkeys(axis.sensor for axis in used):
        own = [axis for axis in used if row.together or axis.sensor == sensor]
        entries |= {entry.name: entry for entry in _entries(row, sensor, own, row.prefix(sensor, instance))}
    idle = [axis.name for axis in axes if axis not in used]
    notes = [say("{channel}: no effect is shown; its coefficients are 0", channel=name) for name in idle]
    alerts = tuple(_alerts(study, used))
    enable = [row.enable.format(prefix=row.prefix(e.sensor, instance), sensor=row.letters[e.sensor])
              for e in entries.values()]  # fmt: skip
    head = [*_header(row, study, used), *(f"warning: {text}" for text in alerts), *(f"note: {text}" for text in notes)]
    suffix, layout = next(iter(row.forms.items()))
    content = Content(tuple(head), tuple(entries.values()), (), None)
    text = replace(layout, start=tuple(dict.fromkeys(enable)))(content)
    return Export(row.name, suffix, text, entries=content.entries, notes=(*notes, *row.notes), alerts=alerts,
                  rejected=study.rejected, recipe=study.choices(), provenance=study.provenance)  # fmt: skip


@dataclass(frozen=True)
class _Axis:
    """An axis of a sensor, the channel that is it, and its regression."""

    sensor: str
    axis: str
    channel: Compensated
    regression: Regression

    @property
    def name(self) -> str:
        return self.channel.record.name

    @property
    def span(self) -> tuple[float, float]:
        """The range of the temperature, degC."""
        return self.regression.regressors[0].span or (-math.inf, math.inf)


def _axes(study: CompensationStudy, sensor: str) -> Iterator[_Axis]:
    """The axes of a sensor that have a regression."""
    channels = [c for c in study.channels if c.record.signal.name == sensor]
    names = [c.record.name for c in channels]
    places = {axis: placed(names, axis) for axis in AXES}
    if sorted(place for place in places.values() if place is not None) != list(range(len(names))):
        raise UsageError(f"which axes {', '.join(names)} are is not known: "
                         "one sensor has at most three channels, whose names end in x, y and z; choose them with "
                         f"{spelled('--channels gx,gy,gz', 'Recipe(channels=...)')}")  # fmt: skip
    for axis, place in places.items():
        if place is not None and (regression := channels[place].regression) is not None:
            yield _Axis(sensor, axis, channels[place], regression)


def _demand(row: ThermalTarget, regression: Regression) -> None:
    row.demand(regression.regressors)
    first = regression.regressors[0]
    if first.unit != "degC":
        raise UsageError(f"{row.program} takes temperatures in degC, and {first.channel!r} is in {first.unit!r}: give "
                         "its unit, " + spelled(f"for example --unit 'gyro=deg/s,{first.channel}=degC'",
                                                "Record(..., unit='degC')"))  # fmt: skip
    if first.span is None:
        raise DataError(f"the saved regression of {regression.name!r} lacks the range of {first.channel!r}: fit again")


def _alerts(study: CompensationStudy, used: Sequence[_Axis]) -> Iterator[str]:
    for channel in study:
        if channel.refusal:
            yield say("{name} is left out: {reason}", name=channel.record.name, reason=channel.refusal)
    for axis in used:
        if axis.regression.ambiguous:
            yield say("{channel}: the effect can hardly be separated from a rate ramp R; record until the temperature "
                      "returns to its initial value", channel=axis.name)  # fmt: skip
    for low, high in {axis.span for axis in used}:
        if high - low < NARROW:
            yield say("the temperature changes by {span:.3g} degC only; record over the range of use", span=high - low)


def _entries(row: ThermalTarget, sensor: str, own: Sequence[_Axis], prefix: str) -> Iterator[Entry]:
    """The fields of a sensor; `own` are the axes that share its range."""
    low, high = max(a.span[0] for a in own), min(a.span[1] for a in own)
    if not low < high:
        raise DataError(f"the regressions of {', '.join(a.name for a in own)} have no temperature in common: fit again")
    channel = tuple(dict.fromkeys(a.regression.regressors[0].channel for a in own))
    reference = (low + high) / 2 if row.reference is None else row.reference
    limits = [("TMIN", "minimum", low, say("below it the correction stays as it is there")),
              ("TMAX", "maximum", high, say("above it the correction stays as it is there"))]  # fmt: skip
    if row.reference is None:
        limits.append(("TREF", "T0", reference, say("middle of the range")))
    for name, formula, value, remark in limits:
        yield Entry(prefix + name, sensor, "", "degC", formula, (value,), channel, remark)
    axes = {axis.axis: axis for axis in own if axis.sensor == sensor}
    polynomials = {axis: polynomial(of.regression, row.order, reference) for axis, of in axes.items()}
    unit = f"{1 / row.scale:g} {signal_named(sensor).unit}".removeprefix("1 ")
    for power in range(0 if row.constant else 1, row.order + 1):
        per = "" if power == 0 else f"/degC^{power}".removesuffix("^1")
        for axis, spelling in zip(AXES, row.axes, strict=True):
            name = prefix + row.coefficient.format(sensor=row.letters[sensor], power=power, axis=spelling)
            value, names, remark = 0.0, list[str](), say("no effect is shown, or there is no record of this axis")
            if axis in polynomials:
                value, error = (float(numbers[power]) * row.scale for numbers in polynomials[axis])
                names = [axes[axis].name]
                remark = say("standard error {error:.2g}", error=error) if error else say("not in the fit")
            yield Entry(name, sensor, "", unit + per, f"coefficient of (T - T0)^{power}", (value,), tuple(names),
                        remark)  # fmt: skip


def _header(row: ThermalTarget, study: CompensationStudy, used: Sequence[_Axis]) -> Iterator[str]:
    """The lines of the head, the same for the same input."""
    yield f"{row.title}, written by allanite {__version__}"
    for source, digest in (("source", "sha256"), ("regressors", "sha256 regressors")):
        if source in study.provenance:
            yield f"{source}: {study.provenance[source]}, sha256 {study.provenance.get(digest, 'unknown')}"
    for axis in used:
        unit = axis.regression.signal.sheet[0]
        scale = unit_of(unit).factor
        for effect in (e for e in axis.regression if e.taken_off):
            size = f"{effect.value / scale:.4g} ({effect.low / scale:.4g} .. {effect.high / scale:.4g}) {unit}"
            centre = f"{effect.label} about {effect.regressor.centre:g} degC"
            yield f"{axis.name}: {size} per {effect.regressor.column_unit}, {centre}"
    where = "the middle of the range" if row.reference is None else f"{row.reference:g} degC"
    zero = "" if row.constant else ", and the correction is zero at the temperature of the calibration"
    yield f"T is the temperature within the range, T0 {where}{zero}"
    yield from (f"note: {note}" for note in row.notes)


def polynomial(regression: Regression, order: int, reference: float) -> tuple[FloatArray, FloatArray]:
    """The correction of a regression as a polynomial about another temperature, by binomials."""
    taken = regression.taken
    shift = np.zeros((order + 1, len(taken)))
    for column, regressor in enumerate(regression.regressors[i] for i in taken):
        for j in range(regressor.power + 1):
            shift[j, column] = comb(regressor.power, j) * (reference - regressor.centre) ** (regressor.power - j)
    covariance = regression.mixture.covariance[np.ix_(taken, taken)]
    return shift @ regression.mixture.values[taken], np.sqrt(np.einsum("ij,jk,ik->i", shift, covariance, shift))
