"""What figures share: colors, places in a panel, the legend, and where the label of a line goes."""

import math
import textwrap
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter

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

NEAR = np.array([(dx, dy) for dx in (0.0, 0.58, -0.58) for dy in (0.9, -0.9, 1.7, -1.7, 2.6, -2.6)])
"""Where a label may stand: shift from its anchor in widths and heights; beside these, on a grid over the panel."""

GRID = np.array(np.meshgrid(np.linspace(0, 1, 21), np.linspace(0, 1, 27))).reshape(2, -1).T
BLOCK, FIRST = 64, 4  # places that are looked at together, the nearest first, and those whose leaders are
CORNERS = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
FREE_END = 0.02  # part of a leader at its anchor, in fractions of the panel, where it may touch what it is about
BREAK = np.full((1, 2), np.nan)  # where one line of the obstacles ends


class LabelBox(NamedTuple):
    """A label's centre and size, and the end of its leader."""

    x: float
    y: float
    width: float
    height: float
    anchor: tuple[float, float] | None = None


def together(paths: Iterable[FloatArray]) -> FloatArray:
    """Lines as one array, with a break behind each."""
    return np.concatenate([BREAK, *(part for path in paths for part in (path, BREAK))])


def place(anchors: FloatArray, size: tuple[float, float], lines: FloatArray, taken: Sequence[LabelBox]) -> LabelBox:
    """The freest place near one of the anchors, whose leader crosses no line, no label and no other leader."""
    shape = np.array(size)
    wanted = (anchors[:, None] + NEAR * shape).reshape(-1, 2)
    low, high = MARGIN + shape / 2, 1 - MARGIN - shape / 2
    centres = np.minimum(np.maximum(np.concatenate((wanted, GRID)), low), high)
    # earlier anchors are preferred
    x, y = (np.subtract.outer(centres[:, i], anchors[:, i]) for i in range(2))
    away = np.sqrt(x * x + y * y) + 0.002 * np.arange(len(anchors))
    at = anchors[away.argmin(axis=1)]
    far = np.hypot(*(at - centres).T)
    nearest, best, most = np.argsort(far, kind="stable"), 0, -math.inf
    for few in np.split(nearest, range(BLOCK, len(nearest), BLOCK)):
        if ENOUGH_DISTANCE - far[few[0]] <= most:  # however free, what is farther off is no better
            break
        free = _freedom(centres[few], size, lines, taken)
        worth = free - (free < 1) - far[few]
        order = np.argsort(-worth, kind="stable")
        for some in (order[:FIRST], order[FIRST:]):  # leaders of the freest places first: few others are as good then
            kept = some[worth[some] > most]
            better, known = few[kept], worth[kept]
            known -= 0.7 * np.minimum(crossings(centres[better], at[better], shape, lines, taken), 3)
            if known.max(initial=-math.inf) > most:
                best, most = int(better[known.argmax()]), float(known.max())
    (x, y), (end, height) = centres[best].tolist(), at[best].tolist()
    return LabelBox(x, y, *size, (end, height))


def crossings(
    centres: FloatArray, at: FloatArray, shape: FloatArray, lines: FloatArray, taken: Sequence[LabelBox]
) -> IntArray:
    """How many lines, labels and leaders each leader crosses, and how many leaders each label."""
    way = at - centres
    start = at - way * np.minimum(1, FREE_END / np.maximum(np.hypot(*way.T), 1e-9))[:, None]
    count = _meetings(start, centres, lines[:-1], lines[1:]).sum(axis=1)
    if taken:
        boxes = np.array([box[:4] for box in taken])
        corners = boxes[:, None, :2] + CORNERS * boxes[:, None, 2:] / 2
        sides = _meetings(start, centres, corners.reshape(-1, 2), np.roll(corners, 1, axis=1).reshape(-1, 2))
        count += sides.reshape(-1, *corners.shape[:2]).any(axis=2).sum(axis=1)
        leaders = np.array([(*box.anchor, box.x, box.y) for box in taken if box.anchor is not None]).reshape(-1, 4)
        ends, half = (leaders[:, :2], leaders[:, 2:]), shape / 2
        rising, falling = (_meetings(centres - d, centres + d, *ends) for d in (half, half * (1, -1)))
        count += (_meetings(start, centres, *ends) + 1 * (rising | falling)).sum(axis=1)
    return np.asarray(count)


