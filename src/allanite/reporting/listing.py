"""A survey as text for the terminal: a short table of each value; the whole of it goes into a file."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.text import Text

from allanite.core.curve import Curve
from allanite.core.spectrum import Spectrum
from allanite.core.surface import Surface
from allanite.statistics import STATISTICS
from allanite.study.survey import Survey

from . import words
from .digits import digits
from .text import header, printed, prose

FloatArray = NDArray[np.float64]
Cells = tuple[list[str], list[list[str]]]
"""Headings and rows."""

MOST_ROWS, MOST_COLUMNS = 28, 8
"""Rows of a table, and averaging times of a surface, that are printed."""

MANY_ROWS = 1000
"""Rows from which on those that are printed are spread by ratio: a curve of every averaging time."""


def render(survey: Survey, *, width: int = 120, color: bool = False) -> str:
    """The survey as text; see `allanite.reporting.table`."""
    return printed(_lines(survey, width), width=width, color=color)


def _lines(survey: Survey, width: int) -> Iterator[Text]:
    yield from header(survey, "", width)
    told = set()
    for value in survey.values:
        title, size, cells = _FORMS[type(value)]
        count = size(value)
        headings, rows = cells(value, survey.recipe.level, _few(count, MOST_ROWS))
        yield Text()
        yield Text(words.printable(value.name) or "channel", style="bold") + Text(f"  {title(value)}", "not bold dim")
        for alert in survey.alerts[value.name] if value.name not in told else ():
            yield from prose(alert, width, first="  ! ", indent=4, style="bold red")
        told.add(value.name)
        yield from _table(headings, rows)
        if len(rows) < count:
            yield Text(f"  {len(rows)} of {count} rows; --csv writes all", style="dim")
    for name, refusal in survey.refusals.items():
        yield Text()
        yield Text(words.printable(name) or "channel", style="bold")
        yield from prose(f"no result: {refusal}", width, first="  ! ", indent=4, style="bold red")


def _table(headings: list[str], rows: list[list[str]]) -> Iterator[Text]:
    widths = [max(map(len, column)) for column in zip(headings, *rows, strict=True)]

    def line(cells: list[str]) -> str:
        return "  " + "  ".join(cell.rjust(width) for cell, width in zip(cells, widths, strict=True))

    yield Text(line(headings).rstrip(), style="dim")
    for row in rows:
        yield Text(line(row).rstrip())


def _few(count: int, most: int) -> list[int]:
    """Indices of at most so many items, evenly spread, the first and the last among them; of very many by ratio."""
    if count > MANY_ROWS:
        return (np.unique(np.rint(np.geomspace(1, count, most))).astype(np.int64) - 1).tolist()  # type: ignore[no-any-return]
    return [round(i) for i in np.linspace(0, count - 1, min(most, count))]


def _curve(curve: Curve, level: float, keep: list[int]) -> Cells:
    m, tau, deviation, count = (values[keep] for values in (curve.m, curve.tau, curve.deviation, curve.count))
    if curve.law is None:
        rows = zip(m, tau, deviation, count, strict=True)
        cells = [[str(m), f"{tau:.6g}", *_number(value), str(n)] for m, tau, value, n in rows]
        return ["m", "tau [s]", f"[{curve.unit}]", "count"], cells
    limits = zip(*(v[keep].tolist() for v in (curve.deviation, *curve.interval(level), curve.edf)), strict=True)
    cells = [
        [str(m), f"{tau:.6g}", *digits(value, low, high).plain(), f"{edf:.4g}", str(n)]
        for m, tau, n, (value, low, high, edf) in zip(m, tau, count, limits, strict=True)
    ]
    return ["m", "tau [s]", f"[{curve.unit}]", _interval(level), "edf", "count"], cells


def _spectrum(spectrum: Spectrum, level: float, keep: list[int]) -> Cells:
    rows = spectrum.rows(level)[1]
    cells = [
        [f"{f:.5g}", *digits(value, low, high).plain(), f"{amplitude:.4g}", f"{dof:.4g}"]
        for f, value, low, high, amplitude, dof in (rows[i] for i in keep)
    ]
    headings = ["f [Hz]", f"[{spectrum.density_unit}]", _interval(level), f"[{spectrum.amplitude_unit}]", "dof"]
    return headings, cells


def _surface(surface: Surface, _: float, keep: list[int]) -> Cells:
    columns = _few(surface.tau.size, MOST_COLUMNS)
    cells = [
        [f"{time:.6g}", *(_number(value)[0] or "-" for value in row)]
        for time, row in zip(surface.time[keep], surface.deviation[np.ix_(keep, columns)].tolist(), strict=True)
    ]
    return ["time [s]", *(f"{surface.tau[j]:.4g} s" for j in columns)], cells


def _number(value: float) -> list[str]:
    return [digits(value).plain()[0] if np.isfinite(value) else ""]


def _interval(level: float) -> str:
    return f"{words.percent(level)} interval"


def _curve_title(curve: Curve) -> str:
    return f"{STATISTICS[curve.statistic].title} in {curve.unit}"


def _spectrum_title(spectrum: Spectrum) -> str:
    return f"{spectrum.sides}-sided density in {spectrum.density_unit}, {spectrum.method}"


def _surface_title(surface: Surface) -> str:
    title = f"{STATISTICS[surface.statistic].title} in {surface.unit}"
    return f"{title}, windows of {surface.window:g} s every {surface.step:g} s"


_FORMS: dict[type, tuple[Callable[[Any], str], Callable[[Any], int], Callable[[Any, float, list[int]], Cells]]] = {
    Curve: (_curve_title, lambda curve: int(curve.m.size), _curve),
    Spectrum: (_spectrum_title, lambda spectrum: int(spectrum.frequency.size), _spectrum),
    Surface: (_surface_title, lambda surface: int(surface.time.size), _surface),
}
"""Title, number of rows, and cells of some of them, by what is measured."""
