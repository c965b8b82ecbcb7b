"""Where the panels of a figure are: as large as what stands beside them allows."""

from collections.abc import Sequence

import numpy as np

from .axes_box import Box, PanelFrame
from .panel import Panel

EDGE, BETWEEN = 3.0, 8.0
"""Room at the edge of the figure, and between panels beside what belongs to them, points."""

ROUNDS = 2
"""How often boxes are made: labels depend on the length of an axis, and that on its labels."""

Grid = Sequence[Sequence[Panel]]


def arranged(
    grid: Grid, ratios: tuple[Sequence[float], Sequence[float]], page: tuple[float, float, float]
) -> list[tuple[Panel, Box]]:
    """The boxes of all panels of a grid.

    Parameters
    ----------
    grid : rows of panels
    ratios : widths of columns and heights of rows, relative to each other
    page : width and height of the figure, and what stands above all panels, points
    """
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
    x, wide = _along(left, right, ratios[0], (EDGE, width - EDGE))
    y, high = _along(top, below, ratios[1], (EDGE + above, height - EDGE))
    return [[Box(a, b, w, h) for a, w in zip(x, wide, strict=True)] for b, h in zip(y, high, strict=True)]


def _along(
    before: np.ndarray, after: np.ndarray, ratios: Sequence[float], ends: tuple[float, float]
) -> tuple[list[float], list[float]]:
    """Starts and lengths."""
    start, end = ends
    free = end - start - before.sum() - after.sum() - BETWEEN * (len(ratios) - 1)
    lengths = np.maximum(free, 10.0) * np.array(ratios) / sum(ratios)
    starts, at = [], start
    for i, length in enumerate(lengths):
        starts.append(float(at + before[i]))
        at += before[i] + length + after[i] + BETWEEN
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
