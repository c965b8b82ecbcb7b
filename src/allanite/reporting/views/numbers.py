"""The first screen of curves, spectra and surfaces, channels side by side; statistics of a recording."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.curve import Curve, Surface
from allanite.core.fit import Fit
from allanite.core.spectrum import Spectrum
from allanite.phrases.phrase import join, say
from allanite.reporting.digits import digits, printed_unit, rounded
from allanite.reporting.first import First
from allanite.reporting.sheet import Column, Drawing, Face, Plot, Table
from allanite.reporting.text import spread
from allanite.study.survey import Survey

from . import view
from .axes import how_read, title_of
from .jobs import alerts, channel_sheet, doubts, job_face, source_of
from .values import BRAND, FORMS, numbers_table, rows_of

ROWS = 12
"""Rows of all tables together."""

BESIDE, BARE = 3, 6
"""Channels side by side with their intervals, and without."""


def first_of_survey(survey: Survey, level: float) -> First:
    """The values of every channel, at averaging times or frequencies that are spread evenly."""
    after = [("--plot curve.png", say("figure")), ("--csv FILE", say("all values")), ("--details", say("edf"))]
    answer = list(tables_of(survey.values, level))
    return First(title_of(survey), "", answer, [*doubts(survey.channels), *alerts(survey)], (), how_read(survey), after)


def tables_of(values: Sequence[Any], level: float, rows: int = ROWS) -> Iterator[Table | str]:
    """A table for each statistic, of so many rows together: a column for each channel with the averaging times."""
    alike: dict[tuple[str, tuple[float, ...]], list[Any]] = {}
    for value in values:
        at, title = tuple(_at(value).tolist()), _heading(value)
        known = (key for key in alike if key[0] == title and {*at} <= {*key[1]})
        alike.setdefault(next(known, (title, at)), []).append(value)
    groups = [
        (title, found[i : i + wide])
        for (title, _), found in alike.items()
        for wide in (BARE if len(found) > BESIDE else BESIDE,)
        for i in range(0, len(found), wide)
    ]
    for title, group in groups:
        yield title
        yield _table(group, level, rows // len(groups), bare=len(group) > BESIDE)


def _at(value: Curve | Spectrum | Surface) -> FloatArray:
    """The averaging times or frequencies of the rows."""
    return value.frequency if isinstance(value, Spectrum) else value.tau


def _heading(value: Curve | Spectrum | Surface) -> str:
    if isinstance(value, Spectrum):
        unit = printed_unit(value.amplitude_unit)
        if value.sides == "one":
            return say("one-sided amplitude spectral density in {unit}", unit=unit)
        return say("two-sided amplitude spectral density in {unit}", unit=unit)
    if isinstance(value, Surface):
        return say("{title}: least to greatest", title=FORMS[Surface].title(value))
    return FORMS[type(value)].title(value)


def _table(values: Sequence[Any], level: float, rows: int, *, bare: bool) -> Table:
    found = [_numbers(value, level, bare=bare) for value in values]
    at = list(found[0])
    heads = [
        Column(
            "f [Hz]" if isinstance(values[0], Spectrum) else "tau [s]",
            form=lambda at: f"{at:.4g}" if at < 1e4 else f"{at:.0f}",
        ),
        *(Column(value.name or say("channel"), "name") for value in values),
    ]
    return Table(heads, [[at[i], *(cells.get(at[i], "") for cells in found)] for i in spread(len(at), rows)])


def _numbers(value: Curve | Spectrum | Surface, level: float, *, bare: bool) -> dict[float, str]:
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
    numbers = [digits(*v).plain() for v in zip(size.tolist(), *limits.tolist(), strict=True)]
    said = [number if bare or not interval else f"{number} ({interval})" for number, interval in numbers]
    return dict(zip(_at(value).tolist(), said, strict=True))


def _plot(values: Sequence[Survey], fit: Fit | None, level: float) -> Plot:
    shown = [value for survey in values for value in survey.values]
    fits = {name: found for survey in values for name, found in survey.fits.items()}
    return FORMS[type(shown[0])].plot(shown, fits, level)


@view(_plot, lambda survey, level: rows_of(survey.values, level), first=first_of_survey)
def survey_view(survey: Survey, level: float) -> Face:
    """The statistics of each channel."""
    sheets = [channel_sheet(c, [numbers_table(value, level) for value in c.values]) for c in survey]
    names = ", ".join(dict.fromkeys(value.name for value in survey.values if value.name))
    titles = join("; ", dict.fromkeys(FORMS[type(value)].title(value) for value in survey.values))
    drawing = Drawing(
        lambda: _plot([survey], None, level),
        say("{titles}, of {channels}", titles=titles, channels=names) if names else titles,
    )
    return job_face(survey, (source_of(survey), BRAND), sheets, [drawing])
