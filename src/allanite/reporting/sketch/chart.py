"""A figure of a page: panels in a grid, as large as what stands beside them allows, a legend above them, all as SVG."""

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from . import svg as ink
from .axis import Side, Ticks, Unsketched, limited
from .marks import LEADING, Artist, Legend
from .panel import Panel, place_in

TICK, LABEL = 9.0, 9.0  # sizes of letters: at ticks, and of the names of axes

PAD, NAME_PAD, TITLE_PAD = 3.5, 4.0, 6.0
"""Room beside the labels of ticks, the name of an axis, and below titles, points."""

LONG_TICK, TICK_WIDTH, FINE_WIDTH, EDGE_WIDTH = 3.5, 0.8, 0.6, 0.8
IN_CORNER = 4.0


class Box(NamedTuple):
    """Left upper corner, width and height, points."""

    left: float
    top: float
    width: float
    height: float


class PanelFrame:
    """A panel in a box."""

    def __init__(self, panel: Panel, box: Box, edge: str) -> None:
        self.panel, self.box, self.edge = panel, box, edge

    @cached_property
    def across(self) -> Ticks:
        """Ticks of the abscissa."""
        return self.panel.xaxis.ticks(self.box.width, TICK)

    @cached_property
    def up(self) -> Ticks:
        """Ticks of the ordinate."""
        return self.panel.yaxis.ticks(self.box.height, TICK)

    def room(self) -> tuple[float, float, float, float]:
        """What stands beside the box: at the left, above, at the right, below."""
        below = right = PAD
        if self.panel.labelled:
            named = ink.size_of(ink.shown(self.panel.xaxis.label), LABEL)[1]
            below += TICK + (NAME_PAD + named + ink.BELOW * LABEL if named else 0.0)
            if self.across.major:  # how far the last label of the abscissa stands out
                share = self.panel.xaxis.share(np.array(self.across.major))
                half = np.array([ink.size_of(ink.shown(text), TICK)[0] / 2 for text in self.across.labels])
                right = float(((share - 1) * self.box.width + half).max(initial=PAD))
        titles = [ink.size_of(ink.shown(text), size)[1] for text, size, *_ in self.panel.titles.values() if text]
        above = TITLE_PAD + max(titles) if titles else 2.0
        if self.up.beside:
            above = max(above, TICK + PAD)
        if self.panel.legends is not None and not self.panel.legends[1]:
            above += self.panel.legends[0].height
        return self._left(), above, right, below

    def _left(self) -> float:
        labels = [*self.up.labels, *self.up.minor_labels]
        left = PAD + max((ink.size_of(ink.shown(text), TICK)[0] for text in labels if text), default=0.0)
        name = ink.shown(self.panel.yaxis.label)
        return left + (NAME_PAD + ink.size_of(name, LABEL)[1] if name else 0.0)

    def svg(self, number: int) -> str:
        """All of it; `number` names its clip."""
        rectangle = "".join(f' {name}="{ink.number(value)}"'
            for name, value in zip(("x", "y", "width", "height"), self.box, strict=True))  # fmt: skip
        place = place_in(self.panel, self.box)
        marks = sorted(self.panel.marks, key=lambda mark: mark.z)
        legend = ""
        if self.panel.legends is not None:
            key, corner = self.panel.legends
            free = self.box.width - key.width
            at = (free - IN_CORNER, IN_CORNER / LEADING) if corner else (free / 2, -key.height)
            legend = key.svg(self.box.left + at[0], self.box.top + at[1], self.panel.ink)
        return "".join((
            f'<clipPath id="c{number}"><rect{rectangle}/></clipPath>', *self._grid(),
            f'<g clip-path="url(#c{number})">', *(mark.draw(place) for mark in marks), "</g>", *self._ticks(),
            f"<rect{rectangle} {ink.stroke(self.edge, EDGE_WIDTH)}/>", *self._names(), legend,
        ))  # fmt: skip

    @cached_property
    def at(self) -> dict[str, tuple[list[float], list[float]]]:
        """Where major and minor ticks are: of the abscissa, and of the ordinate."""
        left, top, width, height = self.box
        of = ((self.panel.xaxis, self.across, left, width), (self.panel.yaxis, self.up, top + height, -height))
        return {which: tuple((start + length * side.share(getattr(t, which))).tolist() for side, t, start, length in of)
            for which in ("major", "minor")}  # fmt: skip

    def _grid(self) -> Iterator[str]:
        left, top, width, height = (ink.number(value) for value in self.box)
        for which in ("minor", "major"):
            if which not in self.panel.grids:
                continue
            color, line, alpha = self.panel.grids[which]
            d = "".join(f"M{ink.number(x)} {top}v{height}" for x in self.at[which][0])
            d += "".join(f"M{left} {ink.number(y)}h{width}" for y in self.at[which][1])
            yield ink.element(d, ink.stroke(color, line, opacity=alpha))

    def _ticks(self) -> Iterator[str]:
        left, top, width, height = self.box
        foot, side = ink.number(top + height), ink.number(left)
        for which, length, line in (("major", LONG_TICK, TICK_WIDTH), ("minor", self.panel.minor_length, FINE_WIDTH)):
            d = "".join(f"M{ink.number(at)} {foot}v{-length:g}" for at in self.at[which][0])
            d += "".join(f"M{side} {ink.number(at)}h{length:g}" for at in self.at[which][1])
            yield ink.element(d, ink.stroke(self.edge, line))
        if self.panel.labelled:
            for which, labels in self.across.labelled:
                for at, label in zip(self.at[which][0], labels, strict=True):
                    yield self._label(label, (at, top + height + PAD), "center", "top")
            yield self._label(self.across.beside, (left + width, top + height + PAD + TICK), "right", "top")
        for which, labels in self.up.labelled:
            for at, label in zip(self.at[which][1], labels, strict=True):
                yield self._label(label, (left - PAD, at), "right", "center")
        end = self.panel.yaxis.beside
        yield self._label(self.up.beside, (left + width * (end == "right"), top - PAD), end, "bottom")

    def _label(self, text: str, at: tuple[float, float], ha: str, va: str) -> str:
        return ink.words(ink.shown(text), at, TICK, color=self.panel.ink, ha=ha, va=va) if text else ""

    def _names(self) -> Iterator[str]:
        left, top, width, height = self.box
        panel = self.panel
        if panel.xaxis.label and panel.labelled:
            at = (left + width / 2, top + height + PAD + TICK + NAME_PAD)
            yield ink.words(ink.shown(panel.xaxis.label), at, LABEL, color=panel.ink, ha="center", va="top")
        lines = ink.shown(panel.yaxis.label)
        beside = left - self._left()
        for i, line in enumerate(lines):
            at = (beside + (i * 1.2 + 0.76) * LABEL, top + height / 2)
            yield ink.words([line], at, LABEL, color=panel.ink, ha="center", turned=True)
        where = {"left": left, "center": left + width / 2, "right": left + width}
        for loc, (text, size, color, bold) in panel.titles.items():
            yield ink.words(
                ink.shown(text), (where[loc], top - TITLE_PAD), size, color=color, ha=loc, va="bottom", bold=bold
            )


