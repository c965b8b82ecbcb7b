"""The model over a curve and the line of each of its terms: dashes, slope, point where the coefficient is read."""

import math
import re
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes

from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.language import join, say
from allanite.core.model import Model, Term
from allanite.core.units import unit_of
from allanite.reporting import style, words
from allanite.reporting.sheet import printed_unit
from allanite.terms import TERMS

from .drawing import MODEL, by_share, color_of, dashes, draw_label, fractions, label_of, pairs
from .labels import Box, FloatArray, freedom
from .panels import Panel, Points

SLOPES = {-1.0: "−1", -0.5: "−½", 0.0: "0", 0.5: "+½", 1.0: "+1"}
"""Slopes of the lines in print."""


class Lines(NamedTuple):
    """What is drawn: averaging times, the whole model there, and the line of each term."""

    tau: FloatArray
    whole: FloatArray
    parts: dict[str, FloatArray]


def draw_model(ax: Axes, panel: Panel, drawn: Points, placed: list[Box], level: float) -> None:
    """The whole model, each of its terms, and a label on each term that was found."""
    fit = panel.fit
    assert fit is not None and fit.valid is not None  # noqa: S101, PT018 - the caller has looked
    lines = _lines(ax, panel, fit.valid)
    shortest = fit.scope.times[0] if fit.scope else 0.0
    inside = (lines.tau >= max(drawn.tau[0] / 1.01, shortest)) & (lines.tau <= drawn.tau[-1] * 1.01)
    ax.plot(lines.tau[inside], lines.whole[inside], color=style.INK, lw=1.3, zorder=3, label=MODEL)
    for symbol, line in lines.parts.items():
        ax.plot(lines.tau, line, color=color_of(symbol), lw=1.2, ls=dashes(symbol), zorder=2.5)
    points = [pairs(drawn.tau, drawn.deviation), pairs(lines.tau[inside], lines.whole[inside])]
    curves = fractions(ax, np.concatenate(points))
    paths = {symbol: fractions(ax, pairs(lines.tau, line)) for symbol, line in lines.parts.items()}
    _draw_labels(ax, panel, fit, (lines, curves, paths), placed, level)
    for symbol, path in paths.items():
        others = [other[::4] for name, other in paths.items() if name != symbol]
        _draw_slope(ax, symbol, path, np.concatenate([curves, *others]), placed)


def _lines(ax: Axes, panel: Panel, model: Model) -> Lines:
    tau = np.geomspace(*ax.get_xlim(), 300)
    terms = {s: Model(tuple(t for t in model if t.symbol == s)) for s in dict.fromkeys(t.symbol for t in model)}
    parts = {symbol: panel.expected(part, tau) for symbol, part in terms.items()}
    return Lines(tau, panel.expected(model, tau), parts)


def _draw_labels(  # noqa: PLR0917 - what is drawn, and where
    ax: Axes,
    panel: Panel,
    fit: Fit,
    seen: tuple[Lines, FloatArray, dict[str, FloatArray]],
    placed: list[Box],
    level: float,
) -> None:
    lines, curves, paths = seen
    assert fit.valid is not None  # noqa: S101 - the caller has looked
    for symbol in (symbol for symbol in paths if TERMS[symbol].periodic):
        _lines_label(ax, (symbol, lines.parts[symbol]), paths[symbol], curves, placed)
    for e in (e for e in fit if e.value is not None and e.symbol in paths):
        mark = _mark(ax, panel, fit.valid[e.symbol], e.sheet_unit)
        anchors = paths[e.symbol][by_share(lines.parts[e.symbol], lines.whole)]
        if mark is not None:
            ax.plot(*mark, "D", ms=5.5, mfc="white", mec=color_of(e.symbol), mew=1.3, zorder=5)
            anchors = fractions(ax, np.array([mark]))
        near = anchors[((anchors > 0.01) & (anchors < 0.99)).all(axis=1)]
        avoid = np.concatenate([curves, *(path[::4] for path in paths.values())])
        if len(near):
            text = _label(panel, e, lines.parts[e.symbol], (mark, level))
            placed.append(draw_label(ax, (e.symbol, text), near[::8], avoid, placed))


def _lines_label(
    ax: Axes, named: tuple[str, FloatArray], path: FloatArray, curves: FloatArray, placed: list[Box]
) -> None:
    """The word at the highest hump of the sinusoids."""
    symbol, line = named
    top = path[int(np.nanargmax(line[np.isfinite(line)]))]
    if ((top > 0.01) & (top < 0.99)).all():
        placed.append(draw_label(ax, (symbol, say("sinusoids taken out")), top[None, :], curves, placed))


def _draw_slope(ax: Axes, symbol: str, path: FloatArray, curves: FloatArray, placed: list[Box]) -> None:
    """The slope on the line of a term, where the line is far from the curve and from the labels."""
    said = SLOPES.get(TERMS[symbol].slope)
    seen = path[((path > 0.06) & (path < 0.94)).all(axis=1)][::6]
    if said is None or not len(seen):
        return
    boxes = [Box(float(x), float(y), 0.12, 0.05) for x, y in seen]
    box = max(boxes, key=lambda box: freedom(box, curves, placed))
    placed.append(box)
    ax.text(
        box.x, box.y, say("slope {slope}", slope=said), transform=ax.transAxes, ha="center", va="center", fontsize=8,
        color=color_of(symbol), zorder=5, bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.8},
    )  # fmt: skip


def _label(panel: Panel, e: Estimate, line: FloatArray, how: tuple[tuple[float, float] | None, float]) -> str:
    """A coefficient, and the value on the axis: the level of a flat line, or that of the point where it is read."""
    mark, level = how
    text, unit = label_of(e, level), printed_unit(panel.unit)
    flat = TERMS[e.symbol].slope == 0 and not e.shape
    if flat and unit_of(e.sheet_unit).dimension == unit_of(panel.unit).dimension:
        # 0.664 in the Allan deviation; other statistics have other levels
        flat_at = float(np.nanmedian(line))
        factor = flat_at / abs(e.to(panel.unit))
        return join("\n", (f"{factor:.3g} {e.symbol} = {flat_at:.3g} {unit}", text))
    if mark is None:
        return text
    at, size = words.duration(mark[0]), f"{mark[1]:.3g} {unit}"
    return say("{coefficient}\nat τ = {tau}: {deviation}", coefficient=text, tau=at, deviation=size)


def _mark(ax: Axes, panel: Panel, term: Term, unit: str) -> tuple[float, float] | None:
    """Where the coefficient is read off the term's line, if that is in sight: at so many seconds, or else hours."""
    if not math.isfinite(term.row.read_at):
        return None
    for seconds in (1.0, 3600.0) if re.search(r"\bh\b", unit) else (1.0,):
        tau = term.row.read_at * seconds
        deviation = float(panel.expected(term, np.array([tau]))[0])
        # so it is in the Allan deviation, but for flicker; other statistics have other levels
        coefficient = abs(term.value) * seconds ** -float(term.row.power) / unit_of(panel.unit).factor
        if not math.isclose(deviation, coefficient, rel_tol=1e-6):
            return None
        ((x, y),) = fractions(ax, np.array([[tau, deviation]]))
        if 0.02 < x < 0.98 and 0.04 < y < 0.96:
            return tau, deviation
    return None
