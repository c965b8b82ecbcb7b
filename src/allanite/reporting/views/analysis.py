"""How a study is shown."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from allanite.core.display_units import readable_unit
from allanite.core.encoding import finite
from allanite.core.errors import DataError, UndrawnError
from allanite.core.estimate import STATUSES
from allanite.core.fit import Fit
from allanite.core.plain import Header
from allanite.core.readings import MINIMUM, minimum_title
from allanite.core.record import Record, Recording
from allanite.identification.methods import METHODS
from allanite.interpretation.sentences import Meaning
from allanite.phrases.phrase import Phrase, join, say, say_count, spelled
from allanite.reporting import figures, words
from allanite.reporting.first import First
from allanite.reporting.sheet import Column, Deferred, Drawing, Face, Fold, Note, Part, Plot, Sheet, Table, header_of
from allanite.statistics import statistic_named
from allanite.statistics.spectra.spectrum import spectrum
from allanite.study.results import Channel, Study

from . import Rows, view
from .channels import first_of
from .datasheet import DATA_SHEET, alternative, data_sheet_table
from .expectation import beside_allan, causes, meaning_notes, meaning_of, meanings
from .export import filter_parts
from .fit import coefficients, definitions, goodness_parts
from .jobs import channel_sheet, job_face, mean_and_spread, remark_notes, source_of
from .values import numbers_table, readings_table, rows_of


def _records(value: Record | Recording) -> Sequence[Record]:
    records = value.records if isinstance(value, Recording) else (value,)
    if not all(isinstance(record, Record) for record in records):
        raise UndrawnError("a stored recording has no samples: read its file once more")
    return records


def _samples(value: Record | Recording, _: float) -> Rows:
    """Time and samples."""
    records = _records(value)
    columns = (records[0].time.tolist(), *(record.values.tolist() for record in records))
    heads = ["time [s]", *(f"{record.name} [{record.unit}]".lstrip() for record in records)]
    return heads, [list(row) for row in zip(*columns, strict=False)]


@view(lambda values, _, __: figures.plot_records([r for value in values for r in _records(value)]), _samples)
def record_view(value: Record | Recording, _: float) -> Face:
    """What each record is, and its samples."""
    sheets = [
        Sheet(
            record.name or say("the record"),
            (words.about(record), *record.history),
            (over_time(record),) if isinstance(record, Record) else (),
        )
        for record in (value.records if isinstance(value, Recording) else (value,))
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
    facts = say("mean {mean:.6g}, standard deviation {deviation:.4g} {unit}", mean=mean, deviation=deviation, unit=unit)
    if channel.refusal:
        return facts if np.isfinite(deviation) else ""  # nothing is known where all samples are missing
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


BRAND = say("noise coefficients of an inertial sensor")

EXPLAINED = {
    "whittle": (say(
        "The rate record is transformed by the orthonormal discrete cosine transform (DCT-II), which removes the "
        "constant bias and does not leak where the two ends of the record differ. Each squared coefficient has a "
        "chi-square distribution with one degree of freedom about the power expected under the model: the sum of the "
        "squared noise coefficients, each times the known spectrum of its term (Whittle likelihood). The model is the "
        "set of terms, none negative, with the highest likelihood; a ramp is estimated jointly, with its sign."
    ), say(
        "A noise term is identified where the models that have it weigh e times as much as those without it, and a "
        "ramp where its 97.7 % limits exclude zero: by chance alone in about 2 % of records without it. Which terms "
        "are present is never certain: each coefficient is averaged over all sets of terms that have it, weighted "
        "by their Akaike criterion, with the other coefficients following. The value is the median of that "
        "distribution, which is flat in the coefficient where nothing is known, and the interval lies between its "
        "quantiles. A term that is not identified has a one-sided 95 % upper limit instead of a value."
    )),
    "gls": (say(
        "The squares of the noise coefficients, none below zero, are fitted to the variance at octaves of the "
        "averaging time up to a quarter of the record, or up to half of the longest one of the statistic if that is "
        "more, with the covariance that the fitted model itself gives the points (generalized least squares, "
        "iterated). Standard errors come from the same covariance. Limits are the coefficients that a likelihood ratio "
        "test does not reject, with the covariance and the degrees of freedom at the coefficient tested; a term is "
        "identified where the ratio against its absence exceeds 4."
    ),),
}  # fmt: skip
"""How a method works, in a few sentences; without them its title is enough."""

CURVE_ALONE = say("The curve is estimated independently and shown for comparison: no coefficient was read off it.")
LIMITS_KEY = say(
    "The intervals of the curve come from the exact distribution of the statistic, averaged over the noise models that "
    "the record leaves open: a random walk that was not identified may still be present."
)
SHARED = say(
    "Correlation of the residuals of two channels: sample by sample, and of means over 64 segments of the record. In "
    "independent channels the second lies within +-0.25 with 95 % probability."
)


def _sheet(
    channel: Channel, level: float, panel: "figures.CurvePanel | None" = None, meant: Meaning | None = None
) -> Sheet:
    if panel is None:
        panel = next(iter(figures.panels_of(channel, demand=False)), None)
    return channel_sheet(channel, _parts(channel, level, panel, meant))


def _parts(channel: Channel, level: float, panel: "figures.CurvePanel | None", meant: Meaning | None) -> Iterator[Part]:
    if channel.fit is None:
        yield from map(Note, filter(None, [fitness(channel)]))
        if isinstance(record := channel.record, Record) and np.isfinite(record.extent[0]) and not record.out_of_range:
            yield over_time(record)
        return
    # what a warning or the verdict says is not repeated
    points = channel.noise.statement.points if channel.noise else ()
    warned = tuple(finding.what for finding in channel.quality.warnings)
    untold = (note for note in channel.fit.advice if not note.startswith(warned))
    advice = [note for note in untold if not any(point.startswith(note) for point in points)]
    yield from (Note(note, "remark", "text") for note in advice)
    yield from coefficients(channel.fit, level)
    if channel.curve is not None and panel is not None:
        supposed = channel.curve.supposed
        caption = say("{sentence}.", sentence=words.capital(supposed)) if supposed else ""
        label = alternative(channel, channel.curve, level)
        yield Drawing(lambda: figures.plot_panels([panel], level=level, titled=False), label, caption)
    yield from beside_allan(channel, meant, level)
    yield from meaning_notes(meant, say("what it means"), "page")
    yield replace(data_sheet_table(channel, level), where="" if channel.explained else "page")
    if channel.readings is not None:
        table = readings_table(channel.readings, level)
        yield from () if channel.explained else (replace(table, where="text"),)  # where there is no data sheet
        yield Fold(say("read off the curve"), [table], shut=True)
    yield from details(channel, level, panel, advice)


def _together(study: Study, panels: "Sequence[figures.CurvePanel]", first: First, level: float) -> Iterator[Part]:
    """All channels in one figure, their values for a filter, the remarks of the first screen, the correlation."""
    if len(panels) > 1:
        names = ", ".join(panel.name for panel in panels)
        title = statistic_named(panels[0].curve.statistic).title
        label = say("{statistic} of {channels} in one panel", statistic=title, channels=names)
        yield Drawing(lambda: figures.plot_overlay(panels, level=level), label)
    yield from filter_parts(study)
    yield from remark_notes(first.remarks)
    if study.shared is not None:
        heads = (
            Column(say("channel"), "name"), Column(say("and"), "name"), Column(say("fast"), form="+.3f"),
            Column(say("slow"), form="+.2f"),
        )  # fmt: skip
        table = Table(heads, study.shared.rows()[1], key=SHARED)
        yield Fold(say("correlation of the channels"), [table], shut=True)


def _statuses(study: Study) -> Iterator[Part]:
    met = {e.status for c in study.channels for e in c.fit or ()}
    for status in STATUSES.values():
        if status.name in met:
            yield Note(say("{status}: {meaning}", status=status.name, meaning=status.meaning), "quiet", where="text")


def _how(study: Study) -> Iterator[Part]:
    recipe, fits = study.recipe, [channel.fit for channel in study.channels if channel.fit]
    row = METHODS.get(recipe.method)
    if row is not None:
        facts = {"method": recipe.method, "title": row.title, "efficiency": row.efficiency}
        yield Note(say("Method: {method}, {title}; measured: {efficiency}.", **facts))
    yield from (Note(paragraph) for paragraph in EXPLAINED.get(recipe.method, ()))
    alone: Phrase = CURVE_ALONE
    if row is not None and row.statistic:
        statistic = recipe.statistic if recipe.statistic in row.allowed else row.statistic
        alone = say(
            "The coefficients were read off a curve, {statistic}: the notes say from which points.", statistic=statistic
        )
    yield Note(join(" ", (alone, LIMITS_KEY)))
    yield Note(DATA_SHEET)
    met = {e.status for fit in fits for e in fit}
    rows = [[status.name, status.meaning] for status in STATUSES.values() if status.name in met]
    yield Table((Column(say("status"), "status"), Column(say("meaning"), "text")), rows)
    yield definitions(fits)


def _coefficients(study: Study, level: float) -> Rows:
    """Coefficients, values read off the curve and data sheet of each channel; an absent term has an upper limit."""
    heads = (
        "channel", "term", "name", "value", "low", "high", "unit", "status", "tau_s", "si_value", "si_unit", "remark"
    )  # fmt: skip
    rows: list[list[Any]] = []
    for channel in study.channels:
        name = channel.record.name
        for e in channel.fit or ():
            shown, title = e.to_dict(level)["shown"].values(), words.title(e.symbol, e.signal)
            remark = ", ".join([*words.shapes(e, level), *(["without sign"] if words.symbol(e) != e.symbol else [])])
            rows.append([name, e.symbol, title, *shown, e.status, "", e.value, e.unit, remark])
            rows += [
                [name, f"{e.symbol}.{p.name}", p.title, *map(finite, size), p.unit, e.status, "", size[0], p.unit, ""]
                for p, *size in e.shaped(level)
                if e.value is not None
            ]
        for title, tau, *size, si, si_unit, remark in channel.readings.rows(level)[1] if channel.readings else ():
            term = MINIMUM if title == minimum_title(channel.record.signal) else ""
            rows.append([name, term, title, *size, "reading", tau, si, si_unit, remark])
        for entry in (entry for entry in channel.data_sheet(level) if not entry.coefficient):
            size = [entry.value, entry.low, entry.high, entry.unit]
            rows.append([name, "", entry.quantity, *size, "data sheet", entry.tau, None, "", entry.remark])
    return heads, rows


def _plot(values: "Sequence[Study | Channel]", fit: Fit | None, level: float) -> Plot:
    """The curves of the channels; of channels that were only looked at, their samples over time."""
    panels = figures.panels_of(list(values), fit, demand=False)
    if panels:
        return figures.plot_panels(panels, level=level)
    channels = [channel for value in values for channel in (value.channels if isinstance(value, Study) else (value,))]
    records = [channel.record for channel in channels if isinstance(channel.record, Record)]
    if not records:
        raise UndrawnError(
            "there is no curve to draw, and no samples are in memory; draw a part of the recording: "
            + spelled("info --from TIME --until TIME --plot PATH", "al.plot(al.read(path, start=..., until=...))")
        )
    return figures.plot_records(records)


@view(
    _plot,
    lambda study, level: rows_of(
        [c.curve.to(readable_unit(c.curve.unit)) for c in study.channels if c.curve is not None], level
    ),
    _coefficients,
    first_of,
)
def study_view(study: Study, level: float) -> Face:
    """A study: its channels, with what their coefficients mean."""
    fitted = any(channel.fit for channel in study.channels)
    panels = {panel.name: panel for panel in figures.panels_of(study, demand=False)}
    meant = [meaning_of(channel, study.recipe.device) for channel in study.channels]
    sheets = [
        _sheet(channel, level, panels.get(channel.record.name), meaning)
        for channel, meaning in zip(study.channels, meant, strict=True)
    ]
    method = say(", method {method}", method=study.recipe.method)
    # sensors, sampling rate and length in a line
    records = [channel.record for channel in study.channels]
    sensors = Counter(record.signal.a_sensor for record in records)
    counted = [
        say_count(n, "{count} channel of {sensor}", "{count} channels of {sensor}", sensor=sensor)
        for sensor, n in sensors.items()
    ]
    same = {(f"{r.rate:.8g} Hz", words.duration(r.duration), say("{count} samples", count=r.size)) for r in records}
    facts = [*counted, *(next(iter(same)) if len(same) == 1 else ())]
    first, shared = first_of(study, level), () if study.shared is None else study.shared.findings
    face = job_face(
        study, (say("Noise of {source}", source=source_of(study)), BRAND), sheets,
        (Note(str(finding), "warning") for finding in shared),
        header=header_of(study.provenance, study.notes, method if fitted else ""),
        close=[*meanings(meant), *_statuses(study)], how=list(_how(study)), device=study.recipe.labels, facts=facts,
        summary=first,
    )  # fmt: skip
    parts = [
        *_together(study, list(panels.values()), first, level),
        *(replace(part, where="text") for part in face.parts),  # on a page the remarks say it
        *causes([meaning for meaning in meant if meaning is not None]),
    ]
    return replace(face, parts=parts)


@view(_plot)
def channel_view(channel: Channel, level: float) -> Face:
    """One channel of a study."""
    return Face(channel.record.name or say("channel"), BRAND, (_sheet(channel, level),))