EDGE_ROOM, PANEL_ROOM = 3.0, 8.0
"""Room at the edge of the figure, and between panels beside what belongs to them, points."""

ROUNDS = 2  # how often boxes are made: labels depend on the length of an axis, and that on its labels

Grid = Sequence[Sequence[Panel]]


def arranged(
    grid: Grid, ratios: tuple[Sequence[float], Sequence[float]], page: tuple[float, float, float]
) -> list[tuple[Panel, Box]]:
    """The boxes of all panels of a grid."""
    room = np.full((len(grid), len(grid[0]), 4), 20.0)
    for _ in range(ROUNDS):
        boxes = _boxes(room, ratios, page)
        boxes = [[_fitted(p, box) for p, box in zip(*pair, strict=True)] for pair in zip(grid, boxes, strict=True)]
        room = np.array([[PanelFrame(p, box, "").room() if p.axison else (0, 0, 0, 0)
            for p, box in zip(*pair, strict=True)] for pair in zip(grid, boxes, strict=True)])  # fmt: skip
    boxes = _boxes(room, ratios, page)
    pairs = (pair for row in zip(grid, boxes, strict=True) for pair in zip(*row, strict=True))
    return [(panel, _fitted(panel, box)) for panel, box in pairs]


def _boxes(
    room: np.ndarray, ratios: tuple[Sequence[float], Sequence[float]], page: tuple[float, float, float]
) -> list[list[Box]]:
    """Boxes whose columns and rows have common edges."""
    width, height, above = page
    left, top, right, below = (room[:, :, i].max(axis=1 - axis) for i, axis in ((0, 1), (1, 0), (2, 1), (3, 0)))
    x, wide = _along(left, right, ratios[0], (EDGE_ROOM, width - EDGE_ROOM))
    y, high = _along(top, below, ratios[1], (EDGE_ROOM + above, height - EDGE_ROOM))
    return [[Box(a, b, w, h) for a, w in zip(x, wide, strict=True)] for b, h in zip(y, high, strict=True)]


