"""Figures of a gyro-vertical: its filter, the errors by source, the angles of a recording, filters in scenarios."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from allanite.applications.attitude.optimum import Optimum
from allanite.applications.attitude.prediction import error_density
from allanite.applications.attitude.result import Angle
from allanite.applications.attitude.scenarios import ScenarioErrors
from allanite.core.record import Record
from allanite.phrases.phrase import say
from allanite.reporting import style
from allanite.reporting.words import ARCSEC

from .drawing import color_of

MAX_LINE_POINTS = 4000  # points of a line over time


@style.plotted
def plot_optima(new_figure: style.NewFigure, found: Sequence[tuple[str, Optimum]]) -> Figure:
    """A column for each angle: both paths of the filter, the error by source, and the cost of detuning."""
    figure = new_figure(6.8 if len(found) == 1 else 5.6 * len(found), 9.0)
    grid = figure.subplots(3, len(found), squeeze=False)
    for column, (name, optimum) in zip(grid.T, found, strict=True):
        ax, f = column[0], _frequencies(optimum)
        predictions = [p for p in (optimum.first, optimum.second) if p is not None]
        for prediction, dash in zip(predictions, ("-", (0, (5, 3))), strict=False):
            _, tilt = prediction.loop.responses(f, None if prediction.rate is None else 1 / prediction.rate)
            order = prediction.loop.order
            ax.plot(f, np.abs(1 - tilt), color=style.SERIES[0], ls=dash, lw=1.3,
                    label=say("gyro path, order {order}", order=order))  # fmt: skip
            ax.plot(f, np.abs(tilt), color=style.SERIES[1], ls=dash, lw=1.3,
                    label=say("accelerometer path, order {order}", order=order))  # fmt: skip
        ax.set(xscale="log", yscale="log", xlabel=say("frequency (Hz)"), ylabel=say("gain"), ylim=(1e-3, 3))
        _finish(ax)
        _draw_sources(column[1], optimum)
        ax = column[2]
        factors, errors = np.array(optimum.detuning).T
        ax.plot(factors * optimum.time_constant, errors / ARCSEC, "o-", color=style.SERIES[0], ms=4, lw=1.2,
                label=say("first order"))  # fmt: skip
        if optimum.second is not None:
            ax.axhline(optimum.second.rms / ARCSEC, color=style.SERIES[2], lw=1.1, label=say("best of second order"))
        ax.axhline(optimum.bound / ARCSEC, color=style.INK, lw=1.0, ls=(0, (5, 3)), label=say("optimal causal filter"))
        ax.set(xscale="log", xlabel=say("time constant (s)"), ylabel=say("RMS error (arcsec)"))
        ax.set_ylim(bottom=0)
        style.grid(ax)
        style.plain_ticks(ax.xaxis)
        ax.legend(loc="best")
        style.title(column[0], name)
    return figure


def _frequencies(found: Optimum) -> np.ndarray:
    corner = found.first.loop.k1 / (2 * math.pi)
    top = corner * 1e3 if found.first.rate is None else found.first.rate / 2 * 0.999
    low = corner * 1e-4 if found.first.duration is None else 1 / (2 * found.first.duration)
    return np.geomspace(min(low, corner / 100), max(top, corner * 10) if found.first.rate is None else top, 400)


def _draw_sources(ax: Axes, found: Optimum) -> None:
    f = _frequencies(found)
    lines = error_density(found.best, f)
    dash: Any
    for label, density in lines.items():
        sensor, symbol = label.split()
        if sensor == "gyro":
            dash, name = "-", say("gyro {symbol}", symbol=symbol)
        else:
            dash, name = (0, (5, 3)), say("accelerometer {symbol}", symbol=symbol)
        ax.plot(f, density / ARCSEC, color=color_of(symbol), ls=dash, lw=1.2, label=name)
    if lines:
        whole = np.sqrt(sum(density**2 for density in lines.values())) / ARCSEC
        ax.plot(f, whole, color=style.INK, lw=1.6, label=say("all noise"))
        ax.set(ylim=(max(whole.min(), whole.max() * 1e-5) / 2, whole.max() * 2))
    ax.set(xscale="log", yscale="log", xlabel=say("frequency (Hz)"), ylabel=say("error density (arcsec/√Hz)"))
    _finish(ax)


def _finish(ax: Axes) -> None:
    style.grid(ax)
    style.plain_ticks(ax.xaxis, ax.yaxis)
    ax.legend(loc="best")


@style.plotted
def plot_angles(new_figure: style.NewFigure, angles: Sequence[Angle]) -> Figure:
    """Roll and pitch over time, one below the other, with the predicted limits about their means."""
    figure = new_figure(7.2, 2.6 * len(angles) + 0.4)
    for ax, angle in zip(figure.subplots(len(angles), 1, squeeze=False)[:, 0], angles, strict=True):
        style.title(ax, angle.name)
        style.grid(ax)
        if isinstance(angle.record, Record):
            values = angle.record.values
            size = max(1, len(values) // MAX_LINE_POINTS)
            blocks = values[: len(values) // size * size].reshape(-1, size)
            t = (np.arange(len(blocks)) + 0.5) * size / angle.record.rate
            ax.fill_between(t, blocks.min(axis=1), blocks.max(axis=1), color=style.SERIES[0], alpha=0.25, lw=0)
            ax.plot(t, blocks.mean(axis=1), color=style.SERIES[0], lw=0.9, label=angle.name)
        mean = math.degrees(angle.mean)
        if angle.prediction is not None:
            limit = 2 * math.degrees(angle.prediction.rms)
            ax.axhline(mean - limit, color=style.SERIES[1], lw=1.0, ls=(0, (5, 3)))
            ax.axhline(mean + limit, color=style.SERIES[1], lw=1.0, ls=(0, (5, 3)), label=say("predicted, 2 σ"))
        ax.set(xlabel=say("time (s)"), ylabel=say("angle (deg)"))
        ax.legend(loc="upper right")
    return figure


@style.plotted
def plot_scenarios(new_figure: style.NewFigure, found: ScenarioErrors) -> Figure:
    """RMS error of every filter in every scenario."""
    figure = new_figure(7.2, 0.32 * len(found.filters) + 1.4)
    ax = figure.subplots()
    places = np.arange(len(found.filters))[::-1]
    for i, scenario in enumerate(found.scenarios):
        ax.plot(np.degrees(found.rms[:, i]), places, style.MARKERS[i], color=style.SERIES[i], ms=6, label=scenario)
    ax.set_yticks(places, found.filters)
    ax.set(xscale="log", xlabel=say("RMS error of roll and pitch (deg)"))
    style.grid(ax)
    style.plain_ticks(ax.xaxis)
    figure.legend(loc="outside upper center", ncols=len(found.scenarios))
    return figure
