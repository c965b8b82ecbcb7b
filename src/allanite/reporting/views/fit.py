"""How coefficients and residuals are shown."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from allanite.core.estimate import Estimate
from allanite.core.fit import Fit, chance
from allanite.core.kinds import meaning_of
from allanite.core.model import Model
from allanite.core.residuals import Residuals, statement
from allanite.phrases.phrase import join, say
from allanite.reporting import figures, words
from allanite.reporting.sheet import Column, Drawing, Face, Note, Part, Plot, Table, one_sheet
from allanite.terms import TERMS

from . import view
from .jobs import statement_note

GOODNESS = say(
    "Power of the record over the power expected with every term free, selected or not, in cells of frequency, and the "
    "same in standard deviations. If the model explains the record, nine cells in ten or more lie within the shaded "
    "band; cells beyond three standard deviations are red."
)
RESIDUALS_CAPTION = say(
    "Residuals in standard deviations: white, Gaussian and stationary if the model is right. Over time: range of short "
    "segments, and RMS of each eighth of the record. Autocorrelation: the band holds 95 % of the values of white "
    "noise. Quantiles: against those of the normal distribution."
)


def terms_table(fit: Fit, level: float) -> Table:
    """The coefficients, in the units of data sheets and in SI."""
    interval = words.interval(level)
    heads = (
        Column("", "symbol"), Column(say("term"), "name"), Column(say("value")), Column(interval, "interval"),
        Column(say("unit"), "unit"), Column(say("status"), "status"), Column(say("SI value"), aside=True),
        Column(interval, "interval", aside=True), Column(say("SI unit"), "unit", aside=True),
    )  # fmt: skip
    rows = [[words.symbol(e), words.named(e, level), *_cells(e, e.sheet_unit, level), e.row.name,
        *_cells(e, e.unit, level)] for e in fit]  # fmt: skip
    return Table(heads, rows, marks=[e.row.mark for e in fit])


def _cells(estimate: Estimate, unit: str, level: float) -> list[str]:
    """Value, interval and unit; of an absent term its limit."""
    number, most = estimate.rounded(unit, level, signed=words.signed(estimate)), estimate.rounded_limit(unit)
    if number is not None:
        return [*number.plain(), unit]
    return ["", words.below(estimate, most.plain()[0]) if most else "", unit if most else ""]


def goodness_parts(fit: Fit, residuals: Residuals | None) -> Iterator[Part]:
    """Whether the model explains the record: figures and checks, for the page."""
    good = fit.goodness
    if good is not None:
        name, title = fit.name or say("the record"), say("does the model explain the record?")
        least, most = float(np.nanmin(good.ratio)), float(np.nanmax(good.ratio))
        label = say(
            "observed over expected power of {channel} by frequency: {least:.2g} to {most:.2g}, {p}",
            channel=name, least=least, most=most, p=chance(good.p),
        )  # fmt: skip
        yield Drawing(lambda: figures.plot_goodness(good), label, GOODNESS, title)
    if residuals is not None and residuals.checks:
        name, title = fit.name or say("the record"), say("residuals")
        checks = join("; ", (join(" ", (check.title, f"{check.value:.3g}")) for check in residuals.checks))
        label = say(
            "residuals of {channel} over time, their correlation and quantiles: {checks}", channel=name, checks=checks
        )
        yield Drawing(lambda: figures.plot_series(residuals), label, RESIDUALS_CAPTION, title)
        yield _checks(residuals, "page")


def _checks(residuals: Residuals, where: Any = "") -> Table:
    heads = (Column(say("check"), "name"), Column(say("value"), form=".4g"), Column("p", "name", form=chance),
        Column(say("meaning"), "text"))  # fmt: skip
    rows = [row[1:] for row in residuals.rows()[1]]
    return Table(heads, rows, marks=["quiet" if c.passed else "weak" for c in residuals.checks], where=where)


def definitions(fits: Iterable[Fit]) -> Table:
    """What each coefficient means, with its formula and source."""
    signals = {e.symbol: e.signal for fit in fits for e in fit}
    heads = (Column("", "symbol"), Column(say("term"), "name"), Column(say("Allan variance"), "formula"),
        Column(say("meaning"), "text"), Column(say("source"), "text"))  # fmt: skip
    rows = [[s, words.title(s, signals[s]), row.formula, meaning_of(s, signals[s]), row.reference]
        for s, row in TERMS.items() if s in signals]  # fmt: skip
    return Table(heads, rows, say("definitions of the coefficients"), where="page")


def fit_parts(fit: Fit, level: float) -> Iterator[Part]:
    """Doubts, coefficients and notes of a fit."""
    yield from statement_note(statement(fit.validity, fit, None))
    yield from coefficients(fit, level)
    yield from (Note(note, "remark") for note in fit.advice)


def coefficients(fit: Fit, level: float) -> Iterator[Part]:
    """The coefficients, and why some of them cannot be known."""
    table = terms_table(fit, level)
    yield replace(table, where="page")
    # the terminal shows one system of units
    yield replace(table.only([i for i, column in enumerate(table.columns) if not column.aside]), where="text")
    unseen: dict[str, list[str]] = {}
    for e in fit:
        if e.status == "not observable":
            unseen.setdefault(e.reason, []).append(e.symbol)
    yield from (Note(say("{symbols} not observable: {reason}", symbols=", ".join(symbols), reason=why), "quiet")
        for why, symbols in unseen.items())  # fmt: skip


def model_table(model: Model) -> Table:
    """The terms of a model, in the units of data sheets."""
    heads = (
        Column("", "name"), Column(say("term"), "name"), Column(say("value"), form=".6g"), Column(say("unit"), "unit"),
    )  # fmt: skip
    sheets = [(t, t.signal.sheet[t.row.power]) for t in model]
    return Table(heads, [[t.symbol, words.title(t.symbol, t.signal), t.to(u), u] for t, u in sheets])


def _plot(fits: Sequence[Fit], fit: Fit | None, level: float) -> Plot:
    """The curve of a fit with its model, or of one without a curve how well it explains the power of the record."""
    good = fits[0].goodness
    if len(fits) == 1 and fits[0].curve is None and good is not None:
        return figures.plot_goodness(good, fits[0].name)
    return figures.plot_panels(figures.panels_of(list(fits), fit), level=level)


@view(_plot, lambda fit, level: fit.rows(level))
def fit_view(fit: Fit, level: float) -> Face:
    """The coefficients, and how well they explain the record."""
    return one_sheet(fit.name or say("Noise"), say("noise coefficients"), fit.name or say("noise"),
        fit_parts(fit, level), about=(say("method {method}", method=fit.method),),
        how=(definitions([fit]),))  # fmt: skip


@view(lambda values, fit, level: figures.plot_residuals(values[0]))
def residuals_view(residuals: Residuals, _: float) -> Face:
    """What a model leaves over."""
    return one_sheet(
        say("Residuals"), say("residuals of a noise model"), say("residuals"),
        (*statement_note(residuals.statement), _checks(residuals),
         Drawing(lambda: figures.plot_residuals(residuals), say("residuals"), RESIDUALS_CAPTION)),
    )  # fmt: skip
