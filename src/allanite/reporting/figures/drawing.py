"""What figures share: colors, places in a panel, the legend, and where the label of a line goes."""

import textwrap
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from rich.cells import cell_len

from allanite.core.arrays import BoolArray, FloatArray, IntArray
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.validity import APPROXIMATE, EXPLAINED, UNEXPLAINED
from allanite.phrases.phrase import Phrase, join, say
from allanite.reporting import style, words
from allanite.reporting.digits import printable
from allanite.reporting.language import tr
from allanite.reporting.sketch.svg import wide
from allanite.terms import TERMS

MARGIN = 0.015

ENOUGH_DISTANCE = 1.25
"""Distance to the nearest thing, in label sizes, beyond which farther away is no better; below 1 it is touched."""

CELLS = 50  # cells of the panel along each axis, by which it is known where the curves are
LINE = np.linspace(0.0, 1.0, 20)  # steps along that line

NEAR = np.array([(dx, dy) for dx in (0.0, 0.58, -0.58) for dy in (0.9, -0.9, 1.7, -1.7)])
"""Where a label may stand: shift from its anchor in widths and heights; beside these, on a grid over the panel."""

GRID = np.array(np.meshgrid(np.linspace(0, 1, 13), np.linspace(0, 1, 15))).reshape(2, -1).T


class LabelBox(NamedTuple):
    """A label's centre and size."""

    x: float
    y: float
    width: float
    height: float


def place(anchors: FloatArray, size: tuple[float, float], obstacles: FloatArray, taken: Sequence[LabelBox]) -> LabelBox:
    """The freest place above or below one of the anchors."""
    shape = np.array(size)
    wanted = (anchors[:, None] + NEAR * shape).reshape(-1, 2)
    low, high = MARGIN + shape / 2, 1 - MARGIN - shape / 2
    centres = np.minimum(np.maximum(np.concatenate((wanted, GRID)), low), high)
    away = np.hypot(*(anchors[:, None] - centres).T) + 0.002 * np.arange(len(anchors))
    at = anchors[away.argmin(axis=1)]
    far = np.hypot(*(at - centres).T)
    # whether the line from a label to its anchor runs across another label, shape (n,)
    line = at + LINE[:, None, None] * (centres - at)
    crossed = np.zeros(len(centres), np.bool_)
    for b in taken:
        crossed |= (np.abs(line - (b.x, b.y)) < (b.width / 2, b.height / 2)).all(axis=2).any(axis=0)
    across = _across(line, shape, obstacles)
    worth = _freedom(centres, size, obstacles, taken) - far - 0.4 * crossed - 0.4 * across
    x, y = centres[int(worth.argmax())].tolist()
    return LabelBox(x, y, *size)


def _across(line: FloatArray, shape: FloatArray, obstacles: FloatArray) -> BoolArray:
    """Whether lines from anchors to labels, shape (steps, n, 2), run across obstacles away from both ends."""
    on = np.zeros((CELLS, CELLS), np.bool_)
    x, y = np.clip(obstacles.T * CELLS, 0, CELLS - 1).astype(np.int64)
    on[x, y] = True
    x, y = (line.T * CELLS).astype(np.int64)
    from_anchor = np.hypot(*(line - line[0]).T)
    from_label = np.abs((line - line[-1]) / shape).max(axis=2).T - 0.5
    return np.asarray((on[x, y] & (from_anchor > 2 / CELLS) & (from_label > 2 / CELLS)).any(axis=1))


def nearest(anchors: FloatArray, box: LabelBox) -> FloatArray:
    """The anchor that is nearest to a label; earlier ones are preferred."""
    away = np.hypot(*(anchors - (box.x, box.y)).T) + 0.002 * np.arange(len(anchors))
    return np.asarray(anchors[int(away.argmin())])


def freedom(box: LabelBox, obstacles: FloatArray, taken: Sequence[LabelBox]) -> float:
    """Distance to the nearest thing in label sizes, at most `ENOUGH_DISTANCE`."""
    return float(_freedom(np.array([[box.x, box.y]]), (box.width, box.height), obstacles, taken)[0])


