"""How the bias and the degrees of freedom of a statistic are shown."""

from allanite.phrases.phrase import say
from allanite.planning.properties import Properties
from allanite.reporting.sheet import Column, Face, Note, Part, Table, one_sheet
from allanite.statistics.table import STATISTICS

from . import view

BRAND = say("bias and degrees of freedom of a statistic")
RATIO = say("Allan variance over the expected variance of the statistic")
HADAMARD = say("Hadamard variance over the expected variance of the statistic")
FREEDOM = say("equivalent degrees of freedom")
EXACT = say("exact for each noise alone; the relative standard deviation of the variance is sqrt(2 / edf)")


@view(rows=lambda value, _: value.rows())
def properties_view(value: Properties, _: float) -> Face:
    """Bias and degrees of freedom by averaging time."""
    statistic = STATISTICS[value.statistic]
    size = say("a record of {n} samples; tau in sampling intervals", n=value.size)
    terms = len(value.symbols)
    rows = value.rows()[1]
    ratios = (Column(symbol, form=".3f") for symbol in value.symbols)
    freedom = (Column(symbol, form=".4g") for symbol in value.symbols)
    at = (Column("m"), Column("tau", form=".6g"))
    parts: list[Part] = [
        Table((*at, *ratios), [row[: 2 + terms] for row in rows], RATIO if statistic.order == 2 else HADAMARD),
        Table((*at, *freedom), [[*row[:2], *row[2 + terms :]] for row in rows], FREEDOM),
        Note(EXACT, "quiet"),
        Note(say("source: {source}", source=statistic.reference), "quiet"),
    ]
    return one_sheet(statistic.title, BRAND, statistic.title, parts, about=(size,))
