"""How measured rates are shown."""

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from typing import Any

from allanite.applications.constant_rate import RATE_ESTIMATORS, Closeup, Experiment, Ranking, RateEstimate, closeup
from allanite.applications.constant_rate.campaign import DURATIONS, RateChannel, RateSettings, RateStudy
from allanite.applications.constant_rate.estimates import sheet_unit
from allanite.core.errors import UndrawnError
from allanite.core.record import Record
from allanite.phrases.phrase import join, say
from allanite.reporting import figures, words
from allanite.reporting.digits import digits, rounded
from allanite.reporting.first import DETAILS, FIGURES, PLUS_MINUS, Answer, ChannelRow, Channels, First, Remark, merged
from allanite.reporting.sheet import Column, Drawing, Face, Note, Part, Plot, Table, known, one_sheet

from . import Rows, rate_experiment as experiments, view
from .channels import by_sensor, fit_words, how_read, names_of, title_of
from .jobs import alerts, channel_sheet, doubts, job_face, source_of, warned


def first_of_rates(study: RateStudy, level: float) -> First:
    """The rate of each channel, of the whole record by the first of the methods where it has several intervals."""
    identified = study.settings.noise is None
    remarks = list(doubts([c for c in study.channels if c.refusal or identified]))
    own = list[Remark]()
    for channel in study.channels:
        name, experiment = channel.record.name or say("channel"), channel.experiment
        told_here = (text for text in channel.alerts if text not in map(str, warned(channel)))
        apart = _unsteady(experiment) if experiment else ""
        own += [Remark.of(name, text) for text in (apart, *told_here) if text]
    remarks += merged(own, len(study.channels))
    answer: list[Answer] = [_channels(alike, study, level) for alike in by_sensor(study.channels)]
    measured = [c.by_reversal or c.experiment for c in study.channels if c.experiment is not None]
    for experiment in measured[: len(study.channels) == 1]:
        answer += [experiments.table_of(experiment, level), *filter(None, [experiments.told(experiment)])]
    answer += dict.fromkeys(experiments.certain_limits([e for channel in study.channels for e in channel.estimates]))
    if study.settings.durations not in (DURATIONS, ()):
        answer += [table for channel in study.channels for table in islice(experiments.by_time(channel), 1)]
    half = say("±: {share} half width.", share=words.percent(level))
    if any(e.ranking is None and e.start.size > 1 for e in measured):
        half = say("±: {share} half width; without a model, by Student's t from the scatter of the intervals.",
                   share=words.percent(level))  # fmt: skip
    legend = [(PLUS_MINUS, half)]
    return First(title_of(study), "", answer, [*remarks, *alerts(study)], legend, how_read(study), [FIGURES, DETAILS])


def _unsteady(experiment: Experiment) -> str:
    """That the rate drifts, or differs between the intervals by more than the noise of their means."""
    if experiment.drift or experiment.start.size < 2:
        return experiment.drift
    scatter = experiment.scatter(experiment.methods[0], 0.95)
    told = say("the means scatter {ratio:.2g} times as much as predicted: the bias changes between the intervals",
               ratio=scatter.deviation / scatter.predicted if scatter.predicted else 0.0)  # fmt: skip
    return told if scatter.low > scatter.predicted > 0 else ""


def _channels(channels: Sequence[RateChannel], study: RateStudy, level: float) -> Channels:
    signal, unit = channels[0].record.signal, channels[0].record.signal.sheet[0]
    length, cells = words.duration(channels[0].record.duration), [_rate(channel, level) for channel in channels]
    rows = [ChannelRow(say("rate, mean over {length}", length=length), "", unit, cells, short=say("rate"))]
    experiments = [channel.experiment for channel in channels]
    several = [e for e in experiments if e is not None and e.start.size > 1]
    if several and len(study.channels) > 1:
        time = words.duration(several[0].duration)
        scatters = [None if e is None else e.scatters()[0] for e in experiments]
        shown = ["" if s is None else rounded(s.deviation) for s in scatters]
        predicted = ["" if s is None or math.isnan(s.predicted) else rounded(s.predicted) for s in scatters]
        rows.append(ChannelRow(say("scatter of {time} means", time=time), "", unit, shown, short=say("scatter")))
        rows.append(ChannelRow(say("predicted for {time}", time=time), "", unit, predicted, 2, say("predicted")))
        best = ["" if e is None else (e.ranking or e).chosen for e in experiments]
        rows.append(ChannelRow(say("method for {time}", time=time), "", "", best, short=say("method")))
    norths = ["" if c.north is None else _number(c.north.heading, c.north.low, c.north.high) for c in channels]
    biases = ["" if c.bias is None else _size(c.bias, level) for c in channels]
    rows.append(ChannelRow(say("north"), "", "deg", norths))
    rows.append(ChannelRow(say("bias by reversal"), "", unit, biases, short=say("bias")))
    fits = [fit_words(channel.noise, channel.refusal) for channel in channels]
    rows.append(ChannelRow(say("model fit"), "", "", fits, short=say("model")))
    return Channels(names_of(channels), [row for row in rows if any(row.cells)], signal.sensor)