def _freedom(
    centres: FloatArray, size: tuple[float, float], obstacles: FloatArray, taken: Sequence[LabelBox]
) -> FloatArray:
    """Distance of labels of a size to the nearest thing in label sizes, at most `ENOUGH_DISTANCE`, shape (n,)."""
    free, half = np.full(len(centres), ENOUGH_DISTANCE), np.array(size) / 2
    if obstacles.size:
        x, y = (np.abs(obstacles[:, None, i] - centres[:, i]) / half[i] for i in range(2))
        free = np.minimum(free, np.maximum(x, y, out=x).min(axis=0))
    for other in taken:
        apart = np.abs(centres - (other.x, other.y)) / (half + np.array([other.width, other.height]) / 2)
        # labels on labels are worse than labels on lines
        free = np.minimum(free, 3 * apart.max(axis=1) - 2)
    return free


TIME = say("averaging time τ (s)")  # what the abscissa of a deviation is called
UNREAD = say("not used by the fit")  # what is shaded where the fit reads nothing

MODEL, EXPECTED = say("model"), say("expected by the model")
"""Labels of lines that the legend explains."""


def with_unit(quantity: str, unit: str) -> Phrase:
    """What an axis shows, and in which unit."""
    return say("{quantity} ({unit})", quantity=quantity, unit=unit)


COLUMN_INCHES = 5.4  # width of a column of panels, inches


def stacked(new_figure: style.NewFigure, lengths: Sequence[int]) -> tuple[Figure, list[list[Axes]]]:
    """A figure of columns with so many panels, which share the abscissa; below each other where there is no room."""
    count, rows = len(lengths), max(lengths)
    if count > 1 and COLUMN_INCHES * count > new_figure.room:
        figure = new_figure(COLUMN_INCHES, 0.6 + 3.6 * sum(lengths))
        panels = iter(figure.subplots(sum(lengths), 1, squeeze=False)[:, 0])
        return figure, [[next(panels) for _ in range(length)] for length in lengths]
    figure = new_figure(*((7.2, 4.4) if rows == count == 1 else (COLUMN_INCHES * count, 0.6 + 3.3 * rows)))
    grid = figure.subplots(rows, count, squeeze=False, sharex="col")
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

NAME_POINTS, GRADE_POINTS = 9.5, 8.5  # sizes of letters above a panel: what it shows, and its grade


def draw_titles(ax: Axes, parts: Iterable[str], fit: Fit | None, *, before: str = "", room: float = 0.0) -> None:
    """Above a panel what it shows, in a line or in several, and how well the model explains it; `room` is in points."""
    grade = join("; ", filter(None, (before, words.grade(fit) if fit is not None else "")))
    known = [printable(part) for part in parts if part]
    room = room or _inside(ax)[0]
    lines = []
    for part in known:
        long = _long(part)
        lines += [part] if long <= room else textwrap.wrap(part, max(1, int(len(part) * room / long)))
    lines = lines or [""]
    beside = room - GRADE_POINTS * wide(tr(grade)) - GRADE_POINTS
    layouts = (["   ".join(known)], lines)
    fitting = (layout for layout in layouts if _long(layout[-1]) <= beside)
    name = "\n".join(next(fitting, [*lines, " "]))
    ax.set_title(name, loc="left", fontweight="bold", fontsize=NAME_POINTS, parse_math=False)
    ax.set_title(grade, loc="right", color=GRADES["" if fit is None else fit.validity], fontsize=GRADE_POINTS)


def _long(text: str) -> float:
    return NAME_POINTS * wide(text, bold=True)


def shade(ax: Axes, spans: Iterable[tuple[float, float]], why: str) -> None:
    """Shade parts of the abscissa where the terms alone do not make the curve, and say `why`."""
    start, end = ax.get_xlim()
    for low, high in spans:
        a, b = max(low, start), min(high, end)
        if a < b:
            ax.axvspan(a, b, color=style.SHADE, lw=0, zorder=0.5, label=why)


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


def label_of(estimate: Estimate, level: float, *, brief: bool = False) -> str:
    """A coefficient with the digits of the table: ``N = 0.310 (0.302 … 0.318) deg/√h``; without limits if `brief`."""
    size = words.number(estimate, level) if brief else words.in_print(estimate, estimate.sheet_unit, level)
    return join(" = ", (words.symbol(estimate), size))


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
    points = [8 * wide(tr(label)) + 38 for label in entries]
    widths = {n: sum(float(part.max()) for part in np.array_split(points, n)) for n in range(2, len(points) + 1)}
    fitting = (n for n in range(min(columns, len(points)), 1, -1) if widths[n] <= 72 * figure.get_figwidth())
    columns = next(fitting, 1)
    legend = figure.legend(
        list(entries.values()), list(entries), loc="outside upper center", ncols=columns, columnspacing=1.6
    )
    for text in legend.get_texts():  # names are the user's, and no formulas
        text.set_parse_math(False)
