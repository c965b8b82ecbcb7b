"""What figures share: colors and labels of terms, places in a panel, the legend."""

import textwrap
from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from rich.cells import cell_len

from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.validity import APPROXIMATE, EXPLAINED, UNEXPLAINED
from allanite.phrases.phrase import Phrase, join, say
from allanite.reporting import style, words
from allanite.reporting.digits import printable
from allanite.reporting.language import tr
from allanite.reporting.sketch.svg import wide
from allanite.terms import TERMS

from .labels import FloatArray, IntArray, LabelBox, nearest, place

TIME = say("averaging time τ (s)")
"""What the abscissa of a deviation is called."""

MODEL, EXPECTED = say("model"), say("expected by the model")
"""Labels of lines that the legend explains."""


def with_unit(quantity: str, unit: str) -> Phrase:
    """What an axis shows, and in which unit."""
    return say("{quantity} ({unit})", quantity=quantity, unit=unit)


def stacked(new_figure: style.NewFigure, lengths: Sequence[int]) -> tuple[Figure, list[list[Axes]]]:
    """A figure of columns with so many panels; those of a column share the abscissa, and its labels stand below it."""
    rows = max(lengths)
    single = rows == len(lengths) == 1
    figure = new_figure(*((7.2, 5.0) if single else (6.4 * len(lengths), 0.6 + 3.3 * rows)))
    grid = figure.subplots(rows, len(lengths), squeeze=False, sharex="col")
    columns = [list(axes[:length]) for axes, length in zip(grid.T, lengths, strict=True)]
    for axes, length in zip(grid.T, lengths, strict=True):
        for ax in axes[length:]:
            ax.set_axis_off()
        axes[length - 1].tick_params(labelbottom=True)
    return figure, columns


def color_of(symbol: str) -> str:
    """The color of a term; that of the text where there is none."""
    return TERMS[symbol].color if symbol else style.INK


def dashes(symbol: str) -> tuple[float, tuple[float, ...]]:
    """The line style of a term."""
    return 0.0, TERMS[symbol].dash


GRADES = {"": style.OTHER, EXPLAINED: style.OTHER, APPROXIMATE: style.FAIR, UNEXPLAINED: style.ALARM}
"""Color of a grade; of none where there is no fit, or it was not tested."""

NAME, GRADE = 9.5, 8.5
"""Sizes of letters above a panel: what it shows, and its grade."""


def draw_titles(ax: Axes, parts: Iterable[str], fit: Fit | None, *, before: str = "", room: float = 0.0) -> None:
    """Say above a panel what it shows, and at the right how well the model explains that.

    `parts` are in one line if they have room beside the grade, else in lines of their own, above it if need be; `room`
    is the width of the panel in points, by default about that of an equal share of the figure.
    """
    said = join("; ", filter(None, (before, words.grade(fit) if fit is not None else "")))
    known = [printable(part) for part in parts if part]
    room = room or _inside(ax)[0]
    lines = []
    for part in known:
        long = _long(part)
        lines += [part] if long <= room else textwrap.wrap(part, max(1, int(len(part) * room / long)))
    lines = lines or [""]
    beside = room - GRADE * wide(tr(said)) - GRADE
    layouts = (["   ".join(known)], lines)
    fitting = (layout for layout in layouts if _long(layout[-1]) <= beside)
    name = "\n".join(next(fitting, [*lines, " "]))
    ax.set_title(name, loc="left", fontweight="bold", fontsize=NAME, parse_math=False)
    ax.set_title(said, loc="right", color=GRADES["" if fit is None else fit.validity], fontsize=GRADE)


def _long(text: str) -> float:
    return NAME * wide(text, bold=True)


def shade(ax: Axes, spans: Iterable[tuple[float, float]]) -> None:
    """Shade parts of the abscissa that the fit does not read."""
    left, right = ax.get_xlim()
    for low, high in spans:
        a, b = max(low, left), min(high, right)
        if a < b:
            ax.axvspan(a, b, color=style.SHADE, lw=0, zorder=0.5, label=say("not used by the fit"))


