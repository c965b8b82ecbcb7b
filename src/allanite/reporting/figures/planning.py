"""The accuracy of coefficients by the length of the record."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from allanite.phrases.phrase import say
from allanite.planning.plan import RecordingPlan
from allanite.reporting import style, words

from .drawing import color_of, stacked

LEAST, MOST = 1e-4, 1.5
"""Errors that are drawn."""


@style.plotted
def plot_plans(new_figure: style.NewFigure, plans: Sequence[tuple[str, RecordingPlan]]) -> Figure:
    """Relative standard errors by length, a panel for each (name, plan) and a line for each parameter."""
    figure, (axes,) = stacked(new_figure, [len(plans)])
    for ax, (name, plan) in zip(axes, plans, strict=True):
        ax.set(xscale="log", yscale="log", ylabel=say("relative standard error (%)"))
        shortest, longest = min(plan.durations) / 3, 3 * max(plan.durations)
        for label, errors, needed in zip(plan.names, plan.errors, plan.needed.tolist(), strict=True):
            # lengths and errors that are worth drawing, the length that is needed among them
            tau, error = np.append(plan.durations, needed), np.append(errors, plan.accuracy)
            kept = np.isfinite(error) & (error < MOST) & (error > LEAST) & (tau > shortest) & (tau < longest)
            order = np.argsort(tau[kept])
            symbol, _, parameter = label.partition(" ")
            color, line = color_of(symbol.partition("(")[0]), "--" if parameter else "-"
            ax.plot(tau[kept][order], 100 * error[kept][order], "o", ls=line, color=color, ms=3.5, lw=1.3, label=label)
        ax.axhline(100 * plan.accuracy, color=style.INK, lw=0.8, ls=(0, (4, 3)))
        ax.set_xticks(plan.durations, [words.duration(d) for d in plan.durations])
        ax.minorticks_off()
        style.grid(ax)
        style.plain_ticks(ax.yaxis)
        ax.legend(loc="best", ncols=2)
        style.title(ax, name or str(plan.model))
    axes[-1].set_xlabel(say("length of the record"))
    return figure
