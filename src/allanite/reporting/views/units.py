"""The first screen of many units: what fails, then a row for each channel of a unit, or what they have in common."""

from collections.abc import Iterable, Iterator
from typing import Any

from allanite.batch.batch import Batch, BatchUnit
from allanite.batch.judgement import FAIL, NOT_SHOWN, OUTCOMES, PASS
from allanite.batch.summary import Across, power_of
from allanite.core.readings import MINIMUM
from allanite.core.units import Signal, convert
from allanite.phrases.phrase import join, say, say_count
from allanite.reporting import words
from allanite.reporting.digits import digits, printed_unit, rounded
from allanite.reporting.first import DETAILS, FIGURES, Answer, First, Remark
from allanite.reporting.sheet import Column, Note, Table
from allanite.study.results import Channel

from .axes import fit_words, names_in_order

EVERY = 1_000_000
"""Rows of a table that has all of them in a terminal, too."""

OUTCOME_WORDS = {PASS: say("pass"), FAIL: say("fail"), NOT_SHOWN: say("not shown"), "": ""}
LOWEST = say("minimum")

SPREAD = say(
    "Mean and standard deviation of the values of those units in which the term was identified, with their number "
    "where it was not in all: for a term that few units show, the mean is too large. The standard deviation includes "
    "the errors of the values."
)

BELOW = 7
"""Column of that table with the limits of the units in which the term was not identified."""

FEW = 12
"""Rows up to which every channel of every unit has one."""


def first_of_batch(batch: Batch, level: float) -> First:
    """The units side by side if they are few, else their means, spreads and worst."""
    told: Note = summary(batch)
    remarks = [Remark.of(batch.label(unit), unit.error, grave=True) for unit in batch if unit.error]
    for outcome in (FAIL, NOT_SHOWN):
        found = [(unit, j) for unit in batch for j in unit.judgements if j.outcome == outcome]
        remarks += [
            Remark.of(
                join(" ", (batch.label(unit), j.channel, symbol_of(j.limit.symbol), OUTCOME_WORDS[outcome])),
                j.reason, say("limit {limit}", limit=j.limit.words()), grave=outcome == FAIL,
            )
            for unit, j in found
        ]  # fmt: skip
    signals = {c.record.signal.name: c.record.signal for unit in batch for c in unit.channels}
    count = sum(len(unit.channels) for unit in batch)
    answer: list[Answer] = [_table(batch, signal, level) for signal in signals.values()]
    if count > FEW:
        whole = across_table(batch, (one for one in batch.across if one.row()[3]))
        answer = [whole.only([i for i in range(len(whole.columns)) if i != BELOW])]
    alerts = sum(any(channel.alerts for channel in unit.channels) for unit in batch)
    if alerts:
        remarks.append(Remark("", [say("warnings in {warned} of {count} units", warned=alerts, count=len(batch))]))
    return First(told.text, "", answer, remarks, (), batch.notes, [FIGURES, ("--csv FILE", say("all values")), DETAILS])


def _table(batch: Batch, signal: Signal, level: float) -> Table:
    channels = list(rows_of_units(batch, signal))
    symbols = names_in_order(e.symbol for _, c in channels for e in c.fit or ())
    heads = [Column(say("file"), "name"), Column(say("channel"), "name")]
    heads += [Column(join(" ", (s, printed_unit(signal.sheet[power_of(s)])))) for s in symbols[:3]]
    heads += [Column(join(" ", (say("in-run"), printed_unit(signal.sheet[0])))), Column(say("model"), "name")]
    rows = []
    for unit, channel in channels:
        usable = {e.symbol: e for e in channel.fit or () if e.row.usable}
        terms = [words.brief(usable[symbol], level) if symbol in usable else "-" for symbol in symbols[:3]]
        fit = fit_words(channel.noise, channel.refusal)
        rows.append([batch.label(unit), channel.record.name, *terms, lowest(channel, level), fit])
    return Table(heads, rows)


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
    level: Any = "alert" if counts[FAIL] or batch.failed else "fair" if counts[NOT_SHOWN] else "good"
    named = [
        join(
            ": ",
            (
                OUTCOME_WORDS[outcome],
                ", ".join(batch.label(unit) for unit in batch if unit.outcome == outcome and not unit.error),
            ),
        )
        for outcome in (FAIL, NOT_SHOWN)
        if counts[outcome]
    ]
    units = say_count(len(batch), "{count} unit", "{count} units")
    return Note(join(": ", (units, join(", ", parts))), level, points=named)


def across_table(batch: Batch, across: Iterable[Across]) -> Table:
    """The values of all units in which a term was identified."""
    heads = (
        Column(say("channel"), "name"), Column(say("term"), "symbol"), Column(say("identified"), "name"),
        Column(say("mean")), Column(say("standard deviation")), Column(say("worst"), form=rounded),
        Column(say("file"), "name"), Column(say("others below"), form=rounded), Column("", "unit"),
    )  # fmt: skip
    rows = []
    for channel, symbol, units, count, *spread, worst, file, below, unit in (found.row() for found in across):
        share = say("{identified} of {units}", identified=count, units=units)
        shown: list[str] = [rounded(value) for value in spread]
        if count < units:
            shown = [number and say("{number} (of {count})", number=number, count=count) for number in shown]
        label = batch.label(batch[file]) if file else ""
        rows.append([channel, symbol_of(symbol), share, *shown, worst, label, below, unit])
    return Table(heads, rows, say("over all units"), key=SPREAD, most=EVERY)


def symbol_of(of: str) -> str:
    """The symbol of a term as tables have it."""
    return LOWEST if of == MINIMUM else of


def rows_of_units(batch: Batch, signal: Signal) -> Iterator[tuple[BatchUnit, Channel]]:
    """The channels of a kind of sensor, one after the other: a lot may be too large to hold all of them."""
    return ((unit, c) for unit in batch for c in unit.channels if c.record.signal is signal)


def lowest(channel: Channel, level: float) -> str:
    """The minimum of the curve; its upper limit where the record does not reach it."""
    readings = channel.readings
    if readings is None or readings.minimum is None:
        return "-"
    scale = convert(1.0, readings.unit, readings.signal.sheet[0])
    low, high = (limit * scale for limit in readings.minimum.interval(level))
    if not readings.inside:
        return f"< {digits(high, figures=2).plain()[0]}"
    return digits(readings.minimum.deviation * scale, low, high).plain()[0]
