"""Figures of a compensation: deviations before and after, and the correction over time."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from allanite.applications.compensation.compensated import Compensated
from allanite.core.units import unit_of
from allanite.phrases.phrase import say
from allanite.reporting import style
from allanite.reporting.words import percent

from .drawing import with_unit
from .labels import FloatArray

BEFORE, AFTER, TAKEN = style.OTHER, style.SERIES[0], style.SERIES[1]

POINTS = 400
"""Means over time that are drawn."""


@style.plotted
def plot_compensated(new_figure: style.NewFigure, channels: Sequence[Compensated], level: float) -> Figure:
    """Deviation by averaging time, and below it rate by time, of each channel that was corrected."""
    width = 7.2 if len(channels) == 1 else 5.2 * len(channels)
    figure = new_figure(width, 6.6)
    for channel, (top, bottom) in zip(channels, figure.subplots(2, len(channels), squeeze=False).T, strict=True):
        unit = channel.record.signal.sheet[0]
        style.grid(top)
        for curve, color, label in ((channel.before, BEFORE, say("before")), (channel.after, AFTER, say("after"))):
            if curve is not None:
                shown = curve.to(unit)
                low, high = shown.interval(level)
                known = np.isfinite(low) & np.isfinite(high)
                top.fill_between(shown.tau[known], low[known], high[known], color=color, alpha=0.2, lw=0)
                top.plot(shown.tau, shown.deviation, color=color, marker="o", ms=3, lw=1.3, label=label)
        top.set(
            xscale="log", yscale="log", xlabel=say("averaging time (s)"), ylabel=with_unit(say("Allan deviation"), unit)
        )
        style.plain_ticks(top.xaxis, top.yaxis)
        top.legend(loc="best", title=say("with {share} bands", share=percent(level)), title_fontsize=8)
        factor = unit_of(unit).factor
        if channel.rates is None:  # read from what was stored, without readings
            bottom.set_axis_off()
        else:
            y, left = (rate / factor for rate in channel.rates)
            bias = float(np.nanmean(left))
            m = max(1, y.size // POINTS)
            t = (np.arange(y.size // m) + 0.5) * m / channel.record.rate / 60
            style.grid(bottom)
            bottom.plot(t, _means(y - bias, m), color=BEFORE, lw=0.9, label=say("before"))
            bottom.plot(t, _means(left - bias, m), color=AFTER, lw=0.9, label=say("after"))
            bottom.plot(t, _means(y - left, m), color=TAKEN, lw=1.5, label=say("correction"))
            rest = with_unit(say("rate less the bias"), unit)
            means = say("{quantity}, means of {length:.3g} s", quantity=rest, length=m / channel.record.rate)
            bottom.set(xlabel=say("time (min)"), ylabel=means if m > 1 else rest)
            bottom.legend(loc="best")
        style.title(top, channel.record.name or say("channel"))
    return figure


def _means(y: FloatArray, m: int) -> FloatArray:
    count = y.size // m
    return np.asarray(y[: count * m].reshape(count, m).mean(axis=1))