def _rate(channel: RateChannel, level: float) -> str:
    """The rate over the record: its error is that under the noise model, or else by the scatter of intervals alike."""
    found = next(iter((*channel.certain, *channel.estimates)), channel.whole)
    measured = channel.by_reversal or channel.experiment
    apart = found is not None and measured is not None and found.method not in measured.methods
    if measured is None or (found is not None and (apart or math.isfinite(found.interval(level)[0]))):
        return "" if found is None else _size(found, level)
    method = measured.methods[0] if found is None else found.method
    value = float(measured.rates[measured.methods.index(method)].mean()) if found is None else found.value
    half = measured.half_width(method, level) / math.sqrt(measured.start.size)
    half = math.nan if measured.drift or not half > 0 else half
    _, factor = sheet_unit(measured.signal)
    return _number(*(v / factor for v in (value, value - half, value + half)))


def _size(estimate: RateEstimate, level: float) -> str:
    _, factor = sheet_unit(estimate.signal)
    return _number(*(v / factor for v in (estimate.value, *estimate.interval(level))))


def _number(value: float, low: float, high: float) -> str:
    number = digits(value, low, high, figures=6)
    return f"{number.value} ± {number.half}" if number.half else number.plain()[0]


NO_ERROR = say("no standard errors: give a noise model (--noise)")


def _parts(channel: RateChannel, settings: RateSettings, level: float) -> Iterator[Part]:
    given = settings.noise
    if channel.noise is not None and channel.noise.explained:
        yield Note(say("noise: {model}", model=str(channel.noise.fit.model)))
    elif given is not None and not channel.refusal:
        yield Note(say("noise as given: {model}", model=str(given)))
    experiment = channel.experiment
    if experiment is None:
        return
    yield from experiments.sentences(experiment)
    yield from _reversed(channel, level)
    if channel.north is not None:
        yield Note(channel.north.words(), "strong")
    if experiment.start.size > 1:
        yield experiments.table_of(experiment, level)
    yield from experiments.by_time(channel)
    yield from _estimates(channel.estimates, level, modeled=experiment.ranking is not None)
    yield Drawing(lambda: _draw([channel]), say("errors of all methods"), experiments.CAPTION)
    if experiment.start.size > 1:
        yield experiments.every_interval(experiment)
    if isinstance(channel.record, Record):
        yield from experiments.closeup_parts(first_of(channel.record, experiment, settings), "page")


def _reversed(channel: RateChannel, level: float) -> Iterator[Part]:
    """Rate and bias by the reversal of the gyro, and how the rates of its pairs of intervals scatter."""
    if channel.bias is not None:
        yield Note(say("rate by reversal: {rate}", rate=channel.estimates[0].words(level=level)), "strong")
        yield Note(say("bias by reversal: {bias}", bias=channel.bias.words(level=level)))
    if channel.by_reversal is not None and channel.by_reversal.start.size > 1:
        yield Note(say("by reversal, half the differences of intervals of both recordings:"))
        yield experiments.table_of(channel.by_reversal, level)


def first_of(record: Record, found: Experiment, settings: RateSettings) -> Closeup:
    """The first interval of an experiment in detail."""
    return closeup(record, settings=settings.experiment, start=float(found.start[0]))


METHODS = Table(
    (Column(say("method"), "symbol"), Column(say("what it is"), "text"), Column(say("formula"), "formula"),
     Column(say("optimal under"), "text"), Column(say("source"), "text")),
    [[r.name, r.title, r.formula, r.assumes, r.reference] for r in RATE_ESTIMATORS.values()], say("the methods"),
)  # fmt: skip


