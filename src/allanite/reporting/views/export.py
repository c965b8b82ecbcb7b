"""How files for other programs are shown: their fields, what they leave out, and what fields mean."""

from allanite.core.titles import title_of
from allanite.core.units import signal_named
from allanite.exporting.conversion import Explanation
from allanite.exporting.export import Export
from allanite.exporting.exports import EXPORTS
from allanite.exporting.imported import Imported
from allanite.exporting.target import ACCELEROMETER, GYRO
from allanite.phrases.phrase import say
from allanite.reporting.sheet import Code, Column, Face, Note, Part, Sheet, Table, header_of, one_sheet
from allanite.statistics import STATISTICS
from allanite.terms import TERMS

from . import view

BRAND = say("noise coefficients for a filter")
KEY = say(
    "f is the rate, T a correlation time; N, K and B are the coefficients of white noise, random walk and flicker"
)


SENSORS = {GYRO: say("gyro"), ACCELEROMETER: say("accelerometer")}
HEADINGS = (
    Column(say("field"), "name"), Column(say("value")), Column(say("unit"), "unit"), Column(say("formula"), "text"),
    Column(say("channel"), "text"), Column(say("remark"), "text"),
)  # fmt: skip


@view(rows=lambda value, _: value.rows())
def export_view(value: Export, _: float) -> Face:
    """The fields of a file, or its text."""
    row = EXPORTS[value.target]
    parts: list[Part] = [Note(alert, "alert") for alert in value.alerts]
    if value.entries:
        parts.append(Table(HEADINGS, value.rows()[1]))
        parts.append(Note(KEY, "quiet"))
    elif not value.binary:
        parts.append(Code(value.text.rstrip("\n")))
    parts += [Note(note) for note in value.notes]
    header = header_of(value.provenance, ()) if value.provenance else ()
    return one_sheet(row.title, BRAND, row.title, parts, header=header, provenance=value.provenance)


@view()
def imported_view(value: Imported, _: float) -> Face:
    """The terms that a file states."""
    row = EXPORTS[value.target]
    terms = [(t, t.signal.sheet[t.row.power]) for model in value.models for t in model]
    rows = [[t.symbol, title_of(t.symbol, t.signal), t.to(unit), unit, t.value, t.unit] for t, unit in terms]
    columns = (Column(say("term"), "symbol"), Column("", "text"), Column(say("value"), form=".6g"),
               Column(say("unit"), "unit"), Column(say("SI"), form=".6g"), Column(say("unit"), "unit"))  # fmt: skip
    about = () if value.rate is None else (say("rate {rate:.9g} Hz", rate=value.rate),)
    return one_sheet(row.title, BRAND, row.title, [Table(columns, rows)], about=about)


def _tables() -> tuple[Sheet, ...]:
    """The names of every table, those of plug-ins among them, and what they are."""
    tables = {
        say("targets"): {name: row.title for name, row in EXPORTS.items()},
        say("statistics"): {name: row.title for name, row in STATISTICS.items()},
        say("noise terms"): {symbol: row.title for symbol, row in TERMS.items()},
    }
    heads = Column("", "name"), Column("", "text")
    return tuple(Sheet(title, (), (Table(heads, list(rows.items()), most=99),)) for title, rows in tables.items())


@view()
def explanation_view(value: Explanation, _: float) -> Face:
    """What the fields of a target mean; without one, the targets."""
    if not value.target:
        return Face(say("targets, statistics and noise terms"), BRAND, _tables())
    row = EXPORTS[value.target]
    fields = [
        [f.full, SENSORS[f.sensor], f.unit, f.formula,
         title_of(f.term, signal_named(f.sensor)) if f.term else say("correlation time")]
        for f in row.fields
    ]  # fmt: skip
    columns = (Column(say("field"), "name"), Column(say("sensor"), "text"), Column(say("unit"), "unit"),
               Column(say("is"), "text"), Column("", "text"))  # fmt: skip
    parts: list[Part] = [Table(columns, fields), Note(KEY, "quiet")] if fields else []
    if row.step:
        parts.append(
            Note(say("f is 1/{step:g} s, the interval of the filter's steps, not the sampling rate", step=row.step))
        )
    parts += [*(Note(note) for note in row.notes), Note(say("source: {source}", source=row.source), "quiet")]
    return one_sheet(row.title, BRAND, row.title, parts)
