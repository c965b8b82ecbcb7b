"""How curves, spectra and surfaces are shown."""

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from allanite.core.curve import Curve
from allanite.core.errors import UsageError
from allanite.core.fit import Fit
from allanite.core.spectrum import Spectrum
from allanite.core.surface import Surface
from allanite.phrases.phrase import join, say
from allanite.reporting import figures, words
from allanite.reporting.digits import digits
from allanite.reporting.sheet import Drawing, Face, Sheet, Table, Where, columns
from allanite.reporting.text import spread
from allanite.statistics import STATISTICS

from . import Rows, View

if TYPE_CHECKING:
    from allanite.reporting.style import Plot

BRAND = say("statistics of an inertial sensor")

MOST_COLUMNS = 8
"""Averaging times of a surface that are printed."""


class NumbersForm(NamedTuple):
    """What is written of a value: title, headings, cells of its rows, and the rows of a CSV file."""

    title: Callable[[Any], str]
    table: Callable[[Any, float], tuple[list[str], list[list[str]]]]
    headings: tuple[str, ...]
    rows: Callable[[Any, float], Iterator[list[Any]]]
    plot: "Callable[[Sequence[Any], dict[str, Fit], float], Plot]"


def numbers_table(value: Any, level: float, title: str = "", where: Where = "") -> Table:
    """The numbers of a curve, spectrum or surface; folded away on a page."""
    form = FORMS[type(value)]
    headings, rows = form.table(value, level)
    said = join("; ", filter(None, (title or form.title(value), _supposed(value))))
    return Table(columns(*headings, left=0), rows, said, details=True, where=where)


def _supposed(value: Any) -> str:
    return value.supposed if isinstance(value, Curve) else ""


def rows_of(values: Sequence[Any], level: float) -> Rows:
    """Rows of a CSV file of curves, spectra or surfaces."""
    if not values:
        return FORMS[Curve].headings, []
    form = FORMS[type(values[0])]
    return form.headings, [row for value in values for row in form.rows(value, level)]


def _curve_table(curve: Curve, level: float) -> tuple[list[str], list[list[str]]]:
    heads, rows = (_without_limits if curve.law is None else _with_limits)(curve, level)
    if curve.alpha is None:
        return heads, rows
    laws = [f"f^{alpha:+d}" if alpha else "f^0" for alpha in curve.alpha.tolist()]
    return [*heads, say("power law")], [[*row, law] for row, law in zip(rows, laws, strict=True)]


def _without_limits(curve: Curve, _: float) -> tuple[list[str], list[list[str]]]:
    numbers = zip(curve.m, curve.tau, curve.deviation, curve.count, strict=True)
    return ["m", "tau [s]", f"[{curve.unit}]", say("terms averaged")], [
        [str(m), f"{tau:.6g}", _number(value), str(n)] for m, tau, value, n in numbers
    ]


def _with_limits(curve: Curve, level: float) -> tuple[list[str], list[list[str]]]:
    numbers = zip(curve.m, curve.tau, curve.deviation, curve.count, strict=True)
    limits = zip(*(v.tolist() for v in (*curve.interval(level), curve.edf)), strict=True)
    rows = [
        [str(m), f"{tau:.6g}", *digits(value, low, high).plain(), f"{edf:.4g}", str(n)]
        for (m, tau, value, n), (low, high, edf) in zip(numbers, limits, strict=True)
    ]
    return ["m", "tau [s]", f"[{curve.unit}]", words.interval(level), "edf", say("terms averaged")], rows


def _spectrum_table(spectrum: Spectrum, level: float) -> tuple[list[str], list[list[str]]]:
    rows = [
        [f"{f:.5g}", *digits(value, low, high).plain(), f"{amplitude:.4g}", f"{dof:.4g}"]
        for f, value, low, high, amplitude, dof in spectrum.rows(level)[1]
    ]
    return ["f [Hz]", f"[{spectrum.density_unit}]", words.interval(level), f"[{spectrum.amplitude_unit}]", "dof"], rows


def _surface_table(surface: Surface, _: float) -> tuple[list[str], list[list[str]]]:
    kept = spread(surface.tau.size, MOST_COLUMNS)
    rows = [
        [f"{time:.6g}", *(_number(value) or "-" for value in row)]
        for time, row in zip(surface.time, surface.deviation[:, kept].tolist(), strict=True)
    ]
    return [say("time [s]"), *(f"{surface.tau[j]:.4g} s" for j in kept)], rows


