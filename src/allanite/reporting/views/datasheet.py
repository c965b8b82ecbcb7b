"""The data sheet of a channel, the card at the top of its page, and the words in place of its figure."""

from collections.abc import Iterator

import numpy as np

from allanite.core.curve import Curve
from allanite.core.datasheet import Entry
from allanite.core.estimate import Estimate
from allanite.core.scope import APPROXIMATE, EXPLAINED, UNEXPLAINED, graded
from allanite.core.units import convert, readable_unit
from allanite.reporting import words
from allanite.reporting.digits import digits
from allanite.reporting.sheet import Card, Column, Mark, Table, printed_unit
from allanite.statistics import STATISTICS
from allanite.study.analysis import Channel

KEY = (
    "N is the square root of the two-sided power spectral density of white noise; a one-sided density, as of most "
    "spectrum analyzers and many data sheets, is larger by the square root of 2. The flat part of an Allan deviation "
    "lies at 0.664 B. N-second stability is the standard deviation of successive means."
)
SIGNS = {EXPLAINED: "✓", APPROXIMATE: "≈", UNEXPLAINED: "✗"}
LEVELS = {EXPLAINED: "good", APPROXIMATE: "fair", UNEXPLAINED: "alert"}


def data_sheet_table(channel: Channel, level: float, *, whole: bool = True) -> Table:
    """The quantities and units that data sheets quote, with intervals; else those that no table of coefficients has."""
    heads = (
        Column("quantity", "name"), Column("value"), Column(words.interval(level), "interval"), Column("unit", "unit"),
        Column("at", "name", aside=True), Column("remark", "text", aside=True),
    )  # fmt: skip
    rows = [_row(entry) for entry in channel.data_sheet(level) if whole or not entry.coefficient]
    marks: list[Mark] = ["" if row[1] else "quiet" for row in rows]
    return Table(heads, rows, "data sheet", marks=marks, key=KEY)


def _row(entry: Entry) -> list[str]:
    tau = "" if entry.tau is None else f"{entry.tau:.4g} s"
    return [entry.quantity, *_number(entry), entry.unit if entry.high or entry.value else "", tau, entry.remark]


def _number(entry: Entry) -> tuple[str, str]:
    """Value and interval; of a term that was not found its limit."""
    if entry.value is None:
        return "", "" if entry.high is None else f"below {digits(entry.high, figures=2).plain()[0]}"
    if entry.low is None or entry.high is None:
        return digits(entry.value).plain()[0], ""
    return digits(entry.value, entry.low, entry.high).plain()


def card_of(channel: Channel, level: float) -> Card | None:
    """The main numbers of a channel; None where nothing was asked."""
    if channel.fit is None:
        return Card("✗ no result", "alert", note=channel.refusal) if channel.refusal else None
    grade = channel.noise.validity if channel.noise else ""
    badge = f"{SIGNS[grade]} {graded(grade, channel.fit.scope)}" if grade else ""
    if grade == UNEXPLAINED:
        points = channel.noise.statement.points if channel.noise else ()
        return Card(badge, "alert", tuple(_minimum(channel)), "; ".join(("Coefficients not valid", *points[:1])))
    rows = [(_short(e), _with_share(e, level)) for e in channel.fit if e.valued]
    absent = [e.symbol for e in channel.fit if e.status == "absent"]
    length = words.duration(channel.record.duration)
    note = f"Not identified in {length}: {', '.join(absent)}" if absent else ""
    return Card(badge, LEVELS.get(grade, ""), (*rows, *_minimum(channel)), note)  # type: ignore[arg-type]


def _short(e: Estimate) -> str:
    title = words.title(e.symbol, e.signal)
    return f"{title[:1].upper()}{title[1:]} ({words.symbol(e)})"


def _with_share(e: Estimate, level: float) -> str:
    """A coefficient with the half width of its interval as a share: ``0.119 deg/√h ± 1 %``."""
    low, high = e.interval(level)
    share = 50 * (high - low) / abs(e.value or np.nan)
    weak = ", weak" if e.status == "weak" else ""
    return words.number(e, level) + (f" ± {share:.2g} %" if np.isfinite(share) else "") + weak


def _minimum(channel: Channel) -> Iterator[tuple[str, str]]:
    readings = channel.readings
    if readings is None or readings.minimum is None:
        return
    unit = readings.shown_unit(0)
    number = digits(convert(readings.minimum.deviation, readings.unit, unit), figures=3).pretty()
    most = "" if readings.inside else "≤ "
    yield "In-run bias stability", f"{most}{number} {printed_unit(unit)} at {readings.minimum.tau:.3g} s"


def alternative(channel: Channel, curve: Curve, level: float) -> str:
    """Description of a figure: the ends of the curve, its minimum, the coefficients."""
    shown = curve.to(readable_unit(curve.unit))
    title = STATISTICS[curve.statistic].title
    unit = printed_unit(shown.unit)
    ends = " and ".join(f"{shown.deviation[i]:.3g} {unit} at {shown.tau[i]:.4g} s" for i in (0, -1))
    said = [f"{title[:1].upper()}{title[1:]} of {channel.record.name or 'the channel'}: {ends}"]
    said += [f"{name[:1].lower()}{name[1:]} {value}" for name, value in _minimum(channel)]
    if channel.fit is not None:
        said += [f"{words.symbol(e)} = {words.in_print(e, e.sheet_unit, level)}" for e in channel.fit if e.claimed]
        said += [words.grade(channel.fit)]
    return "; ".join(filter(None, said))
