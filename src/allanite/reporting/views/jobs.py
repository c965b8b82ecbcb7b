"""Common parts of the views of jobs: where the numbers come from, and the notes on each channel."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, Protocol, TypeGuard

from allanite.core.header import Header
from allanite.core.names import sources_of, told_apart
from allanite.core.record import Record
from allanite.core.residuals import Statement
from allanite.core.syntax import toml
from allanite.core.validity import APPROXIMATE, EXPLAINED, UNEXPLAINED
from allanite.phrases.phrase import join, say
from allanite.reporting import words
from allanite.reporting.first import ABOVE
from allanite.reporting.sheet import Face, Note, Part, Sheet, header_of
from allanite.study.job import Job
from allanite.study.results import Noise

LEVELS: dict[str, Any] = {EXPLAINED: "good", APPROXIMATE: "fair", UNEXPLAINED: "alert"}
"""Level of the note by the grade of a model."""

REFUSED = "no result: "
"""How the note on a refusal begins in English."""


class Warned(Protocol):
    """Every channel of a job."""

    @property
    def alerts(self) -> tuple[str, ...]:
        """Warnings that are shown beside its numbers."""

    @property
    def refusal(self) -> str:
        """Why there is no result."""


class Recorded(Warned, Protocol):
    """A channel with its record."""

    @property
    def record(self) -> Record | Header:
        """What was measured."""


def source_of(job: Job[Any]) -> str:
    """The names of the files, for a title."""
    return ", ".join(told_apart(sources_of(job.provenance))) or say("data in memory")


def job_face(
    job: Job[Any], names: tuple[str, str], sheets: Sequence[Sheet], parts: Iterable[Part] = (), **more: Any
) -> Face:
    """The face of a job: title and brand, findings and other parts, sheets, how it came about; `more` fields."""
    title, brand = names
    once, kept = told_once(sheets)
    face = Face(
        title,
        brand,
        kept,
        header_of(job.provenance, job.notes),
        parts=[*(Note(str(finding), "warning") for finding in job.findings), *once, *parts],
        choices=toml(job.choices()),
        provenance=job.provenance,
        notes=job.notes,
    )
    return replace(face, **more)


def told_once(sheets: Sequence[Sheet]) -> tuple[list[Part], list[Sheet]]:
    """Warnings that several sheets have in common, with the names of the channels, and the sheets without them."""
    where: dict[Note, list[str]] = {}
    for sheet in sheets:
        for note in dict.fromkeys(part for part in sheet.parts if _warns(part)):
            where.setdefault(note, []).append(sheet.name)
    common = {note: names for note, names in where.items() if len(names) > 1}
    once: list[Part] = []
    for note, names in common.items():
        which = say("all channels") if len(names) == len(sheets) else say("channels {names}", names=", ".join(names))
        once.append(replace(note, text=say("{channels}: {warning}", channels=which, warning=note.text)))
    kept = []
    for sheet in sheets:
        parts: list[Part] = []
        for part in sheet.parts:
            if not (_warns(part) and part in common):
                parts.append(part)
            elif part.text.startswith(REFUSED):
                parts.append(ABOVE)
        kept.append(replace(sheet, parts=parts))
    return once, kept


def _warns(part: Part) -> TypeGuard[Note]:
    return isinstance(part, Note) and part.level in ("alert", "warning") and not part.points


def channel_sheet(
    channel: Recorded,
    parts: Iterable[Part],
    verdicts: Sequence[str] = (),
    *,
    doubt: bool = False,
    fair: bool = False,
    of: str = "",
) -> Sheet:
    """The sheet of a channel: its record, warnings and parts."""
    record = channel.record
    about = (words.about(record), *record.history)
    return Sheet(record.name, about, (*warnings(channel, of), *parts), verdicts, doubt, fair)


def statement_note(said: Statement, before: str = "") -> Iterator[Note]:
    """How well a model explains a record: the grade with its reasons; nothing where it was not tested."""
    if said.grade:
        yield Note(join(": ", filter(None, (before, said.head))), LEVELS[said.grade], points=said.points)


def warnings(channel: Warned, of: str = "") -> Iterator[Part]:
    """The grade of the noise of a channel, its warnings, and why there is no result."""
    noise: Noise | None = getattr(channel, "noise", None)
    if noise is not None:
        yield from statement_note(noise.statement, of)
    told = () if noise is None else noise.doubts
    yield from (Note(alert, "warning") for alert in channel.alerts if alert not in told)
    if channel.refusal:
        yield Note(say("no result: {reason}", reason=channel.refusal), "alert")
