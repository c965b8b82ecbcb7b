"""What the views of results have in common that follow from a noise model, given or found in a recording."""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

from allanite.phrases.phrase import join, say
from allanite.reporting import words
from allanite.reporting.sheet import Face, Note, Part, Sheet, header_of, one_sheet

from . import Rows, jobs
from .jobs import source_of

if TYPE_CHECKING:
    from allanite.study.modelled import ModelJob, Modelled


class ModelledForm(NamedTuple):
    """How one kind of result is shown: the name of a nameless one, title and brand of the page, parts, and a key."""

    name: str
    title: str
    brand: str
    about: Callable[[Any], str]
    parts: Callable[[Any, "Modelled | None"], Iterable[Part]]
    key: str


def one_face(form: ModelledForm) -> Callable[[Any, float], Face]:
    """The face of a single result."""

    def face(result: Any, _: float) -> Face:
        title, parts = join(" ", (form.title, str(result.model))), form.parts(result, None)
        legend = {"close": _legend(form), "how": (Note(form.key),)}
        return one_sheet(title, form.brand, form.name, parts, about=(form.about(result),), **legend)

    return face


def job_face(form: ModelledForm) -> Callable[["ModelJob", float], Face]:
    """The face of the results of all channels."""

    def face(job: "ModelJob", _: float) -> Face:
        given = job.settings.given()
        header = header_of(job.provenance, job.notes, say(", method {method}", method=job.recipe.method))
        if given:
            header = [(say("noise"), str(given)), *header_of(job.provenance, ())[1:]]
        names = join(" ", (form.title, job.settings.sensor or str(given or source_of(job)))), form.brand
        limits = [
            Note(say("limit exceeded: {limit}", limit=sentence), "alert", where="page") for sentence in job.exceeded
        ]
        sheets = []
        for channel in job:
            about = [] if channel.record is None else [words.about(channel.record), *channel.record.history]
            about += [] if channel.result is None else [form.about(channel.result)]
            parts = [*jobs.warnings(channel), *map(Note, channel.fit.advice if channel.fit else ())]
            if channel.missing:
                parts.append(Note(say("not taken into account: {terms}", terms=channel.missing)))
            if channel.result is not None:
                parts += form.parts(channel.result, channel)
            sheets.append(Sheet(channel.name or form.name, about, parts))
        shown = {"header": header, "close": _legend(form), "how": (Note(form.key),)}
        return jobs.job_face(job, names, sheets, limits, **shown)

    return face


def _legend(form: ModelledForm) -> list[Part]:
    return [Note(form.key, "quiet", where="text")]


def job_rows(job: "ModelJob", _: float) -> Rows:
    """Rows of the results of all channels, each with the name of its channel before it."""
    tables = [(c.name, *c.result.rows()) for c in job.channels if c.result is not None]
    return ["channel", *tables[0][1]], [[name, *row] for name, _, rows in tables for row in rows]
