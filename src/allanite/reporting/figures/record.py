"""Figures of what changes with time: records, a curve over the model, and surfaces."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator

from allanite.core.arrays import FloatArray
from allanite.core.curve import Surface
from allanite.core.display_units import readable_unit
from allanite.core.errors import UsageError
from allanite.core.fit import Goodness, chance
from allanite.core.record import Record
from allanite.core.residuals import Residuals
from allanite.core.units import unit_of
from allanite.core.validity import APPROXIMATE, EXPLAINED, UNEXPLAINED, graded
from allanite.phrases.phrase import join, say
from allanite.reporting import style, words
from allanite.reporting.digits import printable, printed_unit
from allanite.statistics import statistic_named

from .drawing import TIME, draw_legend, ratio_axis, with_unit
from .panels import CurvePanel, points

STRETCHES = 480  # stretches of a record whose least and largest sample are drawn: more are not seen

MEANS = 6  # stretches of one mean

MIN_HOURS_S, MIN_MINUTES_S = 7200.0, 300.0  # lengths in seconds from which time is shown in hours, and in minutes


def time_scale(length: float) -> tuple[str, float]:
    """The unit of a time axis of so many seconds, and its size."""
    return ("h", 3600.0) if length > MIN_HOURS_S else ("min", 60.0) if length > MIN_MINUTES_S else ("s", 1.0)


class Envelope(NamedTuple):
    """Stretches of a record; where one has no value, its three values are NaN."""

    at: FloatArray  # the sample in their middle
    low: FloatArray
    mean: FloatArray
    high: FloatArray
    broken: FloatArray  # whether samples are missing


def envelope(record: Record, count: int) -> Envelope:
    """Least, mean and largest sample of so many stretches of a record, or of each sample if it has fewer."""
    values, size = record.values, len(record.values)
    edges = np.linspace(0, size, min(count, size) + 1).astype(np.int64)
    starts, lengths = edges[:-1], np.diff(edges)
    low, high = (f.reduceat(values, starts).astype(np.float64) for f in (np.fmin, np.fmax))
    sums, known = np.add.reduceat(values, starts, dtype=np.float64), lengths
    broken = np.isnan(sums)
    if broken.any():
        valid = ~np.isnan(values)
        known = np.add.reduceat(valid, starts, dtype=np.int64)
        sums = np.add.reduceat(np.where(valid, values, 0.0), starts)
    with np.errstate(invalid="ignore"):
        mean = sums / known
    scale = 1.0 if record.kind == "count" or record.scale is None else record.scale
    return Envelope((edges[:-1] + edges[1:] - 1) / 2, low * scale, mean * scale, high * scale, broken)


@style.plotted
def plot_records(new_figure: style.NewFigure, records: Sequence[Record]) -> style.Figure:
    """Records over the time of the whole recording, a panel each: the range of short stretches, and their means."""
    figure = new_figure(7.2, 0.7 + 1.5 * len(records))
    panels = figure.subplots(len(records), 1, squeeze=False, sharex="col")[:, 0]
    name, size = time_scale(max(record.duration for record in records))
    for ax, record in zip(panels, records, strict=True):
        _draw_record(ax, record, size)
        ax.tick_params(labelbottom=ax is panels[-1])
    first, last = min(r.cut for r in records), max(r.cut + r.duration for r in records)
    panels[-1].set(xlabel=say("time ({unit})", unit=name), xlim=(first / size, last / size))
    draw_legend(figure)
    return figure


def _draw_record(ax: style.Axes, record: Record, size: float) -> None:
    """A record over time in units of so many seconds."""
    style.grid(ax, fine=False)
    ranges, length = envelope(record, STRETCHES), len(record.values)
    time = (record.cut + ranges.at / record.rate) / size
    if length <= STRETCHES:
        ax.plot(time, ranges.mean, ".-", color=style.SERIES[0], lw=0.7, ms=2.5, label=say("samples"))
    else:
        both = np.column_stack([ranges.low, ranges.high]).ravel()
        ax.plot(np.repeat(time, 2), both, color=style.SERIES[0], lw=1.0, label=say("samples"))
    if length > MEANS * STRETCHES:
        course = envelope(record, STRETCHES // MEANS)
        ax.plot((record.cut + course.at / record.rate) / size, course.mean, color=style.SERIES[1], lw=1.1,
                label=say("means over {time}", time=words.duration(record.duration * MEANS / STRETCHES)))  # fmt: skip
    if ranges.broken.any():
        gaps = time[ranges.broken]
        ax.plot(gaps, np.full(gaps.size, 0.03), "|", color=style.ALARM, ms=6, label=say("missing samples"),
                transform=ax.get_xaxis_transform())  # fmt: skip
    ax.set_ylabel(join("", [printed_unit(record.unit)]))
    if record.kind == "count":
        ax.set_ylabel(say("pulses of {size}", size=f"{record.scale:g} {printed_unit(record.unit)}"))
        unit = record.signal.sheet[0]
        pulse = record.factor * record.rate / unit_of(unit).factor
        conversions: Any = (lambda count: count * pulse, lambda rate: rate / pulse)
        ax.secondary_yaxis("right", functions=conversions).set_ylabel(printed_unit(unit))
    style.title(ax, record.name)


@style.plotted
def plot_strip(new_figure: style.NewFigure, panel: CurvePanel, *, level: float = 0.95) -> style.Figure:
    """The deviation over that expected under the model, with its band, by averaging time."""
    drawn = points(panel, level)
    expected = panel.whole(drawn.tau)
    figure = new_figure(7.2, 1.9)
    ax = figure.subplots()
    ax.set(xscale="log", xlabel=TIME, ylabel=say("observed /\nexpected"))
    ratio = drawn.deviation / expected
    shown = ratio_axis(ax, drawn.tau, ratio)
    if drawn.low is not None and drawn.high is not None:
        ax.fill_between(drawn.tau, drawn.low / expected, drawn.high / expected, color=style.DATA, alpha=0.18, lw=0)
    ax.plot(drawn.tau, shown, "-", color=style.DATA, lw=0.9)
    ax.plot(drawn.tau, np.where(shown == ratio, ratio, np.nan), "o", color=style.DATA, ms=2.8, mew=0)
    style.plain_ticks(ax.xaxis)
    return figure


TIME_COLORS, RATIO_COLORS = "cividis", "RdBu_r"

RATIOS = (1.5, 2.0, 3.0, 5.0, 10.0)  # ends of the scale of ratios, of which the first that holds nearly all is taken

FEW_WINDOWS = 8
"""Averaging times beyond this part of a window scatter by themselves: their median is marked as uncertain."""


@style.plotted
def plot_surfaces(new_figure: style.NewFigure, surfaces: Sequence[Surface]) -> style.Figure:
    """For each channel, every window's curve, and the ratio of each value to the median of its averaging time."""
    figure = new_figure(9.6, 0.4 + 3.7 * len(surfaces))
    grid = figure.subplots(len(surfaces), 2, squeeze=False, width_ratios=[1, 1.5])
    for (curves, ratios), surface in zip(grid, surfaces, strict=True):
        _draw(figure, (curves, ratios), surface.to(readable_unit(surface.unit)))
    return figure


