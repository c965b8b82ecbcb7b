"""The Allan deviation of a state space beside the model's."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from allanite.core.curve import Curve
from allanite.core.units import convert
from allanite.phrases.phrase import join, say, say_count
from allanite.reporting import style
from allanite.reporting.digits import printable
from allanite.statespace import StateSpace
from allanite.statistics import expected

from .drawing import TIME, with_unit

PER_OCTAVE = 4
"""Averaging times of the lines."""


@style.plotted
def plot_state_spaces(
    new_figure: style.NewFigure, spaces: Sequence[tuple[str, StateSpace, Sequence[Curve]]], *, level: float = 0.95
) -> Figure:
    """A column for each (name, state space, measured curves): Allan deviations, and below how far they are apart."""
    figure = new_figure(7.2 if len(spaces) == 1 else 6.4 * len(spaces), 6.0)
    grid = figure.subplots(2, len(spaces), sharex="col", height_ratios=(3, 1.2), squeeze=False)
    for (above, below), (name, space, curves) in zip(grid.T, spaces, strict=True):
        unit = space.model.signal.sheet[0]
        for curve in curves:
            shown, channel = curve.to(unit), printable(curve.name)
            if curve.law is not None:
                above.fill_between(shown.tau, *shown.interval(level), color=style.DATA, alpha=0.2, lw=0)
            label = say("measured {channel}", channel=channel) if channel else say("measured")
            above.plot(shown.tau, shown.deviation, color=style.DATA, lw=0.9, label=label)
        factor = 1 / convert(1.0, unit, space.model.signal.unit)
        last = max(2.0, 3 * space.tau[1] * space.rate)
        m = np.unique(np.rint(np.geomspace(1, last, round(PER_OCTAVE * np.log2(last)) + 1)).astype(np.int64))
        tau = m / space.rate
        own, whole = np.sqrt(space.allan(m)), np.sqrt(expected(space.model, "oadev", tau))
        above.plot(tau, whole * factor, color=style.INK, lw=1.3, label=say("model"))
        above.plot(tau, own * factor, "o", ms=3.2, mew=0, color=style.SERIES[1], label=say("state space"), zorder=4)
        above.set(xscale="log", yscale="log", ylabel=with_unit(say("Allan deviation"), unit))
        below.plot(tau, 100 * (own / whole - 1), color=style.SERIES[1], lw=1.2)
        below.axhline(0.0, color=style.INK, lw=0.8)
        largest = max(3 * 100 * space.ripple, 1.0)
        below.set(ylim=(-largest, largest), ylabel=say("difference (%)"), xlabel=TIME)
        for ax in (above, below):
            ax.axvspan(*space.tau, color="#9AA3AD", alpha=0.15, lw=0, label=say("where they are matched"))
            style.grid(ax)
        style.plain_ticks(above.xaxis, above.yaxis)
        above.legend(loc="best")
        count = len(space.states)
        title = say_count(count, "{count} state at {rate:g} Hz", "{count} states at {rate:g} Hz", rate=space.rate)
        named = join(": ", (printable(name), title)) if name else title
        above.set_title(named, loc="left", fontweight="bold", parse_math=False)
    return figure
