"""The model over a curve and the line of each of its terms: dashes, slope, point where the coefficient is read."""

import math
import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.model import Model, Term
from allanite.core.units import convert, unit_of
from allanite.phrases.phrase import join, say
from allanite.reporting import style, words
from allanite.reporting.digits import digits, printed_unit
from allanite.terms import TERMS

from .drawing import (  # isort: skip
    MODEL, REDUCED, LabelBox, by_share, color_of, dashes, draw_label, fractions, freedom, label_of, label_size, pairs,
    place, together,
)  # fmt: skip
from .panels import CurvePanel, DrawnPoints

MIN_RUN = 8  # points of a term's line, of 300, below which a part of it between masked times is not drawn
SLOPE_POINTS, MAX_SLOPE_DISTANCE = 8.0, 0.12  # letters of slopes, and how far from their line, of the panel
SLOPES = {-1.5: "−1½", -1.0: "−1", -0.5: "−½", 0.0: "0", 0.5: "+½", 1.0: "+1", 1.5: "+1½", 2.0: "+2"}
"""Slopes of the lines in print."""


class ModelLines(NamedTuple):
    """What is drawn: averaging times, the whole model there, and the line of each term."""

    tau: FloatArray
    whole: FloatArray
    parts: dict[str, FloatArray]


class Named(NamedTuple):
    """The label of a term: its symbol, its coefficient, and the unit of that; no `term` where several share it."""

    symbol: str
    text: str
    unit: str
    term: Term | None


def draw_model(ax: style.Axes, panel: CurvePanel, drawn: DrawnPoints, placed: list[LabelBox], level: float) -> None:
    """The whole model, each of its terms, a label on each term that was found, and the slopes where there is room."""
    fit, model = panel.fit, panel.drawn
    if model is None:
        draw_minimum(ax, panel, fractions(ax, pairs(drawn.tau, drawn.deviation)), placed, level)
        return
    lines = _lines(ax, panel, model)
    shortest = fit.scope.times[0] if fit is not None and fit.scope else 0.0
    inside = (lines.tau >= max(drawn.tau[0] / 1.01, shortest)) & (lines.tau <= drawn.tau[-1] * 1.01)
    name = MODEL if fit is None or tuple(fit.valid or ()) == tuple(model) else REDUCED
    label = name if np.isfinite(lines.whole[inside]).any() else ""
    ax.plot(lines.tau[inside], lines.whole[inside], color=style.INK, lw=1.3, zorder=3, label=label)
    for symbol, line in lines.parts.items():
        ax.plot(lines.tau, line, color=color_of(symbol), lw=1.2, ls=dashes(symbol), zorder=2.5)
    points = (pairs(drawn.tau, drawn.deviation), pairs(lines.tau[inside], lines.whole[inside])[::4])
    curves = together(fractions(ax, part) for part in points)
    paths = {symbol: fractions(ax, pairs(lines.tau, line)) for symbol, line in lines.parts.items()}
    obstacles = together([curves, *(path[::4] for path in paths.values())])
    named = _labels(panel, model, level)
    _draw_labels(ax, panel, [n for n in named if n.symbol in paths], (lines, obstacles, paths), placed)
    draw_minimum(ax, panel, obstacles, placed, level)
    for symbol, path in () if panel.brief else paths.items():
        line = lines.parts[symbol]
        known = np.isfinite(line)
        if known.sum() < 2 or not math.isfinite(TERMS[symbol].slope):
            continue
        # the slope of most of a line, to halves
        steep = round(2 * float(np.median(np.diff(np.log(line[known])) / np.diff(np.log(lines.tau[known]))))) / 2
        slope = SLOPES.get(steep, "")
        if slope:
            _draw_slope(ax, (symbol, slope), path, obstacles, placed)


def _lines(ax: style.Axes, panel: CurvePanel, model: Model) -> ModelLines:
    tau = np.geomspace(*ax.get_xlim(), 300)
    terms = {s: Model(tuple(t for t in model if t.symbol == s)) for s in dict.fromkeys(t.symbol for t in model)}
    parts = {symbol: panel.expected(part, tau) for symbol, part in terms.items()}
    whole = panel.whole(tau)
    for line in (whole, *parts.values()):
        runs = np.flatnonzero(np.diff(np.isfinite(line), prepend=False, append=False)).reshape(-1, 2)
        for start, end in runs.tolist():
            if end - start < MIN_RUN:
                line[start:end] = np.nan
    return ModelLines(tau, whole, parts)


def _labels(panel: CurvePanel, model: Model, level: float) -> list[Named]:
    """The terms that were found, with their intervals; of a model that was given those of one symbol share a label."""
    if panel.fit is not None:
        own = (e for e in panel.fit if e.value is not None and e.symbol in {t.symbol for t in model})
        return [Named(e.symbol, label_of(e, level, brief=panel.brief), e.sheet_unit, model[e.symbol]) for e in own]
    named = []
    for symbol in dict.fromkeys(t.symbol for t in model):
        terms, sizes = [t for t in model if t.symbol == symbol], []
        unit = terms[0].signal.sheet[terms[0].row.power]
        for term in terms:  # coefficient and parameters: ``GM = 0.1 deg/h, T = 20 s``
            shape = [f"{p.letter} = {value:.4g} {p.unit}"
                for p, value in zip(term.row.parameters, term.shape, strict=True) if value != p.default]  # fmt: skip
            sizes.append(", ".join((f"{symbol} = {term.to(unit):.4g} {printed_unit(unit)}", *shape)))
        named.append(Named(symbol, join("\n", sizes), unit, terms[0] if len(terms) == 1 else None))
    return named


