"""What the channels of one body tell about each other: if one axis moves, all of them do."""

from collections.abc import Sequence
from dataclasses import replace

from allanite.core.finding import Finding, Quality
from allanite.core.header import Header
from allanite.core.record import Record
from allanite.phrases.phrase import join, say
from allanite.phrases.wording import spelled

from .stillness import still_words


def of_one_body(records: Sequence[Record | Header], qualities: Sequence[Quality]) -> tuple[Quality, ...]:
    """The findings of each channel of a recording, together with those of the other channels of the same body.

    Motion in one inertial channel is reported for every other one, and if it refuses one channel, it refuses all. A
    changing noise level is reported for the others, too, but refuses none. The static stretch suggested is common to
    all of them.

    Parameters
    ----------
    records : sequence of Record or Header
        The channels of one recording; headers of those that are read in parts.
    qualities : sequence of Quality
        The findings of each channel alone.
    """
    carried = [i for i, record in enumerate(records) if record.signal.inertial]
    found = list(qualities)
    if len(carried) > 1:
        for i, quality in zip(carried, _moved(carried, records, qualities), strict=True):
            found[i] = Quality((*quality.findings, *_levels(i, carried, records, qualities)))
    return tuple(found)


def _named(name: str, quality: Quality) -> Finding | None:
    return next((finding for finding in quality.findings if finding.name == name), None)


def _moved(carried: list[int], records: Sequence[Record | Header], qualities: Sequence[Quality]) -> list[Quality]:
    """The findings of the channels on the same body, with the motion of the others."""
    motions = {i: motion for i in carried if (motion := _named("moving", qualities[i]))}
    if not motions:
        return [qualities[i] for i in carried]
    # the refused axis that moves first
    worst = min(motions, key=lambda i: (not motions[i].fatal, motions[i].place or (0.0, 0.0), i))
    cure = still_words([records[i] for i in carried]) or motions[worst].remedy
    option = spelled("--channels", "channels=...")
    told = replace(
        motions[worst],
        name="body moved",
        what=say(
            "the body moved: {channel} {motion}",
            channel=records[worst].name or say("a channel"),
            motion=motions[worst].what,
        ),
        remedy=say(
            "{remedy}; leave out channels that are not part of this body ({option})", remedy=cure, option=option
        ),
    )
    result = []
    for i in carried:
        own = [replace(f, remedy=cure) if f.name == "moving" else f for f in qualities[i].findings]
        also = i != worst and (i not in motions or (told.fatal and not motions[i].fatal))
        result.append(Quality((told, *own) if also else tuple(own)))
    return result


def _levels(
    at: int, carried: list[int], records: Sequence[Record | Header], qualities: Sequence[Quality]
) -> list[Finding]:
    """Changing noise levels of other channels, if the level of this one is constant."""
    changes = [(records[i].name, change) for i in carried if (change := _named("level", qualities[i]))]
    if not changes or _named("level", qualities[at]) or qualities[at].refusal:
        return []
    name, first = changes[0]
    others = ", ".join(other for other, _ in changes[1:])
    what = say("on the same body, {channel}: {level}", channel=name or say("another channel"), level=first.what)
    if others:
        what = join("; ", (what, say("so does that of {channels}", channels=others)))
    return [
        Finding(
            "body level", what, say("a disturbance of one axis may also affect the others"), first.remedy, first.place
        )
    ]
