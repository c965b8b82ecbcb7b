"""How records are shown, and what a page shows beside the coefficients of their channels."""

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from allanite.core.errors import DataError
from allanite.core.fit import Fit
from allanite.core.plain import Header
from allanite.core.record import Record, Recording
from allanite.phrases.phrase import join, say
from allanite.reporting import figures, words
from allanite.reporting.sheet import Column, Deferred, Drawing, Face, Fold, Note, Part, Plot, Sheet, Table
from allanite.statistics import statistic_named
from allanite.statistics.spectra.spectrum import spectrum
from allanite.study.results import Channel

from . import Rows, view
from .fit import goodness_parts
from .jobs import mean_and_spread
from .values import numbers_table


def _records(value: Record | Recording) -> Sequence[Record]:
    return value.records if isinstance(value, Recording) else (value,)


def _plot_records(values: Sequence[Record | Recording], _: Fit | None, __: float) -> Plot:
    return figures.plot_records([record for value in values for record in _records(value)])


def _samples(value: Record | Recording, _: float) -> Rows:
    """Time and samples."""
    records = _records(value)
    columns = (records[0].time.tolist(), *(record.values.tolist() for record in records))
    heads = ["time [s]", *(f"{record.name} [{record.unit}]".lstrip() for record in records)]
    return heads, [list(row) for row in zip(*columns, strict=False)]


@view(_plot_records, _samples)
def record_view(value: Record | Recording, _: float) -> Face:
    """What each record is, and its samples."""
    sheets = [
        Sheet(record.name or say("the record"), (words.about(record), *record.history), (over_time(record),))
        for record in _records(value)
    ]
    return Face(say("Samples over time"), say("a recording of an inertial sensor"), sheets)


STRIP = say(
    "Deviation over that expected under the model, with its confidence band, which holds 1 if the model is right."
)
CORRELATION = say(
    "Correlation of the estimated coefficients under the best model. Estimates that are correlated by nearly -1 can "
    "hardly be told apart: only a longer record, or a higher sampling rate, separates them."
)
RECORD = say("Every sample, as the range of short stretches, and means.")
SPECTRUM = say(
    "One-sided amplitude spectral density with its confidence band (Welch's method, ten values per decade). The level "
    "of white noise is sqrt(2) N."
)


def overlay(panels: Sequence[figures.CurvePanel], level: float) -> Iterator[Part]:
    """The curves of all channels in one figure."""
    if len(panels) < 2:
        return
    names = ", ".join(panel.name for panel in panels)
    title = statistic_named(panels[0].curve.statistic).title
    label = say("{statistic} of {channels} in one panel", statistic=title, channels=names)
    yield Drawing(lambda: figures.plot_overlay(panels, level=level), label)


def details(
    channel: Channel, level: float, panel: "figures.CurvePanel | None", advice: Sequence[str]
) -> Iterator[Part]:
    """Residuals, what else the record may be, the samples and their spectrum; on the page only."""
    assert channel.fit is not None  # noqa: S101 - the caller has looked
    checked = list(goodness_parts(channel.fit, channel.residuals))
    if panel is not None and panel.drawn is not None:
        name = channel.record.name
        label = say("observed over expected deviation of {channel} by averaging time", channel=name)
        strip = Drawing(lambda: figures.plot_strip(panel, level=level), label, STRIP, say("the curve over its model"))
        checked.insert(0, strip)
    fit = channel.fit
    if fit.correlation is not None and fit.valid is not None:
        known = np.flatnonzero(~np.isnan(np.diag(fit.correlation)))
        symbols = [fit.estimates[i].symbol for i in known]
        heads = (Column("", "name"), *(Column(symbol, form="+.2f") for symbol in symbols))
        rows = [[symbol, *fit.correlation[i, known]] for symbol, i in zip(symbols, known, strict=True)]
        table = Table(heads, rows, say("correlation of the estimates"), key=CORRELATION)
        checked += [table] if len(known) > 1 else []
    checked += map(Note, advice)
    yield from [Fold(say("residuals: does the model explain the record?"), checked, shut=True)] if checked else []
    record = channel.record
    if isinstance(record, Record):
        yield Fold(say("record and spectrum"), Deferred(partial(_raw, record, channel, level)), shut=True)
    if panel is not None:
        shown = panel.curve.to(panel.unit)
        yield numbers_table(shown, level, say("the curve in numbers"), where="page")


def fitness(channel: Channel) -> str:
    """Mean and spread of a channel, and whether it can be analyzed."""
    record = channel.record
    if isinstance(record, Header):
        return ""
    unit, (mean, deviation) = record.signal.sheet[0], mean_and_spread(record)
    facts = say(
        "mean {mean:.6g}, standard deviation {deviation:.4g} {unit}",
        mean=mean, deviation=deviation, unit=unit,
    )  # fmt: skip
    if channel.refusal:
        return facts
    fit = say("fit for analysis, with caution") if channel.quality.warnings else say("fit for analysis")
    return join("; ", (facts, fit))


def over_time(record: Record) -> Drawing:
    """The record over time, with its mean and spread as the words for it."""
    mean, deviation = mean_and_spread(record)
    label = say(
        "{channel} over {length}: mean {mean:.4g}, standard deviation {deviation:.4g} {unit}",
        channel=record.name or say("the record"), length=words.duration(record.duration), mean=mean,
        deviation=deviation, unit=record.signal.sheet[0],
    )  # fmt: skip
    return Drawing(lambda: figures.plot_records([record]), label, RECORD)


def _raw(record: Record, channel: Channel, level: float) -> Iterator[Part]:
    yield over_time(record)
    unit = record.signal.sheet[0]
    try:
        density = spectrum(record, bins=10)
    except DataError as error:
        yield Note(say("no spectrum: {reason}", reason=str(error)), "quiet", where="page")
        return
    fits = {} if channel.fit is None else {record.name: channel.fit}
    shown = density.to(unit)
    first, last = (f"{shown.amplitude[i]:.3g} {shown.amplitude_unit}" for i in (0, -1))
    label = say(
        "one-sided amplitude spectral density of {channel}: {first} at {low:.3g} Hz and {last} at {high:.3g} Hz",
        channel=record.name, first=first, low=shown.frequency[0], last=last, high=shown.frequency[-1],
    )  # fmt: skip
    yield Drawing(lambda: figures.plot_spectra([density], fits, level=level), label, SPECTRUM)
