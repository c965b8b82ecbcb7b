"""What a data sheet says of noise, alone or beside what was measured."""

from collections.abc import Iterator

from allanite.comparison.sheet import Measured, SheetComparison
from allanite.core.units import signal_named
from allanite.phrases.phrase import join, say
from allanite.planning.datasheets import QUANTITIES, SENSORS, Claim, DataSheet
from allanite.reporting import words
from allanite.reporting.digits import digits, printed_unit, rounded
from allanite.reporting.first import DETAILS, Axes, First, Quantity, Remark, merged, plus_minus
from allanite.reporting.sheet import Column, Face, Note, Part, Table, one_sheet
from allanite.study.results import Channel

from . import Rows, view
from .jobs import channel_sheet, job_face, source_of

BRAND = say("noise in a data sheet")
LIMITS = {"typical": say("typical"), "nominal": say("nominal"), "maximum": say("maximum"), "": ""}
"""What kind of value is printed."""


def first_of_sheet(value: DataSheet, _: float) -> First:
    """The models of a data sheet, and the lines from which they are made."""
    answer: list[str | Table] = list(_models(value))
    rows = [[c.printed, *_size(c), LIMITS[c.limit], c.place] for c in value.claims if c.limit != "maximum"]
    answer.append(Table([Column("", "name"), *[Column("", "text")] * 4], rows))
    after = (
        (f"allanite export --datasheet {value.name} --to kalibr", say("a file of a filter")),
        (f"allanite compare FILE --datasheet {value.name}", say("what was measured beside it")),
        DETAILS,
    )
    return First(join(" ", (value.maker, value.name)), value.document, answer, after=after)


@view(rows=lambda value, _: _sheet_rows(value), first=first_of_sheet)
def sheet_view(value: DataSheet, _: float) -> Face:
    """The lines of a data sheet, with the coefficients that follow from them."""
    heads = (
        Column(say("sensor"), "text"), Column(say("quantity"), "name"), Column(say("value")),
        Column(say("unit"), "unit"), Column("", "text"), Column(say("conditions"), "text"),
        Column(say("place"), "text"), Column(say("is"), "text"),
    )  # fmt: skip
    rows = [
        [signal_named(c.sensor).name, c.printed, *_size(c), LIMITS[c.limit], c.conditions, c.place,
         printed_unit(str(c.term or ""))]
        for c in value.claims
    ]  # fmt: skip
    means = dict.fromkeys(QUANTITIES[claim.quantity].meaning for claim in value.claims)
    parts: list[Part] = [
        *(Note(text, "strong") for text in _models(value)),
        Table(heads, rows, most=99), *(Note(text, "quiet") for text in means),
    ]  # fmt: skip
    title = join(" ", (value.maker, value.name))
    return one_sheet(title, BRAND, value.name, parts, about=(say("source: {source}", source=value.document),))


def _models(value: DataSheet) -> Iterator[str]:
    return (join(": ", (model.signal.sensor, str(model))) for model in value.models)


def _sheet_rows(value: DataSheet) -> Rows:
    heads = [
        "name",
        "maker",
        "document",
        "sensor",
        "quantity",
        "printed",
        "value",
        "unit",
        "limit",
        "conditions",
        "place",
    ]
    return heads, [
        [value.name, value.maker, value.document, c.sensor, c.quantity, c.printed, c.value, c.unit, c.limit,
         c.conditions, c.place] for c in value.claims
    ]  # fmt: skip


def _size(claim: Claim) -> tuple[str, str]:
    return f"{claim.value:g}", printed_unit(claim.unit)


def first_of_comparison(value: SheetComparison, level: float) -> First:
    """What was measured of every coefficient, beside the data sheet, and the ratio of the two."""
    tables = [axes for sensor in SENSORS if (axes := _axes(value, sensor, level)).rows]
    alerts = [Remark.of(c.record.name, c.refusal, grave=True) for c in value if c.refusal]
    alerts += merged(Remark.of(c.record.name, said) for c in value for said in c.alerts)
    title = say("{file} beside the data sheet of the {sensor}", file=source_of(value), sensor=value.sheet.name)
    return First(title, value.sheet.document, tables, alerts, read=value.notes)


def _axes(value: SheetComparison, sensor: str, level: float) -> Axes:
    """The lines of which the model of the data sheet is made, by channel."""
    channels = [c for c in value if c.record.signal.name == sensor and not c.refusal]
    found = [{m.claim: m for m in value.measured(channel, level)} for channel in channels]
    rows = []
    for claim in value.sheet.used(sensor) if channels else ():
        symbol = QUANTITIES[claim.quantity].symbol
        measured = [each[claim] for each in found]
        rows.append(Quantity(claim.printed, symbol, claim.unit, [f"{claim.value:g}", *map(_shown, measured)]))
        ratios = [digits(m.ratio[0], figures=3).plain()[0] if m.value == m.value else "" for m in measured]
        rows.append(Quantity(say("ratio to the data sheet"), "", "", ["", *ratios]))
    return Axes([say("data sheet"), *(c.record.name for c in channels)], rows, signal_named(sensor).sensor)


def _shown(found: Measured) -> str:
    if found.value != found.value:
        return found.remark
    return ("≤ " if found.remark else "") + plus_minus(found.value, found.low, found.high)


@view(rows=lambda value, level: value.rows(level), first=first_of_comparison)
def comparison_view(value: SheetComparison, level: float) -> Face:
    """Every line of the data sheet beside what was measured, by channel."""
    heads = (
        Column(say("quantity"), "name"), Column("", "text"), Column(say("data sheet")), Column(say("measured")),
        Column(words.interval(level), "interval"), Column(say("unit"), "unit"), Column(say("ratio")),
        Column(words.interval(level), "interval"), Column(say("remark"), "text"),
    )  # fmt: skip
    sheets = [
        channel_sheet(channel, [Table(heads, list(_rows(value, channel, level)))] if not channel.refusal else ())
        for channel in value
    ]
    names = say("{file} beside the data sheet of the {sensor}", file=source_of(value), sensor=value.sheet.name), BRAND
    means = dict.fromkeys(QUANTITIES[claim.quantity].meaning for claim in value.sheet.claims)
    source = Note(say("source: {source}", source=join(" ", (value.sheet.maker, value.sheet.document))), "quiet")
    return job_face(value, names, sheets, [source], close=[Note(text, "quiet") for text in means])


def _rows(value: SheetComparison, channel: Channel, level: float) -> Iterator[list[str]]:
    for found in value.measured(channel, level):
        claim = found.claim
        shown = [digits(*numbers).plain() for numbers in ((found.value, found.low, found.high), found.ratio)]
        (size, limits), (ratio, around) = shown if rounded(found.value) else [("", "")] * 2
        yield [
            claim.printed,
            LIMITS[claim.limit],
            f"{claim.value:g}",
            size,
            limits,
            claim.unit,
            ratio,
            around,
            found.remark,
        ]