def _number(value: float) -> str:
    return digits(value).plain()[0] if np.isfinite(value) else ""


def _spectrum_title(spectrum: Spectrum) -> str:
    named = {"unit": spectrum.density_unit, "method": spectrum.method}
    if spectrum.sides == "one":
        return say("one-sided power spectral density in {unit}, {method}", **named)
    return say("two-sided power spectral density in {unit}, {method}", **named)


def _surface_title(surface: Surface) -> str:
    return say(
        "{statistic} in {unit}, windows of {length:g} s every {step:g} s",
        statistic=STATISTICS[surface.statistic].title,
        unit=surface.unit,
        length=surface.window,
        step=surface.step,
    )


def _curve_lines(curve: Curve, level: float) -> Iterator[list[Any]]:
    data = curve.to_dict(level)
    none = [""] * len(data["m"])
    known = [data["m"], data["tau"], data["deviation"], data.get("low", none), data.get("high", none)]
    counts = data.get("edf", none), data["count"], none if curve.alpha is None else data["alpha"]
    for m, tau, value, low, high, edf, count, alpha in zip(*known, *counts, strict=True):
        yield [curve.name, curve.statistic, m, tau, value, low, high, curve.unit, edf, count, alpha]


def _spectrum_lines(spectrum: Spectrum, level: float) -> Iterator[list[Any]]:
    for f, density, low, high, amplitude, dof in spectrum.rows(level)[1]:
        yield [spectrum.name, f, density, low, high, spectrum.density_unit, spectrum.sides, amplitude,
               spectrum.amplitude_unit, dof]  # fmt: skip


def _surface_lines(surface: Surface, _: float) -> Iterator[list[Any]]:
    for time, m, tau, value, count in surface.rows()[1]:
        yield [surface.name, surface.statistic, time, m, tau, "" if np.isnan(value) else value, surface.unit, count]


def _plot_curves(curves: Sequence[Curve], fits: dict[str, Fit], level: float) -> "Plot":
    panels = [figures.CurvePanel(curve.name, curve, fits.get(curve.name)) for curve in curves]
    draw = figures.plot_panels if len(panels) == 1 else figures.plot_overlay
    return draw(panels, level=level)


FORMS: dict[type, NumbersForm] = {
    Curve: NumbersForm(
        lambda curve: say("{statistic} in {unit}", statistic=STATISTICS[curve.statistic].title, unit=curve.unit),
        _curve_table,
        ("channel", "statistic", "m", "tau_s", "deviation", "low", "high", "unit", "edf", "count", "alpha"),
        _curve_lines,
        _plot_curves,
    ),
    Spectrum: NumbersForm(
        _spectrum_title,
        _spectrum_table,
        ("channel", "frequency_hz", "density", "low", "high", "unit", "sides", "amplitude", "amplitude_unit", "dof"),
        _spectrum_lines,
        lambda spectra, fits, level: figures.plot_spectra(spectra, fits, level=level),
    ),
    Surface: NumbersForm(
        _surface_title,
        _surface_table,
        ("channel", "statistic", "time_s", "m", "tau_s", "deviation", "unit", "count"),
        _surface_lines,
        lambda surfaces, fits, level: figures.plot_surfaces(surfaces),
    ),
}


def _one_face(value: Any, level: float) -> Face:
    form = FORMS[type(value)]
    title = form.title(value)
    if value.name:
        title = say("{channel}: {statistic}", channel=value.name, statistic=title)
    drawing = Drawing(lambda: form.plot([value], {}, level), form.title(value), _supposed(value))
    sheet = Sheet(value.name or say("channel"), tuple(value.history), (drawing, numbers_table(value, level)))
    return Face(title, BRAND, (sheet,))


def _plot_one(values: Sequence[Any], fit: Fit | None, level: float) -> "Plot":
    kinds = {type(value) for value in values}
    if len(kinds) > 1:
        raise UsageError(
            f"values of one kind are drawn together, not {' and '.join(sorted(k.__name__ for k in kinds))}"
        )
    fits = {value.name: fit for value in values} if fit is not None else {}
    return FORMS[type(values[0])].plot(values, fits, level)


CURVE = SPECTRUM = SURFACE = View(_one_face, _plot_one, lambda value, level: rows_of([value], level))
