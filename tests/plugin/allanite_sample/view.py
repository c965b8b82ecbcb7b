"""How the result is shown: on the terminal, on a page, in a notebook, as CSV."""

from typing import Any

from allanite.phrases.phrase import say
from allanite.reporting.sheet import Face, Table, columns
from allanite.reporting.views import View
from allanite.reporting.views.jobs import channel_sheet, job_face, source_of

from .job import Extents


def _rows(job: Extents, _: float) -> tuple[list[str], list[list[Any]]]:
    return ["channel", "least", "greatest"], [[c.record.name, c.low, c.high] for c in job]


def _face(job: Extents, _: float) -> Face:
    heads = columns(say("least"), say("greatest"), left=0)
    sheets = [channel_sheet(c, [Table(heads, [[f"{c.low:.3g}", f"{c.high:.3g}"]])]) for c in job]
    brand = say("least and greatest samples")
    return job_face(job, (say("Extent of {source}", source=source_of(job)), brand), sheets)


EXTENTS = View(_face, rows=_rows)
