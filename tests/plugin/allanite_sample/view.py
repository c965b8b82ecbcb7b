"""How the result is shown: on the terminal, on a page, in a notebook, as CSV."""

from typing import Any

from allanite.phrases.phrase import say
from allanite.reporting.sheet import Column, Face, Table
from allanite.reporting.views import view
from allanite.reporting.views.jobs import channel_sheet, job_face, source_of

from .job import Extents


def _rows(job: Extents, _: float) -> tuple[list[str], list[list[Any]]]:
    return ["channel", "least", "greatest"], [[c.record.name, c.low, c.high] for c in job]


@view(rows=_rows)
def extents_view(job: Extents, _: float) -> Face:
    """A table for each channel."""
    heads = Column(say("least"), form=".3g"), Column(say("greatest"), form=".3g")
    sheets = [channel_sheet(c, [Table(heads, [[c.low, c.high]])]) for c in job]
    brand = say("least and greatest samples")
    return job_face(job, (say("Extent of {source}", source=source_of(job)), brand), sheets)
