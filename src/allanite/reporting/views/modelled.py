"""What the views of results have in common that follow from a noise model, given or found in a recording."""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from allanite.phrases.phrase import join, say
from allanite.reporting import words
from allanite.reporting.sheet import Face, Note, Part, Sheet, header_of, one_sheet
from allanite.study.modelled import ModelJob, Modelled

from . import Rows
from .jobs import job_face, source_of, warnings


class ModelledForm(NamedTuple):
    """How one kind of result is shown: name of a nameless one, title and brand of the page, a key, and its parts."""

    name: str
    title: str
    brand: str
    key: str
    about: Callable[[Any], str]
    parts: Callable[[Any, Modelled | None], Iterable[Part]]

    def one_face(self, result: Any, _: float) -> Face:
        """The face of a single result."""
        title, parts = join(" ", (self.title, str(result.model))), self.parts(result, None)
        return one_sheet(title, self.brand, self.name, parts, about=(self.about(result),), **self._legend())

    def job_face(self, job: ModelJob, _: float) -> Face:
        """The face of the results of all channels."""
        given = job.settings.given()
        header = header_of(job.provenance, job.notes, say(", method {method}", method=job.recipe.method))
        if given:
            header = [(say("noise"), str(given)), *header_of(job.provenance, ())[1:]]
        names = join(" ", (self.title, job.settings.name or str(given or source_of(job)))), self.brand
        limits = [Note(say("limit exceeded: {limit}", limit=text), "alert", where="page") for text in job.exceeded]
        sheets = []
        for channel in job:
            about = [] if channel.record is None else [words.about(channel.record), *channel.record.history]
            about += [] if channel.result is None else [self.about(channel.result)]
            advice = channel.fit.advice if channel.fit else ()
            parts = [*warnings(channel), *(Note(note, "remark") for note in advice)]
            if channel.missing:
                parts.append(Note(say("not taken into account: {terms}", terms=channel.missing)))
            if channel.result is not None:
                parts += self.parts(channel.result, channel)
            sheets.append(Sheet(channel.name or self.name, about, parts))
        return job_face(job, names, sheets, limits, header=header, **self._legend())

    def _legend(self) -> dict[str, list[Part]]:
        return {"close": [Note(self.key, "quiet", where="text")], "how": [Note(self.key)]}


def job_rows(job: ModelJob, _: float) -> Rows:
    """Rows of the results of all channels, each with the name of its channel before it."""
    tables = [(c.name, *c.result.rows()) for c in job.channels if c.result is not None]
    return ["channel", *tables[0][1]], [[name, *row] for name, _, rows in tables for row in rows]
