"""How pools are shown."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from allanite.comparison.pooled import Pool, PooledChannel, PooledTerm
from allanite.core.curve import Curve
from allanite.core.display_units import readable_unit
from allanite.phrases.phrase import join, say
from allanite.reporting import figures, words
from allanite.reporting.digits import digits
from allanite.reporting.sheet import Column, Face, Mark, Note, Sheet, Table
from allanite.statistics import STATISTICS

from . import Rows, View
from .comparison import face_of, sheet_of, value_of

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


def _pooled_face(value: Pool, level: float) -> Face:
    face = face_of(value, any(channel.curve is not None for channel in value), level)
    sheets = [_pooled_sheet(channel, value, level) for channel in value]
    return replace(face, brand=say("what runs have in common"), sheets=sheets, how=[*map(Note, POOLED)])


def _pooled_sheet(channel: PooledChannel, whole: Pool, level: float) -> Sheet:
    tables = [_terms_table(channel, level), _runs_table(channel, whole, level)] if channel.terms else []
    tables += [_curve_table(channel.curve, channel, level)] if channel.curve is not None else []
    doubt = not channel.alike or bool(channel.apart) or not all(channel.explained)
    return sheet_of(channel, whole.names, doubt, tables)


def _terms_table(channel: PooledChannel, level: float) -> Table:
    heads = (
        Column("", "symbol"), Column(say("term"), "name"), Column(say("common")),
        Column(words.interval(level), "interval"), Column(say("unit"), "unit"), Column(say("between runs")),
        Column(say("within runs")), Column(say("chi-square"), aside=True), Column(say("dof"), aside=True),
        Column("p", aside=True), Column(say("p (Holm)")),
    )  # fmt: skip
    rows = [_term_cells(term, level) for term in channel.terms]
    marks: list[Mark] = ["alarm" if term.adjusted <= channel.alpha else "" for term in channel.terms]
    return Table(heads, rows, say("what the runs have in common"), marks=marks)


def _term_cells(term: PooledTerm, level: float) -> list[str]:
    _, _, value, low, high, unit, between, within, statistic, dof, p, adjusted = term.row(level)
    below = say("below {limit}", limit=digits(high, figures=2).plain()[0])
    shown = digits(value, low, high).plain() if value else ("-", below)
    scatter = [f"{v:.3g} %" if math.isfinite(v) else "-" for v in (between, within)]
    return [term.symbol, words.title(term.symbol, term.signal), *shown, unit, *scatter, f"{statistic:.3g}", f"{dof:g}",
            words.probability(p), words.probability(adjusted)]  # fmt: skip


def _runs_table(channel: PooledChannel, whole: Pool, level: float) -> Table:
    heads = (
        Column(say("run"), "name"),
        *(Column(f"{term.symbol} [{term.sheet_unit}]") for term in channel.terms),
        Column(say("apart, p")),
    )
    rows = []
    for name, fit in zip(whole.names, channel.fits, strict=True):
        p = words.probability(channel.apart[name]) if name in channel.apart else ""
        rows.append([name, *(value_of(fit[term.symbol], level) for term in channel.terms), p])
    marks: list[Mark] = ["alarm" if name in channel.apart else "" for name in whole.names]
    return Table(heads, rows, say("run by run"), marks=marks)


def _curve_table(curve: Curve, channel: PooledChannel, level: float) -> Table:
    shown = curve.to(readable_unit(curve.unit))
    assert channel.p is not None  # noqa: S101 - comes with the curve
    heads = (
        Column("tau [s]"), Column(join(" ", (say("all runs"), f"[{shown.unit}]"))),
        Column(words.interval(level), "interval"), Column(say("edf")), Column(say("p of one variance")),
    )  # fmt: skip
    columns = (shown.tau, shown.deviation, *shown.interval(level), shown.edf, channel.p)
    rows = [
        [f"{tau:.6g}", *digits(value, low, high).plain(), f"{edf:.4g}", words.probability(p)]
        for tau, value, low, high, edf, p in zip(*(c.tolist() for c in columns), strict=True)
    ]
    marks: list[Mark] = ["alarm" if p <= channel.alpha else "" for p in channel.p]
    return Table(heads, rows, say("{statistic} of all runs", statistic=STATISTICS[curve.statistic].title), marks=marks)


def _pooled_rows(value: Pool, level: float) -> Rows:
    return (*RUNS, *value.names), [*_term_lines(value, level), *_curve_lines(value, level)]


def _term_lines(value: Pool, level: float) -> Iterator[list[Any]]:
    for channel in value:
        for term in channel.terms:
            symbol, _, *numbers = term.row(level)
            runs = [None if e.value is None else e.to(term.sheet_unit) for e in term.runs]
            yield [channel.name, symbol, None, *numbers, None, *runs]


def _curve_lines(value: Pool, level: float) -> Iterator[list[Any]]:
    for channel in value:
        if channel.curve is None or channel.p is None:
            continue
        unit = readable_unit(channel.curve.unit)
        whole, runs = channel.curve.to(unit), [curve.to(unit).deviation for curve in channel.curves]
        columns = (whole.tau, whole.deviation, *whole.interval(level), channel.p, whole.edf, *runs)
        for tau, size, low, high, p, edf, *each in zip(*(c.tolist() for c in columns), strict=True):
            yield [channel.name, whole.statistic, tau, size, low, high, unit, None, None, None, None, p, None, edf,
                   *each]  # fmt: skip


POOL = View(_pooled_face, lambda values, fit, level: figures.plot_comparison(values, level), _pooled_rows)
