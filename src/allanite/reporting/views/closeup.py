"""How one interval of a rate is shown."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from allanite.applications.rate import Closeup
from allanite.core.units import unit_of
from allanite.phrases.phrase import say
from allanite.reporting import figures, words
from allanite.reporting.sheet import Drawing, Note, Part, Where, one_sheet

from . import Rows, View

CAPTION = say(
    "One interval: the slope of each regression line by its start, each line one sample later than the one before; "
    "below, the first counts with the staircase nearest to them, and what is left over of all."
)


def parts(found: Closeup, where: Where = "") -> Iterator[Part]:
    """Notes on one interval, and its figure."""
    unit = found.signal.sheet[0]
    rates = found.slopes / unit_of(unit).factor
    yield Note(
        say(
            "{lines} regression lines in the interval from {start}, {kept} kept: slopes from {low:.9g} to {high:.9g} "
            "{unit}",
            lines=rates.size,
            start=words.duration(found.start),
            kept=int(found.kept.sum()),
            low=float(rates.min()),
            high=float(rates.max()),
            unit=unit,
        ),
        where=where,
    )
    if found.counts.size:
        rms = float(np.sqrt(np.square(found.misfit).mean()))
        yield Note(say("counts less the staircase: {rms:.3g} quanta RMS", rms=rms), where=where)
    yield Drawing(lambda: figures.plot_closeups([found]), say("one interval in detail"), CAPTION)


def _rows(found: Closeup, _: float) -> Rows:
    unit = found.signal.sheet[0]
    rates = (found.slopes / unit_of(unit).factor).tolist()
    pairs = enumerate(zip(rates, found.kept.tolist(), strict=True))
    lines: list[list[Any]] = [[i / found.rate, rate, unit, kept] for i, (rate, kept) in pairs]
    return ["start_s", "slope", "unit", "kept"], lines


CLOSEUP = View(
    lambda found, _: one_sheet(
        found.name or say("Rate"), say("a constant rate in a short time"), found.name or say("Rate"), parts(found)
    ),
    lambda values, fit, level: figures.plot_closeups(values),
    _rows,
)
