"""The figure of the field: deviation against averaging time, with its band, the model and what it is made of."""

import math
import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.model import Model, Term
from allanite.core.units import unit_of
from allanite.reporting import style, words
from allanite.reporting.sheet import printed_unit
from allanite.statistics import STATISTICS
from allanite.terms import TERMS

from .drawing import by_share, color_of, draw_grade, draw_label, draw_legend, fractions, label_of, pairs, shade
from .labels import Box, FloatArray
from .panels import Panel, Points, columns_of, points, span

FEW = 2.0
"""Equivalent degrees of freedom below which a point is drawn open."""

WEIGHS = 0.37
"""Frequency times averaging time where the Allan deviation is most sensitive."""

LANDMARKS = ((60.0, "1 min"), (3600.0, "1 h"), (86400.0, "1 d"))


def plot_panels(panels: Sequence[Panel], *, level: float = 0.95) -> Figure:
    """One panel a curve: sensors side by side, the channels of each below each other, on the same scales."""
    columns = columns_of(panels)
    rows = max(map(len, columns))
    width, height = (7.2, 5.0) if len(panels) == 1 else (6.6 * len(columns), 0.6 + 3.3 * rows)
    with style.look():
        figure = style.new_figure(width, height)
        grid = figure.subplots(rows, len(columns), squeeze=False)
        for ax in grid.flat:
            ax.set_axis_off()
        for j, column in enumerate(columns):
            _draw_column(list(grid[: len(column), j]), column, level)
        draw_legend(figure)
    return figure


def _draw_column(axes: Sequence[Axes], panels: Sequence[Panel], level: float) -> None:
    spans = [span(panel) for panel in panels]
    tau, deviation = ((min(s[i][0] for s in spans), max(s[i][1] for s in spans)) for i in (0, 1))
    for ax, panel in zip(axes, panels, strict=True):
        ax.set_axis_on()
        ax.set(xscale="log", yscale="log", xlim=tau, ylim=deviation)
        style.plain_ticks(ax.xaxis, ax.yaxis)
        _draw_panel(ax, panel, level)
        ax.tick_params(labelbottom=ax is axes[-1])
    axes[-1].set_xlabel("averaging time τ (s)")


def _draw_panel(ax: Axes, panel: Panel, level: float) -> None:
    style.grid(ax)
    _draw_landmarks(ax)
    drawn = points(panel, level)
    _draw_curve(ax, drawn, STATISTICS[panel.curve.statistic].title, level)
    if panel.fit is not None:
        _shade(ax, panel.fit)
        if panel.fit.valid is not None:
            _draw_model(ax, panel, drawn, level)
    style.title(ax, panel.name)
    ax.set_ylabel(f"{STATISTICS[panel.curve.statistic].title} ({printed_unit(panel.unit)})")
    if panel.fit is not None:
        draw_grade(ax, panel.fit)


def _shade(ax: Axes, fit: Fit) -> None:
    """Averaging times that the fit does not read: of a frequency, those at which it weighs most in the deviation."""
    if fit.scope is None or fit.valid is None:
        return
    shortest, longest = fit.scope.times
    masks = ((WEIGHS / high, WEIGHS / low) for low, high in fit.scope.masks)
    shade(ax, ((0.0, shortest), *masks, (longest, math.inf)))


def _draw_landmarks(ax: Axes) -> None:
    low, high = ax.get_xlim()
    for tau, label in LANDMARKS:
        if low < tau < high / 1.2:
            ax.axvline(tau, color="#9AA3AD", lw=0.7, ls=(0, (1, 2)), zorder=1)
            ax.annotate(
                label, (tau, 1), xycoords=("data", "axes fraction"), xytext=(2, -3), textcoords="offset points",
                va="top", fontsize=7, color="#6E7781",
            )  # fmt: skip


def _draw_curve(ax: Axes, drawn: Points, title: str, level: float) -> None:
    if drawn.low is not None and drawn.high is not None:
        label = f"{words.percent(level)} confidence"
        ax.fill_between(drawn.tau, drawn.low, drawn.high, color=style.DATA, alpha=0.2, lw=0, zorder=2, label=label)
    # an unknown number of degrees of freedom is not many
    few = np.zeros(drawn.tau.size, dtype=bool) if drawn.edf is None else ~(drawn.edf >= FEW)
    size = 3.4 if drawn.tau.size <= 150 else 0.0
    ax.plot(drawn.tau, drawn.deviation, color=style.DATA, lw=0.9, zorder=4)
    dots: dict[str, Any] = {"ls": "-" if size == 0 else "", "marker": "o", "color": style.DATA, "zorder": 4}
    ax.plot(drawn.tau[~few], drawn.deviation[~few], ms=size, mew=0, label=title, **dots)
    if few.any():
        label = f"below {FEW:g} degrees of freedom"
        ax.plot(drawn.tau[few], drawn.deviation[few], ms=3.6, mfc="white", mew=0.8, label=label, **dots)


