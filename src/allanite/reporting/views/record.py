"""How records are shown: what they are, and their samples over time."""

from collections.abc import Sequence

from allanite.core.fit import Fit
from allanite.core.record import Record, Recording
from allanite.phrases.phrase import say
from allanite.reporting import figures, words
from allanite.reporting.sheet import Face, Plot, Sheet

from . import view
from .details import over_time


def _records(value: Record | Recording) -> Sequence[Record]:
    return value.records if isinstance(value, Recording) else (value,)


def _plot(values: Sequence[Record | Recording], _: Fit | None, __: float) -> Plot:
    return figures.plot_records([record for value in values for record in _records(value)])


@view(_plot)
def record_view(value: Record | Recording, _: float) -> Face:
    """What each record is, and its samples."""
    sheets = [
        Sheet(record.name or say("the record"), (words.about(record), *record.history), (over_time(record),))
        for record in _records(value)
    ]
    return Face(say("Samples over time"), say("a recording of an inertial sensor"), sheets)
