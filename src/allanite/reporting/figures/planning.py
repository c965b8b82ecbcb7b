"""The accuracy of coefficients by the length of the record."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
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
        _draw(ax, plan)
        style.title(ax, name or str(plan.model))
    axes[-1].set_xlabel(say("length of the record"))
    return figure


def _draw(ax: Axes, plan: RecordingPlan) -> None:
    ax.set(xscale="log", yscale="log", ylabel=say("relative standard error (%)"))
    for name, errors, needed in zip(plan.names, plan.errors, plan.needed.tolist(), strict=True):
        tau, error = _points(plan, errors, needed)
        symbol, _, parameter = name.partition(" ")
        color = color_of(symbol.partition("(")[0])
        ax.plot(tau, 100 * error, "o", ls="--" if parameter else "-", color=color, ms=3.5, lw=1.3, label=name)
    ax.axhline(100 * plan.accuracy, color=style.INK, lw=0.8, ls=(0, (4, 3)))
    ax.set_xticks(plan.durations, [words.duration(d) for d in plan.durations])
    ax.minorticks_off()
    style.grid(ax)
    style.plain_ticks(ax.yaxis)
    ax.legend(loc="best", ncols=2)


def _points(plan: RecordingPlan, errors: np.ndarray, needed: float) -> tuple[np.ndarray, np.ndarray]:
    """Lengths and errors that are worth drawing, the length that is needed among them."""
    tau = np.append(plan.durations, needed)
    error = np.append(errors, plan.accuracy)
    shortest, longest = min(plan.durations) / 3, 3 * max(plan.durations)
    kept = np.isfinite(error) & (error < MOST) & (error > LEAST) & (tau > shortest) & (tau < longest)
    order = np.argsort(tau[kept])
    return tau[kept][order], error[kept][order]