def _draw(figure: style.Figure, axes: tuple[style.Axes, style.Axes], surface: Surface) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    curves, ratios = axes
    deviation = np.where(surface.deviation > 0, surface.deviation, np.nan)
    known = np.isfinite(deviation).any(axis=0)
    if not known.any():
        raise UsageError(f"the surface of {surface.name!r} is zero everywhere: logarithmic axes cannot show it")
    tau, deviation = surface.tau[known], deviation[:, known]
    longest = surface.time[-1]
    scales = (("d", 86400.0, 3 * 86400.0), ("h", 3600.0, 3 * 3600.0), ("min", 60.0, 600.0), ("s", 1.0, 0.0))
    unit, size = next((unit, size) for unit, size, least in scales if longest >= least)
    norm = Normalize(0, (surface.time[-1] + surface.window / 2) / size)
    _draw_curves(curves, tau, deviation, surface.time / size, norm)
    curves.set(xlabel=TIME)
    curves.set_ylabel(with_unit(statistic_named(surface.statistic).title, surface.unit))
    style.title(curves, surface.name)
    scale = ScalarMappable(norm=norm, cmap=TIME_COLORS)
    bar = figure.colorbar(scale, cax=curves.inset_axes((0.06, 0.14, 0.42, 0.025)), orientation="horizontal")
    bar.ax.set_title(say("time ({unit})", unit=unit), fontsize=7.5, pad=3)
    bar.ax.tick_params(labelsize=7)
    curves.legend(loc="upper right")
    mesh = _draw_ratios(ratios, tau, deviation, surface.time / size)
    ratios.set(xlabel=say("time ({unit})", unit=unit), ylabel=TIME)
    ratios.set_title(
        say("windows of {length}", length=words.duration(surface.window)), loc="right", fontsize=8, color=style.OTHER
    )
    window = surface.window
    low, high = ratios.get_ylim()
    if low < window / FEW_WINDOWS < high:
        ratios.axhline(window / FEW_WINDOWS, color=style.INK, lw=0.8, ls=(0, (4, 3)))
        ratios.annotate(
            say("above: few degrees of freedom (τ > window/{part})", part=FEW_WINDOWS), (0.01, window / FEW_WINDOWS),
            xycoords=("axes fraction", "data"), xytext=(2, 4), textcoords="offset points", fontsize=7, color=style.INK,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 1.0},
        )  # fmt: skip
    bar = figure.colorbar(mesh, ax=ratios, extend="both", aspect=28)
    end = mesh.get_clim()[1] or RATIOS[-1]
    up = [r for r in (1.2, *RATIOS) if r <= end * 1.001 and (end <= 2 or r >= 2)]
    bar.ax.yaxis.set_major_locator(FixedLocator([*(1 / r for r in up), 1.0, *up]))
    bar.ax.yaxis.set_minor_locator(NullLocator())
    bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"× {v:.2g}"))
    bar.set_label(say("deviation / its median over time"))


