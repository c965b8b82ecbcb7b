"""What is smooth in the averaging time, worked out at some points of a long curve and interpolated between them."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from allanite.core.curve import Law
from allanite.statistics.grids import part_of
from allanite.statistics.row import FloatArray, IntArray
from allanite.statistics.table import Points

MOST = 300
"""Points of a curve that are all dealt with, one by one."""

EVEN, AT_THE_END = 100, 30
"""Points of a longer curve, or of a hybrid's part: evenly in the logarithm, and in its last half, by windows left."""


@dataclass(frozen=True, eq=False)
class SparseLaw:
    """The law of many points, from that of a few."""

    points: Points
    few: Law

    def __call__(self, level: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Degrees of freedom and limits over the variance; see `Curve`."""
        edf, low, high = self.few(level)
        inverse, low, high = (between(self.points, values) for values in (1 / edf, low, high))
        return 1 / inverse, low, high


def sparse_law(points: Points, law: Callable[[Points], Law]) -> Law:
    """A law of many points, from that of a few."""
    return law(points) if points.m.size <= MOST else SparseLaw(points, law(at_nodes(points)))


def sparse(points: Points, function: Callable[[Points], FloatArray]) -> FloatArray:
    """A function of many points, from its values at a few."""
    return function(points) if points.m.size <= MOST else between(points, function(at_nodes(points)))


def _nodes(points: Points) -> list[tuple[IntArray, IntArray]]:
    """Places in m of the points that are worked out, and of those that are read off them; one pair for each part."""
    made, order = part_of(points.row, points.m, points.size, points.join), np.argsort(points.m, kind="stable")
    parts = [order[made[order] == part] for part in np.unique(made)]
    return [(_few(points.m[part], part), part) for part in parts]


def _few(m: IntArray, places: IntArray) -> IntArray:
    if m.size <= MOST:
        return places
    wanted = np.concatenate((np.geomspace(m[0], m[-1], EVEN), m[-1] - np.geomspace(1, m[-1] / 2, AT_THE_END)))
    kept = np.concatenate((np.searchsorted(m, wanted).clip(0, m.size - 1), [0, m.size - 1]))
    return np.asarray(places[np.unique(kept)])


def at_nodes(points: Points) -> Points:
    """The points that are worked out."""
    return points._replace(m=points.m[np.concatenate([few for few, _ in _nodes(points)])])


def between(points: Points, values: FloatArray) -> FloatArray:
    """Values at the nodes, in their order, at all points: linear in the logarithm of m."""
    result, at, logarithm = np.empty(points.m.size), 0, np.log(points.m)
    for few, part in _nodes(points):
        result[part] = np.interp(logarithm[part], logarithm[few], values[at : at + few.size])
        at += few.size
    return result
