"""How curves, spectra, surfaces, and values read off a curve are shown; those of all channels side by side."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.curve import Curve, Surface
from allanite.core.errors import UsageError
from allanite.core.fit import Fit
from allanite.core.readings import Readings
from allanite.core.spectrum import Spectrum
from allanite.phrases.phrase import join, say
from allanite.reporting import figures, words
from allanite.reporting.digits import digits, printed_unit, rounded
from allanite.reporting.sheet import Column, Drawing, Face, Plot, Sheet, Table, Where, one_sheet
from allanite.reporting.text import spread
from allanite.statistics import statistic_named

from . import Rows, view

BRAND = say("statistics of an inertial sensor")

MAX_SURFACE_TIMES = 8  # averaging times of a surface that are printed


class NumbersForm(NamedTuple):
    """What is written of a value: title, columns and rows of its table, headings and rows of a CSV file, figure."""

    title: Callable[[Any], str]
    table: Callable[[Any, float], tuple[Sequence[Column], list[list[Any]]]]
    headings: tuple[str, ...]
    rows: Callable[[Any, float], list[list[Any]]]
    plot: Callable[[Sequence[Any], dict[str, Fit], float], Plot]


def numbers_table(value: Any, level: float, title: str = "", where: Where = "") -> Table:
    """The numbers of a curve, spectrum or surface; folded away on a page."""
    heading = title or join("; ", filter(None, (_title(value), _supposed(value))))
    return Table(*FORMS[type(value)].table(value, level), heading, details=True, where=where)


def _title(value: Any) -> str:
    return FORMS[type(value)].title(value)


def _supposed(value: Any) -> str:
    return value.supposed if isinstance(value, Curve) else ""


def rows_of(values: Sequence[Any], level: float) -> Rows:
    """Rows of a CSV file of curves, spectra or surfaces."""
    form = FORMS[type(values[0]) if values else Curve]
    return form.headings, [row for value in values for row in form.rows(value, level)]


def _curve_table(curve: Curve, level: float) -> tuple[Sequence[Column], list[list[Any]]]:
    """With limits where the noise is known, and with its power law where that was identified at each point."""
    heads = [Column("m"), Column("tau [s]", form=".6g"), Column(f"[{curve.unit}]")]
    numbers = zip(curve.m, curve.tau, curve.deviation, strict=True)
    if curve.law is None:
        rows = [[m, tau, rounded(value)] for m, tau, value in numbers]
    else:
        heads += [Column(words.interval(level), "interval"), Column("edf", form=".4g")]
        limits = zip(*(v.tolist() for v in (*curve.interval(level), curve.edf)), strict=True)
        rows = [[m, tau, *digits(value, low, high).plain(), edf]
            for (m, tau, value), (low, high, edf) in zip(numbers, limits, strict=True)]  # fmt: skip
    heads.append(Column(say("terms averaged")))
    rows = [[*row, count] for row, count in zip(rows, curve.count, strict=True)]
    if curve.alpha is not None:
        heads.append(Column(say("power law, less a ramp"), form=lambda alpha: f"f^{alpha:+d}" if alpha else "f^0"))
        rows = [[*row, alpha] for row, alpha in zip(rows, curve.alpha.tolist(), strict=True)]
    return heads, rows


def _curve_lines(curve: Curve, level: float) -> list[list[Any]]:
    data = curve.to_dict(level)
    none = [""] * len(data["m"])
    keys = ("m", "tau", "deviation", "low", "high", "edf", "count", "alpha")
    rows = zip(*(data.get(key) or none for key in keys), strict=True)
    return [[curve.name, curve.statistic, *row[:5], curve.unit, *row[5:]] for row in rows]


def _surface_table(surface: Surface, _: float) -> tuple[Sequence[Column], list[list[Any]]]:
    kept = spread(surface.tau.size, MAX_SURFACE_TIMES)
    heads = (Column(say("time [s]"), form=".6g"), *(Column(f"{surface.tau[j]:.4g} s") for j in kept))
    numbers = zip(surface.time, surface.deviation[:, kept].tolist(), strict=True)
    return heads, [[time, *(rounded(value) or "-" for value in row)] for time, row in numbers]


FORMS: dict[type, NumbersForm] = {
    Curve: NumbersForm(
        lambda curve: say("{statistic} in {unit}", statistic=statistic_named(curve.statistic).title, unit=curve.unit),
        _curve_table,
        ("channel", "statistic", "m", "tau_s", "deviation", "low", "high", "unit", "edf", "count", "alpha"),
        _curve_lines,
        lambda curves, fits, level: (figures.plot_panels if len(curves) == 1 else figures.plot_overlay)(
            [figures.CurvePanel(curve.name, curve, fits.get(curve.name)) for curve in curves], level=level
        ),
    ),
    Spectrum: NumbersForm(
        lambda found: (
            say("one-sided power spectral density in {unit}, {method}", unit=found.density_unit, method=found.method)
            if found.sides == "one" else
            say("two-sided power spectral density in {unit}, {method}", unit=found.density_unit, method=found.method)
        ),
        lambda found, level: (
            (Column("f [Hz]", form=".5g"), Column(f"[{found.density_unit}]"), Column(words.interval(level), "interval"),
             Column(f"[{found.amplitude_unit}]", form=".4g"), Column("dof", form=".4g")),
            [[f, *digits(*size).plain(), amplitude, dof] for f, *size, amplitude, dof in found.rows(level)[1]],
        ),
        ("channel", "frequency_hz", "density", "low", "high", "unit", "sides", "amplitude", "amplitude_unit", "dof"),
        lambda found, level: [
            [found.name, *density, found.density_unit, found.sides, amplitude, found.amplitude_unit, dof]
            for *density, amplitude, dof in found.rows(level)[1]
        ],
        lambda spectra, fits, level: figures.plot_spectra(spectra, fits, level=level),
    ),
    Surface: NumbersForm(
        lambda surface: say(
            "{statistic} in {unit}, windows of {length:g} s every {step:g} s", step=surface.step,
            statistic=statistic_named(surface.statistic).title, unit=surface.unit, length=surface.window,
        ),
        _surface_table, ("channel", "statistic", "time_s", "m", "tau_s", "deviation", "unit", "count"),
        lambda surface, _: [
            [surface.name, surface.statistic, *at, "" if np.isnan(value) else value, surface.unit, count]
            for *at, value, count in surface.rows()[1]
        ],
        lambda surfaces, fits, level: figures.plot_surfaces(surfaces),
    ),
}  # fmt: skip


def _plot_one(values: Sequence[Any], fit: Fit | None, level: float) -> Plot:
    kinds = {type(value) for value in values}
    if len(kinds) > 1:
        names = " and ".join(sorted(kind.__name__ for kind in kinds))
        raise UsageError(f"values of one kind are drawn together, not {names}")
    fits = {value.name: fit for value in values} if fit is not None else {}
    return FORMS[type(values[0])].plot(values, fits, level)


@view(_plot_one, lambda value, level: rows_of([value], level))
def value_view(value: Curve | Spectrum | Surface, level: float) -> Face:
    """A curve, a spectrum or a surface: its figure and its numbers."""
    return one_sheet(
        say("{channel}: {statistic}", channel=value.name, statistic=_title(value)) if value.name else _title(value),
        BRAND, value.name or say("channel"),
        (Drawing(lambda: FORMS[type(value)].plot([value], {}, level), _title(value), _supposed(value)),
         numbers_table(value, level)),
        about=tuple(value.history),
    )  # fmt: skip


READINGS_KEY = say(
    "Read off the overlapping Allan deviation, as data sheets do. No model is assumed; the intervals "
    "use the power law identified at each averaging time. The deviation at 1 s equals the random walk coefficient only "
    "where the curve has slope -0.5."
)


def readings_table(readings: Readings, level: float) -> Table:
    """Values read off a curve, in the units of data sheets."""
    heads = (Column(say("read off the curve"), "name"), Column(say("value")), Column(words.interval(level), "interval"),
        Column(say("unit"), "unit"), Column("", "name"))  # fmt: skip
    rows = []
    for title, _, value, low, high, unit, *_, remark in readings.rows(level)[1]:
        slope = (f"{value:.3f}", f"{low:.3f} .. {high:.3f}")  # which has no unit
        rows.append([title, *(digits(value, low, high).plain() if unit else slope), unit, remark])
    return Table(heads, rows, key=READINGS_KEY)


@view(rows=lambda readings, level: readings.rows(level))
def readings_view(readings: Readings, level: float) -> Face:
    """Values read off a curve."""
    return Face(say("Readings"), say("read off the Allan deviation"),
        (Sheet(say("readings"), parts=(readings_table(readings, level),)),))  # fmt: skip


MAX_ROWS = 12  # rows of all tables together
MAX_WITH_INTERVALS, MAX_BESIDE = 3, 6  # channels side by side with their intervals, and without


def tables_of(values: Sequence[Any], level: float, rows: int = MAX_ROWS) -> Iterator[Table | str]:
    """A table for each statistic, of so many rows together: a column for each channel with the averaging times."""
    alike: dict[tuple[str, tuple[float, ...]], list[Any]] = {}
    for value in values:
        at, title = tuple(_at(value).tolist()), _heading(value)
        known = (key for key in alike if key[0] == title and {*at} <= {*key[1]})
        alike.setdefault(next(known, (title, at)), []).append(value)
    groups = [
        (title, same[i : i + wide])
        for (title, _), same in alike.items()
        for wide in (MAX_BESIDE if len(same) > MAX_WITH_INTERVALS else MAX_WITH_INTERVALS,)
        for i in range(0, len(same), wide)
    ]
    for title, group in groups:
        table = _side_by_side(group, level, rows // len(groups), bare=len(group) > MAX_WITH_INTERVALS)
        count, every = len(table.rows), len(_at(group[0]))
        some = say("{title}, {count} of {every} rows", title=title, count=count, every=every)
        yield some if count < every else title
        yield table


def _at(value: Curve | Spectrum | Surface) -> FloatArray:
    """The averaging times or frequencies of the rows."""
    return value.frequency if isinstance(value, Spectrum) else value.tau


def _heading(value: Curve | Spectrum | Surface) -> str:
    if isinstance(value, Spectrum):
        unit = printed_unit(value.amplitude_unit)
        if value.sides == "one":
            return say("one-sided amplitude spectral density in {unit}", unit=unit)
        return say("two-sided amplitude spectral density in {unit}", unit=unit)
    title = FORMS[type(value)].title(value)
    return say("{title}: least to greatest", title=title) if isinstance(value, Surface) else title


def _side_by_side(values: Sequence[Any], level: float, rows: int, *, bare: bool) -> Table:
    columns = [_cells(value, level, bare=bare) for value in values]
    at = list(columns[0])
    axis = "f [Hz]" if isinstance(values[0], Spectrum) else "tau [s]"
    heads = [Column(axis, form=lambda at: f"{at:.4g}" if at < 1e4 else f"{at:.0f}")]
    heads += [Column(value.name or say("channel"), "name") for value in values]
    return Table(heads, [[at[i], *(cells.get(at[i], "") for cells in columns)] for i in spread(len(at), rows)])


def _cells(value: Curve | Spectrum | Surface, level: float, *, bare: bool) -> dict[float, str]:
    """What was found at each averaging time or frequency."""
    if isinstance(value, Surface):
        ends = zip(np.nanmin(value.deviation, axis=0), np.nanmax(value.deviation, axis=0), strict=True)
        ranges: list[str] = [say("{low} to {high}", low=rounded(float(a)), high=rounded(float(b))) for a, b in ends]
        return dict(zip(value.tau.tolist(), ranges, strict=True))
    if isinstance(value, Spectrum):
        size, limits = value.amplitude, np.sqrt(value.interval(level))
    else:
        size = value.deviation
        limits = np.array(value.interval(level)) if value.law is not None else np.full((2, size.size), np.nan)
    numbers = [digits(*v) for v in zip(size.tolist(), *limits.tolist(), strict=True)]
    cells = [number.plain()[0] if bare else number.words() for number in numbers]
    return dict(zip(_at(value).tolist(), cells, strict=True))
