"""A figure of a page: panels in a grid, as large as what stands beside them allows, a legend above them, all as SVG."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from . import svg as ink
from .axes_box import LABEL, TICK, Box, PanelFrame
from .axis import Side, Unsketched, limited
from .marks import Artist, Legend
from .panel import Panel

EDGE_ROOM, PANEL_ROOM = 3.0, 8.0
"""Room at the edge of the figure, and between panels beside what belongs to them, points."""

ROUNDS = 2  # how often boxes are made: labels depend on the length of an axis, and that on its labels

Grid = Sequence[Sequence[Panel]]


def arranged(
    grid: Grid, ratios: tuple[Sequence[float], Sequence[float]], page: tuple[float, float, float]
) -> list[tuple[Panel, Box]]:
    """The boxes of all panels of a grid."""
    width, height, above = page
    rows, columns = len(grid), len(grid[0])
    room = np.full((rows, columns, 4), 20.0)
    for _ in range(ROUNDS):
        boxes = _boxes(room, ratios, (width, height, above))
        boxes = [[_fitted(p, box) for p, box in zip(*pair, strict=True)] for pair in zip(grid, boxes, strict=True)]
        room = np.array(
            [[PanelFrame(p, box, "").room() if p.axison else (0, 0, 0, 0) for p, box in zip(*pair, strict=True)]
             for pair in zip(grid, boxes, strict=True)]
        )  # fmt: skip
    boxes = _boxes(room, ratios, (width, height, above))
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


class Look(NamedTuple):
    """Colors of a figure: of letters, and of axes."""

    ink: str
    edge: str


@limited
class Chart:
    """The part of matplotlib's `Figure` that figures of a page use."""

    def __init__(self, width: float, height: float, look: Look) -> None:
        self.width, self.height, self.look = width * POINTS, height * POINTS, look
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
        self,
        rows: int = 1,
        columns: int = 1,
        *,
        squeeze: bool = True,
        sharex: bool | str = False,
        width_ratios: Sequence[float] | None = None,
        height_ratios: Sequence[float] | None = None,
    ) -> Any:
        """Panels, shape (rows, columns), without dimensions of one unless `squeeze` is false."""
        if self.grid:
            raise Unsketched("panels twice")
        across = [Side(across=True) for _ in range(columns)]
        for i in range(rows):
            sides = across if sharex else [Side(across=True) for _ in range(columns)]
            self.grid.append([Panel(side, self.look.ink, (rows, columns)) for side in sides])
            for panel in self.grid[-1]:
                panel.figure = self
                panel.labelled = not sharex or i == rows - 1
        self.ratios = (list(width_ratios or [1.0] * columns), list(height_ratios or [1.0] * rows))
        panels = np.empty((rows, columns), dtype=object)
        for i, row in enumerate(self.grid):
            for j, panel in enumerate(row):
                panels[i, j] = panel
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
        top = self.key.height + LABEL if self.key and self.key.labels else 0.0
        boxes = arranged(self.grid, self.ratios, (self.width, self.height, top))
        wide, high = (f"{length:g}" for length in (round(self.width, 1), round(self.height, 1)))
        ground = ink.element(f"M0 0H{wide}V{high}H0Z", ink.fill("#ffffff"))
        parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide}pt" height="{high}pt" viewBox="0 0 {wide} {high}">'
            + ground
        ]
        for i, (panel, box) in enumerate((p, b) for p, b in boxes if p.axison):
            parts.append(PanelFrame(panel, box, self.look.edge).svg(i))
        if self.key is not None and self.key.labels:
            parts.append(self.key.svg((self.width - self.key.width) / 2, TICK, self.look.ink))
        return "".join([*parts, "</svg>"])
