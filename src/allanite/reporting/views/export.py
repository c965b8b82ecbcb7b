"""How files for other programs are shown: their fields, what they leave out, and what fields mean."""

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from allanite.core.errors import DataError, UndrawnError
from allanite.core.fit import Fit
from allanite.core.model import Model, Term
from allanite.core.readings import FALLING, FALLING_SIGN
from allanite.exporting.content import Entry
from allanite.exporting.export import Export, exported
from allanite.exporting.exports import EXPORTS, row_of_file
from allanite.exporting.fields import How
from allanite.exporting.target import ACCELEROMETER, GYRO, Target
from allanite.phrases.phrase import Phrase, join, say
from allanite.reporting import figures, sheet
from allanite.reporting.digits import digits, printed_unit, upper_limit
from allanite.reporting.first import DETAILS, Channels, First, Remark, condensed, plus_minus
from allanite.reporting.sheet import Code, Column, Drawing, Face, Note, Part, Plot, Table, header_of, one_sheet
from allanite.study.recipe import command_of
from allanite.study.results import Study
from allanite.terms import WHITE

from . import view

BRAND = say("noise coefficients for a filter")
KEY = say(
    "f is the rate (sqrt(f) is 14 at 200 Hz), T a correlation time; N, K and B are the coefficients of white noise, "
    "random walk and flicker"
)

DRAWN_LABEL = say("Allan deviation of the file and of the noise")
DRAWN = say(
    "Above, the Allan deviation of the noise model of the file beside that of the noise. Below, for a filter that knew "
    "the angle (the velocity) and is left alone: the error it makes, and what it predicts."
)

SENSORS = {GYRO: say("gyro"), ACCELEROMETER: say("accelerometer")}


def _fields(value: Export, title: str = "") -> Table:
    """What is written, and beside it what was identified, or given, where that differs, and why."""
    differs = any(entry.why for entry in value.entries)
    columns = (
        Column(say("field"), "name"), Column(say("written")),
        Column(say("identified") if value.recipe else say("given")), Column(say("unit"), "unit"),
        Column(say("why"), "text"), Column(say("channel"), "text"), Column(say("remark"), "text", aside=differs),
        Column(say("formula"), "text", aside=True),
    )  # fmt: skip
    rows = [[*row[:2], row[2] or say("none"), row[3], entry.why, row[7], *row[5:7]]
            for entry, row in zip(value.entries, value.rows()[1], strict=True)]  # fmt: skip
    table = Table(columns, rows, title)
    named = [5] * any(entry.channels for entry in value.entries)
    return table.only([*range(5), *named, 6, 7] if differs else [0, 1, 3, *named, 6, 7])


FILTER = EXPORTS["kalibr"]  # the target whose values stand beside every result


def filter_line(study: Study) -> Iterator[Phrase]:
    """The values of an IMU for a filter, or their upper bounds, and the command that writes the file."""
    command = command_of(study.recipe, "allanite", "export", "FILE", "--to", FILTER.name)
    made = for_filter(study, How())[0]
    what, known = say("{filter}, gyro; accelerometer", filter=FILTER.name), made is not None
    if made is None:
        made, command = for_filter(study, How(from_curve=True))[0], f"{command} --from-curve"
        what = say("{filter}, bounds", filter=FILTER.name)
    if made is not None:
        sizes = [(e.sensor, _size(e, limit=known and not (e.measured or e.covers))) for e in made.entries]
        values = join("; ", (", ".join(size for sensor, size in sizes if sensor == own) for own in SENSORS))
        yield say("{what}: {values} ({command})", what=what, values=values, command=command)


def _size(entry: Entry, *, limit: bool) -> str:
    """The first value of a field, as a limit, which is rounded up, where its coefficient was not identified."""
    value = entry.values[0]
    return f"< {upper_limit(value).plain()[0]}" if limit else digits(value, figures=3).plain()[0]


def filter_parts(study: Study) -> Iterator[Part]:
    """The values of a study for a filter beside those that were identified, its file, and what prevents it."""
    if not any(channel.record.signal.inertial for channel in study if channel.fit is not None):
        return
    title = say("For filters ({filter})", filter=FILTER.name)
    made, why = for_filter(study, How())
    made = made or for_filter(study, How(partial=True))[0]
    if made is not None:
        command = command_of(study.recipe, "allanite", "export", "FILE", "--to", made.target)
        writes = say("{command} writes the values of the worst axis", command=command)
        key = "" if why else join("; ", (writes, *made.notes[: any(entry.covers for entry in made.entries)]))
        fields = _fields(made, title)
        kept = [i for i, column in enumerate(fields.columns) if not column.aside]
        yield replace(fields.only(kept), key=key, where="page")
        body = re.sub(r"\A(#.*\n)*", "", made.text)
        yield sheet.Fold(say("file for {filter}", filter=FILTER.name), [Code(body.rstrip())], shut=True)
    if why:
        yield Note(why if made is not None else join(": ", (title, why)), where="page")


