"""Several curves in one panel: channels of one statistic, or statistics of one channel."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from allanite.phrases.phrase import join, say
from allanite.reporting import style
from allanite.reporting.digits import printable
from allanite.statistics import statistic_named

from .drawing import EXPECTED, TIME, draw_legend, stacked, with_unit
from .panels import CurvePanel, points, span

MOST_BANDS = 3
"""Curves of a panel whose confidence bands can still be told apart."""


@style.plotted
def plot_overlay(new_figure: style.NewFigure, panels: Sequence[CurvePanel], *, level: float = 0.95) -> Figure:
    """One panel for each channel with all its statistics; channels of a single statistic share one panel.

    Sensors of different units stand side by side. Where a fit is given its model's expectation of each statistic is
    drawn as a dashed line.
    """
    # columns by unit, of panels by channel, of curves
    single = len({panel.curve.statistic for panel in panels}) == 1
    by_unit: dict[str, dict[str, list[CurvePanel]]] = {}
    for panel in panels:
        by_unit.setdefault(panel.unit, {}).setdefault("" if single else panel.name, []).append(panel)
    columns = [list(by_name.values()) for by_name in by_unit.values()]
    figure, grid = stacked(new_figure, [len(column) for column in columns])
    for column, axes in zip(columns, grid, strict=True):
        spans = [span(drawn)[0] for group in column for drawn in group]
        for ax, group in zip(axes, column, strict=True):
            ax.set(xscale="log", xlim=(min(low for low, _ in spans), max(high for _, high in spans)))
            _draw_group(ax, group, level)
        axes[-1].set_xlabel(TIME)
    draw_legend(figure, marks=False)
    return figure


def _draw_group(ax: Axes, group: Sequence[CurvePanel], level: float) -> None:
    spans = [span(panel)[1] for panel in group]
    ax.set(yscale="log", ylim=(min(low for low, _ in spans), max(high for _, high in spans)))
    style.plain_ticks(ax.xaxis)
    style.plain_ticks(ax.yaxis, most=3000)
    style.grid(ax)
    names, titles = (dict.fromkeys(found) for found in zip(*map(_called, group), strict=True))
    for i, panel in enumerate(group):
        name, title = _called(panel)
        told = [part for part, known in ((name, names), (title, titles)) if len(known) > 1]
        label = join(", ", told) or title or name
        _draw_curve(ax, panel, (i, label), level if len(group) <= MOST_BANDS else None)
    ax.set_title(next(iter(names)) if len(names) == 1 else "", loc="left", fontweight="bold", parse_math=False)
    what = next(iter(titles)) if len(titles) == 1 else say("deviation")
    ax.set_ylabel(with_unit(what, group[0].unit))


def _called(panel: CurvePanel) -> tuple[str, str]:
    return printable(panel.name), statistic_named(panel.curve.statistic).title


def _draw_curve(ax: Axes, panel: CurvePanel, label: tuple[int, str], level: float | None) -> None:
    i, text = label
    drawn = points(panel, level or 0.95)
    color, marker = style.SERIES[i % len(style.SERIES)], style.MARKERS[i % len(style.MARKERS)]
    if drawn.low is not None and drawn.high is not None and level is not None:
        ax.fill_between(drawn.tau, drawn.low, drawn.high, color=color, alpha=0.14, lw=0, zorder=2)
    size = 3.4 if drawn.tau.size <= 40 else 0.0
    ax.plot(drawn.tau, drawn.deviation, color=color, lw=1.1, marker=marker, ms=size, mew=0, zorder=3, label=text)
    if panel.fit is not None and panel.fit.valid is not None:
        tau = np.geomspace(drawn.tau[0], drawn.tau[-1], 200)
        ax.plot(tau, panel.whole(panel.fit.valid, tau), color=color, lw=1.0, ls=(0, (5, 3)), zorder=2.5, label=EXPECTED)
