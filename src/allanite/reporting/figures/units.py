"""The curves of many units in one figure: a panel for each channel, with what exceeds a limit in color."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from allanite.core.model import Term
from allanite.phrases.phrase import say
from allanite.reporting import style
from allanite.reporting.digits import printable
from allanite.statistics import statistic_named
from allanite.terms import TERMS

from .drawing import TIME, draw_legend, stacked, with_unit
from .panels import CurvePanel, span, thinned

MOST_NAMED = len(style.SERIES) - 1
"""Units of a panel that have a color of their own; the first color is that of all others."""


class UnitCurve(NamedTuple):
    """The curve of one unit: `marked` are drawn in color, with their names."""

    name: str
    marked: bool
    panel: CurvePanel


class LimitLine(NamedTuple):
    """The limit of a term, or of the minimum of the curve, SI."""

    label: str
    symbol: str
    value: float


@style.plotted
def plot_units(
    new_figure: style.NewFigure, curves: Sequence[UnitCurve], limits: dict[str, Sequence[LimitLine]] | None = None
) -> Figure:
    """One panel for each channel; sensors of different units of measurement stand side by side."""
    columns: dict[str, dict[str, list[UnitCurve]]] = {}
    for curve in curves:
        columns.setdefault(curve.panel.unit, {}).setdefault(curve.panel.name, []).append(curve)
    figure, grid = stacked(new_figure, [len(column) for column in columns.values()])
    for column, axes in zip(columns.values(), grid, strict=True):
        for ax, (name, group) in zip(axes, column.items(), strict=True):
            _draw(ax, group, (limits or {}).get(name, ()))
        axes[-1].set_xlabel(TIME)
    draw_legend(figure, marks=False)
    return figure


def _draw(ax: Axes, group: Sequence[UnitCurve], limits: Iterable[LimitLine]) -> None:
    spans = [span(curve.panel._replace(fit=None)) for curve in group]
    tau, deviation = ((min(s[i][0] for s in spans), max(s[i][1] for s in spans)) for i in (0, 1))
    ax.set(xscale="log", yscale="log", xlim=tau, ylim=deviation)
    style.plain_ticks(ax.xaxis, ax.yaxis)
    style.grid(ax)
    first = group[0].panel
    style.title(ax, first.name)
    ax.set_ylabel(with_unit(statistic_named(first.curve.statistic).title, first.unit))
    marked = [curve for curve in group if curve.marked]
    for curve in group:
        if not curve.marked:
            _plot(ax, curve.panel, style.SERIES[0], say("units"), 0.45)
    for i, curve in enumerate(marked):
        named = i < MOST_NAMED
        label = printable(curve.name) if named else say("others beyond a limit")
        color = style.SERIES[i + 1] if named else style.ALARM
        _plot(ax, curve.panel, color, label, 1.0)
    for line in limits:
        _draw_limit(ax, first, line)


def _plot(ax: Axes, panel: CurvePanel, color: str, label: str, alpha: float) -> None:
    keep = thinned(panel.curve.tau.size)
    shown = panel.shown(panel.curve.deviation[keep])
    ax.plot(panel.curve.tau[keep], shown, color=color, lw=0.6 + 0.8 * (alpha == 1.0), alpha=alpha, label=label)


def _draw_limit(ax: Axes, panel: CurvePanel, line: LimitLine) -> None:
    """The asymptote of a term that is as large as it may be, or a level."""
    tau = np.geomspace(*ax.get_xlim(), 50)
    if line.symbol not in TERMS:
        shown = panel.shown(np.full_like(tau, line.value))
    elif TERMS[line.symbol].parameters:
        return
    else:
        signal = next(iter(panel.fit)).signal if panel.fit is not None else None
        if signal is None:
            return
        shown = panel.expected(Term(line.symbol, line.value, signal), tau)
    ax.plot(tau, shown, color=style.INK, lw=1.0, ls=(0, (2, 2)), zorder=2.5, label=say("limits"))
