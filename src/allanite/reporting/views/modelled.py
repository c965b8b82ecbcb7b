"""What the views of results have in common that follow from a noise model, given or found in a recording."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import PurePath
from typing import Any, NamedTuple

from allanite.reporting import words
from allanite.reporting.sheet import Face, Note, Part, Sheet, header_of, toml
from allanite.study.modelled import ModelJob, Modelled

from . import Rows


class Form(NamedTuple):
    """How one kind of result is shown: the name of a nameless one, title and brand of the page, parts, and a key."""

    name: str
    title: str
    brand: str
    about: Callable[[Any], str]
    parts: Callable[[Any, Modelled | None], Iterable[Part]]
    key: str


def one_face(form: Form) -> Callable[[Any, float], Face]:
    """The face of a single result."""

    def face(result: Any, _: float) -> Face:
        sheet = Sheet(form.name, (form.about(result),), tuple(form.parts(result, None)))
        return Face(f"{form.title} {result.model}", form.brand, (sheet,), close=_legend(form), how=(Note(form.key),))

    return face


def job_face(form: Form) -> Callable[[ModelJob, float], Face]:
    """The face of the results of all channels."""

    def face(job: ModelJob, _: float) -> Face:
        given = job.settings.given()
        about = [("noise", str(given)), *header_of(job.provenance, ())[1:]] if given else None
        name = job.settings.sensor or given or PurePath(job.provenance.get("source", "")).name or "data in memory"
        return Face(
            f"{form.title} {name}",
            form.brand,
            [_sheet(channel, form) for channel in job.channels],
            about or header_of(job.provenance, job.notes, f", method {job.recipe.method}"),
            parts=[
                *(Note(str(finding), "alert") for finding in job.findings),
                *(Note(f"limit exceeded: {sentence}", "alert", where="page") for sentence in job.exceeded),
            ],
            close=_legend(form),
            how=(Note(form.key),),
            choices=toml(job.choices()),
            provenance=job.provenance,
            notes=job.notes,
        )

    return face


def _legend(form: Form) -> list[Part]:
    return [Note(form.key, "quiet", where="text")]


def _sheet(channel: Modelled, form: Form) -> Sheet:
    about = [] if channel.record is None else [words.about(channel.record), *channel.record.history]
    about += [] if channel.result is None else [form.about(channel.result)]
    return Sheet(channel.name or form.name, about, tuple(_parts(channel, form)))


def _parts(channel: Modelled, form: Form) -> Iterator[Part]:
    yield from (Note(alert, "alert") for alert in channel.alerts)
    if channel.refusal:
        yield Note(f"no result: {channel.refusal}", "alert")
    yield from (Note(note) for note in (channel.fit.notes if channel.fit else ()))
    if channel.missing:
        yield Note(f"of this record, and not reckoned with: {channel.missing}")
    if channel.result is not None:
        yield from form.parts(channel.result, channel)


def job_rows(job: ModelJob, _: float) -> Rows:
    """Rows of the results of all channels, each with the name of its channel before it."""
    tables = [(c.name, *c.result.rows()) for c in job.channels if c.result is not None]
    return ["channel", *tables[0][1]], [[name, *row] for name, _, rows in tables for row in rows]