def interval_rows(study: RateStudy) -> Rows:
    """The rate of every interval by every method, unrounded, in the unit of data sheets."""
    heads = ("channel", "interval", "start_s", "duration_s", "method", "rate", "error", "unit")
    rows = []
    for e in (channel.experiment for channel in study if channel.experiment is not None):
        unit, factor = sheet_unit(e.signal)
        rates, errors = (e.rates.T / factor).tolist(), (e.errors.T / factor).tolist()
        rows += [[e.name, i + 1, start, e.duration, *cells, unit] for i, start in enumerate(e.start.tolist())
                 for cells in zip(e.methods, rates[i], errors[i], strict=True)]  # fmt: skip
    return heads, rows


def _estimates(estimates: Sequence[RateEstimate], level: float, *, modeled: bool = False) -> Iterator[Part]:
    if not estimates:
        return
    rows = []
    for e in estimates:
        unit, factor = sheet_unit(e.signal)
        rows.append([e.method, *digits(e.to(unit), *(v / factor for v in e.interval(level)), figures=8).plain(), unit])
    heads = (Column(say("method"), "symbol"), Column(say("rate")), Column(words.interval(level), "interval"))
    yield Table((*heads, Column(say("unit"), "unit")), rows)
    unknown = [e.method for e in estimates if math.isnan(e.standard_error) and e.limits is None]
    if unknown:
        between = say("no limits for {methods}: no staircase fits all counts, so that none are certain, and with so "
                      "little noise beside a pulse the error follows no model", methods=", ".join(unknown))  # fmt: skip
        yield Note(between if modeled else NO_ERROR)
    yield from map(Note, experiments.certain_limits(estimates))


def _draw(channels: Iterable[RateChannel]) -> Plot:
    shown = [(c.experiment, c.by_duration) for c in channels if c.experiment is not None]
    if not shown:
        raise UndrawnError("there is nothing to draw: no channel was measured")
    return figures.plot_rates(shown)


def _rows(study: RateStudy, level: float) -> Rows:
    rows: list[list[Any]] = []
    for channel in study.channels:
        for experiment in (*experiments.series_of(channel), *filter(None, [channel.by_reversal])):
            whole = experiment is channel.experiment and experiment.start.size == 1  # an estimate, below
            rows += () if whole else experiments.experiment_rows(experiment)
        for e in channel.estimates:
            unit, factor = sheet_unit(e.signal)
            numbers = [v / factor for v in (e.value, *e.interval(level), e.standard_error)]
            rows.append([channel.record.name, e.method, e.duration, 1, *map(experiments.finite, numbers[:3]), *[""] * 7,
                         experiments.finite(numbers[3]), *[""] * 6, 1 + (channel.bias is not None), unit])  # fmt: skip
    return experiments.HEADINGS, rows


@view(
    lambda values, fit, level: _draw(channel for study in values for channel in study),
    _rows,
    lambda study, level: interval_rows(study),
    first_of_rates,
)
def study_view(study: RateStudy, level: float) -> Face:
    """The rate of each channel by every method."""
    sheets = []
    for channel in study.channels:
        told = "" if channel.experiment is None else experiments.told(channel.experiment)
        verdict = say("no result: {reason}", reason=channel.refusal) if channel.refusal else told
        verdicts = (join(", ", (channel.record.name or say("the channel"), verdict)),) if verdict else ()
        explained = study.settings.noise is not None or (channel.noise is not None and channel.noise.explained)
        grade = "" if (explained or channel.certain) and not channel.refusal else "alert"
        sheets.append(channel_sheet(channel, _parts(channel, study.settings, level), verdicts, grade))
    title = say("Rate of {source}", source=source_of(study))
    return job_face(study, (title, experiments.BRAND), sheets, how=[METHODS])


@view(rows=lambda ranking, level: ranking.rows())
def ranking_view(ranking: Ranking, _: float) -> Face:
    """The methods in the order of their standard errors."""
    error = Column(say("standard error, {unit}", unit=ranking.signal.sheet[0]), form=known(".4g"))
    heads = Column(say("method"), "name"), error, Column(say("over the bound"), form=known(".4g"))
    noise = Note(say("noise: {model}", model=str(ranking.model)))
    parts = Note(experiments.told(ranking), "strong"), noise, Table(heads, ranking.rows()[1])
    return one_sheet(say("Methods"), experiments.BRAND, say("methods"), parts, how=(METHODS,))


@view()
def estimate_view(found: RateEstimate, level: float) -> Face:
    """One rate."""
    parts = (*(Note(str(finding), "warning") for finding in found.findings), *_estimates([found], level))
    names = found.name or say("Rate"), experiments.BRAND, found.name or say("rate")
    return one_sheet(*names, parts, about=found.history)
