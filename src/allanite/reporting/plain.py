"""Results for machines: JSON and CSV."""

import csv
import io
import json
import math
from collections.abc import Callable, Iterator
from typing import Any, Protocol

from allanite.core.curve import Curve
from allanite.core.spectrum import Spectrum
from allanite.core.surface import Surface
from allanite.study.analysis import Study
from allanite.study.survey import Survey

from .words import readable_unit


class Plain(Protocol):
    """Whatever can become plain data."""

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""


def to_json(value: Plain) -> str:
    """Strictly valid JSON: what is no number is null."""
    return json.dumps(_strict(value.to_dict()), allow_nan=False, ensure_ascii=False) + "\n"


def _strict(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _strict(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_strict(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def to_csv(value: Study | Survey) -> str:
    """The values of all channels below each other; those of a study in the units of data sheets.

    Limits are at the recipe's level.
    """
    values = value.values if isinstance(value, Survey) else _curves(value)
    headings, rows_of = _FORMS[type(values[0])] if values else _FORMS[Curve]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(headings)
    for item in values:
        writer.writerows(rows_of(item, value.recipe.level))
    return out.getvalue()


def _curves(study: Study) -> list[Curve]:
    return [c.curve.to(readable_unit(c.curve.unit)) for c in study.channels if c.curve is not None]


def _curve_rows(curve: Curve, level: float) -> Iterator[list[Any]]:
    data = curve.to_dict(level)
    none = [""] * len(data["m"])
    columns = [data["m"], data["tau"], data["deviation"], data.get("low", none), data.get("high", none)]
    for m, tau, value, low, high, edf, count in zip(*columns, data.get("edf", none), data["count"], strict=True):
        yield [curve.name, curve.statistic, m, tau, value, low, high, curve.unit, edf, count]


def _spectrum_rows(spectrum: Spectrum, level: float) -> Iterator[list[Any]]:
    for f, density, low, high, amplitude, dof in spectrum.rows(level)[1]:
        yield [spectrum.name, f, density, low, high, spectrum.density_unit, spectrum.sides, amplitude,
               spectrum.amplitude_unit, dof]  # fmt: skip


def _surface_rows(surface: Surface, _: float) -> Iterator[list[Any]]:
    for time, m, tau, value, count in surface.rows()[1]:
        shown = "" if math.isnan(value) else value
        yield [surface.name, surface.statistic, time, m, tau, shown, surface.unit, count]


_FORMS: dict[type, tuple[tuple[str, ...], Callable[[Any, float], Iterator[list[Any]]]]] = {
    Curve: (
        ("channel", "statistic", "m", "tau_s", "deviation", "low", "high", "unit", "edf", "count"),
        _curve_rows,
    ),
    Spectrum: (
        ("channel", "frequency_hz", "density", "low", "high", "unit", "sides", "amplitude", "amplitude_unit", "dof"),
        _spectrum_rows,
    ),
    Surface: (("channel", "statistic", "time_s", "m", "tau_s", "deviation", "unit", "count"), _surface_rows),
}
"""Columns of a CSV file, and its rows, by what is in them."""
