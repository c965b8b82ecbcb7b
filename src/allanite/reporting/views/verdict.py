"""What was found in a channel, in a sentence."""

from collections.abc import Iterator

from allanite.core.arrays import mean_and_deviation
from allanite.core.header import Header
from allanite.core.record import Record
from allanite.core.units import convert
from allanite.core.validity import APPROXIMATE, graded
from allanite.phrases.phrase import Phrase, join, say
from allanite.reporting import words
from allanite.reporting.digits import printable
from allanite.study.results import Channel


def mean_and_spread(record: Record) -> tuple[float, float]:
    """Mean and standard deviation of a record, in the unit of data sheets."""
    return mean_and_deviation(record.rate_values / convert(1.0, record.signal.sheet[0], record.signal.unit))


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


def verdict(channel: Channel, level: float) -> str:
    """The result for a channel in one or two sentences."""
    name = printable(channel.record.name) or say("the channel")
    if channel.fit is None:
        reason = channel.refusal or say("nothing was fitted")
        return say("{channel} gives no result: {reason}.", channel=name, reason=reason)
    if not channel.explained:
        return say("{channel}: not explained. Its coefficients are not valid.", channel=name)
    found = []
    for e in channel.fit:
        if e.value is not None and e.status != "not valid":
            said = join(" ", (words.named(e, level), words.number(e, level)))
            found.append(say("{term} (weak)", term=said) if e.status == "weak" else said)
    sensor = channel.record.signal.a_sensor
    first = say("{channel} is {sensor} of which no noise term was identified.", channel=name, sensor=sensor)
    if found:
        *others, last = found
        terms = say("{terms} and {last}", terms=join(", ", others), last=last) if others else last
        first = say("{channel} is {sensor} with {terms}.", channel=name, sensor=sensor, terms=terms)
    noise, more = channel.noise, list(_missing(channel))
    if noise is not None and noise.validity == APPROXIMATE:  # how good the model is
        more.append(say("{sentence}.", sentence=words.capital(graded(noise.validity, noise.fit.scope))))
    return join(" ", (first, *more))


def _missing(channel: Channel) -> Iterator[Phrase]:
    """Sentences about the terms without a result."""
    length = words.duration(channel.record.duration)
    if absent := _titles(channel, "absent", "reported", "negative"):
        yield say("Not identified in {length} of data: {terms}.", length=length, terms=absent)
    if unseen := _titles(channel, "not observable"):
        yield say("Not observable: {terms}.", terms=unseen)
    if wrong := _titles(channel, "not valid"):
        yield say("Not valid: {terms}.", terms=wrong)


def _titles(channel: Channel, *statuses: str) -> str:
    """Names of the terms without a result that have one of these statuses."""
    there = (e for e in channel.fit or () if e.status in statuses and (e.value is None or e.status == "not valid"))
    return join(", ", (words.title(e.symbol, e.signal) for e in there))
