"""The figures of goodness of fit and residuals: power over that expected, series, autocorrelation, and quantiles."""

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from allanite.core.errors import UsageError
from allanite.core.fit import Goodness, chance
from allanite.core.residuals import Residuals
from allanite.core.validity import APPROXIMATE, EXPLAINED, UNEXPLAINED, graded
from allanite.phrases.phrase import join, say
from allanite.reporting import style
from allanite.reporting.digits import printable

from .drawing import ratio_axis
from .record import time_scale

MIN_MARKED_SIGMAS = 3.0  # standard deviations beyond which a cell is marked: one in 370 by chance


@style.plotted
def plot_goodness(new_figure: style.NewFigure, goodness: Goodness, name: str = "") -> Figure:
    """Two strips over frequency: the ratio of powers, and how surprising it is."""
    figure = new_figure(7.2, 3.6)
    color = style.ALARM if goodness.grade == UNEXPLAINED else style.INK
    _draw_goodness(figure, goodness, (name, say("goodness of fit p = {p:.2g}", p=goodness.p)), color)
    return figure


def _draw_goodness(figure: Any, goodness: Goodness, named: tuple[str, str], color: str) -> None:
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[1.25, 1])
    title = join("   ", filter(None, (printable(named[0]), named[1])))
    upper.set_title(title, loc="left", fontweight="bold", color=color, parse_math=False)
    draw_ratio(upper, goodness)
    draw_surprise(lower, goodness)
    lower.set(xlabel=say("frequency (Hz)"), xlim=goodness.frequency[[0, -1]])
    style.plain_ticks(lower.xaxis)


def draw_ratio(ax: Axes, goodness: Goodness) -> None:
    """Observed over expected power of every cell."""
    ax.set(xscale="log", ylabel=say("observed /\nexpected power"))
    low, high = goodness.frequency[:-1], goodness.frequency[1:]
    odd = np.abs(goodness.z) > MIN_MARKED_SIGMAS
    # a cell of one coefficient may be as good as empty by chance
    ratio = ratio_axis(ax, np.sqrt(low * high), np.nan_to_num(goodness.ratio), odd)
    for where, color in ((~odd, style.DATA), (odd, style.ALARM)):
        ax.hlines(ratio[where], low[where], high[where], color=color, lw=2.2, zorder=3)


def draw_surprise(ax: Axes, goodness: Goodness) -> None:
    """The same in standard deviations."""
    ax.set(xscale="log", ylabel=say("standard\ndeviations"))
    style.grid(ax, fine=False)
    ax.axhspan(-2, 2, color=style.DATA, alpha=0.14, lw=0, zorder=1)
    ax.axhline(0.0, color=style.INK, lw=1.0, zorder=2)
    low, high = goodness.frequency[:-1], goodness.frequency[1:]
    odd = np.abs(goodness.z) > MIN_MARKED_SIGMAS
    for where, color in ((~odd, style.DATA), (odd, style.ALARM)):
        ax.bar(low[where], goodness.z[where], (high - low)[where], align="edge", color=color, alpha=0.85, zorder=3)
    reach = max(4.0, 1.15 * float(np.nanmax(np.abs(goodness.z), initial=0.0)))
    ax.set_ylim(-reach, reach)


MAX_QUANTILES = 70  # quantiles that are drawn, about


@style.plotted
def plot_series(new_figure: style.NewFigure, residuals: Residuals) -> Figure:
    """The whitened series with its RMS, the autocorrelation, and the quantiles, side by side."""
    if new_figure.room < 7:
        figure = new_figure(7.2, 6.6)
        axes = figure.subplots(3, 1)
    else:
        figure = new_figure(7.2, 2.6)
        axes = figure.subplots(1, 3, width_ratios=[1.9, 1.0, 1.0])
    _draw(axes, residuals)
    return figure


@style.plotted
def plot_residuals(new_figure: style.NewFigure, residuals: Residuals) -> Figure:
    """All of it: the ratio of powers by cells of frequency and how surprising it is, and below it the series."""
    if not residuals.checks:
        raise UsageError(f"{residuals.name!r} has too few samples, without ends and gaps, to draw residuals")
    figure = new_figure(7.2, 6.0)
    halves: Any = figure.subfigures(2, 1, height_ratios=[1.3, 1.0])
    above, below = halves
    statement = residuals.statement
    color = {EXPLAINED: style.INK, APPROXIMATE: style.FAIR, UNEXPLAINED: style.ALARM}[statement.grade]
    if residuals.goodness is not None:
        title = say("{grade}, goodness of fit {p}", grade=graded(statement.grade), p=chance(residuals.goodness.p))
        _draw_goodness(above, residuals.goodness, (residuals.name, title), color)
    _draw(below.subplots(1, 3, width_ratios=[1.9, 1.0, 1.0]), residuals)
    return figure


def _draw(axes: Any, residuals: Residuals) -> None:
    _draw_series(axes[0], residuals)
    ax = axes[1]
    style.grid(ax, fine=False)
    lag = np.arange(1, residuals.correlation.size + 1)
    band = 1.96 / math.sqrt(residuals.size)
    ax.axhspan(-band, band, color=style.DATA, alpha=0.14, lw=0)
    ax.axhline(0.0, color=style.INK, lw=1.0)
    ax.bar(lag, residuals.correlation, color=_color(residuals, "correlation"), width=0.7, zorder=3)
    reach = max(4 * band, 1.2 * float(np.abs(residuals.correlation).max()))
    ax.set(xlabel=say("lag (samples)"), xlim=(0, lag[-1] + 1), ylim=(-reach, reach))
    ax.yaxis.set_major_locator(MaxNLocator(5))
    ax.set_title(say("autocorrelation"), loc="left")
    ax = axes[2]
    style.grid(ax, fine=False)
    ends = residuals.expected[[0, -1]]
    ax.plot(ends, ends, color=style.INK, lw=1.0)
    some = slice(None, None, max(residuals.expected.size // MAX_QUANTILES, 1))
    ax.plot(
        residuals.expected[some], residuals.observed[some], ".", color=_color(residuals, "kurtosis"), ms=3, zorder=3
    )
    ax.set(xlabel=say("normal quantile"), xticks=range(-4, 5, 2))
    ax.set_title(say("quantiles"), loc="left")


def _color(residuals: Residuals, *names: str) -> str:
    return style.DATA if all(residuals[name].passed for name in names) else style.ALARM


def _draw_series(ax: Axes, residuals: Residuals) -> None:
    style.grid(ax, fine=False)
    length = residuals.size / residuals.rate
    unit, size = time_scale(length)
    time = residuals.time / size
    ax.fill_between(time, residuals.low, residuals.high, color=style.DATA, alpha=0.35, lw=0)
    edges = np.linspace(time[0], time[-1], residuals.level.size + 1)
    color = _color(residuals, "halves", "eighths")
    for sign in (-1, 1):
        level, error = sign * residuals.level, 2 * residuals.level_error
        ax.stairs(level, edges, baseline=None, color=color, lw=1.4)
        ax.errorbar((edges[:-1] + edges[1:]) / 2, level, error, fmt="none", ecolor=color, lw=1.0)
    reach = max(5.0, 1.1 * float(max(residuals.high.max(), -residuals.low.min())))
    ax.set(
        xlabel=say("time ({unit})", unit=unit), ylabel=say("standard deviations"), xlim=(0, length / size),
        ylim=(-reach, reach),
    )  # fmt: skip
    ax.set_title(say("over time"), loc="left")
