"""Surveys of several files as one."""

from collections.abc import Sequence
from dataclasses import replace

from allanite.core.names import told_apart
from allanite.phrases.phrase import join

from .provenance import joined
from .survey import Measured, Survey


def side_by_side(surveys: Sequence[Survey], files: Sequence[str]) -> Survey:
    """Surveys of several files as one: each channel has the name of its file before its own."""
    if len(surveys) == 1:
        return surveys[0]
    pairs = list(zip(told_apart(files), surveys, strict=True))
    return replace(
        surveys[0],
        channels=tuple(_of_file(name, channel, len(one.channels)) for name, one in pairs for channel in one),
        findings=tuple(replace(f, what=join(": ", (name, f.what))) for name, one in pairs for f in one.findings),
        notes=tuple(dict.fromkeys(note for one in surveys for note in one.notes)),
        provenance=joined([one.provenance for one in surveys]),
    )


def _of_file(file: str, channel: Measured, count: int) -> Measured:
    """A channel with the name of its file before its own, which the only one of a file does not need."""
    name = f"{file} {channel.record.name}" if count > 1 else file
    values = tuple(replace(value, name=name) for value in channel.values)
    return replace(channel, record=replace(channel.record, name=name), values=values)
