"""Data sheet: what was found of a channel, as the quantities and in the units that data sheets quote."""

import math
from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

from allanite.phrases.phrase import Phrase, say
from allanite.terms import TERMS, WHITE

from .estimate import Estimate
from .fit import Fit
from .readings import Means, Readings, stability_over
from .titles import title_of
from .units import convert

ONE_SIDED = math.sqrt(2)
"""One-sided over two-sided amplitude spectral density."""

MOSTLY = 0.8
"""Part of an N-second stability that a ramp alone makes, from which it is named."""

BANDWIDTH = say("bandwidth (-3 dB)")


class DataSheetRow(NamedTuple):
    """One line of a data sheet.

    `value`, `low` and `high` are in `unit`; of a term that was not found only `high` is known, a one-sided 95 % upper
    limit. `tau` is the averaging time in s, where the quantity has one. `coefficient`: whether it is a coefficient of
    the model in its usual unit, as tables of coefficients have it, too.
    """

    quantity: str
    value: float | None
    low: float | None
    high: float | None
    unit: str
    tau: float | None = None
    remark: str = ""
    coefficient: bool = False


def data_sheet(fit: Fit | None, readings: Readings | None, rate: float, level: float = 0.95) -> list[DataSheetRow]:
    """The quantities of a data sheet, each with its limits.

    Examples
    --------
    >>> from allanite import N, Model
    >>> white = N(0.12, "deg/sqrt(h)")
    >>> walk = Estimate("N", white.signal, white.value, None, "identified", None, "whittle")
    >>> found = data_sheet(Fit((walk,), "whittle", white.signal, Model((white,))), None, 10.0)
    >>> [f"{entry.value:.4g} {entry.unit}" for entry in found[:3]]
    ['0.12 deg/sqrt(h)', '0.002 deg/s/sqrt(Hz)', '7.2 deg/h/sqrt(Hz)']
    """
    estimates = () if fit is None else fit.estimates
    white = [e for e in estimates if TERMS[e.symbol].slope == WHITE]
    found = list[DataSheetRow]()
    densities = ((say("noise density, two-sided"), 1.0, ""), (say("noise density, one-sided"), ONE_SIDED, "sqrt(2) "))
    for e in white:
        for unit in dict.fromkeys((e.sheet_unit, e.signal.sheet[TERMS[e.symbol].power])):
            found.append(_entry(e, _name(e), unit, level)._replace(coefficient=unit == e.sheet_unit))
        for (quantity, factor, before), unit in product(densities, e.signal.density):
            row = _entry(e, quantity, unit, level, factor)
            found.append(row if row.remark else row._replace(remark=f"{before}{e.symbol}"))
    found += _minimum(readings, level)
    for e in (e for e in estimates if e not in white):
        found.append(_entry(e, _name(e), e.sheet_unit, level)._replace(coefficient=True))
        if TERMS[e.symbol].slope == 0:
            floor = math.sqrt(TERMS[e.symbol].level)
            found.append(_entry(e, say("flicker floor, {floor:.3f} B", floor=floor), e.sheet_unit, level, floor))
    if readings is not None:
        unit = readings.shown_unit(0)
        for means in readings.means:
            value = convert(means.value, readings.unit, unit)
            remark = say("{count} means", count=means.count)
            if any(_spread_of(e, means) > MOSTLY * means.value for e in estimates):
                remark = say("{means}; mostly the ramp: R x {length:.6g} s / sqrt(12)", means=remark,
                             length=means.count * means.seconds)  # fmt: skip
            found.append(DataSheetRow(stability_over(means.seconds), value, None, None, unit, means.seconds, remark))
    return found if fit is None else [*found, _bandwidth(fit, rate)]


def _spread_of(e: Estimate, means: Means) -> float:
    """Standard deviation of means that a ramp alone makes, SI: R n s / sqrt(12); 0 of any other term."""
    if TERMS[e.symbol].waveform is None or TERMS[e.symbol].slope != 1 or e.value is None:
        return 0.0
    return abs(e.value) * means.count * means.seconds / math.sqrt(12)


def _name(e: Estimate) -> Phrase:
    return say("{term} {symbol}", term=title_of(e.symbol, e.signal), symbol=e.symbol)


def _entry(e: Estimate, quantity: str, unit: str, level: float, factor: float = 1.0) -> DataSheetRow:
    scale = factor * convert(1.0, e.unit, unit)
    remark = {"identified": "", "absent": say("not identified")}.get(e.status, e.row.name)
    if e.status == "not valid" or e.value is None:
        most = None if e.upper is None or e.status == "not valid" else e.upper * scale
        return DataSheetRow(quantity, None, None, most, unit, None, remark)
    low, high = (None if math.isnan(v) else v * scale for v in e.interval(level))
    return DataSheetRow(quantity, e.value * scale, low, high, unit, None, remark)


def _minimum(readings: Readings | None, level: float) -> Iterator[DataSheetRow]:
    if readings is None or readings.minimum is None:
        return
    point, unit = readings.minimum, readings.shown_unit(0)
    factor = convert(1.0, readings.unit, unit)
    low, high = point.interval(level)
    lowest, inertial = say("minimum of the Allan deviation"), readings.signal.inertial
    remark = lowest if readings.inside else say("upper limit: still falling")
    name = say("in-run bias stability") if inertial else lowest
    yield DataSheetRow(
        name, point.deviation * factor, low * factor, high * factor, unit, point.tau,
        remark if inertial or not readings.inside else "",
    )  # fmt: skip


def _bandwidth(fit: Fit, rate: float) -> DataSheetRow:
    behind = fit.scope.filter if fit.scope else None
    if behind is not None:
        return DataSheetRow(BANDWIDTH, behind.cutoff, behind.low, behind.high, "Hz", None, behind.title)
    if fit.scope is None or not fit.scope.whole:
        return DataSheetRow(BANDWIDTH, None, None, None, "", None, say("not determined"))
    remark = say("no roll-off up to {frequency:.6g} Hz", frequency=rate / 2)
    return DataSheetRow(BANDWIDTH, None, None, None, "", None, remark)