def _draw_labels(
    ax: style.Axes, panel: CurvePanel, named: Sequence[Named],
    drawn: tuple[ModelLines, FloatArray, dict[str, FloatArray]], placed: list[LabelBox],
) -> None:  # fmt: skip
    lines, obstacles, paths = drawn
    for symbol in (symbol for symbol in paths if TERMS[symbol].periodic and panel.fit is not None):
        # the word at the highest hump of the sinusoids, if the model holds anywhere near
        path = paths[symbol]
        top = path[path[:, 1].argmax()] if len(path) else np.array([-1.0, -1.0])
        if ((top > 0.01) & (top < 0.99)).all():
            placed.append(draw_label(ax, (symbol, say("sinusoids taken out")), top[None, :], obstacles, placed))
    for label in named:
        mark = None if label.term is None else _mark(ax, panel, label.term, label.unit)
        line = lines.parts[label.symbol]
        # of a sinusoid, the humps
        anchors = paths[label.symbol][by_share(line, lines.whole if not TERMS[label.symbol].periodic else line**0)]
        if mark is not None:
            ax.plot(*mark, "D", ms=5.5, mfc="white", mec=color_of(label.symbol), mew=1.3, zorder=5)
            anchors = fractions(ax, np.array([mark]))
        near = anchors[((anchors > 0.01) & (anchors < 0.99)).all(axis=1)]
        if len(near):
            text = _label(panel, label, line, mark)
            placed.append(draw_label(ax, (label.symbol, text), near[::8], obstacles, placed))


def _draw_slope(
    ax: style.Axes, named: tuple[str, str], path: FloatArray, lines: FloatArray, placed: list[LabelBox]
) -> None:
    """The slope beside the line of a term, where it hides nothing; nowhere if there is no room."""
    text = say("slope {slope}", slope=named[1])
    visible = path[((path > 0.06) & (path < 0.94)).all(axis=1)][::6]
    if not len(visible):
        return
    box = place(visible, label_size(ax, text, SLOPE_POINTS), lines, placed)
    if freedom(box, lines, placed) < 1 or math.dist(box.anchor or visible[0], (box.x, box.y)) > MAX_SLOPE_DISTANCE:
        return
    placed.append(box._replace(anchor=None))
    ax.text(box.x, box.y, text, transform=ax.transAxes, ha="center", va="center", fontsize=SLOPE_POINTS,
        color=color_of(named[0]), zorder=5)  # fmt: skip


def draw_minimum(ax: style.Axes, panel: CurvePanel, lines: FloatArray, placed: list[LabelBox], level: float) -> None:
    """The minimum of the Allan deviation with its averaging time, as data sheets quote it."""
    readings = panel.readings
    if readings is None or readings.minimum is None or panel.curve.statistic != "oadev":
        return
    if not readings.minimum.deviation > 0:  # logarithmic axes have no place for it
        return
    low, high = readings.minimum.interval(level)
    factor = convert(1.0, readings.unit, panel.unit)
    deviation = readings.minimum.deviation * factor
    rounded = digits(deviation, low * factor, high * factor)
    number = rounded.value + rounded.power if panel.brief else rounded.pretty()
    size = {"value": f"{number} {panel.unit}", "tau": words.averaging(readings.minimum.tau)}
    text, shape = say("minimum {value}\nat τ = {tau}", **size), "v"
    if not readings.inside:
        text, shape = say("last well-determined point:\n{value} at τ = {tau}", **size), "s"
    ax.plot(readings.minimum.tau, deviation, shape, ms=6.5, color=style.INK, zorder=5)
    anchor = fractions(ax, np.array([[readings.minimum.tau, deviation]]))
    placed.append(draw_label(ax, ("", text), anchor, lines, placed))


def _label(panel: CurvePanel, label: Named, line: FloatArray, mark: tuple[float, float] | None) -> str:
    """A coefficient, and the value on the axis: the level of a flat line, or that of the point where it is read."""
    text, term, unit = label.text, label.term, printed_unit(panel.unit)
    flat = term is not None and TERMS[label.symbol].slope == 0 and not term.shape
    if term is not None and flat and not panel.brief and unit_of(label.unit).dimension == unit_of(panel.unit).dimension:
        # 0.664 in the Allan deviation; other statistics have other levels
        flat_at = float(np.nanmedian(line))
        factor = flat_at / abs(term.to(panel.unit))
        return join("\n", (f"{factor:.3g} {label.symbol} = {flat_at:.3g} {unit}", text))
    if mark is None or panel.brief:
        return text
    at, size = words.averaging(mark[0]), f"{mark[1]:.3g} {unit}"
    return say("{coefficient}\nat τ = {tau}: {deviation}", coefficient=text, tau=at, deviation=size)


def _mark(ax: style.Axes, panel: CurvePanel, term: Term, unit: str) -> tuple[float, float] | None:
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