def _meetings(start: FloatArray, end: FloatArray, a: FloatArray, b: FloatArray) -> BoolArray:
    """Which of the segments from a to b, shape (m, 2), each of those from start to end crosses, shape (n, m)."""
    (dx, dy), (ex, ey) = (end - start).T[:, :, None], (b - a).T
    apart = a - start[:, None]
    of_start = ex * apart[..., 1] - ey * apart[..., 0]
    of_end = of_start + dx * ey - dy * ex
    of_a = dx * apart[..., 1] - dy * apart[..., 0]
    of_b = of_a + dx * ey - dy * ex
    return np.asarray((of_start * of_end < 0) & (of_a * of_b < 0))


def freedom(box: LabelBox, lines: FloatArray, taken: Sequence[LabelBox]) -> float:
    """Distance to the nearest thing in label sizes, at most `ENOUGH_DISTANCE`."""
    return float(_freedom(np.array([[box.x, box.y]]), (box.width, box.height), lines, taken)[0])


def _freedom(
    centres: FloatArray, size: tuple[float, float], lines: FloatArray, taken: Sequence[LabelBox]
) -> FloatArray:
    """Distance of labels of a size to the nearest thing in label sizes, at most `ENOUGH_DISTANCE`, shape (n,)."""
    free, half = np.full(len(centres), ENOUGH_DISTANCE), np.array(size) / 2
    known = lines[np.isfinite(lines).all(axis=1)]
    if known.size:
        x, y = (np.abs(known[:, None, i] - centres[:, i]) / half[i] for i in range(2))
        free = np.minimum(free, np.maximum(x, y, out=x).min(axis=0))
    for other in taken:
        apart = np.abs(centres - (other.x, other.y)) / (half + np.array([other.width, other.height]) / 2)
        # labels on labels are worse than labels on lines
        free = np.minimum(free, 3 * apart.max(axis=1) - 2)
    return free


TIME = say("averaging time τ (s)")  # what the abscissa of a deviation is called
UNREAD = say("not used by the fit")  # what is shaded where the fit reads nothing

MODEL, REDUCED, EXPECTED = say("model"), say("model without absent terms"), say("expected by the model")
"""Labels of lines that the legend explains."""


def with_unit(quantity: str, unit: str) -> Phrase:
    """What an axis shows, and in which unit."""
    return say("{quantity} ({unit})", quantity=quantity, unit=unit)


COLUMN_INCHES = 5.4  # width of a column of panels, inches


def stacked(new_figure: style.NewFigure, lengths: Sequence[int]) -> tuple[style.Figure, list[list[style.Axes]]]:
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


def draw_titles(ax: style.Axes, parts: Iterable[str], fit: Fit | None, *, before: str = "", room: float = 0.0) -> None:
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


def shade(ax: style.Axes, spans: Iterable[tuple[float, float]], why: str) -> None:
    """Shade parts of the abscissa where the terms alone do not make the curve, and say `why`."""
    start, end = ax.get_xlim()
    for low, high in spans:
        a, b = max(low, start), min(high, end)
        if a < b:
            ax.axvspan(a, b, color=style.SHADE, lw=0, zorder=0.5, label=why)


RATIO_ENDS = 3.0, 1000.0  # ratios at the ends of an axis: at least, and at most
RATIO_SHARE = 0.95  # part of the points that are within it


def ratio_axis(ax: style.Axes, x: FloatArray, ratio: FloatArray, odd: BoolArray | None = None) -> FloatArray:
    """A logarithmic ordinate about 1 for ratios, which come back: those beyond it at its edge, marked by arrows."""
    least, most = RATIO_ENDS
    size = np.abs(np.log(np.clip(ratio, 1 / most, most)))
    size = np.sort(size[np.isfinite(size)])
    needed = float(size[math.ceil(RATIO_SHARE * len(size)) - 1]) if len(size) else 0.0
    end = max(least, 1.15 * math.exp(needed))
    ax.set(yscale="log", ylim=(1 / end, end))
    style.grid(ax, fine=False)
    ax.axhline(1.0, color=style.INK, lw=1.0, zorder=2)
    ax.yaxis.set_major_locator(LogLocator(subs=(1.0,) if end > 20 else (1.0, 2.0, 5.0)))
    style.plain_ticks(ax.yaxis)
    ax.yaxis.set_minor_formatter(NullFormatter())
    odd = np.zeros(len(ratio), np.bool_) if odd is None else odd
    for beyond, edge, arrow in ((ratio > end, end / 1.08, "^"), (ratio < 1 / end, 1.08 / end, "v")):
        for where, color in ((beyond & ~odd, style.DATA), (beyond & odd, style.ALARM)):
            if where.any():
                ax.plot(x[where], np.full(where.sum(), edge), arrow, color=color, ms=5, zorder=4)
    return np.clip(ratio, 1 / end, end)