def _draw_model(ax: Axes, panel: Panel, drawn: Points, level: float) -> None:
    """The whole model, each term of it, and a label on each term that was found."""
    fit = panel.fit
    assert fit is not None and fit.valid is not None  # noqa: S101, PT018 - the caller has looked
    model = fit.valid
    tau = np.geomspace(*ax.get_xlim(), 300)
    whole = panel.expected(model, tau)
    shortest = fit.scope.times[0] if fit.scope else 0.0
    inside = (tau >= max(drawn.tau[0] / 1.01, shortest)) & (tau <= drawn.tau[-1] * 1.01)
    ax.plot(tau[inside], whole[inside], color=style.INK, lw=1.3, zorder=3, label="model")
    terms = {s: Model(tuple(t for t in model if t.symbol == s)) for s in dict.fromkeys(t.symbol for t in model)}
    lines = {symbol: panel.expected(part, tau) for symbol, part in terms.items()}
    for symbol, line in lines.items():
        ax.plot(tau, line, color=color_of(symbol), lw=1.0, ls=(0, (5, 3)), zorder=2.5)
    curves = fractions(ax, np.concatenate([pairs(drawn.tau, drawn.deviation), pairs(tau[inside], whole[inside])]))
    paths = {symbol: fractions(ax, pairs(tau, line)) for symbol, line in lines.items()}
    placed: list[Box] = []
    for symbol in (symbol for symbol in lines if TERMS[symbol].periodic):
        _lines_label(ax, (symbol, lines[symbol]), paths[symbol], curves, placed)
    for e in (e for e in fit if e.value is not None and e.symbol in lines):
        mark = _mark(ax, panel, model[e.symbol], e.sheet_unit)
        anchors = paths[e.symbol][by_share(lines[e.symbol], whole)]
        if mark is not None:
            ax.plot(*mark, "D", ms=5, mfc="white", mec=color_of(e.symbol), mew=1.3, zorder=5)
            anchors = fractions(ax, np.array([mark]))
        seen = anchors[((anchors > 0.01) & (anchors < 0.99)).all(axis=1)]
        avoid = np.concatenate([curves, *(path[::6] for symbol, path in paths.items() if symbol != e.symbol)])
        if len(seen):
            label = _label(panel, e, lines[e.symbol], (mark, level))
            placed.append(draw_label(ax, (e.symbol, label), seen[::8], avoid, placed))


def _lines_label(
    ax: Axes, named: tuple[str, FloatArray], path: FloatArray, curves: FloatArray, placed: list[Box]
) -> None:
    """The word at the highest hump of the sinusoids."""
    symbol, line = named
    top = path[int(np.nanargmax(line[np.isfinite(line)]))]
    if ((top > 0.01) & (top < 0.99)).all():
        placed.append(draw_label(ax, (symbol, "sinusoids taken out"), top[None, :], curves, placed))


def _label(panel: Panel, e: Estimate, line: FloatArray, how: tuple[tuple[float, float] | None, float]) -> str:
    """A coefficient, and what stands on the axis for it: the level of a flat line, or the value at the mark."""
    mark, level = how
    text, unit = label_of(e, level), printed_unit(panel.unit)
    if TERMS[e.symbol].slope == 0 and not e.shape and e.sheet_unit == panel.unit:
        return f"{line[0] / e.to(e.sheet_unit):.3g} {e.symbol} = {line[0]:.3g} {unit} ({text})"
    if mark is None or math.isclose(mark[1], abs(e.to(e.sheet_unit)), rel_tol=1e-6):
        return text
    return f"{text} ({mark[1]:.3g} {unit} at {words.duration(mark[0])})"


def _mark(ax: Axes, panel: Panel, term: Term, unit: str) -> tuple[float, float] | None:
    """Where the coefficient is read off the term's line, if that is in sight: at so many hours, or else seconds."""
    if not math.isfinite(term.row.read_at):
        return None
    for seconds in (3600.0, 1.0) if re.search(r"\bh\b", unit) else (1.0,):
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