def _draw_curves(ax: style.Axes, tau: FloatArray, deviation: FloatArray, time: FloatArray,
                 norm: style.Normalize) -> None:  # fmt: skip
    from matplotlib.collections import LineCollection

    ax.set(xscale="log", yscale="log", xlim=(tau[0] / 1.3, tau[-1] * 1.3))
    # the outermost windows at the longest times are not worth the room
    low, high = np.nanpercentile(deviation, (5, 95), axis=0)
    ax.set_ylim(np.nanmin(low) / 2.5, np.nanmax(high) * 1.4)
    style.plain_ticks(ax.xaxis, ax.yaxis)
    style.grid(ax)
    lines = [np.column_stack([tau, row]) for row in deviation]
    look: Any = {"cmap": TIME_COLORS, "norm": norm, "lw": 0.9, "alpha": 0.75, "zorder": 2, "rasterized": True}
    ax.add_collection(LineCollection(lines, array=time, **look))
    ax.plot(tau, np.nanmedian(deviation, axis=0), color=style.ALARM, lw=1.8, zorder=3, label=say("median over time"))


def _draw_ratios(ax: style.Axes, tau: FloatArray, deviation: FloatArray, time: FloatArray) -> style.QuadMesh:
    from matplotlib.colors import LogNorm

    ratio = deviation / np.nanmedian(deviation, axis=0)
    extreme = np.nanpercentile(np.abs(np.log(ratio)), 98)
    end = next((r for r in RATIOS if np.log(r) >= extreme), RATIOS[-1])
    ax.set(yscale="log")
    x, y, norm = _edges(time), np.exp(_edges(np.log(tau))), LogNorm(1 / end, end)
    mesh = ax.pcolormesh(x, y, ratio.T, norm=norm, cmap=RATIO_COLORS, rasterized=True)
    ax.set_facecolor("#BFC4CA")
    style.plain_ticks(ax.yaxis)
    return mesh


