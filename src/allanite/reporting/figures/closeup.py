"""One interval of a rate: slopes of its regression lines by their start, and the staircase over its counts."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from allanite.applications.constant_rate import RATE_ESTIMATORS, Closeup
from allanite.core.units import unit_of
from allanite.phrases.phrase import join, say
from allanite.reporting import style, words
from allanite.reporting.digits import printable

from .drawing import with_unit

STAIRS = 10
"""Quanta of the staircase that are drawn: more are not seen."""

MOST = 6000
"""Counts whose residuals are drawn."""


@style.plotted
def plot_closeups(new_figure: style.NewFigure, closeups: Sequence[Closeup]) -> Figure:
    """A column for each interval: slopes; below, if there are counts, their first steps and all that is left over."""
    rows = 3 if any(found.counts.size for found in closeups) else 1
    width = 7.2 if len(closeups) == 1 else 5.4 * len(closeups)
    figure = new_figure(width, 3.2 if rows == 1 else 7.8)
    grid = figure.subplots(rows, len(closeups), squeeze=False, height_ratios=(1.0, 1.25, 0.7)[:rows])
    for column, found in zip(grid.T, closeups, strict=True):
        for ax in column:
            style.grid(ax)
        _draw_slopes(column[0], found)
        if found.counts.size:
            _draw_stairs(column[1], found)
            kept = np.linspace(0, found.misfit.size - 1, min(found.misfit.size, MOST)).astype(np.int64)
            misfit = column[2]
            misfit.plot(kept / found.rate, found.misfit[kept], ".", ms=1.5, color=style.DATA, rasterized=True)
            misfit.set(xlabel=say("time in the interval (s)"), ylabel=say("counts minus staircase"))
            misfit.margins(y=0.12)
        else:
            for ax in column[1:]:
                ax.set_axis_off()
    return figure


def _draw_slopes(ax: Axes, found: Closeup) -> None:
    unit = found.signal.sheet[0]
    start = np.arange(found.slopes.size) / found.rate
    rates = found.slopes / unit_of(unit).factor
    middle = float(rates[found.kept].mean())
    rates = rates - middle
    color = RATE_ESTIMATORS["conditional"].color
    ax.plot(start[found.kept], rates[found.kept], ".", ms=4, color=color, zorder=3, label=say("kept"))
    if not found.kept.all():
        ax.plot(start[~found.kept], rates[~found.kept], "o", ms=3, mfc="white", color=style.OTHER, zorder=3,
                label=say("left out"))  # fmt: skip
    ax.axhline(0.0, color=style.INK, lw=1.0, ls=(0, (5, 3)), label=say("mean of those kept"))
    ax.set(xlabel=say("start of the line (s)"), ylabel=with_unit(say("slope less {rate:.7g}", rate=middle), unit))
    ax.ticklabel_format(axis="y", style="sci", scilimits=(-3, 4), useMathText=True)
    when = say("from {start}, {length}", start=words.duration(found.start), length=words.duration(found.duration))
    title = join("   ", [part for part in (printable(found.name), when) if part])
    ax.set_title(title, loc="left", fontsize=9.5, pad=22, parse_math=False)
    ax.legend(ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))


def _draw_stairs(ax: Axes, found: Closeup) -> None:
    time = np.arange(found.counts.size) / found.rate
    steep = abs(found.line[-1] - found.line[0]) / found.line.size
    last = min(found.line.size, max(20, int(STAIRS / steep) if steep > 0 else found.line.size))
    shown = slice(0, last, max(1, last // 4000))
    color = RATE_ESTIMATORS["staircase"].color
    ax.step(time[shown], found.counts[shown], where="post", color=style.DATA, lw=1.1, label=say("counts"), zorder=3)
    ax.step(time[shown], np.floor(found.line[shown]), where="post", color=color, lw=1.4, zorder=4,
            label=say("staircase"))  # fmt: skip
    ax.plot(time[shown], found.line[shown], color=color, lw=0.9, ls=(0, (5, 3)), zorder=2, label=say("its line"))
    ax.set(xlabel=say("time in the interval (s)"), ylabel=say("angle (quanta)"))
    ax.legend(loc="upper left")
