"""Where the label of a line goes: near its line, far from everything else. Lengths are fractions of the panel."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

MARGIN = 0.015

ENOUGH = 1.25
"""Distance to the nearest thing, in label sizes, beyond which farther away is no better; below 1 it is touched."""

CELLS = 50
"""Cells of the panel along each axis, by which it is known where the curves are."""

LINE = np.linspace(0.0, 1.0, 20)
"""Steps along that line."""

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
    """Distance to the nearest thing in label sizes, at most `ENOUGH`."""
    return float(_freedom(np.array([[box.x, box.y]]), (box.width, box.height), obstacles, taken)[0])


def _freedom(
    centres: FloatArray, size: tuple[float, float], obstacles: FloatArray, taken: Sequence[LabelBox]
) -> FloatArray:
    """Distance of labels of a size to the nearest thing in label sizes, at most `ENOUGH`, shape (n,)."""
    free, half = np.full(len(centres), ENOUGH), np.array(size) / 2
    if obstacles.size:
        x, y = (np.abs(obstacles[:, None, i] - centres[:, i]) / half[i] for i in range(2))
        free = np.minimum(free, np.maximum(x, y, out=x).min(axis=0))
    for other in taken:
        apart = np.abs(centres - (other.x, other.y)) / (half + np.array([other.width, other.height]) / 2)
        # labels on labels are worse than labels on lines
        free = np.minimum(free, 3 * apart.max(axis=1) - 2)
    return free
