"""Figures of what is made of a noise model: stated and claimed curves, state spaces, drift, plans."""

from collections.abc import Sequence

import numpy as np

from allanite.claims.drift import Drift
from allanite.claims.result import ClaimCheck
from allanite.core.arrays import FloatArray
from allanite.core.curve import Curve
from allanite.core.display_units import readable_unit
from allanite.core.errors import UndrawnError, UsageError
from allanite.core.units import convert, signal_named, unit_of
from allanite.exporting.stated_noise import StatedNoise
from allanite.phrases.phrase import join, say, say_count
from allanite.planning.plan import RecordingPlan
from allanite.reporting import style, words
from allanite.reporting.digits import printable, printed_unit
from allanite.statespace import StateSpace
from allanite.statistics import expected
from allanite.study.results import Channel
from allanite.terms import TERMS

from .comparison import draw_curve, frame_curves
from .drawing import TIME, color_of, dashes, draw_legend, stacked, with_unit

FILE, IDENTIFIED, UPPER = say("the file"), say("identified noise"), say("its upper limit")


@style.plotted
def plot_stated(new_figure: style.NewFigure, values: Sequence[StatedNoise]) -> style.Figure:
    """A column for each sensor: deviations by averaging time, and errors of a filter by the time without aid."""
    figure, columns = stacked(new_figure, [2] * len(values))
    for (above, below), value in zip(columns, values, strict=True):
        _draw_deviations(above, value)
        _draw_errors(below, value)
    return figure


def _draw_deviations(ax: style.Axes, value: StatedNoise) -> None:
    signal = value.noise.signal
    unit = readable_unit(signal.unit)
    size = unit_of(unit).factor
    for i, curve in enumerate(value.curves):
        near = (curve.tau >= value.span[0] / 3) & (curve.tau <= 3 * value.span[1])
        measured = curve.to(signal.unit).deviation[near] / size
        label = say("measured") if not i else "_"
        ax.plot(curve.tau[near], measured, ".", color=style.OTHER, ms=3, label=label)
    lines = (
        (value.upper / size, UPPER, style.FAIR, "--"), (value.identified / size, IDENTIFIED, style.INK, "-"),
        (value.deviation / size, FILE, style.ALARM, "-"),
    )  # fmt: skip
    _draw_lines(ax, value.tau, lines, value.label, (TIME, with_unit(say("Allan deviation"), printed_unit(unit))))


def _draw_errors(ax: style.Axes, value: StatedNoise) -> None:
    unit = readable_unit(value.noise.signal.si[1])
    size = unit_of(unit).factor
    lines = (
        (value.best / size, say("of the best filter"), style.INK, "-"),
        (value.actual / size, say("with the file"), style.ALARM, "-"),
        (value.predicted / size, say("predicted with the file"), style.ALARM, "--"),
    )
    names = say("time without aid (s)"), with_unit(say("error"), printed_unit(unit))
    _draw_lines(ax, value.times, lines, say("standard deviation of the error, by the time without aid"), names)


def _draw_lines(
    ax: style.Axes, x: FloatArray, lines: Sequence[tuple[FloatArray, str, str, str]], title: str, names: tuple[str, str]
) -> None:
    """Lines (values, label, color, style) over a common abscissa, with the names of both axes."""
    for values, label, color, line in lines:
        ax.plot(x, values, line, color=color, lw=1.3, label=label)
    ax.set(xscale="log", yscale="log", xlabel=names[0], ylabel=names[1])
    style.grid(ax)
    ax.legend(loc="best")
    style.title(ax, title)


TIMES_PER_OCTAVE = 4  # averaging times of the lines


@style.plotted
def plot_state_spaces(
    new_figure: style.NewFigure, spaces: Sequence[tuple[str, StateSpace, Sequence[Curve]]], *, level: float = 0.95
) -> style.Figure:
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
        m = np.unique(np.rint(np.geomspace(1, last, round(TIMES_PER_OCTAVE * np.log2(last)) + 1)).astype(np.int64))
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


MIN_ERROR, MAX_ERROR = 1e-4, 1.5  # errors that are drawn


@style.plotted
def plot_plans(new_figure: style.NewFigure, plans: Sequence[tuple[str, RecordingPlan]]) -> style.Figure:
    """Relative standard errors by length, a panel for each (name, plan) and a line for each parameter."""
    figure, (axes,) = stacked(new_figure, [len(plans)])
    for ax, (name, plan) in zip(axes, plans, strict=True):
        ax.set(xscale="log", yscale="log", ylabel=say("relative standard error (%)"))
        shortest, longest = min(plan.durations) / 3, 3 * max(plan.durations)
        for label, errors, needed in zip(plan.names, plan.errors, plan.needed.tolist(), strict=True):
            # lengths and errors that are worth drawing, the length that is needed among them
            tau, error = np.append(plan.durations, needed), np.append(errors, plan.accuracy)
            kept = np.isfinite(error) & (error < MAX_ERROR) & (error > MIN_ERROR) & (tau > shortest) & (tau < longest)
            order = np.argsort(tau[kept])
            symbol, _, parameter = label.partition(" ")
            color, line = color_of(symbol.partition("(")[0]), "--" if parameter else "-"
            ax.plot(tau[kept][order], 100 * error[kept][order], "o", ls=line, color=color, ms=3.5, lw=1.3, label=label)
        ax.axhline(100 * plan.accuracy, color=style.INK, lw=0.8, ls=(0, (4, 3)))
        ax.set_xticks(plan.durations, [words.duration(d) for d in plan.durations])
        ax.minorticks_off()
        style.grid(ax)
        style.plain_ticks(ax.yaxis)
        ax.legend(loc="best", ncols=2)
        style.title(ax, name or str(plan.model))
    axes[-1].set_xlabel(say("length of the record"))
    return figure


