"""The noise model that a file states beside the noise that was identified, and the errors of a filter with it."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from allanite.core.display_units import readable_unit
from allanite.core.units import unit_of
from allanite.exporting.stated_noise import StatedNoise
from allanite.phrases.phrase import say
from allanite.reporting import style
from allanite.reporting.digits import printed_unit

from .drawing import TIME, stacked, with_unit

FILE, IDENTIFIED, UPPER = say("the file"), say("identified noise"), say("its upper limit")


@style.plotted
def plot_stated(new_figure: style.NewFigure, values: Sequence[StatedNoise]) -> Figure:
    """A column for each sensor: deviations by averaging time, and errors of a filter by the time without aid."""
    figure, columns = stacked(new_figure, [2] * len(values))
    for (above, below), value in zip(columns, values, strict=True):
        _draw_deviations(above, value)
        _draw_errors(below, value)
    return figure


def _draw_deviations(ax: Axes, value: StatedNoise) -> None:
    signal = value.noise.signal
    unit = readable_unit(signal.unit)
    size = unit_of(unit).factor
    ax.set(xscale="log", yscale="log", xlabel=TIME, ylabel=with_unit(say("Allan deviation"), printed_unit(unit)))
    for i, curve in enumerate(value.curves):
        near = (curve.tau >= value.span[0] / 3) & (curve.tau <= 3 * value.span[1])
        measured = curve.to(signal.unit).deviation[near] / size
        label = say("measured") if not i else "_"
        ax.plot(curve.tau[near], measured, ".", color=style.OTHER, ms=3, label=label)
    for deviation, label, color, line in (
        (value.upper, UPPER, style.FAIR, "--"), (value.identified, IDENTIFIED, style.INK, "-"),
        (value.deviation, FILE, style.ALARM, "-"),
    ):  # fmt: skip
        ax.plot(value.tau, deviation / size, line, color=color, lw=1.3, label=label)
    style.grid(ax)
    ax.legend(loc="best")
    style.title(ax, value.label)


def _draw_errors(ax: Axes, value: StatedNoise) -> None:
    signal = value.noise.signal
    unit = readable_unit(signal.si[1])
    size = unit_of(unit).factor
    ax.set(
        xscale="log",
        yscale="log",
        xlabel=say("time without aid (s)"),
        ylabel=with_unit(say("error"), printed_unit(unit)),
    )
    for errors, label, color, line in (
        (value.best, say("of the best filter"), style.INK, "-"), (value.actual, say("with the file"), style.ALARM, "-"),
        (value.predicted, say("predicted with the file"), style.ALARM, "--"),
    ):  # fmt: skip
        ax.plot(value.times, errors / size, line, color=color, lw=1.3, label=label)
    style.grid(ax)
    ax.legend(loc="best")
    style.title(ax, say("standard deviation of the error, by the time without aid"))
