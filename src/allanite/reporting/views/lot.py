"""How a lot is shown: its units, then distributions, trends and units that differ from the others."""

from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

from allanite.batch.lot import DAY, FEWEST, Lot, detectable
from allanite.batch.sources import DATE
from allanite.phrases.phrase import say, say_count
from allanite.reporting import figures
from allanite.reporting.digits import rounded
from allanite.reporting.sheet import Column, Drawing, Face, Mark, Note, Part, Table

from . import view
from .batch import ALL_ROWS, batch_view, symbol_of

CAPTION = say(
    "The values of each coefficient in ascending order, and over temperature and date where these are given, with a "
    "straight line: red if its slope differs from zero."
)
OUTLYING_KEY = say(
    "A unit is outlying if the logarithm of its value differs from those of the others by more than a normal "
    "distribution explains (generalized extreme studentized deviate); one coefficient in twenty of a uniform lot has "
    "one."
)
TREND_KEY = say(
    "Slope of a straight line through the values of the units, with its 95 % interval; one coefficient in twenty shows "
    "a trend by chance."
)

TERM, UNIT = (Column(say("channel"), "name"), Column(say("term"), "symbol")), Column("", "unit")


def _parts(lot: Lot) -> Iterator[Part]:
    if _drawn(lot):
        yield Drawing(lambda: figures.plot_lot(_drawn(lot)), say("values of all units"), CAPTION)
    rows: list[list[Any]] = [
        [row.channel, symbol_of(row.symbol), row.values.size,
         *(value / row.factor for value in (row.low, row.median, row.high)), row.sheet_unit]
        for row in lot.distributions if row.values.size >= FEWEST
    ]  # fmt: skip
    if rows:
        shares = (Column(f"{share} %", form=rounded) for share in (10, 50, 90))
        title = say("quantiles of the units in which the term was identified")
        yield Table((*TERM, Column(say("units")), *shares, UNIT), rows, title, most=ALL_ROWS)
    if lot.trends:
        yield _trends_table(lot)
    if lot.outlying:
        heads = (Column(say("file"), "name"), *TERM, Column(say("value"), form=rounded),
                 Column(say("median"), form=rounded), UNIT)  # fmt: skip
        rows = [[lot.batch.label(lot.batch[row.file]), row.channel, symbol_of(row.symbol), row.value / row.factor,
            row.median / row.factor, row.sheet_unit] for row in lot.outlying]  # fmt: skip
        yield Table(heads, rows, say("outlying units"), key=OUTLYING_KEY, most=ALL_ROWS)
    yield from _tested(lot)


def _trends_table(lot: Lot) -> Table:
    heads = (*TERM, Column(say("against"), "name"), Column(say("units")), Column(say("slope"), form=rounded),
        Column(say("interval"), "interval"), UNIT)  # fmt: skip
    rows = []
    for course in lot.trends:
        slope, low, high = (value * course.step / course.factor for value in (course.slope, course.low, course.high))
        along, each = (say("date"), say("day")) if course.along == DATE else (say("temperature"), "K")
        unit = say("{unit} per {step}", unit=course.sheet_unit, step=each)
        interval = f"{rounded(low)} .. {rounded(high)}"
        rows.append([course.channel, symbol_of(course.symbol), along, course.values.size, slope, interval, unit])
    marks: list[Mark] = ["alarm" if trend.shown else "" for trend in lot.trends]
    return Table(heads, rows, say("trends"), marks, TREND_KEY, most=ALL_ROWS)


def _tested(lot: Lot) -> Iterator[Note]:
    """Whether and how well units were tested for being outlying."""
    tested = [row.values.size for row in lot.distributions if row.tested]
    if tested and not lot.outlying:
        yield Note(say("No unit is outlying."), "good")
    if tested:
        text = say_count(
            len(tested),
            "{count} coefficient of {all} was tested for outlying units: of {fewest} units one is found that lies "
            "{distance:.2g} standard deviations away from the others.",
            "{count} coefficients of {all} were tested for outlying units: of {fewest} units one is found that lies "
            "{distance:.2g} standard deviations away from the others.",
            all=len(lot.distributions), fewest=min(tested), distance=detectable(min(tested)),
        )  # fmt: skip
        yield Note(text, "quiet")
    elif lot.distributions:
        none = say("Not tested for outlying units: no coefficient has values of {fewest} units.", fewest=FEWEST)
        yield Note(none, "fair")


def _drawn(lot: Lot) -> "list[figures.LotRow]":
    """What is drawn: the coefficients with several values."""
    drawn = []
    for row in lot.distributions:
        courses: dict[str, figures.Course] = {}
        own = (t for t in lot.trends if (t.channel, t.symbol, t.signal) == (row.channel, row.symbol, row.signal))
        for trend in own:
            start, label = 0.0, say("temperature (°C)")
            if trend.along == DATE:
                start = float(trend.at.min() // DAY * DAY)
                label = say("days since {date}", date=datetime.fromtimestamp(start, UTC).date().isoformat())
            at, values = (trend.at - start) / trend.step, trend.values / trend.factor
            courses[label] = figures.Course(at, values, trend.slope * trend.step / trend.factor, trend.shown)
        symbol, values = symbol_of(row.symbol), row.values / row.factor
        if values.size > 1:
            drawn.append(figures.LotRow(row.channel, symbol, row.sheet_unit, values, courses))
    return drawn


_UNITS = batch_view.through(lambda lot: lot.batch)


@view(_UNITS.plot, _UNITS.rows, _UNITS.coefficients, _UNITS.first)
def lot_view(lot: Lot, level: float) -> Face:
    """The units of a lot, then distributions, trends and units that differ from the others."""
    face = _UNITS.face(lot, level)
    return replace(face, parts=[*face.parts, *_parts(lot)])
