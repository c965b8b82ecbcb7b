"""Figure of a budget: what each stage adds by its bits, beside what was measured."""

from collections.abc import Sequence

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from allanite.applications.signals import Budget
from allanite.phrases.phrase import say
from allanite.reporting import style
from allanite.reporting.digits import printable


@style.plotted
def plot_budgets(new_figure: style.NewFigure, budgets: Sequence[Budget]) -> Figure:
    """A panel for each channel, one below the other."""
    figure = new_figure(6.4, 0.4 + 3.4 * len(budgets))
    for ax, budget in zip(figure.subplots(len(budgets), 1, squeeze=False)[:, 0], budgets, strict=True):
        # one unit to an axis: what the first stage makes
        first = budget.stages[0]
        shown = [s for s in budget.stages if s.symbol == first.symbol]
        bits = range(max(1, min(s.stage.bits for s in shown) - 6), max(s.stage.bits for s in shown) + 7)
        style.grid(ax)
        for s, color, marker in zip(shown, style.SERIES * 9, style.MARKERS * 9, strict=False):
            at = s.to(s.coefficient) or 0.0
            ax.plot(bits, [at * 2.0 ** (s.stage.bits - b) for b in bits], color=color, lw=1.1)
            ax.plot(
                [s.stage.bits],
                [at],
                marker,
                color=color,
                ms=7,
                label=say("{stage}, as it is", stage=printable(s.stage.name)),
            )
        known = first.to(first.measured if first.measured is not None else first.limit)
        if known is not None:
            label = say("measured") if first.measured is not None else say("upper limit")
            ax.axhline(known, color=style.INK, lw=1.2, label=label)
            tenth = say("a tenth of it: 1 % of the variance")
            ax.axhline(known / 10, color=style.INK, lw=0.9, ls=(0, (5, 3)), label=tenth)
        size = say("{symbol} by rounding ({unit})", symbol=first.symbol, unit=first.sheet_unit)
        ax.set(yscale="log", xlabel=say("bits"), ylabel=size)
        style.plain_ticks(ax.yaxis)
        ax.xaxis.set_major_locator(MaxNLocator(integer=True))
        style.title(ax, budget.record.name)
        ax.legend(loc="best")
    return figure
