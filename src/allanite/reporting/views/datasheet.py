"""The data sheet of a channel, the card at the top of its page, and the words in place of its figure."""

from collections.abc import Iterator

import numpy as np

from allanite.core.curve import Curve
from allanite.core.datasheet import DataSheetRow
from allanite.core.display_units import readable_unit
from allanite.core.estimate import Estimate
from allanite.core.units import convert
from allanite.core.validity import APPROXIMATE, EXPLAINED, UNEXPLAINED, graded
from allanite.phrases.phrase import join, say
from allanite.reporting import words
from allanite.reporting.digits import digits, printed_unit
from allanite.reporting.sheet import Card, Column, Mark, Table, known
from allanite.statistics import statistic_named
from allanite.study.results import Channel

from .axes import cell_of

DATA_SHEET = say(
    "N is the square root of the two-sided power spectral density of white noise; a one-sided density, as of most "
    "spectrum analyzers and many data sheets, is larger by the square root of 2. The flat part of an Allan deviation "
    "lies at 0.664 B. N-second stability is the standard deviation of successive means."
)
SIGNS = {EXPLAINED: "✓", APPROXIMATE: "≈", UNEXPLAINED: "✗"}
LEVELS = {EXPLAINED: "good", APPROXIMATE: "fair", UNEXPLAINED: "alert"}


def data_sheet_table(channel: Channel, level: float) -> Table:
    """The quantities of data sheets that no table of coefficients has, each in one unit, with intervals."""
    heads = (
        Column(say("quantity"), "name"), Column(say("value")), Column(words.interval(level), "interval"),
        Column(say("unit"), "unit"), Column(say("at"), "name", aside=True, form=known(".4g", unit=" s")),
        Column(say("remark"), "text", aside=True),
    )  # fmt: skip
    rows = []
    found = dict[str, DataSheetRow]()
    for entry in channel.data_sheet(level):
        found |= {} if entry.coefficient or entry.quantity in found else {entry.quantity: entry}
    for entry in found.values():
        low, high = (np.nan if limit is None else limit for limit in (entry.low, entry.high))
        shown: tuple[str, str] = "", ""
        if entry.value is not None:
            shown = digits(entry.value, low, high).plain()
        elif entry.high is not None:  # of a term that was not found its limit
            shown = "", say("below {limit}", limit=digits(high, figures=2).plain()[0])
        unit = entry.unit if entry.high or entry.value else ""
        rows.append([entry.quantity, *shown, unit, entry.tau, entry.remark])
    marks: list[Mark] = ["" if row[1] else "quiet" for row in rows]
    return Table(heads, rows, say("data sheet"), marks=marks)


def card_of(channel: Channel, level: float) -> Card | None:
    """The main numbers of a channel; None where nothing was asked."""
    if channel.fit is None:
        return Card(say("✗ no result"), "alert", note=channel.refusal) if channel.refusal else None
    grade = channel.noise.validity if channel.noise else ""
    badge = join(" ", (SIGNS[grade], graded(grade, channel.fit.scope))) if grade else ""
    if grade == UNEXPLAINED:
        points = channel.noise.statement.points if channel.noise else ()
        return Card(badge, "alert", tuple(_capital(channel)), join("; ", (say("Coefficients not valid"), *points[:1])))
    rows = []
    for e in (e for e in channel.fit if e.valued):
        # with the half width of its interval as a share: ``0.119 deg/√h ± 1 %``
        low, high = e.interval(level)
        share = 50 * (high - low) / abs(e.value or np.nan)
        number: str = words.number(e, level) + (f" ± {share:.2g} %" if np.isfinite(share) else "")
        number = say("{value}, weak", value=number) if e.status == "weak" else number
        name = say("{term} ({symbol})", term=words.title(e.symbol, e.signal), symbol=words.symbol(e))
        rows.append((words.capital(name), number))
    others = [_without_value(e, level) for e in channel.fit if not e.valued]
    length = words.duration(channel.record.duration)
    note = say("Not identified in {length}: {symbols}", length=length, symbols=join(", ", others)) if others else ""
    return Card(badge, LEVELS.get(grade, ""), (*rows, *_capital(channel)), note)  # type: ignore[arg-type]


def _without_value(estimate: Estimate, level: float) -> str:
    """A term that was not identified: its limit, or why there is none."""
    cell, symbol = cell_of(estimate, level), words.symbol(estimate)
    limited = words.limit(estimate, estimate.sheet_unit) is not None
    lead = "" if cell.startswith("|") else symbol
    return join(" ", filter(None, (lead, cell, printed_unit(estimate.sheet_unit) if limited else "")))


def _minimum(channel: Channel) -> Iterator[tuple[str, str]]:
    readings = channel.readings
    if readings is None or readings.minimum is None:
        return
    unit = readings.shown_unit(0)
    number = digits(convert(readings.minimum.deviation, readings.unit, unit), figures=3).pretty()
    most = "" if readings.inside else "≤ "
    size, tau = f"{most}{number} {unit}", readings.minimum.tau
    yield say("in-run bias stability"), say("{value} at {tau}", value=size, tau=words.averaging(tau))


def _capital(channel: Channel) -> Iterator[tuple[str, str]]:
    """The rows of a card."""
    yield from ((words.capital(name), value) for name, value in _minimum(channel))


def alternative(channel: Channel, curve: Curve, level: float) -> str:
    """Description of a figure: the ends of the curve, its minimum, the coefficients."""
    shown = curve.to(readable_unit(curve.unit))
    unit = shown.unit
    ends = say(
        "{statistic} of {channel}: {first:.3g} {unit} at {start:.4g} s and {last:.3g} {unit} at {end:.4g} s",
        statistic=statistic_named(curve.statistic).title, channel=channel.record.name or say("the channel"), unit=unit,
        first=shown.deviation[0], start=shown.tau[0], last=shown.deviation[-1], end=shown.tau[-1],
    )  # fmt: skip
    said: list[str] = [words.capital(ends)]
    said += [join(" ", row) for row in _minimum(channel)]
    if channel.fit is not None:
        said += [
            join(" = ", (words.symbol(e), words.in_print(e, e.sheet_unit, level))) for e in channel.fit if e.claimed
        ]
        said += [words.grade(channel.fit)]
    return join("; ", filter(None, said))
