"""Data sheets: of a channel as it was measured, and of a type as its maker states it."""

from collections.abc import Iterator

import numpy as np

from allanite.comparison.sheet import Measured, SheetComparison
from allanite.core.curve import Curve
from allanite.core.display_units import readable_unit
from allanite.core.readings import FALLING_SIGN, IN_RUN, DataSheetRow
from allanite.core.units import signal_named
from allanite.phrases.phrase import join, say
from allanite.planning.datasheets import QUANTITIES, SENSOR_TYPES, Claim, DataSheet
from allanite.reporting import words
from allanite.reporting.digits import digits, printed_unit, rounded, upper_limit
from allanite.reporting.first import DETAILS, ChannelRow, Channels, First, Remark, merged, plus_minus
from allanite.reporting.sheet import Column, Face, Mark, Note, Part, Table, known, one_sheet
from allanite.statistics import statistic_named
from allanite.study.results import Channel

from . import Rows, view
from .jobs import OUTCOME_WORDS, channel_sheet, job_face, source_of

DATA_SHEET = say(
    "N is the square root of the two-sided power spectral density of white noise; a one-sided density, as of most "
    "spectrum analyzers and many data sheets, is larger by the square root of 2. The flat part of an Allan deviation "
    "lies at 0.664 B. N-second stability is the standard deviation of successive means."
)


def data_sheet_table(channel: Channel, level: float) -> Table:
    """The quantities of data sheets that no table of coefficients has, each in one unit, with intervals."""
    heads = (
        Column(say("quantity"), "name"), Column(say("value")), Column(words.interval(level), "interval"),
        Column(say("unit"), "unit"), Column(say("at"), "name", aside=True, form=known(".4g", unit=" s")),
        Column(say("remark"), "text", aside=True),
    )  # fmt: skip
    rows = []
    entries = dict[str, DataSheetRow]()
    for entry in channel.data_sheet(level):
        entries |= {} if entry.coefficient or entry.quantity in entries else {entry.quantity: entry}
    for entry in entries.values():
        low, high = (np.nan if limit is None else limit for limit in (entry.low, entry.high))
        shown: tuple[str, str] = "", ""
        if entry.value is not None:
            shown = digits(entry.value, low, high).plain()
        elif entry.high is not None:  # of a term that was not found its limit
            shown = "", say("below {limit}", limit=upper_limit(high).plain()[0])
        unit = entry.unit if entry.high or entry.value else ""
        rows.append([entry.quantity, *shown, unit, entry.tau, entry.remark])
    marks: list[Mark] = ["" if row[1] else "quiet" for row in rows]
    return Table(heads, rows, say("data sheet"), marks=marks)


def alternative(channel: Channel, curve: Curve, level: float) -> str:
    """Description of a figure: the ends of the curve, its minimum, the coefficients."""
    shown = curve.to(readable_unit(curve.unit))
    unit = shown.unit
    ends = say(
        "{statistic} of {channel}: {first:.3g} {unit} at {start:.4g} s and {last:.3g} {unit} at {end:.4g} s",
        statistic=statistic_named(curve.statistic).title, channel=channel.record.name or say("the channel"), unit=unit,
        first=shown.deviation[0], start=shown.tau[0], last=shown.deviation[-1], end=shown.tau[-1],
    )  # fmt: skip
    sentences: list[str] = [words.capital(ends)]
    lowest = "" if channel.readings is None else channel.readings.lowest_words(level, pretty=True)
    sentences += [join(" ", (IN_RUN, lowest))] if lowest else []
    if channel.fit is not None:
        sentences += [
            join(" = ", (words.symbol(e), words.in_print(e, e.sheet_unit, level))) for e in channel.fit if e.claimed
        ]
        sentences += [words.grade(channel.fit)]
    return join("; ", filter(None, sentences))


BRAND = say("noise in a data sheet")
LIMITS = {"typical": say("typical"), "nominal": say("nominal"), "maximum": say("maximum"), "": ""}
"""What kind of value is printed."""


def first_of_sheet(value: DataSheet, _: float) -> First:
    """The models of a data sheet, and the lines from which they are made."""
    answer: list[str | Table] = list(_models(value))
    rows = [[c.printed, *_size(c), LIMITS[c.limit], c.place] for c in value.claims if c.limit != "maximum"]
    answer.append(Table([Column("", "name"), *[Column("", "text")] * 4], rows))
    after = ((f"allanite export --datasheet {value.name} --to kalibr", say("a file of a filter")),
        (f"allanite compare FILE --datasheet {value.name}", say("what was measured beside it")), DETAILS)  # fmt: skip
    return First(join(" ", (value.maker, value.name)), value.document, answer, after=after)


