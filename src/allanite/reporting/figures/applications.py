"""Figures of measured rates, budgets and compensations."""

from collections.abc import Sequence

import numpy as np
from matplotlib.ticker import MaxNLocator

from allanite.applications.compensation.compensating import Compensated
from allanite.applications.constant_rate import RATE_ESTIMATORS, Closeup, Experiment
from allanite.applications.constant_rate.estimates import sheet_unit
from allanite.applications.signals import Budget
from allanite.core.arrays import FloatArray
from allanite.core.model import Model
from allanite.core.units import unit_of
from allanite.phrases.phrase import join, say
from allanite.reporting import style, words
from allanite.reporting.digits import printable
from allanite.reporting.words import percent
from allanite.statistics import expected

from .drawing import with_unit


@style.plotted
def plot_budgets(new_figure: style.NewFigure, budgets: Sequence[Budget]) -> style.Figure:
    """A panel for each channel, one below the other."""
    figure = new_figure(6.4, 0.4 + 3.4 * len(budgets))
    for ax, budget in zip(figure.subplots(len(budgets), 1, squeeze=False)[:, 0], budgets, strict=True):
        # one unit to an axis: what the first stage makes
        first = budget.stages[0]
        shown = [s for s in budget.stages if s.symbol == first.symbol]
        bits = range(max(1, min(s.stage.bits for s in shown) - 6), max(s.stage.bits for s in shown) + 7)
        style.grid(ax)
        for s, color, marker in zip(shown, style.SERIES * 9, style.MARKERS * 9, strict=False):
            at = s.to(s.coefficient) or 0.0
            ax.plot(bits, [at * 2.0 ** (s.stage.bits - b) for b in bits], color=color, lw=1.1)
            ax.plot([s.stage.bits], [at], marker, color=color, ms=7,
                label=say("{stage}, as it is", stage=printable(s.stage.name)))  # fmt: skip
        known = first.to(first.measured if first.measured is not None else first.limit)
        if known is not None:
            label = say("measured") if first.measured is not None else say("upper limit")
            ax.axhline(known, color=style.INK, lw=1.2, label=label)
            tenth = say("a tenth of it: 1 % of the variance")
            ax.axhline(known / 10, color=style.INK, lw=0.9, ls=(0, (5, 3)), label=tenth)
        size = say("{symbol} by rounding ({unit})", symbol=first.symbol, unit=first.sheet_unit)
        ax.set(yscale="log", xlabel=say("bits"), ylabel=size)
        style.plain_ticks(ax.yaxis)
        ax.xaxis.set_major_locator(MaxNLocator(integer=True))
        style.title(ax, budget.record.name)
        ax.legend(loc="best")
    return figure


BEFORE, AFTER, TAKEN = style.OTHER, style.SERIES[0], style.SERIES[1]

MAX_MEANS = 400  # means over time that are drawn


