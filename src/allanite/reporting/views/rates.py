"""The first screen of measured rates: the rate with its interval, what it scatters, and the best method."""

import math
from collections.abc import Sequence

from allanite.applications.constant_rate import RateEstimate, estimate, subtract_bias
from allanite.applications.constant_rate.campaign import DURATIONS, RateChannel, RateStudy
from allanite.applications.constant_rate.estimates import rate_factor
from allanite.core.record import Record
from allanite.phrases.phrase import say
from allanite.reporting import words
from allanite.reporting.digits import digits, rounded
from allanite.reporting.first import DETAILS, FIGURES, PLUS_MINUS, Answer, Axes, First, Quantity, Remark, merged

from .axes import by_sensor, fit_words, how_read, names_of, title_of
from .rate_experiment import by_time, certain_limits, series_of, told
from .remarks import alerts, doubts, warned


def first_of_rates(study: RateStudy, level: float) -> First:
    """The rate of each channel, of the whole record by the first of the methods where it has several intervals."""
    identified = study.settings.noise is None
    remarks = list(doubts([c for c in study.channels if c.refusal or identified]))
    own = list[Remark]()
    for channel in study.channels:
        name, found = channel.record.name or say("channel"), channel.experiment
        told_here = (text for text in channel.alerts if text not in map(str, warned(channel)))
        own += [Remark.of(name, text) for text in (found.drift if found else "", *told_here) if text]
    remarks += merged(own, len(study.channels))
    answer: list[Answer] = [_axes(alike, study, level) for alike in by_sensor(study.channels)]
    ranked = [c.experiment.ranking for c in study.channels if c.experiment is not None]
    answer += dict.fromkeys(told(ranking) for ranking in ranked if ranking is not None)
    answer += dict.fromkeys(text for channel in study.channels for text in certain_limits(channel.estimates))
    if study.settings.durations not in (DURATIONS, ()):
        answer += [next(by_time(series_of(c))) for c in study.channels if any(e.start.size > 1 for e in c.by_duration)]
    legend = [(PLUS_MINUS, say("±: {share} half width.", share=words.percent(level)))]
    return First(title_of(study), "", answer, [*remarks, *alerts(study)], legend, how_read(study), [FIGURES, DETAILS])


def _axes(channels: Sequence[RateChannel], study: RateStudy, level: float) -> Axes:
    signal, unit = channels[0].record.signal, channels[0].record.signal.sheet[0]
    length, rows = words.duration(channels[0].record.duration), list[Quantity]()
    cells = [_rate(_whole(channel, study), channel, level) for channel in channels]
    rows.append(Quantity(say("rate, mean over {length}", length=length), "", unit, cells, short=say("rate")))
    norths = ["" if c.north is None else _number(c.north.heading, c.north.low, c.north.high) for c in channels]
    biases = ["" if c.bias is None else _size(c.bias, level) for c in channels]
    found = [channel.experiment for channel in channels]
    several = [e for e in found if e is not None and e.start.size > 1]
    if several:
        time = words.duration(several[0].duration)
        scatters = [None if e is None else e.scatter(e.methods[0]) for e in found]
        factor = rate_factor(unit, signal)
        shown = ["" if s is None else rounded(s.deviation / factor) for s in scatters]
        told = ["" if s is None or math.isnan(s.predicted) else rounded(s.predicted / factor) for s in scatters]
        rows.append(Quantity(say("scatter of {time} means", time=time), "", unit, shown, short=say("scatter")))
        rows.append(Quantity(say("predicted for {time}", time=time), "", unit, told, 2, say("predicted")))
    rows.append(Quantity(say("north"), "", "deg", norths))
    rows.append(Quantity(say("bias by reversal"), "", unit, biases, short=say("bias")))
    fits = [fit_words(channel.noise, channel.refusal) for channel in channels]
    rows.append(Quantity(say("model fit"), "", "", fits, short=say("model")))
    return Axes(names_of(channels), [row for row in rows if any(row.cells)], signal.sensor)


def _whole(channel: RateChannel, study: RateStudy) -> RateEstimate | None:
    """The rate over the record: as measured, or of several intervals by the first method."""
    if channel.estimates or channel.experiment is None or not isinstance(channel.record, Record):
        return next(iter((*channel.certain, *channel.estimates)), None)
    chosen, model = study.settings.experiment_on(channel.record), study.settings.noise
    if model is None and channel.noise is not None and channel.noise.explained:
        model = channel.noise.fit.usable()
    method = channel.experiment.methods[0]
    found = estimate(channel.record, method, model=model, dither=chosen.dither, options=chosen.options)
    return subtract_bias(found, chosen.bias, channel.record.signal.unit) if chosen.bias else found


def _rate(found: RateEstimate | None, channel: RateChannel, level: float) -> str:
    if found is not None:
        return _size(found, level)
    if channel.experiment is None:
        return ""
    return rounded(channel.experiment.reference / rate_factor(channel.record.signal.sheet[0], channel.record.signal))


def _size(found: RateEstimate, level: float) -> str:
    factor = rate_factor(found.signal.sheet[0], found.signal)
    low, high = (limit / factor for limit in found.interval(level))
    return _number(found.value / factor, low, high)


def _number(value: float, low: float, high: float) -> str:
    number = digits(value, low, high, figures=6)
    half = (high - low) / 2 / 10.0**number.exponent
    return f"{number.value} ± {half:.{len(number.value.partition('.')[2])}f}" if number.low else number.plain()[0]
