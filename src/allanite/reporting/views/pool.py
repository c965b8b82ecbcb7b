"""How pools are shown."""

from collections.abc import Iterator
from typing import Any

from allanite.comparison.pooled import Pool, PooledChannel
from allanite.core.display_units import readable_unit
from allanite.phrases.phrase import join, say
from allanite.reporting import figures, words
from allanite.reporting.digits import digits
from allanite.reporting.sheet import Column, Face, Mark, Note, Table, known
from allanite.statistics import statistic_named

from . import Rows, view
from .comparison import face_of, sheet_of

POOLED = (
    say(
        "The runs are assumed to be independent. One noise model for all is tested by its likelihood ratio against a "
        "separate model for each run, with the distribution simulated from the common model. The common coefficient is "
        "the one that all runs together make most likely; its limits are averaged over the sets of terms that may be "
        "there."
    ),
    say(
        "Between runs: standard deviation of the runs' coefficients, in percent of the common one. Within runs: the "
        "scatter that equal sensors would show, from the standard errors. The difference is tested by a chi-square of "
        "homogeneity, adjusted by Holm's method. Each run has its own ramp, which the noise model does not contain."
    ),
    say(
        "A run is an outlier if it differs from all the others taken together (likelihood ratio, adjusted by Holm's "
        "method); the worst one is removed and the others are tested again. Variances are averaged with their degrees "
        "of freedom as weights; that they are equal is tested at each averaging time by Bartlett's test."
    ),
)
RUNS = ("channel", "quantity", "tau_s", "common", "low", "high", "unit", "between_percent", "within_percent",
        "chi_square", "dof", "p", "p_holm", "edf")  # fmt: skip
"""The runs have columns of their own, after these."""


_SCATTER = known(".3g", "-", " %")


def _terms_table(channel: PooledChannel, level: float) -> Table:
    heads = (
        Column("", "symbol"), Column(say("term"), "name"), Column(say("common")),
        Column(words.interval(level), "interval"), Column(say("unit"), "unit"),
        Column(say("between runs"), form=_SCATTER), Column(say("within runs"), form=_SCATTER),
        Column(say("chi-square"), aside=True, form=".3g"), Column(say("dof"), aside=True, form="g"),
        Column("p", aside=True, form=words.probability), Column(say("p (Holm)"), form=words.probability),
    )  # fmt: skip
    rows = []
    for term in channel.terms:
        symbol, title, value, low, high, *rest = term.row(level)
        limit = say("below {limit}", limit=digits(high, figures=2).plain()[0])
        rows.append([symbol, title, *(digits(value, low, high).plain() if value else ("-", limit)), *rest])
    marks: list[Mark] = ["alarm" if term.adjusted <= channel.alpha else "" for term in channel.terms]
    return Table(heads, rows, say("what the runs have in common"), marks=marks)


def _runs_table(channel: PooledChannel, whole: Pool, level: float) -> Table:
    heads = (
        Column(say("run"), "name"), *(Column(f"{term.symbol} [{term.sheet_unit}]") for term in channel.terms),
        Column(say("apart, p"), form=lambda p: "" if p is None else words.probability(p)),
    )  # fmt: skip
    rows = [
        [name, *(words.brief(fit[term.symbol], level) for term in channel.terms), channel.apart.get(name)]
        for name, fit in zip(whole.names, channel.fits, strict=True)
    ]
    marks: list[Mark] = ["alarm" if name in channel.apart else "" for name in whole.names]
    return Table(heads, rows, say("run by run"), marks=marks)


def _curve_rows(channel: PooledChannel, level: float) -> Iterator[list[float]]:
    """tau, deviation, its limits, edf and p of the common curve, then the deviation of each run."""
    assert channel.curve is not None  # noqa: S101 - the caller has looked
    assert channel.p is not None  # noqa: S101 - comes with the curve
    unit = readable_unit(channel.curve.unit)
    whole, runs = channel.curve.to(unit), [curve.to(unit).deviation for curve in channel.curves]
    numbers = (whole.tau, whole.deviation, *whole.interval(level), whole.edf, channel.p, *runs)
    yield from (list(row) for row in zip(*(column.tolist() for column in numbers), strict=True))


def _curve_table(channel: PooledChannel, level: float) -> Table:
    assert channel.curve is not None  # noqa: S101 - the caller has looked
    whole = join(" ", (say("all runs"), f"[{readable_unit(channel.curve.unit)}]"))
    heads = (
        Column("tau [s]", form=".6g"), Column(whole), Column(words.interval(level), "interval"),
        Column(say("edf"), form=".4g"), Column(say("p of one variance"), form=words.probability),
    )  # fmt: skip
    rows, marks = [], list[Mark]()
    for tau, value, low, high, edf, p, *_ in _curve_rows(channel, level):
        rows.append([tau, *digits(value, low, high).plain(), edf, p])
        marks.append("alarm" if p <= channel.alpha else "")
    title = say("{statistic} of all runs", statistic=statistic_named(channel.curve.statistic).title)
    return Table(heads, rows, title, marks=marks)


def _pooled_rows(value: Pool, level: float) -> Rows:
    """The coefficients of each channel, and then the curves."""
    rows: list[list[Any]] = []
    for channel in value:
        for term in channel.terms:
            symbol, _, *numbers = term.row(level)
            runs = [None if e.value is None else e.to(term.sheet_unit) for e in term.runs]
            rows.append([channel.name, symbol, None, *numbers, None, *runs])
    for channel, curve in ((channel, channel.curve) for channel in value):
        if curve is None:
            continue
        unit = readable_unit(curve.unit)
        for tau, size, low, high, edf, p, *each in _curve_rows(channel, level):
            rows.append([channel.name, curve.statistic, tau, size, low, high, unit, *[None] * 4, p, None, edf,
                         *each])  # fmt: skip
    return (*RUNS, *value.names), rows


@view(lambda values, fit, level: figures.plot_comparison(values, level), _pooled_rows)
def pool_view(value: Pool, level: float) -> Face:
    """What the runs of each channel have in common."""
    sheets = []
    for channel in value:
        tables = [_terms_table(channel, level), _runs_table(channel, value, level)] if channel.terms else []
        if channel.curve is not None:
            tables.append(_curve_table(channel, level))
        doubt = not channel.alike or bool(channel.apart) or not all(channel.explained)
        sheets.append(sheet_of(channel, value.names, doubt, tables))
    own = {"brand": say("what runs have in common"), "sheets": sheets, "how": [*map(Note, POOLED)]}
    return face_of(value, any(channel.curve is not None for channel in value), level, **own)
