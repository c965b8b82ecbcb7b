"""How files that were read back, targets and words of the field are shown."""

from dataclasses import replace
from itertools import groupby

from allanite.core.kinds import title_of
from allanite.core.units import signal_named
from allanite.exporting.exports import EXPORTS, TEMPERATURE, row_of_file
from allanite.exporting.imported import Explanation, Imported
from allanite.interpretation.glossary import Word, words
from allanite.phrases.phrase import say
from allanite.planning.datasheets import DATASHEETS
from allanite.reporting.first import DETAILS, First, Remark, condensed
from allanite.reporting.sheet import Column, Face, Note, Part, Sheet, Table, one_sheet
from allanite.statistics import STATISTICS
from allanite.terms import TERMS

from . import view
from .export import BRAND, KEY, SENSORS, noted
from .papers import about


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


def _tables() -> dict[str, dict[str, str]]:
    """The names of every table, those of plug-ins among them, and what they are."""
    rest = {*TERMS, *STATISTICS}
    return {
        say("targets"): {name: row.title for name, row in EXPORTS.items()},
        say("temperature parameters"): {row.name: row.title for row in TEMPERATURE.values()},
        say("statistics"): {name: row.title for name, row in STATISTICS.items()},
        say("noise terms"): {symbol: row.title for symbol, row in TERMS.items()},
        say("words"): {name: row.meaning for name, row in words().items() if rest.isdisjoint(row.synonyms)},
        say("data sheets"): {name: row.document for name, row in DATASHEETS.items()},
    }


def first_of_explanation(value: Explanation, level: float) -> First:
    """The names of all tables, or what the fields of a target mean."""
    if value.target:
        notes = [Remark.of("", note) for note in row_of_file(value.target).notes]
        return replace(condensed(explanation_view.face(value, level)), remarks=notes)
    lines = [say("{table}: {names}", table=title, names=", ".join(rows)) for title, rows in _tables().items()]
    after = ("allanite explain NAME", say("what one of them means; abbreviations too")), DETAILS
    title, papers = say("targets, statistics, noise terms and data sheets"), say("papers: allanite example")
    return First(title, papers, lines, after=after)


@view(first=first_of_explanation)
def explanation_view(value: Explanation, _: float) -> Face:
    """What the fields of a target mean; without one, the targets."""
    if not value.target:
        heads = Column("", "name"), Column("", "text")
        tables = ((title, Table(heads, list(rows.items()), most=99)) for title, rows in _tables().items())
        sheets = tuple(Sheet(title, (), (table,)) for title, table in tables)
        return Face(say("targets, statistics, noise terms and data sheets"), BRAND, sheets)
    row = row_of_file(value.target)
    fields = list[list[str]]()
    for section, own in groupby(row.fields, lambda f: f.section):
        fields += [[section, *[""] * 7]] if section else []
        fields += [["  " * bool(section) + f.name, f.formula, *f.nature, f.unit, SENSORS[f.sensor],
            title_of(f.term, signal_named(f.sensor)) if f.term else ""] for f in own]  # fmt: skip
    columns = (Column(say("field"), "name"), Column(say("is"), "text"), Column(say("kind"), "text"),
               Column(say("often mistaken for"), "text"), Column(say("wrong by"), "text"), Column(say("unit"), "unit"),
               Column(say("sensor"), "text", aside=True), Column("", "text", aside=True))  # fmt: skip
    parts: list[Part] = [Table(columns, fields), Note(KEY, "quiet")] if fields else []
    if row.step:
        parts.append(
            Note(say("f is 1/{step:g} s, the interval of the filter's steps, not the sampling rate", step=row.step))
        )
    parts += [*noted(row, row.notes), Note(say("source: {source}", source=row.source), "quiet")]
    return one_sheet(row.title, BRAND, row.title, parts)


def _worded(value: Word, *more: tuple[str, str]) -> Table:
    """The formula, the example and the related words, and more."""
    own = (say("formula"), value.formula), (say("example"), value.example), (say("see also"), ", ".join(value.see))
    rows = [*own, *((why, command) for command, why in more)]
    return Table((Column("", "name"), Column("", "text")), [row for row in rows if row[1]])


@view(
    first=lambda value, _: First(
        value.name, ", ".join(value.synonyms[:4]), [value.meaning, _worded(value)], after=about(*value.synonyms)
    )
)
def word_view(value: Word, _: float) -> Face:
    """The same as a page."""
    names, ways = (", ".join(value.synonyms),) if value.synonyms else (), about(*value.synonyms)
    return one_sheet(
        value.name, say("words of the field"), value.name, (Note(value.meaning), _worded(value, *ways)), about=names
    )
