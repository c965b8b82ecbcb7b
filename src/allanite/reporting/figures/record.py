"""The figures of records over time, and of a curve over the model."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from allanite.core.arrays import FloatArray
from allanite.core.record import Record
from allanite.phrases.phrase import Phrase, join, say
from allanite.reporting import style, words
from allanite.reporting.digits import printed_unit

from .drawing import TIME, draw_legend
from .panels import CurvePanel, points

STRETCHES = 480
"""Stretches of a record whose least and largest sample are drawn: more are not seen."""

MEANS = 6
"""Stretches of one mean."""

HOURS, MINUTES = 7200.0, 300.0
"""Lengths in seconds from which time is shown in hours, and in minutes."""


def time_scale(length: float) -> tuple[str, float]:
    """The unit of a time axis of so many seconds, and its size."""
    return ("h", 3600.0) if length > HOURS else ("min", 60.0) if length > MINUTES else ("s", 1.0)


class Envelope(NamedTuple):
    """Stretches of a record: the sample in their middle, least, mean and largest value, whether samples are missing.

    Where a stretch has no value, its three values are NaN.
    """

    at: FloatArray
    low: FloatArray
    mean: FloatArray
    high: FloatArray
    broken: FloatArray


def envelope(record: Record, count: int) -> Envelope:
    """Least, mean and largest sample of so many stretches of a record, or of each sample if it has fewer."""
    values, size = record.values, len(record.values)
    edges = np.linspace(0, size, min(count, size) + 1).astype(np.int64)
    starts, lengths = edges[:-1], np.diff(edges)
    low, high = (f.reduceat(values, starts).astype(np.float64) for f in (np.fmin, np.fmax))
    sums, known = np.add.reduceat(values, starts, dtype=np.float64), lengths
    broken = np.isnan(sums)
    if broken.any():
        there = ~np.isnan(values)
        known = np.add.reduceat(there, starts, dtype=np.int64)
        sums = np.add.reduceat(np.where(there, values, 0.0), starts)
    with np.errstate(invalid="ignore"):
        mean = sums / known
    scale = 1.0 if record.kind == "count" or record.scale is None else record.scale
    return Envelope((edges[:-1] + edges[1:] - 1) / 2, low * scale, mean * scale, high * scale, broken)


def quantity_of(record: Record) -> Phrase:
    """What the samples of a record are, for an ordinate."""
    if record.kind == "count":
        return say("pulses of {size}", size=f"{record.scale:g} {printed_unit(record.unit)}")
    return join("", [printed_unit(record.unit)])


@style.plotted
def plot_records(new_figure: style.NewFigure, records: Sequence[Record]) -> Figure:
    """Records over time, a panel each, as if every sample were drawn: the range of short stretches, and their means.

    Times are those of the whole recording; samples are in the unit of the record, counts in pulses.
    """
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


def _draw_record(ax: Axes, record: Record, size: float) -> None:
    """A record over time in units of so many seconds."""
    style.grid(ax, fine=False)
    seen, length = envelope(record, STRETCHES), len(record.values)
    time = (record.cut + seen.at / record.rate) / size
    if length <= STRETCHES:
        ax.plot(time, seen.mean, ".-", color=style.SERIES[0], lw=0.7, ms=2.5, label=say("samples"))
    else:
        both = np.column_stack([seen.low, seen.high]).ravel()
        ax.plot(np.repeat(time, 2), both, color=style.SERIES[0], lw=1.0, label=say("samples"))
    if length > MEANS * STRETCHES:
        course = envelope(record, STRETCHES // MEANS)
        ax.plot((record.cut + course.at / record.rate) / size, course.mean, color=style.SERIES[1], lw=1.1,
                label=say("means over {time}", time=words.duration(record.duration * MEANS / STRETCHES)))  # fmt: skip
    if seen.broken.any():
        gaps = time[seen.broken]
        ax.plot(gaps, np.full(gaps.size, 0.03), "|", color=style.ALARM, ms=6, label=say("missing samples"),
                transform=ax.get_xaxis_transform())  # fmt: skip
    ax.set_ylabel(quantity_of(record))
    style.title(ax, record.name)


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
