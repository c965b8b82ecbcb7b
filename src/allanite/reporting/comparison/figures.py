"""Both curves with their bands, and how far apart they are; all runs, and the curve they have in common."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from allanite.comparison.change import alpha_of
from allanite.comparison.comparison import Comparison, Pair, Ratios
from allanite.comparison.pooled import PooledChannel
from allanite.core.curve import Curve
from allanite.core.errors import UsageError
from allanite.core.units import readable_unit
from allanite.reporting import style, words
from allanite.reporting.drawing import draw_legend
from allanite.reporting.sheet import printable, printed_unit
from allanite.statistics import STATISTICS

from .sheets import Value

FloatArray = NDArray[np.float64]

COLORS = (0, 3)
"""Of the series, before and after: neither is the red of what has changed."""

FEW = 2.0
"""Ratio within which the axis of ratios always reaches."""


def plot_comparison(value: Value) -> Figure:
    """Two panels a channel: the curves with their bands, and the ratio of their variances.

    Raises
    ------
    UsageError
        There are no curves.
    """
    drawn: list[Callable[[Axes, Axes], None]]
    if isinstance(value, Comparison):
        drawn = [_pair(pair, value) for pair in value if pair.ratios is not None]
    else:
        drawn = [_pooled(channel, value.names, value.level) for channel in value if channel.curve is not None]
    if not drawn:
        raise UsageError("there are no curves to draw: only coefficients were compared")
    with style.look():
        alone = len(drawn) == 1
        figure = style.new_figure(*((7.2, 6.8) if alone else (12.4, 0.6 + 3.3 * len(drawn))))
        grid = (
            figure.subplots(2, 1, height_ratios=(3, 2), sharex=True)[None, :]
            if alone
            else figure.subplots(len(drawn), 2)
        )
        for draw, (above, below) in zip(drawn, np.reshape(grid, (-1, 2)), strict=True):
            draw(above, below)
            below.set_xlabel("averaging time τ (s)")
            if not alone:
                above.set_xlabel("averaging time τ (s)")
        draw_legend(figure, marks=False)
    return figure


def _pair(pair: Pair, whole: Comparison) -> Callable[[Axes, Axes], None]:
    ratios = pair.ratios
    assert ratios is not None  # noqa: S101 - the caller has looked

    def draw(above: Axes, below: Axes) -> None:
        for i, curve, name in zip(COLORS, (ratios.before, ratios.after), whole.names, strict=True):
            _curve(above, curve, (i, name), whole.level)
        _frame(above, ratios.before, pair.name, [ratios.before, ratios.after])
        _ratio(below, ratios, whole)

    return draw


def _curve(ax: Axes, curve: Curve, called: tuple[int, str], level: float) -> None:
    i, name = called
    shown = curve.to(readable_unit(curve.unit))
    low, high = shown.interval(level)
    color, marker = style.SERIES[i % len(style.SERIES)], style.MARKERS[i % len(style.MARKERS)]
    ax.fill_between(
        shown.tau,
        low,
        high,
        color=color,
        alpha=0.16,
        lw=0,
        zorder=2,
        label=f"{words.percent(level)} confidence" if i == 0 else None,
    )
    ax.plot(
        shown.tau,
        shown.deviation,
        color=color,
        lw=1.1,
        marker=marker,
        ms=3.4,
        mew=0,
        zorder=3,
        label=printable(name),
    )


def _frame(ax: Axes, curve: Curve, name: str, curves: Sequence[Curve]) -> None:
    """Axes, title and grid; the upper limits of the last points are far off, and not worth the room."""
    unit = readable_unit(curve.unit)
    values = np.concatenate([c.to(unit).deviation for c in curves])
    ax.set(xscale="log", yscale="log", ylim=(values.min() / 2.5, values.max() * 2.5))
    style.plain_ticks(ax.xaxis, ax.yaxis)
    style.grid(ax)
    ax.set_title(printable(name), loc="left", fontweight="bold", parse_math=False)
    ax.set_ylabel(f"{STATISTICS[curve.statistic].title} ({printed_unit(unit)})")


def _ratio(ax: Axes, ratios: Ratios, whole: Comparison) -> None:
    low, high = ratios.interval(whole.level)
    apart = ratios.p <= alpha_of(whole.level)
    ratio = ratios.ratio
    ax.axhline(1.0, color=style.INK, lw=0.9, zorder=2)
    for there, color, label in ((~apart, style.OTHER, "no change"), (apart, style.ALARM, "changed")):
        if there.any():
            error = np.abs(np.array([low[there], high[there]]) - ratio[there])
            ax.errorbar(
                ratios.tau[there], ratio[there], error, fmt="o", ms=3.6, mew=0, color=color, elinewidth=1.0,
                capsize=2.0, zorder=3, label=label,
            )  # fmt: skip
    _ratio_frame(ax, ratio, f"variance of {printable(whole.names[1])}\nover {printable(whole.names[0])}")


def _ratio_frame(ax: Axes, ratio: FloatArray, label: str) -> None:
    ax.set(
        xscale="log", yscale="log",
        ylim=(min(1 / FEW, float(ratio.min()) / 1.6), max(FEW, float(ratio.max()) * 1.6)),
    )  # fmt: skip
    style.plain_ticks(ax.xaxis, ax.yaxis)
    style.grid(ax)
    ax.set_ylabel(label, parse_math=False)


def _pooled(channel: PooledChannel, names: tuple[str, ...], level: float) -> Callable[[Axes, Axes], None]:
    whole = channel.curve
    assert whole is not None  # noqa: S101 - the caller has looked
    apart = channel.apart or {}

    def draw(above: Axes, below: Axes) -> None:
        _curve(above, whole, (0, "all runs"), level)
        for name, curve in zip(names, channel.curves, strict=True):
            color, label = (style.ALARM, "apart") if name in apart else (style.OTHER, "one run")
            unit = readable_unit(curve.unit)
            above.plot(curve.tau, curve.to(unit).deviation, color=color, lw=0.8, zorder=2.5, label=label)
            below.plot(curve.tau, curve.variance / whole.variance, color=color, lw=0.8, zorder=3)
        _frame(above, whole, channel.name, channel.curves)
        low, high = channel.curves[0].interval(level)
        size = channel.curves[0].variance
        below.fill_between(
            whole.tau, size / high**2, size / low**2, color=style.DATA, alpha=0.16, lw=0, zorder=2,
            label=f"where {words.percent(level)} of equal runs lie",
        )  # fmt: skip
        below.axhline(1.0, color=style.INK, lw=0.9, zorder=2)
        _ratio_frame(
            below,
            np.concatenate([c.variance / whole.variance for c in channel.curves]),
            "variance of a run\nover that of all",
        )

    return draw
