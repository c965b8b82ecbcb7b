"""Figures for print, by matplotlib: how they look, and how they become bytes, on every machine the same."""

import io
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, cast

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.text import Text

from allanite.core.files import PathLike, write

from . import fonts
from .language import spoken, tr
from .sheet import Plot
from .style import EDGE, FORMATS, INK, NewFigure, demand_figure_path

_LOOK: dict[str, Any] = {
    "font.size": 9.0, "text.color": INK,
    "axes.labelsize": 9.0, "axes.titlesize": 10.0, "axes.titley": 1.0,  # a fixed height
    "axes.edgecolor": EDGE, "axes.linewidth": 0.8, "axes.labelcolor": INK, "axes.axisbelow": True,
    "xtick.color": EDGE, "xtick.labelcolor": INK, "xtick.direction": "in",
    "ytick.color": EDGE, "ytick.labelcolor": INK, "ytick.direction": "in",
    "legend.fontsize": 8.0, "legend.frameon": False, "mathtext.fontset": "dejavusans",
    "svg.hashsalt": "allanite", "svg.fonttype": "path",  # glyphs travel with the file: no font is missing elsewhere
    "pdf.fonttype": 42, "savefig.dpi": 200,
}  # fmt: skip


@contextmanager
def look() -> Iterator[None]:
    """These settings and no matplotlibrc; the settings from before are restored afterwards."""
    lang = spoken()
    with mpl.rc_context(), fonts.quiet(lang):
        dict.update(cast(Any, mpl.rcParams), _settings(lang))  # they were checked when they were collected
        yield


@cache
def _settings(lang: str) -> dict[str, Any]:
    """All settings of figures in a language."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(cast(Any, _LOOK | {"font.family": fonts.families(lang)}))
        if lang in fonts.FURTHER:
            mpl.rcParams["pdf.fonttype"] = 3  # a subset of so large a font takes seconds as 42
        settings = dict(cast(Any, mpl.rcParams.copy()))  # asking the original for its backend imports pyplot
        del settings["backend"]
        return settings


class NotebookFigure(Figure):
    """A figure that a notebook shows without a magic word."""

    def _repr_svg_(self) -> str:
        return encode(self, "svg").decode()


STAYS = 0.5  # pixels that a layout moves an edge at most where it need not be repeated


class Settled(ConstrainedLayoutEngine):
    """A layout that is repeated: where panels have equal decades, a single one leaves labels beyond the edge."""

    def execute(self, fig: Figure) -> None:
        """Place everything, each time nearer to where it stays."""
        for _ in range(3):
            before = [ax.bbox.extents for ax in fig.axes]
            super().execute(fig)
            if np.allclose(before, [ax.bbox.extents for ax in fig.axes], 0.0, STAYS):
                break


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of so many inches, outside of pyplot's list of open ones."""
    figure = NotebookFigure(figsize=(width, height), layout=Settled(), facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def printed(plot: Plot, room: float = math.inf, make: Callable[[float, float], Figure] = new_figure) -> Figure:
    """A plot for print. It is drawn with phrases; afterwards these are in the language spoken."""
    with look():
        figure = plot.draw(NewFigure(make, room))
    for text in figure.findobj(Text):
        assert isinstance(text, Text)  # noqa: S101 - as asked for
        text.set_text(tr(text.get_text()))
    return figure


def save(figure: Figure, path: PathLike, *, force: bool = False) -> None:
    """Write a figure in the format of the suffix."""
    write(path, encode(figure, demand_figure_path(path, force=force)), force=force)


def encode(figure: Figure, form: str, *, text: bool = False) -> bytes:
    """The figure as png, svg or pdf; with `text`, an svg keeps its letters as text and needs a font to show them."""
    buffer = io.BytesIO()
    with look():
        mpl.rcParams["svg.fonttype"] = "none" if text else "path"
        figure.savefig(buffer, format=form, metadata=FORMATS[form])
    return buffer.getvalue()
