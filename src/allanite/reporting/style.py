"""How figures look: colors, markers, grids and ticks; a figure that is yet to be drawn, on a page or in print."""

import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, cast

from matplotlib.ticker import FuncFormatter, NullFormatter

from allanite.core.errors import UsageError
from allanite.core.files import PathLike, demand_writable
from allanite.terms import TERMS

from .digits import printable
from .language import tr
from .sketch.chart import Chart
from .sketch.marks import line_of

if TYPE_CHECKING:
    from matplotlib.artist import Artist as Artist  # noqa: PLC0414
    from matplotlib.axes import Axes as Axes  # noqa: PLC0414
    from matplotlib.axis import Axis
    from matplotlib.collections import QuadMesh as QuadMesh  # noqa: PLC0414
    from matplotlib.colors import Normalize as Normalize  # noqa: PLC0414
    from matplotlib.figure import Figure as Figure  # noqa: PLC0414
    from matplotlib.lines import Line2D
else:
    Artist = Axes = Figure = Normalize = QuadMesh = Any  # imported where a figure is made

SERIES = ("#2E5C94", "#C1272D", "#008F6B", "#B97700", "#AA4499", "#444B54")
"""Colors of curves in one panel, in this order; their order of brightness differs too."""

MARKERS = "osD^vP"  # one a color

OTHER, SOFT = "#6B6B6B", "#5B6570"
INK, DATA, GRID, FAIR, ALARM = "#1A1A1A", "#3C444D", "#D9DDE2", "#8A5A00", "#B00020"
SHADE, EDGE = "#E9ECEF", "#555B63"

DARK: dict[str, str] = {
    "#ffffff": "#14171b", "#1a1a1a": "#e6e9ec", "#3c444d": "#c9d1d9", "#d9dde2": "#343a42", "#555b63": "#8b949e",
    "#6b6b6b": "#a0a7ae", "#5b6570": "#a0aab4", "#8a5a00": "#e3b341", "#b00020": "#ff8a94", "#e9ecef": "#262b31",
    "#2e5c94": "#79b0ff", "#c1272d": "#ff7b72", "#008f6b": "#3fc9a0", "#b97700": "#e3b341", "#aa4499": "#dc8fd0",
    "#444b54": "#b0b8c1",
} | {row.color.lower(): row.dark for row in TERMS.values()}  # fmt: skip
"""Colors of figures on a page: on a light ground and on a dark one."""

# no date and no program version: a figure in version control changes only when its content does
FORMATS: dict[str, dict[str, Any]] = {
    "png": {"Software": None}, "svg": {"Date": None, "Creator": None, "Format": None, "Type": None},
    "pdf": {"CreationDate": None, "ModDate": None, "Producer": None, "Creator": None},
}  # fmt: skip


@dataclass(frozen=True)
class NewFigure:
    """Makes an empty figure of (width, height) in inches, of `room` at most in width."""

    make: "Callable[[float, float], Figure]"
    room: float = math.inf

    def __call__(self, width: float, height: float) -> "Figure":
        """The figure."""
        return self.make(min(width, self.room), height)


P = ParamSpec("P")


@dataclass(frozen=True)
class StyledPlot:
    """A figure that is yet to be drawn, on whatever `draw` is given; `room` inches wide at most, made by `make`."""

    draw: "Callable[[NewFigure], Figure]"

    def sketched(self, room: float = math.inf) -> Chart:
        """For a page, by `sketch`; what that cannot draw raises `Unsketched`."""
        make = lambda width, height: cast("Figure", Chart(width, height, INK, EDGE))  # noqa: E731
        return cast(Chart, self.draw(NewFigure(make, room)))


def plotted(function: "Callable[Concatenate[NewFigure, P], Figure]") -> Callable[P, StyledPlot]:
    """A function that draws on a new figure, as one that gives a `StyledPlot`."""

    @wraps(function)
    def plot(*arguments: P.args, **named: P.kwargs) -> StyledPlot:
        return StyledPlot(lambda new_figure: function(new_figure, *arguments, **named))

    return plot


def key(figure: "Figure", **look: Any) -> "Line2D":
    """A line of no panel, for the legend of a figure."""
    if isinstance(figure, Chart):
        return cast("Line2D", line_of([], [], **look))
    from matplotlib.lines import Line2D

    return Line2D([], [], **look)


def grid(axes: "Axes", *, fine: bool = True) -> None:
    """Major and, where `fine`, minor lines, both faint."""
    axes.grid(which="major", color=GRID, linewidth=0.8)
    if fine:
        axes.grid(which="minor", color=GRID, linewidth=0.35, alpha=0.7)
    axes.tick_params(which="minor", length=2)


def title(axes: "Axes", name: str) -> None:
    """Whose panel it is; a name is the user's, and no formula."""
    axes.set_title(printable(tr(name)), loc="left", fontweight="bold", parse_math=False)
    axes.yaxis.set_offset_position("right")  # the power of ten of an ordinate would be beneath the name


def plain_ticks(*axes: "Axis", most: float = 60.0) -> None:
    """Label 0.01 to 100000 in full, the rest as powers of ten; 2 and 5 too where the ends have a ratio below `most`."""
    two_and_five = lambda v, _: f"{v:g}" if round(v / 10 ** math.floor(math.log10(v) + 1e-9)) in (2, 5) else ""  # noqa: E731
    for axis in axes:
        axis.set_major_formatter(
            FuncFormatter(lambda v, _: f"{v:g}" if 9e-4 < v < 2e5 else f"$10^{{{math.log10(v):.0f}}}$")
        )
        low, high = axis.get_view_interval()
        few = low > 0 and high / low < most
        axis.set_minor_formatter(FuncFormatter(two_and_five) if few else NullFormatter())


def demand_figure_path(path: PathLike, *, force: bool = False) -> str:
    """The format that the suffix of `path` names, once the file can be written."""
    suffix = Path(path).suffix.lower().lstrip(".")
    if suffix not in FORMATS:
        raise UsageError(
            f"a figure is saved as {', '.join(FORMATS)}, by its suffix, but {os.fspath(path)!r} has {suffix!r}"
        )
    demand_writable(path, force=force)
    return suffix
