"""How the bias and the degrees of freedom of a statistic are shown."""

from allanite.core.arrays import FloatArray
from allanite.phrases.phrase import say
from allanite.planning.properties import Properties
from allanite.reporting.sheet import Column, Face, Note, Part, Sheet, Table
from allanite.statistics.table import STATISTICS

from . import View

BRAND = say("bias and degrees of freedom of a statistic")
RATIO = say("Allan variance over the expected variance of the statistic")
HADAMARD = say("Hadamard variance over the expected variance of the statistic")
FREEDOM = say("equivalent degrees of freedom")
EXACT = say("exact for each noise alone; the relative standard deviation of the variance is sqrt(2 / edf)")


def _face(value: Properties, _: float) -> Face:
    row = STATISTICS[value.statistic]
    size = say("a record of {n} samples; tau in sampling intervals", n=value.size)
    parts: list[Part] = [
        _table(value, value.ratio, RATIO if row.order == 2 else HADAMARD, ".3f"),
        _table(value, value.edf, FREEDOM, ".4g"),
        Note(EXACT, "quiet"),
        Note(say("source: {source}", source=row.reference), "quiet"),
    ]
    return Face(row.title, BRAND, (Sheet(row.title, (size,), tuple(parts)),))


def _table(value: Properties, numbers: FloatArray, title: str, form: str) -> Table:
    columns = (Column("m"), Column("tau"), *(Column(symbol) for symbol in value.symbols))
    together = zip(value.m.tolist(), value.tau.tolist(), numbers.tolist(), strict=True)
    rows = [[f"{m}", f"{tau:.6g}", *(format(x, form) for x in each)] for m, tau, each in together]
    return Table(columns, rows, title)


PROPERTIES = View(_face, rows=lambda value, _: value.rows())