@style.plotted
def plot_compensated(new_figure: style.NewFigure, channels: Sequence[Compensated], level: float) -> style.Figure:
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
            y, corrected = (rate / factor for rate in channel.rates)
            bias = float(np.nanmean(corrected))
            m = max(1, y.size // MAX_MEANS)
            t = (np.arange(y.size // m) + 0.5) * m / channel.record.rate / 60
            style.grid(bottom)
            bottom.plot(t, _means(y - bias, m), color=BEFORE, lw=0.9, label=say("before"))
            bottom.plot(t, _means(corrected - bias, m), color=AFTER, lw=0.9, label=say("after"))
            bottom.plot(t, _means(y - corrected, m), color=TAKEN, lw=1.5, label=say("correction"))
            rest = with_unit(say("rate less the bias"), unit)
            means = say("{quantity}, means of {length:.3g} s", quantity=rest, length=m / channel.record.rate)
            bottom.set(xlabel=say("time (min)"), ylabel=means if m > 1 else rest)
            bottom.legend(loc="best")
        style.title(top, channel.record.name or say("channel"))
    return figure


def _means(y: FloatArray, m: int) -> FloatArray:
    count = y.size // m
    return np.asarray(y[: count * m].reshape(count, m).mean(axis=1))


MAX_MARKED = 40  # intervals up to which each is marked


@style.plotted
def plot_rates(new_figure: style.NewFigure,
               channels: Sequence[tuple[Experiment, tuple[Experiment, ...]]]) -> style.Figure:  # fmt: skip
    """A column a channel: its experiment, and below it the experiments of several measuring times, if any."""
    # a scatter of nothing has no place on a logarithmic axis
    channels = [(experiment, tuple(e for e in series if any(e.scatter(m).deviation > 0 for m in e.methods)))
        for experiment, series in channels]  # fmt: skip
    rows = 1 + any(series for _, series in channels)
    figure = new_figure(7.2 if len(channels) == 1 else 5.2 * len(channels), 3.2 if rows == 1 else 5.6)
    grid = figure.subplots(rows, len(channels), squeeze=False)
    for column, (experiment, series) in zip(grid.T, channels, strict=True):
        ax, (unit, factor) = column[0], sheet_unit(experiment.signal)
        t = (experiment.start + experiment.duration / 2) / 60
        style.grid(ax)
        ax.axhline(0.0, color=style.INK, lw=0.8, zorder=2)
        marker = "o" if t.size <= MAX_MARKED else ""
        for method, errors in zip(experiment.methods, experiment.errors / factor, strict=True):
            color = RATE_ESTIMATORS[method].color
            ax.plot(t, errors, color=color, lw=0.9, marker=marker, ms=2.5, label=method, zorder=3)
        ax.set(xlabel=say("time after the start of the record (min)"), ylabel=with_unit(say("error"), unit))
        ax.legend(ncols=len(experiment.methods), loc="lower center", bbox_to_anchor=(0.5, 1.0), columnspacing=1.0)
        ax.set_title(printable(experiment.name), loc="left", fontweight="bold", parse_math=False, pad=22)
        if series:
            _draw_accuracy(column[1], series)
        elif rows > 1:
            column[1].set_axis_off()
    return figure


def _draw_accuracy(ax: style.Axes, series: tuple[Experiment, ...]) -> None:
    unit, factor = sheet_unit(series[0].signal)
    style.grid(ax)
    for method in series[0].methods:
        kept = [(e.duration, e.scatter(method)) for e in series if method in e.methods]
        times, measured, predicted = np.array([(time, s.deviation, s.predicted) for time, s in kept]).T
        color = RATE_ESTIMATORS[method].color
        ax.plot(times, measured / factor, "o", color=color, ms=3.5, label=method, zorder=4)
        if np.isfinite(predicted).any():
            ax.plot(times, predicted / factor, color=color, lw=1.0, zorder=3)
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


MAX_STAIRS = 10  # quanta of the staircase that are drawn: more are not seen
MAX_COUNTS = 6000  # counts whose residuals are drawn


@style.plotted
def plot_closeups(new_figure: style.NewFigure, closeups: Sequence[Closeup]) -> style.Figure:
    """A column for each interval: slopes, or a descent; below, of counts, their first steps and what is left over."""
    rows = 3 if any(closeup.counts.size for closeup in closeups) else 1
    width = 7.2 if len(closeups) == 1 else 5.4 * len(closeups)
    figure = new_figure(width, 3.2 if rows == 1 else 7.8)
    grid = figure.subplots(rows, len(closeups), squeeze=False, height_ratios=(1.0, 1.25, 0.7)[:rows])
    for column, closeup in zip(grid.T, closeups, strict=True):
        for ax in column:
            style.grid(ax)
        (_draw_descent if closeup.descent.size else _draw_slopes)(column[0], closeup)
        if closeup.counts.size:
            _draw_stairs(column[1], closeup)
            kept = np.linspace(0, closeup.misfit.size - 1, min(closeup.misfit.size, MAX_COUNTS)).astype(np.int64)
            misfit = column[2]
            misfit.plot(kept / closeup.rate, closeup.misfit[kept], ".", ms=1.5, color=style.DATA, rasterized=True)
            misfit.set(xlabel=say("time in the interval (s)"), ylabel=say("counts minus staircase"))
            misfit.margins(y=0.12)
        else:
            for ax in column[1:]:
                ax.set_axis_off()
    return figure


def _draw_slopes(ax: style.Axes, found: Closeup) -> None:
    unit, factor = sheet_unit(found.signal)
    start, rates = np.arange(found.slopes.size) / found.rate, found.slopes / factor
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


def _draw_descent(ax: style.Axes, found: Closeup) -> None:
    (unit, factor), color = sheet_unit(found.signal), RATE_ESTIMATORS["staircase"].color
    ax.plot(found.descent / factor, "o-", ms=3.5, lw=1.1, color=color)
    ax.set(xlabel=say("step of the descent"), ylabel=with_unit(say("rate"), unit))
    ax.ticklabel_format(axis="y", useOffset=False)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    style.title(ax, found.name)


def _draw_stairs(ax: style.Axes, found: Closeup) -> None:
    time = np.arange(found.counts.size) / found.rate
    steep = abs(found.line[-1] - found.line[0]) / found.line.size
    last = min(found.line.size, max(20, int(MAX_STAIRS / steep) if steep > 0 else found.line.size))
    shown = slice(0, last, max(1, last // 4000))
    color = RATE_ESTIMATORS["staircase"].color
    ax.step(time[shown], found.counts[shown], where="post", color=style.DATA, lw=1.1, label=say("counts"), zorder=3)
    ax.step(time[shown], np.floor(found.line[shown]), where="post", color=color, lw=1.4, zorder=4,
            label=say("staircase"))  # fmt: skip
    ax.plot(time[shown], found.line[shown], color=color, lw=0.9, ls=(0, (5, 3)), zorder=2, label=say("its line"))
    ax.set(xlabel=say("time in the interval (s)"), ylabel=say("angle (quanta)"))
    ax.legend(loc="upper left")
