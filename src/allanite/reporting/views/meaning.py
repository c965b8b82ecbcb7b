"""How the meaning of coefficients is shown."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from allanite.interpretation.causes import Meaning, meaning
from allanite.interpretation.device import REFERENCES
from allanite.interpretation.devices import DEVICES
from allanite.phrases.phrase import join, say
from allanite.reporting.sheet import Column, Face, Note, Part, Table, Where, one_sheet
from allanite.study.results import Channel

from . import view


def meaning_of(channel: Channel, device: str | None) -> Meaning | None:
    """What the coefficients of a channel mean; None where it has none."""
    if channel.fit is None:
        return None
    record = channel.record
    found = meaning(channel.fit, channel.readings, rate=record.rate, length=record.duration, device=device)
    return replace(found, name=record.name)


def meaning_notes(found: Meaning | None, head: str, where: Where = "") -> Iterator[Part]:
    """What the coefficients of a channel mean, a line each."""
    if found is not None and found.sentences:
        yield Note(head, "strong", where, found.sentences)


def meanings(found: Sequence[Meaning | None]) -> Iterator[Part]:
    """What the coefficients of each channel mean, in the terminal; a page says it with the channel."""
    for one in found:
        if one is not None:
            yield from meaning_notes(one, join(": ", (say("what it means"), one.name)), "text")


def causes_of(channels: Iterable[Channel], device: str | None) -> Iterator[Part]:
    """What may cause the terms that were found in any of these channels, in a device; nothing where none is named."""
    if device is not None:
        found = [meaning_of(channel, device) for channel in channels]
        yield from causes([replace(one, name="") for one in found if one is not None])


def causes(found: Sequence[Meaning]) -> Iterator[Part]:
    """The rows of a device's table for the terms that were found, with the channels that have them."""
    if not (found and found[0].device):
        return
    device = DEVICES[found[0].device]
    yield from (Note(note, "quiet") for note in dict.fromkeys(one.note for one in found if one.note))
    channels: dict[str, list[str]] = {}
    for one in found:
        for symbol in one.symbols:
            channels.setdefault(symbol, []).append(one.name)
    rows = []
    for symbol, cause in ((symbol, cause) for symbol, cause in device.terms.items() if symbol in channels):
        names = ", ".join(filter(None, channels[symbol]))
        sources, remedies = (join("; ", texts) for texts in (cause.sources, cause.remedies))
        head = say("{symbol} in a {device}: {cause}", symbol=symbol, device=device.title, cause=cause.name)
        points = (
            say("sources: {sources}", sources=sources),
            say("try: {remedies}", remedies=remedies),
            say("see {reference}", reference=cause.reference),
        )
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
        say("What it means"),
        say("noise coefficients of an inertial sensor"),
        found.name or say("record"),
        (*meaning_notes(found, say("what it means")), *causes([found])),
    )
