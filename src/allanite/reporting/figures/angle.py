"""Figures of angle sensors and of gyro-verticals: errors, how they were found, where to measure; filters, angles."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from allanite.applications.angle import Gimbals, Harmonics, Scan, Solution
from allanite.applications.angle.calibration import Result, parts_of
from allanite.applications.angle.harmonics import waves
from allanite.applications.angle.solve import quantile
from allanite.applications.attitude.optimum import Optimum
from allanite.applications.attitude.prediction import error_density
from allanite.applications.attitude.result import Angle
from allanite.applications.attitude.scenarios import ScenarioErrors
from allanite.core.arrays import FloatArray
from allanite.core.record import Record
from allanite.phrases.phrase import say
from allanite.reporting import style
from allanite.reporting.words import ARCSEC, percent

from .drawing import color_of

PALETTE = ("#0072B2", "#C1272D", "#008F6B", "#AA4499", "#B97700", "#555B63", "#56B4E9", "#7F5539")

MAX_INNOVATIONS = 3000  # innovations that are drawn
MAX_PERIODS = 60  # periods of an error that can be told apart in one panel
LAGS = 40


@style.plotted
def plot_errors(new_figure: style.NewFigure, result: Result, level: float = 0.95) -> style.Figure:
    """The error of each sensor over one period of its harmonics together, with its confidence band."""
    sensors = parts_of(result)
    figure = new_figure(3.9 * len(sensors) if len(sensors) > 1 else 6.4, 3.4)
    axes = figure.subplots(1, len(sensors), squeeze=False)[0]
    for ax, harmonics in zip(axes, sensors, strict=True):
        common = math.gcd(*harmonics.orders)
        period = 2 * math.pi / common
        angle = np.linspace(0, period, max(400, 16 * max(harmonics.orders) // common))
        error, half = _error(harmonics, angle, level)
        _draw_error(ax, np.degrees(angle), error, half, level, lw=1.4, label=say("error"))
        style.title(ax, harmonics.name or say("angle"))
        ax.set(xlabel=say("angle (deg), one period"), ylabel=say("error (arcsec)"), xlim=(0, math.degrees(period)))
        ax.legend(loc="best")
    return figure


@style.plotted
def plot_error_in_time(
    new_figure: style.NewFigure, gimbals: Gimbals, harmonics: Sequence[Harmonics], level: float = 0.95
) -> style.Figure:
    """The error of each sensor while its angle moves; of many periods the first and the last ones, too."""
    panels = [(sensor, part) for sensor in harmonics for part in _parts(gimbals, sensor)]
    figure = new_figure(7.2, 1.1 + 2.0 * len(panels))
    axes = figure.subplots(len(panels), 1, squeeze=False)[:, 0]
    for ax, (sensor, part) in zip(axes, panels, strict=True):
        keep = part[np.linspace(0, part.size - 1, min(part.size, MAX_INNOVATIONS)).astype(np.int64)]
        time, angle = gimbals.time[keep] / 60, np.asarray(getattr(gimbals, sensor.name))[keep]
        error, half = _error(sensor, angle, level)
        crowded = part.size == gimbals.time.size and len(panels) > len(harmonics)
        _draw_error(ax, time, error, half, level, lw=0.5 if crowded else 1.1)
        if half.any():
            ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        ax.set(ylabel=say("error (arcsec)"), xlim=(time[0], time[-1]))
        low, high = (f"{v:.2f}".replace("-", "−") for v in np.degrees((angle.min(), angle.max())))
        orders = ", ".join(map(str, sensor.orders))
        about = say("harmonic {orders}; {low} to {high} deg", orders=orders, low=low, high=high)
        ax.set_title(about, loc="right", fontsize=8.5, color=style.SOFT)
        style.title(ax, sensor.name)
    axes[-1].set_xlabel(say("time (min)"))
    return figure


def _draw_error(ax: style.Axes, x: FloatArray, error: FloatArray, half: FloatArray, level: float, **look: Any) -> None:
    style.grid(ax)
    if half.any():
        band = say("{share} band", share=percent(level))
        ax.fill_between(x, error - half, error + half, color=style.DATA, alpha=0.2, lw=0, label=band)
    ax.plot(x, error, color=style.DATA, **look)
    ax.axhline(0, color=style.INK, lw=0.8)


def _error(sensor: Harmonics, angle: FloatArray, level: float) -> tuple[FloatArray, FloatArray]:
    """The error at angles and the half width of its band, arcsec; 0 where its limits would not hold."""
    complete = sensor.solution is None or sensor.solution.complete
    rows = waves(angle, sensor.orders)
    spread = np.sqrt(np.einsum("ij,jk,ik->i", rows, sensor.covariance, rows))
    return sensor.at(angle) / ARCSEC, complete * quantile(level, sensor.freedom) * spread / ARCSEC


def _parts(gimbals: Gimbals, sensor: Harmonics) -> list[NDArray[np.int64]]:
    """Samples of the panels of an error: all, or of more than `MAX_PERIODS` periods the first and the last."""
    whole, order = np.arange(gimbals.time.size), max(sensor.orders)
    period, length = gimbals.mean_period(sensor.name, order), gimbals.time[-1] - gimbals.time[0]
    if length < MAX_PERIODS * period:
        return [whole]
    near = MAX_PERIODS / 5 * period
    first, last = gimbals.time <= gimbals.time[0] + near, gimbals.time >= gimbals.time[-1] - near
    return [whole, whole[first], whole[last]]


@style.plotted
def plot_history(new_figure: style.NewFigure, result: Result, solution: Solution, level: float = 0.95) -> style.Figure:
    """Convergence of every amplitude, with its confidence band."""
    sensors = parts_of(result)
    half, numbered = quantile(level, math.inf) * solution.complete, "offset" in solution.names
    figure = new_figure(7.2, 2.1 + 1.5 * len(sensors))
    axes = figure.subplots(len(sensors), 1, sharex=True, squeeze=False)[:, 0]
    first = 0
    for ax, harmonics in zip(axes, sensors, strict=True):
        count = 2 * len(harmonics.orders)
        which = range(first, first + count)
        way = solution.history
        x = way.time if numbered else way.time / 60
        style.grid(ax)
        # what is not known yet is anywhere: the scale is that of the last half, and nothing wider is drawn
        late = slice(len(x) // 2, None)
        sizes = [np.abs(way.values[late, i]) + half * way.errors[late, i] for i in which]
        reach = 1.1 * float(np.max(sizes)) / ARCSEC
        for i, color in zip(which, PALETTE * len(which), strict=False):
            known = half * way.errors[:, i] / ARCSEC < reach
            value, error = way.values[known, i] / ARCSEC, half * way.errors[known, i] / ARCSEC
            ax.fill_between(x[known], value - error, value + error, color=color, alpha=0.13, lw=0)
            ax.plot(x[known], value, color=color, lw=1.1, label=solution.names[i].split()[0])
        ax.set(ylabel="arcsec", ylim=(-reach, reach), xlim=(x[0], x[-1]) if len(x) > 1 else None)
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        style.title(ax, harmonics.name or say("angle"))
        first += count
    axes[-1].set_xlabel(say("samples") if numbered else say("time (min)"))
    return figure


@style.plotted
def plot_innovations(new_figure: style.NewFigure, solution: Solution) -> style.Figure:
    """Innovations in standard deviations, and their autocorrelation."""
    innovations = solution.innovations
    keep = np.linspace(0, innovations.size - 1, min(innovations.size, MAX_INNOVATIONS)).astype(np.int64)
    lags = min(LAGS, innovations.size // 4)
    centred = innovations - innovations.mean()
    r = np.array([centred[k:] @ centred[: innovations.size - k] for k in range(1, lags + 1)]) / (centred @ centred)
    passed = all(check.passed for check in solution.checks)
    figure = new_figure(7.2, 2.9)
    over_time, correlation = figure.subplots(1, 2, width_ratios=[1.6, 1])
    style.grid(over_time)
    over_time.axhspan(-3, 3, color=style.DATA, alpha=0.12, lw=0)
    over_time.plot(keep + 1, innovations[keep], ".", ms=2.5, color=style.DATA)
    over_time.set(xlabel=say("sample"), ylabel=say("innovation (standard deviations)"), xlim=(1, innovations.size))
    style.grid(correlation)
    limit = 2.58 / math.sqrt(innovations.size)
    correlation.axhspan(-limit, limit, color=style.DATA, alpha=0.15, lw=0)
    correlation.bar(range(1, lags + 1), r, color=style.DATA if passed else style.ALARM, width=0.7)
    correlation.axhline(0, color=style.INK, lw=0.8)
    reach = max(2 * limit, 1.15 * float(np.abs(r).max()))
    correlation.set(xlabel=say("lag (samples)"), ylabel=say("autocorrelation"), ylim=(-reach, reach))
    correlation.xaxis.set_major_locator(MaxNLocator(integer=True))
    return figure


@style.plotted
def plot_scan(new_figure: style.NewFigure, scan: Scan) -> style.Figure:
    """Expected accuracy and condition by the start of the interval."""
    hours = scan.starts / 3600
    figure = new_figure(7.2, 4.6)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[1.6, 1])
    for ax, values, label in (
        (upper, scan.totals, say("sum of expected\nstandard deviations")),
        (lower, scan.conditions, say("condition")),
    ):
        style.grid(ax)
        ax.plot(hours, values, "o-", ms=2.8 if hours.size > 30 else 4, lw=1.1, color=style.DATA)
        ax.set(ylabel=label)
        if values.max() > 3 * values.min():
            ax.set_yscale("log")
            style.plain_ticks(ax.yaxis)
            # labels of 2, 3 and 5 times a power of ten, and of no other minor tick
            ax.yaxis.set_minor_formatter(lambda value, _: f"{value:g}" if f"{value:e}"[0] in "235" else "")
        ax.axvline(scan.best.start / 3600, color=style.ALARM, lw=1.1)
    low, high = (f"{math.degrees(v):.1f}".replace("-", "−") for v in scan.best.h)
    best = say("best: h from {low} to {high} deg, sum {total:.3g}", low=low, high=high, total=scan.best.total)
    upper.plot([], [], color=style.ALARM, lw=1.1, label=best)
    upper.legend(loc="best")
    lower.set_xlabel(say("start of the interval (h after h = 0)"))
    ticks = np.unique(np.linspace(0, scan.starts.size - 1, 9).astype(np.int64))
    top = upper.secondary_xaxis("top")
    top.set_xticks(scan.starts[ticks] / 3600, [f"{math.degrees(v):.1f}".replace("-", "−") for v in scan.h[ticks, 0]])
    top.set_xlabel(say("smallest h of the interval (deg)"))
    return figure


MAX_LINE_POINTS = 4000  # points of a line over time


@style.plotted
def plot_optima(new_figure: style.NewFigure, optima: Sequence[tuple[str, Optimum]]) -> style.Figure:
    """A column for each angle: both paths of the filter, the error by source, and the cost of detuning."""
    figure = new_figure(6.8 if len(optima) == 1 else 5.6 * len(optima), 9.0)
    grid = figure.subplots(3, len(optima), squeeze=False)
    for column, (name, optimum) in zip(grid.T, optima, strict=True):
        ax, f = column[0], _frequencies(optimum)
        predictions = [p for p in (optimum.first, optimum.second) if p is not None]
        for prediction, dash in zip(predictions, ("-", (0, (5, 3))), strict=False):
            _, tilt = prediction.loop.responses(f, None if prediction.rate is None else 1 / prediction.rate)
            gyro = say("gyro path, order {order}", order=prediction.loop.order)
            accelerometer = say("accelerometer path, order {order}", order=prediction.loop.order)
            ax.plot(f, np.abs(1 - tilt), color=style.SERIES[0], ls=dash, lw=1.3, label=gyro)
            ax.plot(f, np.abs(tilt), color=style.SERIES[1], ls=dash, lw=1.3, label=accelerometer)
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


def _frequencies(optimum: Optimum) -> np.ndarray:
    corner = optimum.first.loop.k1 / (2 * math.pi)
    top = corner * 1e3 if optimum.first.rate is None else optimum.first.rate / 2 * 0.999
    low = corner * 1e-4 if optimum.first.duration is None else 1 / (2 * optimum.first.duration)
    return np.geomspace(min(low, corner / 100), max(top, corner * 10) if optimum.first.rate is None else top, 400)


def _draw_sources(ax: style.Axes, optimum: Optimum) -> None:
    f = _frequencies(optimum)
    lines = error_density(optimum.best, f)
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


def _finish(ax: style.Axes) -> None:
    style.grid(ax)
    style.plain_ticks(ax.xaxis, ax.yaxis)
    ax.legend(loc="best")


@style.plotted
def plot_angles(new_figure: style.NewFigure, angles: Sequence[Angle]) -> style.Figure:
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
def plot_scenarios(new_figure: style.NewFigure, errors: ScenarioErrors) -> style.Figure:
    """RMS error of every filter in every scenario."""
    figure = new_figure(7.2, 0.32 * len(errors.filters) + 1.4)
    ax = figure.subplots()
    places = np.arange(len(errors.filters))[::-1]
    for i, scenario in enumerate(errors.scenarios):
        ax.plot(np.degrees(errors.rms[:, i]), places, style.MARKERS[i], color=style.SERIES[i], ms=6, label=scenario)
    ax.set_yticks(places, errors.filters)
    ax.set(xscale="log", xlabel=say("RMS error of roll and pitch (deg)"))
    style.grid(ax)
    style.plain_ticks(ax.xaxis)
    figure.legend(loc="outside upper center", ncols=len(errors.scenarios))
    return figure