def _edges(centres: FloatArray) -> FloatArray:
    """Borders half way between neighbours, and as far beyond the first and the last."""
    if centres.size == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    middle = (centres[1:] + centres[:-1]) / 2
    return np.concatenate(([2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]))


MIN_MARKED_SIGMAS = 3.0  # standard deviations beyond which a cell is marked: one in 370 by chance


@style.plotted
def plot_goodness(new_figure: style.NewFigure, goodness: Goodness, name: str = "") -> style.Figure:
    """Two strips over frequency: the ratio of powers, and how surprising it is."""
    figure = new_figure(7.2, 3.6)
    color = style.ALARM if goodness.grade == UNEXPLAINED else style.INK
    _draw_goodness(figure, goodness, (name, say("goodness of fit p = {p:.2g}", p=goodness.p)), color)
    return figure


def _draw_goodness(figure: Any, goodness: Goodness, named: tuple[str, str], color: str) -> None:
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[1.25, 1])
    title = join("   ", filter(None, (printable(named[0]), named[1])))
    upper.set_title(title, loc="left", fontweight="bold", color=color, parse_math=False)
    upper.set(xscale="log", ylabel=say("observed /\nexpected power"))
    lower.set(xscale="log", ylabel=say("standard\ndeviations"))
    low, high = goodness.frequency[:-1], goodness.frequency[1:]
    odd = np.abs(goodness.z) > MIN_MARKED_SIGMAS
    # a cell of one coefficient may be as good as empty by chance
    ratio = ratio_axis(upper, np.sqrt(low * high), np.nan_to_num(goodness.ratio), odd)
    style.grid(lower, fine=False)
    lower.axhspan(-2, 2, color=style.DATA, alpha=0.14, lw=0, zorder=1)
    lower.axhline(0.0, color=style.INK, lw=1.0, zorder=2)
    for where, shade in ((~odd, style.DATA), (odd, style.ALARM)):
        a, b = low[where], high[where]
        upper.hlines(ratio[where], a, b, color=shade, lw=2.2, zorder=3)
        lower.bar(a, goodness.z[where], b - a, align="edge", color=shade, alpha=0.85, zorder=3)
    reach = max(4.0, 1.15 * float(np.abs(goodness.z[np.isfinite(goodness.z)]).max(initial=0.0)))
    lower.set(xlabel=say("frequency (Hz)"), xlim=goodness.frequency[[0, -1]], ylim=(-reach, reach))
    style.plain_ticks(lower.xaxis)


MAX_QUANTILES = 70  # quantiles that are drawn, about


@style.plotted
def plot_series(new_figure: style.NewFigure, residuals: Residuals) -> style.Figure:
    """The whitened series with its RMS, the autocorrelation, and the quantiles, side by side."""
    if new_figure.room < 7:
        figure = new_figure(7.2, 6.6)
        axes = figure.subplots(3, 1)
    else:
        figure = new_figure(7.2, 2.6)
        axes = figure.subplots(1, 3, width_ratios=[1.9, 1.0, 1.0])
    _draw_tests(axes, residuals)
    return figure


@style.plotted
def plot_residuals(new_figure: style.NewFigure, residuals: Residuals) -> style.Figure:
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
    _draw_tests(below.subplots(1, 3, width_ratios=[1.9, 1.0, 1.0]), residuals)
    return figure


def _draw_tests(axes: Any, residuals: Residuals) -> None:
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
    expected, observed = residuals.expected[some], residuals.observed[some]
    ax.plot(expected, observed, ".", color=_color(residuals, "kurtosis"), ms=3, zorder=3)
    ax.set(xlabel=say("normal quantile"), xticks=range(-4, 5, 2))
    ax.set_title(say("quantiles"), loc="left")


def _color(residuals: Residuals, *names: str) -> str:
    return style.DATA if all(residuals[name].passed for name in names) else style.ALARM


def _draw_series(ax: style.Axes, residuals: Residuals) -> None:
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
    ax.set(xlabel=say("time ({unit})", unit=unit), xlim=(0, length / size), ylim=(-reach, reach))
    ax.set_ylabel(say("standard deviations"))
    ax.set_title(say("over time"), loc="left")
