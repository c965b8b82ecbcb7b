"""The curve of each channel with the one that is claimed of it."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from allanite.claims.result import ClaimCheck
from allanite.core.display_units import readable_unit
from allanite.core.errors import UsageError
from allanite.core.units import convert
from allanite.phrases.phrase import say
from allanite.reporting import style
from allanite.study.results import Channel

from .comparison import draw_curve, frame_curves
from .drawing import TIME, draw_legend, stacked


@style.plotted
def plot_claims(new_figure: style.NewFigure, values: Sequence[ClaimCheck], level: float) -> Figure:
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


def _draw(ax: Axes, value: ClaimCheck, channel: Channel, level: float) -> None:
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
