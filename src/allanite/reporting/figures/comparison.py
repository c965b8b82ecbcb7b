"""Figures of several records: curves with their bands, lots, and many units."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from allanite.comparison.comparison import Comparison, Pair
from allanite.comparison.pooled import Pool, PooledChannel
from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.curve import Curve
from allanite.core.display_units import readable_unit
from allanite.core.errors import UsageError
from allanite.core.model import Term
from allanite.phrases.phrase import join, say
from allanite.reporting import style, words
from allanite.reporting.digits import printable
from allanite.statistics import statistic_named
from allanite.terms import TERMS

from .drawing import TIME, draw_legend, ratio_axis, stacked, with_unit
from .panels import CurvePanel, around, positive, span, thinned

Panels = tuple[style.Axes, style.Axes]

COLORS = (0, 3)  # colors of the series before and after; neither is the red that marks a change


@style.plotted
def plot_comparison(new_figure: style.NewFigure, values: Sequence[Comparison | Pool], level: float) -> style.Figure:
    """Two panels a channel: the curves with their bands, and the ratio of their variances."""
    drawn: list[Callable[[Panels], None]] = []  # what draws each channel that has curves
    for value in values:
        if isinstance(value, Comparison):
            drawn += [partial(_draw_pair, pair, value.names, level) for pair in value if pair.ratios is not None]
        else:
            drawn += [partial(_draw_pooled, c, value.names, level) for c in value if c.curve is not None]
    if not drawn:
        raise UsageError("there are no curves to draw: only coefficients were compared")
    # one below the other, or side by side if there are several and room for them
    count, beside = len(drawn), len(drawn) > 1 and new_figure.room > 12
    figure = new_figure(*((12.4, 0.6 + 3.3 * count) if beside else (7.2, 0.6 + 6.2 * count)))
    grid = figure.subplots(count, 2) if beside else figure.subplots(2 * count, 1, height_ratios=(3, 2) * count)
    for draw, (above, below) in zip(drawn, np.reshape(grid, (-1, 2)), strict=True):
        draw((above, below))
        below.set_xlabel(TIME)
        if count > 1:
            above.set_xlabel(TIME)
    draw_legend(figure, marks=False)
    return figure


def _draw_pair(pair: Pair, names: tuple[str, ...], level: float, axes: Panels) -> None:
    above, below = axes
    ratios = pair.ratios
    assert ratios is not None  # noqa: S101 - the caller has looked
    before, after = map(printable, names)
    for i, curve, name in zip(COLORS, (ratios.before, ratios.after), (before, after), strict=True):
        draw_curve(above, curve, (i, name), level)
    frame_curves(above, ratios.before, pair.name, [ratios.before, ratios.after])
    apart = ratios.p <= pair.alpha
    (low, high), ratio = ratios.interval(level), ratios.ratio
    _ratio_frame(below, ratios.tau, ratio, apart)
    for chosen, color, label in ((~apart, style.OTHER, say("no change")), (apart, style.ALARM, say("changed"))):
        if chosen.any():
            error = np.abs(np.array([low[chosen], high[chosen]]) - ratio[chosen])
            below.errorbar(ratios.tau[chosen], ratio[chosen], error, fmt="o", ms=3.6, mew=0, color=color,
                           elinewidth=1.0, capsize=2.0, zorder=3, label=label)  # fmt: skip
    below.set_ylabel(say("variance of {after}\nover {before}", after=after, before=before), parse_math=False)


def draw_curve(ax: style.Axes, curve: Curve, called: tuple[int, str], level: float) -> None:
    """A curve with its band; it is called by the place of its color and marker, and its name."""
    i, name = called
    shown = curve.to(readable_unit(curve.unit))
    low, high = shown.interval(level)
    color, marker = style.SERIES[i % len(style.SERIES)], style.MARKERS[i % len(style.MARKERS)]
    label = say("{share} confidence", share=words.percent(level)) if i == 0 else None
    ax.fill_between(shown.tau, low, high, color=color, alpha=0.16, lw=0, zorder=2, label=label)
    ax.plot(shown.tau, shown.deviation, color=color, lw=1.1, marker=marker, ms=3.4, mew=0, zorder=3, label=name)


def frame_curves(ax: style.Axes, curve: Curve, name: str, curves: Sequence[Curve]) -> None:
    """Axes, title and grid; the upper limits of the last points are far off, and not worth the room."""
    unit = readable_unit(curve.unit)
    values = positive(np.concatenate([c.to(unit).deviation for c in curves]), name)
    tau = around(np.concatenate([c.tau for c in curves]))
    ax.set(xscale="log", yscale="log", xlim=tau, ylim=(values.min() / 2.5, values.max() * 2.5))
    style.plain_ticks(ax.xaxis, ax.yaxis)
    style.grid(ax)
    style.title(ax, name)
    ax.set_ylabel(with_unit(statistic_named(curve.statistic).title, unit))


def _ratio_frame(ax: style.Axes, tau: FloatArray, ratio: FloatArray, apart: BoolArray | None = None) -> None:
    ax.set(xscale="log", xlim=around(tau))
    ratio_axis(ax, tau, ratio, apart)
    style.plain_ticks(ax.xaxis)


def _draw_pooled(channel: PooledChannel, names: tuple[str, ...], level: float, axes: Panels) -> None:
    above, below = axes
    whole = channel.curve
    assert whole is not None  # noqa: S101 - the caller has looked
    unit = readable_unit(whole.unit)
    draw_curve(above, whole, (0, say("all runs")), level)
    for name, curve in zip(names, channel.curves, strict=True):
        color, label = (style.ALARM, say("apart")) if name in channel.apart else (style.OTHER, say("one run"))
        above.plot(curve.tau, curve.to(unit).deviation, color=color, lw=0.8, zorder=2.5, label=label)
        below.plot(curve.tau, curve.variance / whole.variance, color=color, lw=0.8, zorder=3)
    frame_curves(above, whole, channel.name, channel.curves)
    low, high = channel.curves[0].interval(level)
    size = channel.curves[0].variance
    label = say("where {share} of equal runs lie", share=words.percent(level))
    limits = whole.tau, size / high**2, size / low**2
    below.fill_between(*limits, color=style.DATA, alpha=0.16, lw=0, zorder=2, label=label)
    ratios = np.concatenate([curve.variance / whole.variance for curve in channel.curves])
    _ratio_frame(below, np.concatenate([curve.tau for curve in channel.curves]), ratios)
    below.set_ylabel(say("variance of a run\nover that of all"))


MAX_FIGURE_ROWS = 24  # rows of the figure at most, those with the most units first


class Course(NamedTuple):
    """Values at places of an abscissa, the slope of their line, and whether it differs from zero."""

    at: FloatArray
    value: FloatArray
    slope: float
    shown: bool


class LotRow(NamedTuple):
    """The values of one coefficient, and its course by the label of the abscissa."""

    channel: str
    symbol: str
    unit: str
    values: FloatArray
    courses: dict[str, Course]


@style.plotted
def plot_lot(new_figure: style.NewFigure, rows: Sequence[LotRow]) -> style.Figure:
    """A row of panels for each coefficient."""
    shown = sorted(rows, key=lambda row: -row.values.size)[:MAX_FIGURE_ROWS]
    labels = list(dict.fromkeys(label for row in shown for label in row.courses))
    wide = 1 + len(labels)
    figure = new_figure(max(3.6 * wide + 1.0, 7.2), 0.6 + 2.3 * len(shown))
    grid = figure.subplots(len(shown), wide, squeeze=False)
    for row, axes in zip(shown, grid, strict=True):
        # the share of units that are not above each value
        shares, size = axes[0], row.values.size
        shares.plot(np.sort(row.values), 100 * (np.arange(size) + 0.5) / size, "o", ms=3.5, color=style.SERIES[0])
        shares.set_ylim(0, 100)
        shares.set_ylabel(say("units below (%)"))
        shares.set_xlabel(with_unit(row.symbol, row.unit))
        shares.locator_params(axis="x", nbins=5)
        style.title(shares, join(", ", [printable(row.channel), row.symbol]))
        style.grid(shares, fine=False)
        for ax, label in zip(axes[1:], labels, strict=True):
            course = row.courses.get(label)
            if course is None:
                ax.set_axis_off()
            else:
                ax.plot(course.at, course.value, "o", ms=3.5, color=style.SERIES[0])
                ends = np.array([course.at.min(), course.at.max()])
                line = course.value.mean() + course.slope * (ends - course.at.mean())
                ax.plot(ends, line, color=style.ALARM if course.shown else style.OTHER, lw=1.2)
                ax.set_xlabel(label)
                ax.set_ylabel(with_unit(row.symbol, row.unit))
                ax.locator_params(nbins=5)
                style.grid(ax, fine=False)
    return figure


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
) -> style.Figure:
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


def _draw(ax: style.Axes, group: Sequence[UnitCurve], limits: Iterable[LimitLine]) -> None:
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


def _plot(ax: style.Axes, panel: CurvePanel, color: str, label: str, alpha: float) -> None:
    keep = thinned(panel.curve.tau.size)
    shown = panel.shown(panel.curve.deviation[keep])
    ax.plot(panel.curve.tau[keep], shown, color=color, lw=0.6 + 0.8 * (alpha == 1.0), alpha=alpha, label=label)


def _draw_limit(ax: style.Axes, panel: CurvePanel, line: LimitLine) -> None:
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
