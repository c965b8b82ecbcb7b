"""How a model is shown: its coefficients, the curves expected of it, and what they mean."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from allanite.core.curve import Curve
from allanite.core.display_units import readable_unit
from allanite.core.fit import Fit
from allanite.core.model import model_of
from allanite.core.record import Record
from allanite.core.syntax import toml
from allanite.core.units import convert
from allanite.interpretation.devices import DEVICES, REFERENCES
from allanite.interpretation.sentences import Meaning, lasting, meaning
from allanite.phrases.phrase import join, say
from allanite.reporting import figures, words
from allanite.reporting.first import DETAILS, Answer, First
from allanite.reporting.sheet import Column, Drawing, Face, Note, Part, Plot, Sheet, Table, Where, one_sheet
from allanite.reporting.text import spread
from allanite.simulation.record import Simulation
from allanite.statistics import Expectation, Expectations, deviation, expectation, statistic_named
from allanite.study.results import Channel
from allanite.terms import TERMS

from . import view
from .fit import model_table
from .values import MAX_ROWS, tables_of

BRAND = say("a noise model")
CAPTION = say(
    "What is expected of the model, without data: the whole in black, each term alone in its color, with its slope and "
    "its coefficient where that is read off."
)


def _numbers(expectation: Expectation, curve: Curve) -> Iterator[list[float]]:
    columns = (curve.tau, curve.deviation, *expectation.terms(curve))
    yield from (list(row) for row in zip(*(column.tolist() for column in columns), strict=True))


def _plot(values: Sequence[Expectation], _: Fit | None, level: float) -> Plot:
    panels = [
        figures.CurvePanel(value.name, curve, None, facts=figures.facts_of(curve), model=value.model)
        for value in values
        for curve in value.curves
    ]
    return figures.plot_panels(panels, level=level)


def _curves(found: Expectation) -> Iterator[Table]:
    """The whole and each term, in the unit of data sheets."""
    terms = [Column(t.symbol, aside=True, form=".4g") for t in found.model]
    for curve in found.curves:
        unit = readable_unit(curve.unit)
        factor = convert(1.0, curve.unit, unit)
        heads = (Column("tau [s]", form=".5g"), Column(say("expected [{unit}]", unit=unit), form=".4g"), *terms)
        rows = [[tau, *(v * factor for v in row)] for tau, *row in _numbers(found, curve)]
        title = say("expected {statistic}", statistic=statistic_named(curve.statistic).title)
        yield Table(heads, rows, title, details=True)


def first_of_expectation(found: Expectation, level: float) -> First:
    """The expected deviations, and those of each term."""
    most, answer = MAX_ROWS // len(found.curves), list[Answer]()
    for table in _curves(found):
        answer += [table.title, replace(table, rows=[table.rows[i] for i in spread(len(table.rows), most)])]
    return First(str(found.model), "", answer, after=[("--plot curve.png", say("figure")), DETAILS])


@view(
    _plot,
    # the deviations, SI, with a column for each term
    lambda found, _: (
        ["statistic", "tau_s", "deviation", *(t.symbol for t in found.model), "unit"],
        [[curve.statistic, *row, curve.unit] for curve in found.curves for row in _numbers(found, curve)],
    ),
    first=first_of_expectation,
)
def expectation_view(found: Expectation, _: float) -> Face:
    """The model, and what is expected of it."""
    drawing = Drawing(lambda: _plot([found], None, 0.95), say("expected deviation of the model"), CAPTION)
    parts: list[Part] = [model_table(found.model), drawing]
    parts += _curves(found)
    return one_sheet(join("", [str(found.model)]), BRAND, found.name or say("model"), parts)


def _plot_all(values: Sequence[Expectations], _: Fit | None, level: float) -> Plot:
    named = [replace(each, name=name) for value in values for name, each in value.apart]
    return _plot(named, None, level)


def first_of_expectations(found: Expectations, level: float) -> First:
    """The expected deviations of the models side by side, by their numbers."""
    curves = [
        replace(curve.to(readable_unit(curve.unit)), name=str(i))
        for i, each in enumerate(found.each, 1)
        for curve in each.curves
    ]
    named = [join("  ", (str(i), name)) for i, (name, _) in enumerate(found.apart, 1)]
    answer = [*named, *tables_of(curves, level, max(4, MAX_ROWS - len(named)))]
    return First(say("Expected of several models"), "", answer, after=[("--plot curve.png", say("figure")), DETAILS])


@view(
    _plot_all,
    lambda found, _: (
        ["model", "statistic", "tau_s", "deviation", "unit"],
        [
            [name, curve.statistic, *point, curve.unit]
            for name, each in found.apart
            for curve in each.curves
            for point in zip(curve.tau.tolist(), curve.deviation.tolist(), strict=True)
        ],
    ),
    first=first_of_expectations,
)
def expectations_view(found: Expectations, level: float) -> Face:
    """The models, and what is expected of each."""
    drawing = Drawing(lambda: _plot_all([found], None, level), say("expected deviation of each model"), CAPTION)
    sheets = [Sheet(name, (), (model_table(each.model), *_curves(each))) for name, each in found.apart]
    return Face(say("Expected of several models"), BRAND, sheets, parts=[drawing])


MODEL = expectation_view.through(lambda model: expectation(model_of(model)))


def first_of_simulation(simulation: Simulation, _: float) -> First:
    """What every channel holds."""
    lines = [say("{channel}: {warning}", channel=c.name, warning=words.about(c)) for c in simulation.channels]
    lines += [join("; ", c.history) for c in simulation.channels[:1] if c.history]
    title = say("Simulation of {model}", model=str(simulation.model))
    return First(title, "", lines, after=[("allanite analyze FILE", say("the noise")), DETAILS])


@view(first=first_of_simulation)
def simulation_view(simulation: Simulation, _: float) -> Face:
    """The channels of a simulation, and the truth."""
    return Face(
        say("Simulation of {model}", model=str(simulation.model)), say("a recording whose noise is known"),
        [Sheet(c.name, (words.about(c), *c.history)) for c in simulation.channels],
        close=(model_table(simulation.model),), choices=toml({"seed": simulation.seed}),
    )  # fmt: skip


def meaning_of(channel: Channel, device: str | None) -> Meaning | None:
    """What the coefficients of a channel mean; None where it has none."""
    if channel.fit is None:
        return None
    record = channel.record
    result = meaning(channel.fit, channel.readings, rate=record.rate, length=record.duration, device=device)
    return replace(result, name=record.name)


def meaning_notes(found: Meaning | None, head: str, where: Where = "") -> Iterator[Part]:
    """What the coefficients of a channel mean, a line each."""
    if found is not None and found.sentences:
        yield Note(head, "strong", where, found.sentences)


LESS_RAMP = say(
    "The Hadamard deviation is blind to a ramp: what else there is at long averaging times, the hump of a loop or a "
    "random walk, stands out in it."
)


def beside_allan(channel: Channel, meant: Meaning | None, level: float) -> Iterator[Part]:
    """The Allan deviation and that of Hadamard, which the device calls for, or a loop beside a ramp."""
    claimed = [e for e in channel.fit or () if e.claimed]
    loop = any(TERMS[e.symbol].slope == 1 for e in claimed) and any(e.shape and lasting(e) for e in claimed)
    named = meant is not None and bool(meant.symbols) and DEVICES[meant.device].hadamard
    record, curve, name = channel.record, channel.curve, "ohdev"
    if not (named or loop) or curve is None or not isinstance(record, Record):
        return

    def drawn() -> Plot:
        other = deviation(record, name, taus="log", noise=channel.fit)
        return figures.plot_overlay(
            [panel for each in (curve, other) for panel in figures.panels_of(each, channel.fit)], level=level
        )

    titles = [statistic_named(each).title for each in (curve.statistic, name)]
    label = say("{first} and {second} of {channel}", first=titles[0], second=titles[1], channel=record.name)
    yield Drawing(drawn, label, LESS_RAMP, say("without the ramp"))


def meanings(each: Sequence[Meaning | None]) -> Iterator[Part]:
    """What the coefficients of each channel mean, in the terminal; a page says it with the channel."""
    for result in each:
        if result is not None:
            yield from meaning_notes(result, join(": ", (say("what it means"), result.name)), "text")


def causes_of(channels: Iterable[Channel], device: str | None) -> Iterator[Part]:
    """What may cause the terms that were found in any of these channels, in a device; nothing where none is named."""
    if device is not None:
        results = [meaning_of(channel, device) for channel in channels]
        yield from causes([replace(result, name="") for result in results if result is not None])


def causes(results: Sequence[Meaning]) -> Iterator[Part]:
    """The rows of a device's table for the terms that were found, with the channels that have them."""
    if not (results and results[0].device):
        return
    device = DEVICES[results[0].device]
    yield from (Note(note, "quiet") for note in dict.fromkeys(result.note for result in results if result.note))
    channels: dict[str, list[str]] = {}
    for result in results:
        for symbol in result.symbols:
            channels.setdefault(symbol, []).append(result.name)
    rows = []
    for symbol, cause in ((symbol, cause) for symbol, cause in device.terms.items() if symbol in channels):
        names = ", ".join(filter(None, channels[symbol]))
        sources, remedies = (join("; ", texts) for texts in (cause.sources, cause.remedies))
        head = say("{symbol} in a {device}: {cause}", symbol=symbol, device=device.title, cause=cause.name)
        points = (
            say("sources: {sources}", sources=sources), say("try: {remedies}", remedies=remedies),
            say("see {reference}", reference=cause.reference),
        )  # fmt: skip
        head = join("", (head, f" ({names})")) if names else head
        yield Note(head, "strong", where="text", points=points)
        rows.append([symbol, names, cause.name, sources, remedies, cause.reference])
    if rows:
        heads = (
            Column("", "symbol"), Column(say("channels"), "name"), Column(say("term"), "text"),
            Column(say("sources"), "text"), Column(say("what to try"), "text"), Column(say("reference"), "text"),
        )  # fmt: skip
        title = say("likely causes in a {device}", device=device.title)
        named = " ".join(row[-1] for row in rows)
        works = [join("", (key, ": ", text, ".")) for key, text in REFERENCES.items() if key in named]
        yield Table(heads, rows, title, key=join(" ", works), where="page")


@view()
def meaning_view(found: Meaning, _: float) -> Face:
    """What the coefficients of one record mean."""
    return one_sheet(
        say("What it means"), say("noise coefficients of an inertial sensor"), found.name or say("record"),
        (*meaning_notes(found, say("what it means")), *causes([found])),
    )  # fmt: skip
