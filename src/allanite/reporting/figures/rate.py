"""The figure of a rate: errors of every method over the intervals, and the accuracy against the measuring time."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from allanite.applications.constant_rate import RATE_ESTIMATORS, Experiment
from allanite.core.model import Model
from allanite.core.units import unit_of
from allanite.phrases.phrase import say
from allanite.reporting import style
from allanite.reporting.digits import printable
from allanite.statistics import expected

from .drawing import with_unit

MOST_MARKED = 40
"""Intervals up to which each is marked."""


@style.plotted
def plot_rates(new_figure: style.NewFigure, channels: Sequence[tuple[Experiment, tuple[Experiment, ...]]]) -> Figure:
    """A column a channel: its experiment, and below it the experiments of several measuring times, if any."""
    # a scatter of nothing has no place on a logarithmic axis
    channels = [
        (found, tuple(e for e in series if any(e.scatter(m).deviation > 0 for m in e.methods)))
        for found, series in channels
    ]
    rows = 1 + any(series for _, series in channels)
    figure = new_figure(7.2 if len(channels) == 1 else 5.2 * len(channels), 3.2 if rows == 1 else 5.6)
    grid = figure.subplots(rows, len(channels), squeeze=False)
    for column, (found, series) in zip(grid.T, channels, strict=True):
        ax = column[0]
        unit = found.signal.sheet[0]
        t = (found.start + found.duration / 2) / 60
        style.grid(ax)
        ax.axhline(0.0, color=style.INK, lw=0.8, zorder=2)
        marker = "o" if t.size <= MOST_MARKED else ""
        for method, errors in zip(found.methods, found.errors / unit_of(unit).factor, strict=True):
            ax.plot(
                t, errors, color=RATE_ESTIMATORS[method].color, lw=0.9, marker=marker, ms=2.5, label=method, zorder=3
            )
        ax.set(xlabel=say("time after the start of the record (min)"), ylabel=with_unit(say("error"), unit))
        ax.legend(ncols=len(found.methods), loc="lower center", bbox_to_anchor=(0.5, 1.0), columnspacing=1.0)
        column[0].set_title(printable(found.name), loc="left", fontweight="bold", parse_math=False, pad=22)
        if series:
            _draw_accuracy(column[1], series)
        elif rows > 1:
            column[1].set_axis_off()
    return figure


def _draw_accuracy(ax: Axes, series: tuple[Experiment, ...]) -> None:
    unit = series[0].signal.sheet[0]
    factor = unit_of(unit).factor
    style.grid(ax)
    for method in series[0].methods:
        kept = [(e.duration, e.scatter(method)) for e in series if method in e.methods]
        times = [time for time, _ in kept]
        measured, predicted = (
            np.array([getattr(s, key) for _, s in kept]) / factor for key in ("deviation", "predicted")
        )
        ax.plot(times, measured, "o", color=RATE_ESTIMATORS[method].color, ms=3.5, label=method, zorder=4)
        if np.isfinite(predicted).any():
            ax.plot(times, predicted, color=RATE_ESTIMATORS[method].color, lw=1.0, zorder=3)
    # how far B, K and R move the rate itself from interval to interval: measured scatter includes it
    ranking = series[0].ranking
    terms = () if ranking is None else tuple(t for t in ranking.model if t.row.slope >= 0)
    if terms:
        durations = np.array([e.duration for e in series])
        moved = np.sqrt(expected(Model(terms), "adev", durations)) / factor
        symbols = ", ".join(dict.fromkeys(t.symbol for t in terms))
        label = say("change of the rate itself from interval to interval ({terms})", terms=symbols)
        ax.plot(durations, moved, color=style.INK, lw=1.0, ls=(0, (5, 3)), zorder=2.5, label=label)
        ax.legend(handles=[ax.lines[-1]], loc="best")
    ax.set(xscale="log", yscale="log", xlabel=say("measuring time (s)"))
    ax.set_ylabel(say("standard deviation ({unit})\npoints measured, lines predicted", unit=unit))
    style.plain_ticks(ax.xaxis, ax.yaxis)
