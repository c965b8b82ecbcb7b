"""A study as one HTML page that needs nothing else: no script, no font, no request."""

import json
import re
from collections.abc import Iterator
from importlib.resources import files
from pathlib import PurePath
from typing import Any

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup
from matplotlib.figure import Figure

from allanite.core.fit import Estimate, Fit
from allanite.core.residuals import Residuals, chance
from allanite.identification import METHODS, Method
from allanite.study.analysis import Channel, Recipe, Study
from allanite.terms import TERMS

from . import style, words
from .figures import plot_panels
from .goodness import plot_goodness
from .panels import Panel, panels_of
from .residuals import plot_series

EXPLAINED = {
    "whittle": (
        "The rate record is transformed by the orthonormal discrete cosine transform (DCT-II), which removes "
        "the constant bias and does not leak where the two ends of the record differ. Each squared "
        "coefficient scatters, as a chi-square with one degree of freedom, about the power that the terms "
        "lead one to expect: the squares of the noise coefficients, each times the known spectrum of its "
        "term. The noise coefficients that make the record most likely (Whittle likelihood), none below zero, "
        "are the estimates; a ramp is estimated along with them, with its sign.",
        "A noise term is called found only where it lowers twice the negative log-likelihood by more than 4 "
        "and its interval excludes zero, so that about one record in twenty shows a term that is not there. "
        "The intervals are profile intervals: the values of a coefficient that the data do not contradict, "
        "whatever the other coefficients are and whichever of the other terms are there. A term that was not "
        "found has a one-sided 95 % upper limit instead of a value.",
    ),
    "gls": (
        "The squares of the noise coefficients, none below zero, are fitted to the variance at octaves of the "
        "averaging time up to a quarter of the record, with the covariance that the fitted model itself gives the "
        "points (generalised least squares, iterated). A term is called found where the quadratic form rises by more "
        "than 4 without it. Standard errors come from the same covariance and suppose Gaussian errors.",
    ),
}
"""How a method works, in a few sentences; without them its title is enough."""

CURVE = "The curve is an estimate by itself and is drawn for the eye: no coefficient was read off it."
READ = "The coefficients were read off a curve, {statistic}: the notes say from which points."
LIMITS = (
    "The limits of the curve are chi-square limits with the exact equivalent degrees of freedom under the model that "
    "was found."
)

_LATEX = (
    (r"\sigma", "σ"), (r"\tau", "τ"), (r"\ln", "ln "), (r"\pi", "π"), (r"\,", " "), (r"\sqrt", "√"),
    (r"\sin", "sin"), (r"\exp", "exp"), ("^2", "²"), ("^3", "³"), ("^4", "⁴"), ("  ", " "),
)  # fmt: skip


def page(study: Study) -> str:
    """The page as text."""
    template = files("allanite.reporting").joinpath("page.html.j2").read_text(encoding="utf-8")
    env = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    env.filters["unit"], env.filters["clean"] = words.printed_unit, words.printable
    return env.from_string(template).render(_content(study))


def _content(study: Study) -> dict[str, Any]:
    level, recipe = study.recipe.level, study.recipe
    fits = [channel.fit for channel in study.channels if channel.fit]
    statuses = {estimate.status for fit in fits for estimate in fit}
    return {
        "name": PurePath(study.provenance.get("source", "")).name or "data in memory",
        "verdicts": [(words.verdict(c, level), _doubtful(c)) for c in study.channels],
        "channels": [_channel(channel, level, i) for i, channel in enumerate(study.channels)],
        "shared": _shared(study),
        "statuses": {s: meaning for s, meaning in words.STATUS.items() if s in statuses},
        "method": _method(METHODS[recipe.method], recipe.method) if recipe.method in METHODS else recipe.method,
        "explained": EXPLAINED.get(recipe.method, ()),
        "curve_explained": _curve_explained(recipe),
        "definitions": _definitions(fits),
        "notes": study.notes,
        "recipe": toml(recipe),
        "provenance": study.provenance,
        "level": words.percent(level),
    }


def _method(row: Method, name: str) -> str:
    return f"{name}, {row.title}; measured: {row.efficiency}"


def _curve_explained(recipe: Recipe) -> str:
    row = METHODS.get(recipe.method)
    if row is None or not row.statistic:
        return f"{CURVE} {LIMITS}"
    statistic = recipe.statistic if recipe.statistic in row.allowed else row.statistic
    return f"{READ.format(statistic=statistic)} {LIMITS}"


