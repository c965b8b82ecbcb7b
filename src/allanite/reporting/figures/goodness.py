"""The figure that says whether to believe the model: observed over expected power, by frequency."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from allanite.core.fit import Goodness
from allanite.core.validity import UNEXPLAINED
from allanite.phrases.phrase import join, say
from allanite.reporting import style
from allanite.reporting.digits import printable

SURPRISING = 3.0
"""Standard deviations beyond which a cell is marked: one in 370 by chance."""

LEAST = 0.05
"""Ratio below which a cell is drawn at the edge."""


@style.plotted
def plot_goodness(new_figure: style.NewFigure, goodness: Goodness, name: str = "") -> Figure:
    """Two strips over frequency: the ratio of powers, and how surprising it is.

    Parameters
    ----------
    goodness : Goodness
        Of a fit.
    name : str
        Of the channel, for the title.
    """
    figure = new_figure(7.2, 3.6)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[1.25, 1])
    title = join("   ", filter(None, (printable(name), say("goodness of fit p = {p:.2g}", p=goodness.p))))
    color = style.ALARM if goodness.grade == UNEXPLAINED else style.INK
    upper.set_title(title, loc="left", fontweight="bold", color=color, parse_math=False)
    draw_ratio(upper, goodness)
    draw_surprise(lower, goodness)
    lower.set_xlabel(say("frequency (Hz)"))
    lower.set_xlim(goodness.frequency[0], goodness.frequency[-1])
    style.plain_ticks(lower.xaxis)
    return figure


def draw_ratio(ax: Axes, goodness: Goodness) -> None:
    """Observed over expected power of every cell."""
    ax.set(xscale="log", yscale="log", ylabel=say("observed /\nexpected power"))
    style.grid(ax, fine=False)
    ax.axhline(1.0, color=style.INK, lw=1.0, zorder=2)
    low, high = goodness.frequency[:-1], goodness.frequency[1:]
    # a cell of one coefficient may be as good as empty by chance: it stands at the edge, with an arrow
    ratio = np.maximum(np.nan_to_num(goodness.ratio), LEAST)
    odd = np.abs(goodness.z) > SURPRISING
    for where, color in ((~odd, style.DATA), (odd, style.ALARM)):
        ax.hlines(ratio[where], low[where], high[where], color=color, lw=2.2, zorder=3)
        edge = where & (ratio == LEAST)
        ax.plot(np.sqrt(low * high)[edge], ratio[edge], "v", color=color, ms=5, zorder=3)
    ax.set_ylim(min(0.5, ratio.min() / 1.2), max(2.0, 1.3 * ratio.max()))
    wide = ratio.max() / ratio.min() > 300
    ax.yaxis.set_major_locator(LogLocator(subs=(1.0,) if wide else (1.0, 2.0, 5.0)))
    ax.yaxis.set_minor_formatter(NullFormatter())
    style.plain_ticks(ax.yaxis)


def draw_surprise(ax: Axes, goodness: Goodness) -> None:
    """The same in standard deviations."""
    ax.set(xscale="log", ylabel=say("standard\ndeviations"))
    style.grid(ax, fine=False)
    ax.axhspan(-2, 2, color=style.DATA, alpha=0.14, lw=0, zorder=1)
    ax.axhline(0.0, color=style.INK, lw=1.0, zorder=2)
    low, high = goodness.frequency[:-1], goodness.frequency[1:]
    odd = np.abs(goodness.z) > SURPRISING
    for where, color in ((~odd, style.DATA), (odd, style.ALARM)):
        ax.bar(low[where], goodness.z[where], (high - low)[where], align="edge", color=color, alpha=0.85, zorder=3)
    reach = max(4.0, 1.15 * float(np.nanmax(np.abs(goodness.z), initial=0.0)))
    ax.set_ylim(-reach, reach)
