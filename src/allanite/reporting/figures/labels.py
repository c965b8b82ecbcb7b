"""Where the label of a line goes: near its line, far from everything else. Lengths are fractions of the panel."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

MARGIN = 0.015

PLACES = [(reach, dx, dy) for reach in (1.0, 1.8, 3.0, 4.5, 6.0) for dx in (0.0, 0.58, -0.58) for dy in (0.9, -0.9)]
"""Where a label may stand: distance above or below its anchor and shift to a side, in heights and widths."""


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
    best, most = Box(0.5, 0.5, width, height), -np.inf
    for rank, (x, y) in enumerate(anchors):
        for reach, dx, dy in PLACES:
            box = Box(*_inside(x + dx * width, y + dy * reach * height, width, height), width, height)
            free = _freedom(box, obstacles, taken) - 0.004 * rank - 0.06 * reach
            free -= 0.4 * _crossed(box, (x, y), taken)
            if free > most:
                best, most = box, free
    return best


def _inside(x: float, y: float, width: float, height: float) -> tuple[float, float]:
    low, high = MARGIN + width / 2, 1 - MARGIN - width / 2
    return min(max(x, low), high), min(max(y, MARGIN + height / 2), 1 - MARGIN - height / 2)


def _crossed(box: Box, anchor: tuple[float, float], taken: Sequence[Box]) -> bool:
    """Whether the line from a label to its anchor runs across another label."""
    share = np.linspace(0.0, 1.0, 12)
    x, y = (start + share * (end - start) for start, end in zip(anchor, (box.x, box.y), strict=True))
    return any(bool(((np.abs(x - b.x) < b.width / 2) & (np.abs(y - b.y) < b.height / 2)).any()) for b in taken)


def _freedom(box: Box, obstacles: FloatArray, taken: Sequence[Box]) -> float:
    """Distance to the nearest thing in label sizes, at most 1.6: farther away is no better; below 1 it is touched."""
    nearest = 1.6
    if obstacles.size:
        away = np.abs(obstacles - (box.x, box.y)) / (box.width / 2, box.height / 2)
        nearest = min(nearest, float(away.max(axis=1).min()))
    for other in taken:
        x = abs(other.x - box.x) / ((other.width + box.width) / 2)
        y = abs(other.y - box.y) / ((other.height + box.height) / 2)
        # labels on labels are worse than labels on lines
        nearest = min(nearest, 1.5 * max(x, y) - 0.5)
    return nearest