TIMES_PER_DECADE = 12  # times of a decade that are drawn


@style.plotted
def plot_drifts(new_figure: style.NewFigure, value: Drift) -> style.Figure:
    """A panel for each quantity, but attitude where it is as the heading."""
    if not value.axes:
        raise UndrawnError("a requirement alone is not drawn: give the noise, too")
    times = value.settings.times
    ends = (min(times), max(times)) if len(times) > 1 else (times[0] / 100, times[0])
    grid = np.geomspace(*ends, max(8, round(TIMES_PER_DECADE * np.log10(ends[1] / ends[0]))))
    courses = [value.course(name, grid) for name in value.quantities]
    if len(courses) > 1 and np.allclose(courses[0].sigma, courses[1].sigma, rtol=1e-9):
        del courses[1]
    figure, columns = stacked(new_figure, [1] * len(courses))
    several = len({axis.sensor for axis in value.axes}) > 1
    for (ax,), course in zip(columns, courses, strict=True):
        scale = course.scale
        if np.isfinite(course.high).all():
            ax.fill_between(grid, course.low * scale, course.high * scale, color=style.INK, alpha=0.15, lw=0)
        ax.plot(grid, course.sigma * scale, color=style.INK, lw=2.0, label=say("all causes"))
        if (course.most > 1.02 * np.fmax(course.sigma, course.high)).any():
            ax.plot(grid, course.most * scale, color=style.INK, lw=1.2, ls=":", label=say("at most"))
        for share in course.shares:
            if share.cause.limit or not share.variance.any():
                continue
            name = share.cause.name
            label = join(" ", (signal_named(share.sensor).name, name)) if several else name
            color = TERMS[name].color if name in TERMS else style.OTHER
            dashed = name in TERMS and share.sensor == "gyro"  # thin and solid: what does not come from the gyros
            line, width = (dashes(name), 1.4) if dashed else ("-", 0.8)
            ax.plot(grid, np.sqrt(share.variance) * scale, color=color, ls=line, lw=width, label=label)
        top = max(course.most.max(), course.sigma.max()) * scale
        bottom = max(course.sigma.min() * scale / 10, top * 1e-12)
        ax.set(xscale="log", yscale="log", ylim=(bottom, 2 * top), xlim=ends,
               xlabel=say("time without aid (s)"), ylabel=with_unit(course.title, course.unit))  # fmt: skip
        style.grid(ax)
        style.plain_ticks(ax.xaxis, ax.yaxis)
        style.title(ax, words.capital(course.title))
    draw_legend(figure, marks=False, columns=5)
    return figure


@style.plotted
def plot_claims(new_figure: style.NewFigure, values: Sequence[ClaimCheck], level: float) -> style.Figure:
    """A panel for each channel of which something is claimed, those of a sensor below each other."""
    columns: dict[str, list[tuple[ClaimCheck, Channel]]] = {}
    for value in values:
        for channel in value.checked:
            if channel.curve is not None:
                columns.setdefault(channel.record.signal.name, []).append((value, channel))
    if not columns:
        raise UsageError("there are no curves to draw: no channel of which something is claimed has a result")
    figure, grid = stacked(new_figure, [len(column) for column in columns.values()])
    for axes, column in zip(grid, columns.values(), strict=True):
        for ax, (value, channel) in zip(axes, column, strict=True):
            _draw(ax, value, channel, level)
        axes[-1].set_xlabel(TIME)
    draw_legend(figure, marks=False)
    return figure


def _draw(ax: style.Axes, value: ClaimCheck, channel: Channel, level: float) -> None:
    curve = channel.curve
    assert curve is not None  # noqa: S101 - the caller has looked
    draw_curve(ax, curve, (0, say("measured")), level)
    frame_curves(ax, curve, channel.record.name, [curve])
    claimed = value.claimed_curve(channel)
    if claimed is None:
        return
    claimed = claimed * convert(1.0, curve.unit, readable_unit(curve.unit))
    ax.plot(curve.tau, claimed, color=style.ALARM, lw=1.4, ls="--", zorder=4, label=say("claimed"))
    low, high = ax.get_ylim()
    ax.set_ylim(min(low, claimed.min() / 1.6), max(high, claimed.max() * 1.6))
