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
    """
    carried = [i for i, record in enumerate(records) if record.signal.inertial]
    found = list(qualities)
    if len(carried) < 2:
        return tuple(found)
    changes = [(records[i].name, change) for i in carried if (change := _named("level", qualities[i]))]
    for i, quality in zip(carried, _moved(carried, records, qualities), strict=True):
        found[i] = quality
        if changes and not (_named("level", qualities[i]) or qualities[i].refusal):
            (name, first), *others = changes
            what = say("on the same body, {channel}: {level}", channel=name or say("another channel"), level=first.what)
            if others:
                names = ", ".join(other for other, _ in others)
                what = join("; ", (what, say("so does that of {channels}", channels=names)))
            why = say("a disturbance of one axis may also affect the others")
            also = Finding("body level", what, why, first.remedy, first.place)
            found[i] = Quality((*quality.findings, also))
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
