"""The figure of a surface: what changes with time, apart from what changes with averaging time."""

from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, QuadMesh
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from allanite.core.display_units import readable_unit
from allanite.core.errors import UsageError
from allanite.core.surface import Surface
from allanite.phrases.phrase import say
from allanite.reporting import style, words
from allanite.statistics import statistic_named

from .drawing import TIME, with_unit
from .labels import FloatArray

TIME_COLORS, RATIO_COLORS = "cividis", "RdBu_r"

RATIOS = (1.5, 2.0, 3.0, 5.0, 10.0)
"""Ends of the scale of ratios, of which the first that holds nearly all is taken."""

FEW_WINDOWS = 8
"""Averaging times beyond this part of a window scatter by themselves: their median is marked as uncertain."""


@style.plotted
def plot_surfaces(new_figure: style.NewFigure, surfaces: Sequence[Surface]) -> Figure:
    """For each channel, every window's curve, and the ratio of each value to the median of its averaging time."""
    figure = new_figure(9.6, 0.4 + 3.7 * len(surfaces))
    grid = figure.subplots(len(surfaces), 2, squeeze=False, width_ratios=[1, 1.5])
    for (left, right), surface in zip(grid, surfaces, strict=True):
        _draw(figure, (left, right), surface.to(readable_unit(surface.unit)))
    return figure


def _draw(figure: Figure, axes: tuple[Axes, Axes], surface: Surface) -> None:
    left, right = axes
    deviation = np.where(surface.deviation > 0, surface.deviation, np.nan)
    there = np.isfinite(deviation).any(axis=0)
    if not there.any():
        raise UsageError(f"the surface of {surface.name!r} is zero everywhere: logarithmic axes cannot show it")
    tau, deviation = surface.tau[there], deviation[:, there]
    longest = surface.time[-1]
    scales = (("d", 86400.0, 3 * 86400.0), ("h", 3600.0, 3 * 3600.0), ("min", 60.0, 600.0), ("s", 1.0, 0.0))
    unit, size = next((unit, size) for unit, size, least in scales if longest >= least)
    norm = Normalize(0, (surface.time[-1] + surface.window / 2) / size)
    _draw_curves(left, tau, deviation, surface.time / size, norm)
    left.set(xlabel=TIME)
    left.set_ylabel(with_unit(statistic_named(surface.statistic).title, surface.unit))
    style.title(left, surface.name)
    scale = mpl.cm.ScalarMappable(norm=norm, cmap=TIME_COLORS)
    bar = figure.colorbar(scale, cax=left.inset_axes((0.06, 0.14, 0.42, 0.025)), orientation="horizontal")
    bar.ax.set_title(say("time ({unit})", unit=unit), fontsize=7.5, pad=3)
    bar.ax.tick_params(labelsize=7)
    left.legend(loc="upper right")
    mesh = _draw_ratios(right, tau, deviation, surface.time / size)
    right.set(xlabel=say("time ({unit})", unit=unit), ylabel=TIME)
    right.set_title(
        say("windows of {length}", length=words.duration(surface.window)), loc="right", fontsize=8, color=style.OTHER
    )
    window = surface.window
    low, high = right.get_ylim()
    if low < window / FEW_WINDOWS < high:
        right.axhline(window / FEW_WINDOWS, color=style.INK, lw=0.8, ls=(0, (4, 3)))
        right.annotate(
            say("above: few degrees of freedom (τ > window/{part})", part=FEW_WINDOWS), (0.01, window / FEW_WINDOWS),
            xycoords=("axes fraction", "data"), xytext=(2, 4), textcoords="offset points", fontsize=7, color=style.INK,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 1.0},
        )  # fmt: skip
    bar = figure.colorbar(mesh, ax=right, extend="both", aspect=28)
    end = mesh.get_clim()[1] or RATIOS[-1]
    up = [r for r in (1.2, *RATIOS) if r <= end * 1.001 and (end <= 2 or r >= 2)]
    bar.ax.yaxis.set_major_locator(FixedLocator([*(1 / r for r in up), 1.0, *up]))
    bar.ax.yaxis.set_minor_locator(NullLocator())
    bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"× {v:.2g}"))
    bar.set_label(say("deviation / its median over time"))


def _draw_curves(ax: Axes, tau: FloatArray, deviation: FloatArray, time: FloatArray, norm: Normalize) -> None:
    ax.set(xscale="log", yscale="log", xlim=(tau[0] / 1.3, tau[-1] * 1.3))
    # the outermost windows at the longest times are not worth the room
    low, high = np.nanpercentile(deviation, (5, 95), axis=0)
    ax.set_ylim(np.nanmin(low) / 2.5, np.nanmax(high) * 1.4)
    style.plain_ticks(ax.xaxis, ax.yaxis)
    style.grid(ax)
    lines = [np.column_stack([tau, row]) for row in deviation]
    look: dict[str, Any] = {
        "cmap": TIME_COLORS,
        "norm": norm,
        "lw": 0.9,
        "alpha": 0.75,
        "zorder": 2,
        "rasterized": True,
    }
    ax.add_collection(LineCollection(lines, array=time, **look))
    ax.plot(tau, np.nanmedian(deviation, axis=0), color=style.ALARM, lw=1.8, zorder=3, label=say("median over time"))


def _draw_ratios(ax: Axes, tau: FloatArray, deviation: FloatArray, time: FloatArray) -> QuadMesh:
    ratio = deviation / np.nanmedian(deviation, axis=0)
    extreme = np.nanpercentile(np.abs(np.log(ratio)), 98)
    end = next((r for r in RATIOS if np.log(r) >= extreme), RATIOS[-1])
    ax.set(yscale="log")
    mesh = ax.pcolormesh(
        _edges(time), np.exp(_edges(np.log(tau))), ratio.T, norm=LogNorm(1 / end, end), cmap=RATIO_COLORS,
        rasterized=True,
    )  # fmt: skip
    ax.set_facecolor("#BFC4CA")
    style.plain_ticks(ax.yaxis)
    return mesh


def _edges(centres: FloatArray) -> FloatArray:
    """Borders half way between neighbours, and as far beyond the first and the last."""
    if centres.size == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    middle = (centres[1:] + centres[:-1]) / 2
    return np.concatenate(([2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]))
