"""The figures of a record over time, and of its curve over the model."""

import numpy as np
from matplotlib.figure import Figure

from allanite.core.record import Record
from allanite.core.units import convert
from allanite.phrases.phrase import say
from allanite.reporting import style
from allanite.reporting.digits import printed_unit

from .drawing import TIME
from .panels import CurvePanel, points

STRETCHES = 240
"""Stretches of a record whose least and largest sample are drawn: more are not seen."""

HOURS, MINUTES = 7200.0, 300.0
"""Lengths in seconds from which time is shown in hours, and in minutes."""


def time_scale(length: float) -> tuple[str, float]:
    """The unit of a time axis of so many seconds, and its size."""
    return ("h", 3600.0) if length > HOURS else ("min", 60.0) if length > MINUTES else ("s", 1.0)


@style.plotted
def plot_record(new_figure: style.NewFigure, record: Record) -> Figure:
    """A record over time: the range of short stretches, their means, and the missing samples."""
    unit = record.signal.sheet[0]
    values = record.rate_values * convert(1.0, record.signal.si[0], unit)
    count = min(STRETCHES, values.size)
    edges = np.linspace(0, values.size, count + 1).astype(np.int64)
    # least, mean and largest value of each stretch; NaN where it has none
    there = np.isfinite(values)
    sizes = np.add.reduceat(there, edges[:-1], dtype=np.float64)
    with np.errstate(invalid="ignore", divide="ignore"):
        means = np.add.reduceat(np.where(there, values, 0.0), edges[:-1]) / sizes
    lows = np.minimum.reduceat(np.where(there, values, np.inf), edges[:-1])
    highs = np.maximum.reduceat(np.where(there, values, -np.inf), edges[:-1])
    low, mean, high = (np.where(sizes > 0, part, np.nan) for part in (lows, means, highs))
    name, size = time_scale(record.duration)
    middle = (edges[:-1] + edges[1:]) / 2 / record.rate / size
    figure = new_figure(7.2, 2.0)
    ax = figure.subplots()
    style.grid(ax, fine=False)
    ax.fill_between(middle, low, high, color=style.DATA, alpha=0.3, lw=0, label=say("range"))
    ax.plot(middle, mean, color=style.DATA, lw=0.9, label=say("mean"))
    missing = np.isnan(values)
    gaps = middle[np.add.reduceat(missing, edges[:-1]) > 0]
    if gaps.size:
        ax.plot(gaps, np.full(gaps.size, 0.03), "|", color=style.ALARM, ms=6, label=say("missing samples"),
                transform=ax.get_xaxis_transform())  # fmt: skip
    ax.set(xlabel=say("time ({unit})", unit=name), ylabel=printed_unit(unit), xlim=(0, record.duration / size))
    style.title(ax, record.name)
    ax.legend(loc="upper right", ncols=3)
    return figure


@style.plotted
def plot_strip(new_figure: style.NewFigure, panel: CurvePanel, *, level: float = 0.95) -> Figure:
    """The deviation over that expected under the model, with its band, by averaging time."""
    drawn = points(panel, level)
    assert panel.fit is not None and panel.fit.valid is not None  # noqa: S101, PT018 - the caller has looked
    expected = panel.expected(panel.fit.valid, drawn.tau)
    figure = new_figure(7.2, 1.9)
    ax = figure.subplots()
    ax.set(xscale="log", yscale="log", xlabel=TIME, ylabel=say("observed /\nexpected"))
    style.grid(ax, fine=False)
    ax.axhline(1.0, color=style.INK, lw=1.0)
    if drawn.low is not None and drawn.high is not None:
        ax.fill_between(drawn.tau, drawn.low / expected, drawn.high / expected, color=style.DATA, alpha=0.18, lw=0)
    ax.plot(drawn.tau, drawn.deviation / expected, "o-", color=style.DATA, ms=2.8, mew=0, lw=0.9)
    seen = (drawn.deviation / expected)[np.isfinite(drawn.deviation / expected) & (drawn.deviation > 0)]
    ax.set_ylim(min(0.45, seen.min(initial=1.0) / 1.2), max(2.2, seen.max(initial=1.0) * 1.2))
    style.plain_ticks(ax.xaxis, ax.yaxis)
    return figure
