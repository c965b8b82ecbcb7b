"""Drift against the time without aid: the total and each of its causes."""

import numpy as np
from matplotlib.figure import Figure

from allanite.claims.drift import Drift
from allanite.core.errors import UndrawnError
from allanite.core.units import signal_named
from allanite.phrases.phrase import join, say
from allanite.reporting import style, words
from allanite.terms import TERMS

from .drawing import dashes, draw_legend, stacked, with_unit

PER_DECADE, DEEP = 12, 1e-3
"""Times of a decade; the least share of the largest drift that is drawn."""


@style.plotted
def plot_drifts(new_figure: style.NewFigure, value: Drift) -> Figure:
    """A panel for each quantity, but attitude where it is as the heading."""
    if not value.axes:
        raise UndrawnError("a requirement alone is not drawn: give the noise, too")
    times = value.settings.times
    ends = (min(times), max(times)) if len(times) > 1 else (times[0] / 100, times[0])
    grid = np.geomspace(*ends, max(8, round(PER_DECADE * np.log10(ends[1] / ends[0]))))
    courses = [value.course(name, grid) for name in value.quantities]
    if len(courses) > 1 and np.allclose(courses[0].sigma, courses[1].sigma, rtol=1e-9):
        del courses[1]
    figure, columns = stacked(new_figure, [1] * len(courses))
    several = len({axis.sensor for axis in value.axes}) > 1
    for (ax,), course in zip(columns, courses, strict=True):
        scale = course.scale
        if np.isfinite(course.high).all():
            ax.fill_between(grid, course.low * scale, course.high * scale, color=style.INK, alpha=0.15, lw=0)
        ax.plot(grid, course.sigma * scale, color=style.INK, lw=2.0, label=say("all causes"))
        if (course.most > 1.02 * np.fmax(course.sigma, course.high)).any():
            ax.plot(grid, course.most * scale, color=style.INK, lw=1.2, ls=":", label=say("at most"))
        for share in course.shares:
            if share.cause.limit or not share.variance.any():
                continue
            name = share.cause.name
            label = join(" ", (signal_named(share.sensor).name, name)) if several else name
            color = TERMS[name].color if name in TERMS else style.OTHER
            dashed = name in TERMS and share.sensor == "gyro"  # thin and solid: what does not come from the gyros
            line, width = (dashes(name), 1.4) if dashed else ("-", 0.8)
            ax.plot(grid, np.sqrt(share.variance) * scale, color=color, ls=line, lw=width, label=label)
        top = max(course.most.max(), course.sigma.max()) * scale
        bottom = max(course.sigma.min() * scale / 10, top * 1e-12)
        ax.set(xscale="log", yscale="log", ylim=(bottom, 2 * top), xlim=ends,
               xlabel=say("time without aid (s)"), ylabel=with_unit(course.title, course.unit))  # fmt: skip
        style.grid(ax)
        style.plain_ticks(ax.xaxis, ax.yaxis)
        style.title(ax, words.capital(course.title))
    draw_legend(figure, marks=False, columns=5)
    return figure