def for_filter(study: Study, how: How) -> tuple[Export | None, str]:
    """The values for the usual filter, or why there are none."""
    try:
        return exported(FILTER, study, how, FILTER.form("")), ""
    except DataError as error:
        return None, str(error)


def first_of_models(models: Iterable[Model], texts: Sequence[str]) -> First:
    """Values of data sheets in the units in use, that of the texts first: a line each."""
    return First("", answer=[_equal(term, texts) for model in models for term in model], after=())


def _equal(term: Term, texts: Sequence[str]) -> Phrase:
    power, white = term.row.power, term.row.slope == WHITE
    density = f"{term.signal.si[power - 0.5]}/sqrt(Hz)" if power % 1 else term.signal.si[power]
    units = dict.fromkeys((term.signal.sheet[power], *(term.signal.density if white else ()), density))
    given = sorted(units, key=lambda unit: not any(text.endswith(f" {unit}") for text in texts))
    values = " = ".join(f"{_trimmed(term.to(unit))} {printed_unit(unit)}" for unit in given)
    return say("{values} (two-sided; one-sided: × √2)", values=values) if white else join("", (values,))


def _trimmed(value: float) -> str:
    """A number with four digits, without zeros at its end."""
    mantissa, power, exponent = digits(value).plain()[0].partition("e")
    return (mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa) + power + exponent


def first_of_export(value: Export, level: float) -> First:
    """The fields of a file; of a table of quantities its rows by channel."""
    after = (("--output FILE", say("write it")), DETAILS)
    if value.entries or value.suffix != ".md" or value.target != "datasheet":
        first = condensed(export_view.face(value, level))
        why = dict.fromkeys((SENSORS[e.sensor], e.remark) for e in value.entries if e.covers)
        costs = {line for made in value.stated if made.covers for line in made.words()}
        notes = [Remark.of("", note) for note in value.notes if note not in costs]
        own = [*(Remark.of(*reason) for reason in why), *notes[: bool(why)]]
        answer = first.answer if value.entries or not row_of_file(value.target).fields else []
        return replace(first, answer=answer, remarks=[*own, *first.remarks, *notes[bool(why) :]], after=after)
    rows = [line[2:-2].split(" | ") for line in value.text.splitlines() if line.startswith("| ")][2:]
    cells = []
    for channel, quantity, size, low, high, unit, tau, remark in (row for row in rows if any(row[2:5])):
        limits = [float(v) if v.strip() else math.nan for v in (low, high)]
        shown = plus_minus(float(size), *limits) if size.strip() else f"< {upper_limit(float(high)).plain()[0]}"
        if tau.strip():  # read off a curve
            shown = digits(float(size), *limits).words() + f" {FALLING_SIGN}" * (remark.strip() == FALLING)
        cells.append((channel, quantity, unit, shown))
    channels = Channels.of(list(dict.fromkeys(row[0] for row in rows)), cells)
    alerts = [Remark.of("", alert, grave=True) for alert in value.alerts]
    return First(EXPORTS[value.target].title, "", [channels], alerts, after=after)


def _plot(values: Sequence[Export], _: Fit | None, __: float) -> Plot:
    stated = [noise for value in values for noise in value.stated]
    if not stated:
        raise UndrawnError("there is no figure of this file: it holds the whole model, or no noise was found")
    return figures.plot_stated(stated)


@view(_plot, rows=lambda value, _: value.rows(), first=first_of_export)
def export_view(value: Export, _: float) -> Face:
    """The fields of a file, or its text."""
    row = row_of_file(value.target)
    parts: list[Part] = [Note(alert, "alert") for alert in value.alerts]
    if value.entries:
        parts.append(_fields(value))
        parts.append(Note(KEY, "quiet"))
        if value.stated:
            parts.append(Drawing(lambda: figures.plot_stated(value.stated), DRAWN_LABEL, DRAWN))
    elif not value.binary and not row.fields:
        parts.append(Code(value.text.rstrip("\n")))
    parts += noted(row, value.notes)
    header = header_of(value.provenance, ()) if value.provenance else ()
    return one_sheet(row.title, BRAND, row.title, parts, header=header, provenance=value.provenance)


def noted(row: Target, notes: Iterable[str]) -> list[Part]:
    """Notes, of which those of the target that are no sentences are code."""
    code = [note for note in row.notes if not isinstance(note, Phrase)]
    return [Code(note) if note in code else Note(note) for note in notes]