def _channel(channel: Channel, level: float, i: int) -> dict[str, Any]:
    good = channel.fit.goodness if channel.fit else None
    return {
        "name": channel.record.name or "channel",
        "about": words.about(channel.record),
        "history": channel.record.history,
        "alerts": words.alerts(channel),
        "refusal": channel.refusal,
        "good": channel.verdict if channel.fit and channel.explained else "",
        "notes": channel.fit.notes if channel.fit else (),
        "rows": [_row(e, level) for e in channel.fit] if channel.fit else [],
        "figure": svg(plot_panels(panels_of(channel), level=level), f"curve{i}", "deviation by averaging time")
        if channel.curve
        else "",
        "goodness": svg(plot_goodness(good), f"goodness{i}", "observed over expected power by frequency")
        if good
        else "",
        "residuals": _residuals(channel.residuals, i) if channel.residuals and channel.residuals.checks else None,
        "curve": _curve(panels_of(channel)[0], level) if channel.curve else None,
    }


def _doubtful(channel: Channel) -> bool:
    return channel.fit is None or not channel.explained


def _residuals(residuals: Residuals, i: int) -> dict[str, Any]:
    return {
        "figure": svg(plot_series(residuals), f"residuals{i}", "residuals over time, their correlation and quantiles"),
        "rows": [(c.title, f"{c.value:.4g}", chance(c.p), c.meaning, c.passed) for c in residuals.checks],
    }


def _shared(study: Study) -> dict[str, Any] | None:
    if study.shared is None:
        return None
    rows = [(a, b, f"{fast:+.3f}", f"{slow:+.2f}") for a, b, fast, slow in study.shared.rows()[1]]
    return {"rows": rows, "hints": [str(finding) for finding in study.shared.findings]}


def _row(estimate: Estimate, level: float) -> dict[str, Any]:
    return {
        "symbol": estimate.symbol,
        "color": TERMS[estimate.symbol].color,
        "title": words.named(estimate, level),
        "status": estimate.status,
        "absent": estimate.value is None,
        "cells": [_cell(estimate, unit, level) for unit in (estimate.sheet_unit, estimate.unit)],
    }


def _cell(estimate: Estimate, unit: str, level: float) -> dict[str, str]:
    number = words.shown(estimate, unit, level)
    if number is None:
        return {"limit": words.in_print(estimate, unit, level)}
    interval = f"{number.low} … {number.high}".replace("-", "−") if number.low else ""
    return {"value": number.value.replace("-", "−"), "interval": interval, "unit": f"{number.power} {unit}".strip()}


def _curve(panel: Panel, level: float) -> dict[str, Any]:
    headings, rows = panel.curve.to(panel.unit).rows(level)
    shown = [[_number(value) for value in row] for row in rows]
    return {"headings": headings, "rows": shown, "count": len(rows)}


def _number(value: float) -> str:
    if isinstance(value, int):
        return str(value)
    return f"{value:.5g}"


def svg(figure: Figure, prefix: str, label: str) -> Markup:
    """A figure for the middle of a page: names made its own, so that figures do not share parts by mistake."""
    text = style.encode(figure, "svg").decode()
    text = text[text.index("<svg") :]
    text = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{prefix}-", text)
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    # the figure has no text of its own, glyphs are drawn: nothing of the user's is in it
    return Markup(text.replace("<svg ", f'<svg role="img" aria-label="{label}" ', 1))  # noqa: S704


def _definitions(fits: list[Fit]) -> Iterator[dict[str, str]]:
    for symbol, row in TERMS.items():
        signal = next((fit.signal for fit in fits for e in fit if e.symbol == symbol), None)
        if signal is not None:
            title = words.title(symbol, signal)
            yield {
                "symbol": symbol,
                "title": title,
                "meaning": row.meaning,
                "formula": formula(row.formula),
                "source": row.reference,
            }


def formula(latex: str) -> str:
    r"""A formula of the tables as text.

    Examples
    --------
    >>> formula(r"\sigma^2(\tau) = (2 \ln 2 / \pi) B^2")
    'σ²(τ) = (2 ln 2 / π) B²'
    """
    for code, sign in _LATEX:
        latex = latex.replace(code, sign)
    return latex


def toml(recipe: Recipe) -> str:
    """The recipe as the TOML that `Recipe.load` reads."""
    return "".join(f"{key} = {json.dumps(value, ensure_ascii=False)}\n" for key, value in recipe.to_dict().items())
