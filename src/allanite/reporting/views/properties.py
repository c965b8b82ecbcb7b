"""How the bias and the degrees of freedom of a statistic are shown."""

from allanite.phrases.phrase import say
from allanite.planning.properties import Properties
from allanite.reporting.first import DETAILS, Answer, First
from allanite.reporting.sheet import Column, Face, Note, Part, Table, one_sheet
from allanite.reporting.text import spread
from allanite.statistics import statistic_named

from . import view

BRAND = say("bias and degrees of freedom of a statistic")
RATIO = say("Allan variance over the expected variance of the statistic")
HADAMARD = say("Hadamard variance over the expected variance of the statistic")
FREEDOM = say("equivalent degrees of freedom")
EXACT = say("exact for each noise alone; the relative standard deviation of the variance is sqrt(2 / edf)")


MOST = 10
"""Averaging times of a first screen."""


def first_of_properties(value: Properties, _: float) -> First:
    """Degrees of freedom by averaging time, and the range of the ratio to the Allan variance."""
    rows, terms = value.rows()[1], len(value.symbols)
    ratios = [ratio for row in rows for ratio in row[2 : 2 + terms]]
    said = say("{ratio}: {low:.3f} to {high:.3f}", ratio=_ratio(value), low=min(ratios), high=max(ratios))
    heads = (Column("tau", form=".6g"), *(Column(symbol, form=".4g") for symbol in value.symbols))
    kept = [rows[i] for i in spread(len(rows), MOST)]
    table = Table(heads, [[row[1], *row[2 + terms :]] for row in kept])
    title = say("{statistic}: a record of {n} samples", statistic=statistic_named(value.statistic).title, n=value.size)
    answer: list[Answer] = [say("{what}, by tau in sampling intervals:", what=FREEDOM), table, said]
    return First(title, "", answer, after=[DETAILS])


def _ratio(value: Properties) -> str:
    return RATIO if statistic_named(value.statistic).order == 2 else HADAMARD


@view(rows=lambda value, _: value.rows(), first=first_of_properties)
def properties_view(value: Properties, _: float) -> Face:
    """Bias and degrees of freedom by averaging time."""
    statistic = statistic_named(value.statistic)
    size = say("a record of {n} samples; tau in sampling intervals", n=value.size)
    terms = len(value.symbols)
    rows = value.rows()[1]
    ratios = (Column(symbol, form=".3f") for symbol in value.symbols)
    freedom = (Column(symbol, form=".4g") for symbol in value.symbols)
    at = (Column("m"), Column("tau", form=".6g"))
    parts: list[Part] = [
        Table((*at, *ratios), [row[: 2 + terms] for row in rows], _ratio(value)),
        Table((*at, *freedom), [[*row[:2], *row[2 + terms :]] for row in rows], FREEDOM),
        Note(EXACT, "quiet"),
        Note(say("source: {source}", source=statistic.reference), "quiet"),
    ]
    return one_sheet(statistic.title, BRAND, statistic.title, parts, about=(size,))