def by_share(line: FloatArray, whole: FloatArray) -> IntArray:
    """Indices of the points of a term's line, first where it has most to say."""
    known = np.isfinite(line)
    return np.argsort(-(line / whole)[known], kind="stable")


LABEL_POINTS = 8.5  # size of letters beside lines


def label_size(ax: style.Axes, text: str, points: float) -> tuple[float, float]:
    """Width and height of a text in letters of a size, as fractions of the panel."""
    width, height = _inside(ax)
    lines = tr(text).splitlines()
    return (points * max(map(wide, lines)) + 3) / width, (1.25 * points * len(lines) + 2) / height


def draw_label(
    ax: style.Axes, label: tuple[str, str], anchors: FloatArray, avoid: FloatArray, placed: Sequence[LabelBox]
) -> LabelBox:
    """Write (symbol, text) where it is free, with a line to its anchor if that is farther off, and say where it is."""
    symbol, text = label
    box = place(anchors, label_size(ax, text, LABEL_POINTS), avoid, placed)
    assert box.anchor is not None  # noqa: S101 - as `place` makes it
    ax.annotate(
        text, box.anchor, (box.x, box.y), xycoords="axes fraction", textcoords="axes fraction", ha="center",
        va="center", fontsize=LABEL_POINTS, parse_math=False, linespacing=1.25, color=color_of(symbol), zorder=6,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.0},
        arrowprops={"arrowstyle": "-", "color": color_of(symbol), "lw": 0.8, "shrinkA": 0, "shrinkB": 4},
    )  # fmt: skip
    return box


def label_of(estimate: Estimate, level: float, *, brief: bool = False) -> str:
    """A coefficient with the digits of the table: ``N = 0.310 (0.302 … 0.318) deg/√h``; without limits if `brief`."""
    size = words.number(estimate, level) if brief else words.in_print(estimate, estimate.sheet_unit, level)
    return join(" = ", (words.symbol(estimate), size))


def _inside(ax: style.Axes) -> tuple[float, float]:
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


def fractions(ax: style.Axes, points: FloatArray) -> FloatArray:
    """Points as fractions of the panel."""
    low, high = np.log(np.array([ax.get_xlim(), ax.get_ylim()]).T)
    return np.asarray((np.log(points) - low) / (high - low))


def draw_legend(figure: style.Figure, *, marks: bool = True, columns: int = 3, apart: bool = False) -> None:
    """One legend for all panels, above them, or `apart` one above each; with `marks`, the one of read coefficients."""
    for ax in figure.axes if apart else figure.axes[:1]:
        width = _inside(ax)[0] if apart else 72 * figure.get_figwidth()
        entries = _entries(figure, [ax] if apart else figure.axes, marks)
        # points of a label of 8 points with its line and the space beside it
        points = [8 * wide(tr(label)) + 38 for label in entries]
        widths = {n: sum(max(points[i::n]) for i in range(n)) for n in range(2, len(points) + 1)}
        count = next((n for n in range(min(columns, len(points)), 1, -1) if widths[n] <= width), 1)
        labels = [label for i in range(count) for label in list(entries)[i::count]]  # read in rows, filled by columns
        handles = [entries[label] for label in labels]
        owner: Any = ax if apart else figure
        where = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0)} if apart else {"loc": "outside upper center"}
        legend = owner.legend(handles, labels, ncols=count, columnspacing=1.6, **where)
        for text in legend.get_texts():  # names are the user's, and no formulas
            text.set_parse_math(False)


def _entries(figure: style.Figure, axes: Sequence[style.Axes], marks: bool) -> dict[str, style.Artist]:
    """Handles by labels in the order of the panels; keys that several lines share are last."""
    entries: dict[str, style.Artist] = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    if MODEL in entries or REDUCED in entries:
        entries[say("each term alone")] = style.key(figure, color=style.OTHER, lw=1.0, ls=(0, (5, 3)))
        if marks:
            mark = style.key(figure, ls="", marker="D", ms=5, mfc="white", color=style.OTHER, mew=1.3)
            entries[say("where its coefficient is read off")] = mark
    if entries.pop(EXPECTED, None) is not None:
        entries[EXPECTED] = style.key(figure, color=style.OTHER, lw=1.0, ls=(0, (5, 3)))
    return entries