def _along(
    before: np.ndarray, after: np.ndarray, ratios: Sequence[float], ends: tuple[float, float]
) -> tuple[list[float], list[float]]:
    """Starts and lengths."""
    start, end = ends
    free = end - start - before.sum() - after.sum() - PANEL_ROOM * (len(ratios) - 1)
    lengths = np.maximum(free, 10.0) * np.array(ratios) / sum(ratios)
    starts, at = [], start
    for i, length in enumerate(lengths):
        starts.append(float(at + before[i]))
        at += before[i] + length + after[i] + PANEL_ROOM
    return starts, [float(length) for length in lengths]


def _fitted(panel: Panel, box: Box) -> Box:
    """The part of a box in which both axes have equal lengths, in the middle at the top."""
    if not panel.equal:
        return box
    views = (side.place(np.array(side.get_view_interval())) for side in (panel.xaxis, panel.yaxis))
    across, up = (float(high - low) for low, high in views)
    unit = min(box.width / across, box.height / up)
    wide = unit * across
    return Box(box.left + (box.width - wide) / 2, box.top, wide, unit * up)


POINTS = 72.0  # points of an inch


@limited
class Chart:
    """The part of matplotlib's `Figure` that figures of a page use; with the colors of letters and of axes."""

    def __init__(self, width: float, height: float, ink: str, edge: str) -> None:
        self.width, self.height, self.ink, self.edge = width * POINTS, height * POINTS, ink, edge
        self.grid: list[list[Panel]] = []
        self.ratios: tuple[list[float], list[float]] = ([], [])
        self.key: Legend | None = None

    @property
    def axes(self) -> list[Panel]:
        """All panels, row by row."""
        return [panel for row in self.grid for panel in row]

    def get_figwidth(self) -> float:
        """Width in inches."""
        return self.width / POINTS

    def get_size_inches(self) -> tuple[float, float]:
        """Width and height."""
        return self.width / POINTS, self.height / POINTS

    def subplots(
        self, rows: int = 1, columns: int = 1, *, squeeze: bool = True, sharex: bool | str = False,
        width_ratios: Sequence[float] | None = None, height_ratios: Sequence[float] | None = None,
    ) -> Any:  # fmt: skip
        """Panels, shape (rows, columns), without dimensions of one unless `squeeze` is false."""
        if self.grid:
            raise Unsketched("panels twice")
        across = [Side(across=True) for _ in range(columns)]
        for i in range(rows):
            sides = across if sharex else [Side(across=True) for _ in range(columns)]
            self.grid.append([Panel(side, self.ink, (rows, columns)) for side in sides])
            for panel in self.grid[-1]:
                panel.figure = self
                panel.labelled = not sharex or i == rows - 1
        self.ratios = (list(width_ratios or [1.0] * columns), list(height_ratios or [1.0] * rows))
        panels = np.array(self.grid, dtype=object)
        if not squeeze:
            return panels
        return panels.item() if panels.size == 1 else panels.squeeze()

    def legend(
        self, handles: Sequence[Artist], labels: Sequence[str], *, loc: str, ncols: int, columnspacing: float
    ) -> Legend:
        """What the lines of all panels are, above them."""
        if loc != "outside upper center":
            raise Unsketched(f"legend {loc}")
        self.key = Legend(handles, labels, ncols, columnspacing)
        return self.key

    def svg(self) -> str:
        """The figure."""
        for side in {side for panel in self.axes for side in (panel.xaxis, panel.yaxis)}:
            side.settle()
        top = self.key.height + LABEL if self.key and self.key.labels else 0.0
        boxes = arranged(self.grid, self.ratios, (self.width, self.height, top))
        wide, high = (f"{length:g}" for length in (round(self.width, 1), round(self.height, 1)))
        ground = ink.element(f"M0 0H{wide}V{high}H0Z", ink.fill("#ffffff"))
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide}pt" height="{high}pt" viewBox="0 0 {wide} {high}">'
        )
        parts = [head, ground]
        for i, (panel, box) in enumerate((p, b) for p, b in boxes if p.axison):
            parts.append(PanelFrame(panel, box, self.edge).svg(i))
        if self.key is not None and self.key.labels:
            parts.append(self.key.svg((self.width - self.key.width) / 2, TICK, self.ink))
        return "".join([*parts, "</svg>"])
