"""Where the label of a line goes: near its line, far from everything else. Lengths are fractions of the panel."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

MARGIN = 0.015

ENOUGH = 1.25
"""Distance to the nearest thing, in label sizes, beyond which farther away is no better; below 1 it is touched."""

NEAR = [(dx, dy) for dx in (0.0, 0.58, -0.58) for dy in (0.9, -0.9, 1.7, -1.7)]
"""Where a label may stand: shift from its anchor in widths and heights; beside these, on a grid over the panel."""

GRID = np.array(np.meshgrid(np.linspace(0, 1, 13), np.linspace(0, 1, 15))).reshape(2, -1).T


class Box(NamedTuple):
    """A label's centre and size."""

    x: float
    y: float
    width: float
    height: float


def place(anchors: FloatArray, size: tuple[float, float], obstacles: FloatArray, taken: Sequence[Box]) -> Box:
    """The freest place above or below one of the anchors.

    Parameters
    ----------
    anchors : array, shape (k, 2)
        Points of the line that is labelled; earlier ones are preferred.
    size : (width, height)
        Of the label.
    obstacles : array, shape (n, 2)
        Points that should stay visible.
    taken : sequence of Box
        Labels that are placed already.
    """
    width, height = size
    wanted = [(x + dx * width, y + dy * height) for x, y in anchors for dx, dy in NEAR]
    boxes = [Box(*_inside(x, y, width, height), width, height) for x, y in (*wanted, *GRID.tolist())]
    return max(boxes, key=lambda box: _worth(box, anchors, obstacles, taken))


def nearest(anchors: FloatArray, box: Box) -> FloatArray:
    """The anchor that is nearest to a label; earlier ones are preferred."""
    away = np.hypot(*(anchors - (box.x, box.y)).T) + 0.002 * np.arange(len(anchors))
    return np.asarray(anchors[int(away.argmin())])


def _worth(box: Box, anchors: FloatArray, obstacles: FloatArray, taken: Sequence[Box]) -> float:
    """How good a place is: free, near its anchor, and no label on the way."""
    x, y = nearest(anchors, box)
    far = 0.5 * float(np.hypot(x - box.x, y - box.y))
    return freedom(box, obstacles, taken) - far - 0.4 * _crossed(box, (x, y), taken)


def _inside(x: float, y: float, width: float, height: float) -> tuple[float, float]:
    low, high = MARGIN + width / 2, 1 - MARGIN - width / 2
    return min(max(x, low), high), min(max(y, MARGIN + height / 2), 1 - MARGIN - height / 2)


def _crossed(box: Box, anchor: tuple[float, float], taken: Sequence[Box]) -> bool:
    """Whether the line from a label to its anchor runs across another label."""
    share = np.linspace(0.0, 1.0, 12)
    x, y = (start + share * (end - start) for start, end in zip(anchor, (box.x, box.y), strict=True))
    return any(bool(((np.abs(x - b.x) < b.width / 2) & (np.abs(y - b.y) < b.height / 2)).any()) for b in taken)


def freedom(box: Box, obstacles: FloatArray, taken: Sequence[Box]) -> float:
    """Distance to the nearest thing in label sizes, at most `ENOUGH`."""
    free = ENOUGH
    if obstacles.size:
        away = np.abs(obstacles - (box.x, box.y)) / (box.width / 2, box.height / 2)
        free = min(free, float(away.max(axis=1).min()))
    for other in taken:
        x = abs(other.x - box.x) / ((other.width + box.width) / 2)
        y = abs(other.y - box.y) / ((other.height + box.height) / 2)
        # labels on labels are worse than labels on lines
        free = min(free, 3 * max(x, y) - 2)
    return free