def by_share(line: FloatArray, whole: FloatArray) -> IntArray:
    """Indices of the points of a term's line, first where it has most to say."""
    known = np.isfinite(line)
    return np.argsort(-(line / whole)[known], kind="stable")


def draw_label(
    ax: Axes, label: tuple[str, str], anchors: FloatArray, avoid: FloatArray, placed: Sequence[LabelBox]
) -> LabelBox:
    """Write (symbol, text) where it is free, with a line to its anchor if that is farther off, and say where it is."""
    symbol, text = label
    width, height = _inside(ax)
    lines = tr(text).splitlines()  # whose letters, of 8.5 points, are 5.3 points wide
    box = place(anchors, (max(map(cell_len, lines)) * 5.3 / width, 11.5 * len(lines) / height), avoid, placed)
    at = nearest(anchors, box)
    ax.annotate(
        text, (at[0], at[1]), (box.x, box.y), xycoords="axes fraction", textcoords="axes fraction", ha="center",
        va="center", fontsize=8.5, parse_math=False, linespacing=1.25, color=color_of(symbol), zorder=6,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.0},
        arrowprops={"arrowstyle": "-", "color": color_of(symbol), "lw": 0.8, "shrinkA": 0, "shrinkB": 4},
    )  # fmt: skip
    return box


def label_of(estimate: Estimate, level: float) -> str:
    """A coefficient for the figure, with the digits of the table: ``N = 0.310 (0.302 … 0.318) deg/√h``."""
    return join(" = ", (words.symbol(estimate), words.in_print(estimate, estimate.sheet_unit, level)))


def _inside(ax: Axes) -> tuple[float, float]:
    """About the width and height of a panel within its axes, in points, before anything is laid out."""
    figure = ax.get_figure(root=True)
    spec = ax.get_subplotspec()
    assert figure is not None and spec is not None  # noqa: S101, PT018 - every panel has both
    rows, columns = spec.get_gridspec().get_geometry()
    width, height = figure.get_size_inches()
    return 72 * 0.86 * width / columns, 72 * 0.8 * height / rows


def pairs(x: FloatArray, y: FloatArray) -> FloatArray:
    """Points, shape (k, 2), where there is a value that a logarithmic axis has."""
    return np.column_stack([x, y])[np.isfinite(y) & (y > 0)]


def fractions(ax: Axes, points: FloatArray) -> FloatArray:
    """Points as fractions of the panel."""
    low, high = np.log(np.array([ax.get_xlim(), ax.get_ylim()]).T)
    return np.asarray((np.log(points) - low) / (high - low))


def draw_legend(figure: Figure, *, marks: bool = True, columns: int = 3) -> None:
    """One legend for all panels, above them; with `marks`, the one where coefficients are read off."""
    entries: dict[str, Artist] = {}
    for ax in figure.axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    if MODEL in entries:
        entries[say("each term alone")] = style.key(figure, color=style.OTHER, lw=1.0, ls=(0, (5, 3)))
        if marks:
            mark = style.key(figure, ls="", marker="D", ms=5, mfc="white", color=style.OTHER, mew=1.3)
            entries[say("where its coefficient is read off")] = mark
    if EXPECTED in entries:
        entries[EXPECTED] = style.key(figure, color=style.OTHER, lw=1.0, ls=(0, (5, 3)))
    # points of a label of 8 points with its line and the space beside it; columns are filled one by one
    points = [4.9 * cell_len(tr(label)) + 45 for label in entries]
    widths = {n: sum(float(part.max()) for part in np.array_split(points, n)) for n in range(2, len(points) + 1)}
    fitting = (n for n in range(min(columns, len(points)), 1, -1) if widths[n] <= 72 * figure.get_figwidth())
    columns = next(fitting, 1)
    legend = figure.legend(
        list(entries.values()), list(entries), loc="outside upper center", ncols=columns, columnspacing=1.6
    )
    for text in legend.get_texts():  # names are the user's, and no formulas
        text.set_parse_math(False)
