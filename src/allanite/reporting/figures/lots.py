"""The values of a lot: a row for each coefficient, its distribution, and its course over temperature and date."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from allanite.core.arrays import FloatArray
from allanite.phrases.phrase import join, say
from allanite.reporting import style
from allanite.reporting.digits import printable

from .drawing import with_unit

MOST = 24
"""Rows of the figure at most, those with the most units first."""


class Course(NamedTuple):
    """Values at places of an abscissa, the slope of their line, and whether it differs from zero."""

    at: FloatArray
    value: FloatArray
    slope: float
    shown: bool


class LotRow(NamedTuple):
    """The values of one coefficient, and its course by the label of the abscissa."""

    channel: str
    symbol: str
    unit: str
    values: FloatArray
    courses: dict[str, Course]


@style.plotted
def plot_lot(new_figure: style.NewFigure, found: Sequence[LotRow]) -> Figure:
    """A row of panels for each coefficient."""
    shown = sorted(found, key=lambda one: -one.values.size)[:MOST]
    labels = list(dict.fromkeys(label for one in shown for label in one.courses))
    wide = 1 + len(labels)
    figure = new_figure(max(3.6 * wide + 1.0, 7.2), 0.6 + 2.3 * len(shown))
    grid = figure.subplots(len(shown), wide, squeeze=False)
    for one, axes in zip(shown, grid, strict=True):
        # the share of units that are not above each value
        shares, size = axes[0], one.values.size
        shares.plot(np.sort(one.values), 100 * (np.arange(size) + 0.5) / size, "o", ms=3.5, color=style.SERIES[0])
        shares.set_ylim(0, 100)
        shares.set_ylabel(say("units below (%)"))
        shares.set_xlabel(with_unit(one.symbol, one.unit))
        shares.locator_params(axis="x", nbins=5)
        style.title(shares, join(", ", [printable(one.channel), one.symbol]))
        style.grid(shares, fine=False)
        for ax, label in zip(axes[1:], labels, strict=True):
            course = one.courses.get(label)
            if course is None:
                ax.set_axis_off()
            else:
                ax.plot(course.at, course.value, "o", ms=3.5, color=style.SERIES[0])
                ends = np.array([course.at.min(), course.at.max()])
                line = course.value.mean() + course.slope * (ends - course.at.mean())
                ax.plot(ends, line, color=style.ALARM if course.shown else style.OTHER, lw=1.2)
                ax.set_xlabel(label)
                ax.set_ylabel(with_unit(one.symbol, one.unit))
                ax.locator_params(nbins=5)
                style.grid(ax, fine=False)
    return figure