@view(rows=lambda value, _: _sheet_rows(value), first=first_of_sheet)
def sheet_view(value: DataSheet, _: float) -> Face:
    """The lines of a data sheet, with the coefficients that follow from them."""
    heads = (
        Column(say("sensor"), "text"), Column(say("quantity"), "name"), Column(say("value")),
        Column(say("unit"), "unit"), Column("", "text"), Column(say("conditions"), "text"),
        Column(say("place"), "text"), Column(say("is"), "text"),
    )  # fmt: skip
    rows = [[signal_named(c.sensor).name, c.printed, *_size(c), LIMITS[c.limit], c.conditions, c.place,
        printed_unit(str(c.term or ""))] for c in value.claims]  # fmt: skip
    means = dict.fromkeys(QUANTITIES[claim.quantity].meaning for claim in value.claims)
    parts: list[Part] = [*(Note(text, "strong") for text in _models(value)), Table(heads, rows, most=99),
        *(Note(text, "quiet") for text in means)]  # fmt: skip
    title = join(" ", (value.maker, value.name))
    return one_sheet(title, BRAND, value.name, parts, about=(say("source: {source}", source=value.document),))


def _models(value: DataSheet) -> Iterator[str]:
    return (join(": ", (model.signal.sensor, str(model))) for model in value.models)


def _sheet_rows(value: DataSheet) -> Rows:
    own = ("sensor", "quantity", "printed", "value", "unit", "limit", "conditions", "place")
    rows = [[value.name, value.maker, value.document, *(getattr(c, key) for key in own)] for c in value.claims]
    return ("name", "maker", "document", *own), rows


def _size(claim: Claim) -> tuple[str, str]:
    return f"{claim.value:g}", printed_unit(claim.unit)


def first_of_comparison(value: SheetComparison, level: float) -> First:
    """What was measured of every coefficient, beside the data sheet, and the ratio of the two."""
    tables = [axes for sensor in SENSOR_TYPES if (axes := _channels(value, sensor, level)).rows]
    alerts = [Remark.of(c.record.name, c.refusal, grave=True) for c in value if c.refusal]
    alerts += merged(Remark.of(c.record.name, alert) for c in value for alert in c.alerts)
    title = say("{file} beside the data sheet of the {sensor}", file=source_of(value), sensor=value.sheet.name)
    means = say("N: identified; B: minimum of the Allan deviation, {sign}: still falling. ±: {share} half width.",
                sign=FALLING_SIGN, share=words.percent(level))  # fmt: skip
    return First(title, value.sheet.document, tables, alerts, [("", means)], value.notes)


def _channels(value: SheetComparison, sensor: str, level: float) -> Channels:
    """The lines of which the model of the data sheet is made, by channel."""
    channels = [c for c in value if c.record.signal.name == sensor and not c.refusal]
    coefficients = [{m.claim: m for m in value.measured(channel, level)} for channel in channels]
    rows = []
    for claim in value.sheet.used(sensor) if channels else ():
        symbol = QUANTITIES[claim.quantity].symbol
        measured = [each[claim] for each in coefficients]
        rows.append(ChannelRow(claim.printed, symbol, claim.unit, [f"{claim.value:g}", *map(_shown, measured)]))
        ratios = [_ratio(m) if m.value == m.value else "" for m in measured]
        rows.append(ChannelRow(say("ratio"), "", "", ["", *ratios]))
    return Channels([say("data sheet"), *(c.record.name for c in channels)], rows, signal_named(sensor).sensor, True)


def _ratio(measured: Measured) -> str:
    """The factor on the value of the data sheet, and whether it is kept as a limit."""
    factor = f"×{digits(measured.ratio[0], figures=3).plain()[0]}"
    return join(", ", filter(None, (factor, OUTCOME_WORDS[measured.outcome])))


def _shown(measured: Measured) -> str:
    if measured.value != measured.value:
        return measured.remark
    if QUANTITIES[measured.claim.quantity].symbol != "B":
        return plus_minus(measured.value, measured.low, measured.high)
    return digits(measured.value, measured.low, measured.high).words() + f" {FALLING_SIGN}" * bool(measured.remark)


@view(rows=lambda value, level: value.rows(level), first=first_of_comparison)
def comparison_view(value: SheetComparison, level: float) -> Face:
    """Every line of the data sheet beside what was measured, by channel."""
    heads = (
        Column(say("quantity"), "name"), Column("", "text"), Column(say("data sheet")), Column(say("measured")),
        Column(words.interval(level), "interval"), Column(say("unit"), "unit"), Column(say("ratio")),
        Column(words.interval(level), "interval"), Column(say("remark"), "text"),
    )  # fmt: skip
    sheets = [channel_sheet(channel, [Table(heads, list(_rows(value, channel, level)))] if not channel.refusal else ())
        for channel in value]  # fmt: skip
    names = say("{file} beside the data sheet of the {sensor}", file=source_of(value), sensor=value.sheet.name), BRAND
    means = dict.fromkeys(QUANTITIES[claim.quantity].meaning for claim in value.sheet.claims)
    source = Note(say("source: {source}", source=join(" ", (value.sheet.maker, value.sheet.document))), "quiet")
    return job_face(value, names, sheets, [source], close=[Note(text, "quiet") for text in means])


def _rows(value: SheetComparison, channel: Channel, level: float) -> Iterator[list[str]]:
    for measured in value.measured(channel, level):
        claim = measured.claim
        shown = [
            digits(*numbers).plain() for numbers in ((measured.value, measured.low, measured.high), measured.ratio)
        ]
        (size, limits), (ratio, around) = shown if rounded(measured.value) else [("", "")] * 2
        yield [claim.printed, LIMITS[claim.limit], f"{claim.value:g}", size, limits, claim.unit, ratio, around,
            measured.remark]  # fmt: skip
