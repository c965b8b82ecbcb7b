"""What one channel of a body says of the others: where one axis moves, all of them do."""

from collections.abc import Sequence
from dataclasses import replace

from allanite.core.finding import Finding, Quality
from allanite.core.record import Record

from .stillness import still_words


def of_one_body(records: Sequence[Record], qualities: Sequence[Quality]) -> tuple[Quality, ...]:
    """What was found in each channel of a recording, with what the others tell of the body that carries them all.

    Motion in one inertial channel is told of every other one, and refuses all where it refuses one; so is a noise
    level that changes, which refuses none. The still stretch that is offered is one of all of them.

    Parameters
    ----------
    records : sequence of Record
        The channels of one recording.
    qualities : sequence of Quality
        What was found in each by itself.
    """
    carried = [i for i, record in enumerate(records) if record.signal.inertial]
    found = list(qualities)
    if len(carried) > 1:
        for i, quality in zip(carried, _moved(carried, records, qualities), strict=True):
            found[i] = Quality((*quality.findings, *_levels(i, carried, records, qualities)))
    return tuple(found)


def _named(name: str, quality: Quality) -> Finding | None:
    return next((finding for finding in quality.findings if finding.name == name), None)


def _moved(carried: list[int], records: Sequence[Record], qualities: Sequence[Quality]) -> list[Quality]:
    """The findings of the channels that are carried, with the motion of the others."""
    motions = {i: motion for i in carried if (motion := _named("moving", qualities[i]))}
    if not motions:
        return [qualities[i] for i in carried]
    # the axis that is refused speaks first
    worst = min(motions, key=lambda i: (not motions[i].fatal, i))
    same_size = len({(records[i].size, records[i].rate) for i in carried}) == 1
    cure = still_words([records[i] for i in carried]) if same_size else motions[worst].remedy
    told = replace(
        motions[worst], name="body moved", what=f"the body moved: {records[worst].name or 'a channel'} "
        f"{motions[worst].what}", remedy=f"{cure}; leave out what is no part of this body (--channels)",
    )  # fmt: skip
    result = []
    for i in carried:
        own = [replace(f, remedy=cure) if f.name == "moving" else f for f in qualities[i].findings]
        also = i != worst and (i not in motions or (told.fatal and not motions[i].fatal))
        result.append(Quality((told, *own) if also else tuple(own)))
    return result


def _levels(at: int, carried: list[int], records: Sequence[Record], qualities: Sequence[Quality]) -> list[Finding]:
    """Noise levels that change in other channels, where this one's does not."""
    changes = [(records[i].name, change) for i in carried if (change := _named("level", qualities[i]))]
    if not changes or _named("level", qualities[at]) or qualities[at].refusal:
        return []
    name, first = changes[0]
    others = ", ".join(other for other, _ in changes[1:])
    what = f"{name or 'another channel'}, of the same body: {first.what}"
    what += f"; so does that of {others}" if others else ""
    return [Finding("body level", what, "what disturbs one axis may reach the others", first.remedy, first.place)]
