"""How many units are shown: what fails, a row for each channel of a unit, and what they have in common."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

from allanite.batch.batch import Batch, BatchUnit
from allanite.batch.specification import OUTCOMES, worst_of
from allanite.batch.tables import Across, power_of
from allanite.core.fit import Fit
from allanite.core.limits import FAIL, NOT_DECIDED
from allanite.core.readings import MINIMUM
from allanite.core.syntax import toml
from allanite.core.units import Signal
from allanite.core.validity import APPROXIMATE, EXPLAINED, UNEXPLAINED
from allanite.phrases.phrase import join, say, say_count
from allanite.reporting import figures, words
from allanite.reporting.digits import printed_unit, rounded
from allanite.reporting.first import DETAILS, FIGURES, Answer, First, Remark
from allanite.reporting.sheet import Column, Drawing, Face, Note, Part, Plot, Table
from allanite.study.results import Channel

from . import Rows, view
from .analysis import study_view
from .channels import IN_RUN_SHORT, first_of, fit_words, lowest_cell, names_in_order
from .expectation import causes_of
from .fit import definitions, terms_table
from .jobs import OUTCOME_WORDS

ALL_ROWS = 1_000_000  # rows of a table that has all of them in a terminal, too

LOWEST = say("minimum")

SPREAD = say(
    "Mean and standard deviation of the values of those units in which the term was identified, with their number "
    "where it was not in all: for a term that few units show, the mean is too large. The standard deviation includes "
    "the errors of the values."
)

MAX_UNIT_ROWS = 12  # rows up to which every channel of every unit has one


def first_of_batch(batch: Batch, level: float) -> First:
    """The units side by side if they are few, else their means, spreads and worst."""
    told: Note = summary(batch)
    remarks = [Remark.of(batch.label(unit), unit.error, grave=True) for unit in batch if unit.error]
    for outcome in (FAIL, NOT_DECIDED):
        for file, j in ((batch.label(unit), j) for unit in batch for j in unit.judgements if j.outcome == outcome):
            what = join(" ", (file, j.channel, symbol_of(j.limit.symbol), OUTCOME_WORDS[outcome]))
            limit = say("limit {limit}", limit=j.limit.words())
            remarks.append(Remark.of(what, j.reason, limit, grave=outcome == FAIL))
    if len(batch) == 1 and batch[0].study is not None:
        own = first_of(batch[0].study, level)
        limits = say("limits: {outcome}", outcome=OUTCOME_WORDS[batch[0].outcome]) if batch[0].outcome else ""
        return replace(own, verdict=join("; ", filter(None, (limits, own.verdict))), remarks=[*remarks, *own.remarks])
    signals = {c.record.signal.name: c.record.signal for unit in batch for c in unit.channels}
    count = sum(len(unit.channels) for unit in batch)
    answer: list[Answer] = [_table(batch, signal, level) for signal in signals.values()]
    if count > MAX_UNIT_ROWS:
        answer = [across_table(batch, (term for term in batch.across if term.row()[3]))]
    return First(told.text, "", answer, remarks, (), batch.notes, [FIGURES, ("--csv FILE", say("all values")), DETAILS])


def _table(batch: Batch, signal: Signal, level: float) -> Table:
    channels = list(rows_of_units(batch, signal))
    symbols = names_in_order(e.symbol for _, c in channels for e in c.fit or ())
    heads = [Column(say("file"), "name"), Column(say("channel"), "name")]
    heads += [Column(join(" ", (s, printed_unit(signal.sheet[power_of(s)])))) for s in symbols[:3]]
    heads += [Column(join(" ", (IN_RUN_SHORT, printed_unit(signal.sheet[0])))), Column(say("model"), "name")]
    rows = [[batch.label(unit), c.record.name, *_cells(c, symbols[:3], level), fit_words(c.noise, c.refusal)]
        for unit, c in channels]  # fmt: skip
    return Table(heads, rows)


def _cells(channel: Channel, symbols: Sequence[str], level: float) -> list[str]:
    """The usable coefficients of a channel, and the minimum of its curve."""
    usable = {e.symbol: e for e in channel.fit or () if e.row.usable}
    terms = [words.brief(usable[symbol], level) if symbol in usable else "-" for symbol in symbols]
    return [*terms, lowest_cell(channel, level) or "-"]


def summary(batch: Batch) -> Note:
    """How many units there are, and how many of them pass."""
    done = [unit for unit in batch if not unit.error]
    if batch.specification is None:
        text = say_count(
            len(batch), "{done} of {count} unit analyzed", "{done} of {count} units analyzed", done=len(done)
        )
        return Note(text, "alert" if batch.failed else "strong")
    counts = {outcome: sum(unit.outcome == outcome for unit in done) for outcome in reversed(OUTCOMES)}
    parts = [join(" ", (str(count), OUTCOME_WORDS[outcome])) for outcome, count in counts.items() if count]
    parts += [say("{files} not analyzed", files=len(batch.failed))] if batch.failed else []
    level: Any = "alert" if counts[FAIL] or batch.failed else "fair" if counts[NOT_DECIDED] else "good"
    named = []
    for outcome in (outcome for outcome in (FAIL, NOT_DECIDED) if counts[outcome]):
        labels = ", ".join(batch.label(unit) for unit in done if unit.outcome == outcome)
        named.append(join(": ", (OUTCOME_WORDS[outcome], labels)))
    units = say_count(len(batch), "{count} unit", "{count} units")
    return Note(join(": ", (units, join(", ", parts))), level, points=named)


def across_table(batch: Batch, across: Iterable[Across]) -> Table:
    """The values of all units in which a term was identified."""
    heads = (
        Column(say("channel"), "name"), Column(say("term"), "symbol"), Column(say("identified"), "name"),
        Column(say("mean")), Column(say("standard deviation")), Column(say("worst"), form=rounded),
        Column(say("file"), "name"), Column(say("others below"), form=rounded, aside=True), Column("", "unit"),
    )  # fmt: skip
    rows = []
    for channel, symbol, units, count, *spread, worst, file, below, unit in (term.row() for term in across):
        share = say("{identified} of {units}", identified=count, units=units)
        shown: list[str] = [rounded(value) for value in spread]
        if count < units:
            shown = [number and say("{number} (of {count})", number=number, count=count) for number in shown]
        label = batch.label(batch[file]) if file else ""
        rows.append([channel, symbol_of(symbol), share, *shown, worst, label, below, unit])
    return Table(heads, rows, say("over all units"), key=SPREAD, most=ALL_ROWS)


def symbol_of(of: str) -> str:
    """The symbol of a term as tables have it."""
    return LOWEST if of == MINIMUM else of


def rows_of_units(batch: Batch, signal: Signal) -> Iterator[tuple[BatchUnit, Channel]]:
    """The channels of a kind of sensor, one after the other: a lot may be too large to hold all of them."""
    return ((unit, c) for unit in batch for c in unit.channels if c.record.signal is signal)


MARKS: dict[str, Any] = {FAIL: "alarm", NOT_DECIDED: "weak", "": ""}  # mark of a row by its outcome

GRADE_WORDS = {EXPLAINED: say("explained"), APPROXIMATE: say("approximate"), UNEXPLAINED: say("unexplained"), "": ""}

RULE = say(
    "A term passes if its interval lies below the limit and fails if it lies above. A term that was not identified "
    "passes if its 95 % upper limit does not exceed the limit. Everything else is not decided."
)
MAIN_KEY = say("'< 2' is the 95 % upper limit of a term that was not identified, '-' a term without a valid result.")
CAPTION = say("The Allan deviation of all units; those that exceed a limit are in color.")


def _parts(batch: Batch, level: float) -> Iterator[Part]:
    yield summary(batch)
    for unit in batch:
        if unit.error:
            told = say("not analyzed: {file}: {reason}", file=batch.label(unit), reason=unit.error)
            yield Note(told, "alert")
    yield from _judged(batch)
    if any(channel.curve for unit in batch for channel in unit.channels):
        yield Drawing(lambda: _plot([batch], None, level), say("deviations of all units"), CAPTION)
    signals = {c.record.signal.name: c.record.signal for unit in batch for c in unit.channels}
    for signal in signals.values():
        yield _main(batch, signal, level)
    yield across_table(batch, batch.across)


def _judged(batch: Batch) -> Iterator[Part]:
    """What fails or is not decided by the limits, and the rule."""
    judged = [(unit, j) for unit in batch for j in unit.judgements if j.outcome in (FAIL, NOT_DECIDED)]
    judged.sort(key=lambda pair: OUTCOMES.index(pair[1].outcome))
    heads = (Column(say("file"), "name"), Column(say("channel"), "name"), Column(say("term"), "symbol"),
        Column(say("found"), "name"), Column(say("limit"), "interval"), Column(say("result"), "name"))  # fmt: skip
    rows = [[batch.label(u), j.channel, symbol_of(j.limit.symbol), j.reason, j.limit.words(), OUTCOME_WORDS[j.outcome]]
        for u, j in judged]  # fmt: skip
    marks = [MARKS.get(j.outcome, "") for _, j in judged]
    if judged:
        yield Table(heads, rows, say("limits that are exceeded or not decided"), marks, most=ALL_ROWS)
    if batch.specification is not None:
        yield Note(RULE, "quiet", where="page")


def _main(batch: Batch, signal: Signal, level: float) -> Table:
    """A row for each channel of each unit: coefficients in the units of data sheets."""
    symbols = list(dict.fromkeys(e.symbol for _, c in rows_of_units(batch, signal) for e in c.fit or ()))
    heads = [Column(say("file"), "name"), Column(say("channel"), "name")]
    heads += [Column(f"{s} [{signal.sheet[power_of(s)]}]") for s in symbols]
    heads += [Column(join(" ", (LOWEST, f"[{signal.sheet[0]}]"))), Column(say("model"), "name")]
    heads += [Column(say("result"), "name")] if batch.specification else []
    cells, marks = [], []
    for unit, channel in rows_of_units(batch, signal):
        grade = say("no result") if channel.refusal else GRADE_WORDS[channel.noise.validity] if channel.noise else ""
        outcome = _outcome(unit, channel)
        last = [grade, *([OUTCOME_WORDS[outcome]] if batch.specification else [])]
        cells.append([batch.label(unit), channel.record.name, *_cells(channel, symbols, level), *last])
        marks.append(MARKS.get(outcome, ""))
    title = say("units: {sensor}", sensor=signal.sensor)
    return Table(heads, cells, title, marks, MAIN_KEY, most=ALL_ROWS)


def _outcome(unit: BatchUnit, channel: Channel) -> str:
    """The worst outcome of a channel."""
    return worst_of([j.outcome for j in unit.judgements if j.channel == channel.record.name])


def _details(batch: Batch, level: float) -> Iterator[Part]:
    """What was found in each unit, folded away on the page."""
    yield from causes_of((c for unit in batch for c in unit.channels), batch.choices.get("device"))
    for unit in batch:
        for channel in unit.channels:
            named = say("unit {file}", file=batch.label(unit))
            name = join(", ", [named, *filter(None, [channel.record.name])])
            told = [*channel.alerts, *filter(None, [channel.refusal])]
            yield from (Note(join(": ", (name, text)), "quiet", where="page") for text in told)
            if channel.fit is not None:
                table = terms_table(channel.fit, level)
                yield Table(table.columns, table.rows, name, table.marks, details=True, where="page")


def _plot(values: Sequence[Any], _: Fit | None, level: float) -> Plot:
    batch: Batch = values[0]
    curves = []
    lines: dict[str, Sequence[figures.LimitLine]] = {}
    for unit in batch:
        for channel in (channel for channel in unit.channels if channel.curve is not None):
            (panel,) = figures.panels_of(channel)
            curves.append(figures.UnitCurve(batch.label(unit), _outcome(unit, channel) == FAIL, panel))
            limits = batch.specification.of(channel.record.name, channel.record.signal) if batch.specification else ()
            lines[panel.name] = [figures.LimitLine(limit.words(), limit.symbol, limit.maximum) for limit in limits]
    return figures.plot_units(curves, lines)


def _rows(batch: Batch, level: float) -> Rows:
    tables = [(unit.file, study_view.rows(unit.study, level)) for unit in batch if unit.study and study_view.rows]
    heads = tables[0][1][0]
    return ("file", *heads), [[file, *row] for file, (_, rows) in tables for row in rows]


def _coefficients(batch: Batch, level: float) -> Rows:
    """As of a study, after the file and before what the limits say; a file that was not analyzed has one row."""
    heads: Sequence[str] = ()
    rows: list[list[Any]] = []
    for unit in batch:
        judged = {(j.channel, j.limit.symbol): j for j in unit.judgements}
        if unit.study is None or study_view.coefficients is None:
            continue
        heads, own = study_view.coefficients(unit.study, level)
        for row in own:
            judgement = judged.get((row[0], row[1]))
            limit = ("", "") if judgement is None else (judgement.limit.words(), judgement.outcome)
            rows.append([unit.file, *row, *limit])
    for unit in (unit for unit in batch if unit.error):
        told = {"status": "not analyzed", "remark": unit.error}
        rows.append([unit.file, *(told.get(head, "") for head in heads), "", ""])
    return ("file", *heads, "limit", "result"), rows


def _limits(batch: Batch) -> Iterator[tuple[str, str]]:
    """The line on the limits of the first lines."""
    if batch.specification is not None:
        yield say("limits"), join(": ", (batch.specification.source, batch.specification._summary()))


@view(_plot, _rows, _coefficients, first_of_batch)
def batch_view(batch: Batch, level: float) -> Face:
    """The units, what they have in common, and which of them pass; of a single one all that was found."""
    if len(batch) == 1 and batch[0].study is not None:
        face = study_view.face(batch[0].study, level)
        return replace(
            face, header=[*face.header, *_limits(batch)], parts=[summary(batch), *_judged(batch), *face.parts]
        )
    fits = (channel.fit for unit in batch for channel in unit.channels if channel.fit)
    files: str = str(len(batch))
    if batch.folder:
        files = say("{files} in {folder}", files=files, folder=batch.folder)
    lines: list[tuple[str, str]] = [(say("files"), files), *(("", note) for note in batch.notes)]
    return Face(
        say_count(len(batch), "Noise of {count} unit", "Noise of {count} units"),
        say("noise coefficients of inertial sensors"),
        header=[*lines, *_limits(batch), (say("made by"), f"allanite {batch.provenance.get('allanite', '')}")],
        parts=list(_parts(batch, level)), close=list(_details(batch, level)), how=(definitions(fits),),
        choices=toml(batch.choices), provenance=batch.provenance, notes=batch.notes,
    )  # fmt: skip
