"""What is smooth in the averaging time, computed at some points of a long curve and interpolated between them."""

# Derivation: docs/derivations.md.

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.curve import DerivedLaw, Law
from allanite.core.splines import cubic, linear, valued
from allanite.statistics.table import CurvePoints

FIRST_NODES, FIRST_OF_WINDOWS = 4, 24
"""Averaging factors that are all nodes: of differences, and of windows that are none, which integers change more."""

NODES_PER_DECADE, LATE, MAX_LATE_NODES = 3, 64, 80
"""Nodes a decade up to the record's length over LATE, beyond which all points are, but at most so many.

There the leading eigenvalues decide, and cross each other: limits have kinks.
"""

MAX_SINGLE_POINTS = 300  # points of a curve that is not smooth which are all processed, one by one

EVEN_NODES, END_NODES = 100, 30
"""Points of a longer one: evenly in the logarithm, and in its last half, by windows left."""


def sparse_law(points: CurvePoints, law: Callable[[CurvePoints], Law]) -> Law:
    """A law of many points, from that of a few."""
    few = _at_nodes(points)
    return law(points) if few.m.size == points.m.size else DerivedLaw((law(few),), partial(_between, points))


def sparse(points: CurvePoints, function: Callable[[CurvePoints], FloatArray]) -> FloatArray:
    """A positive function of many points, shape (..., points), from its values at a few."""
    few = _at_nodes(points)
    return function(points) if few.m.size == points.m.size else _between(points, function(few))


class CurvePart(NamedTuple):
    """Places in m of the points of a statistic, or of a hybrid's part, by rising m, and which of them are nodes."""

    places: IntArray
    nodes: IntArray
    smooth: bool


def _parts(points: CurvePoints) -> list[CurvePart]:
    made, order = points.row.part_of(points.m, points.size), np.argsort(points.m, kind="stable")
    parts = []
    for i in np.unique(made):
        row = points.row.parts[i] if points.row.parts else points.row
        smooth = row.overlapped and len(points.runs) == 1 and points.runs[0][1] == 1
        places = order[made[order] == i]
        m = points.m[places]
        first = FIRST_NODES if row.differences else FIRST_OF_WINDOWS
        parts.append(CurvePart(places, _smooth_nodes(m, first, points.size / LATE) if smooth else _nodes(m), smooth))
    return parts


def _smooth_nodes(m: IntArray, first: int, end: float) -> IntArray:
    late = np.flatnonzero(m > end)
    if late.size > MAX_LATE_NODES:
        u = _stretched(m)[late]
        late = late[np.searchsorted(u, np.linspace(u[0], u[-1], MAX_LATE_NODES)).clip(0, late.size - 1)]
    end = max(end, float(m[0]))
    early = np.geomspace(m[0], end, math.ceil(NODES_PER_DECADE * math.log10(end / m[0])) + 1)
    early = np.searchsorted(m, early).clip(0, m.size - 1)
    return np.unique(np.concatenate((np.flatnonzero(m <= first), early, late, [m.size - 1])))


def _nodes(m: IntArray) -> IntArray:
    if m.size <= MAX_SINGLE_POINTS:
        return np.arange(m.size)
    wanted = np.concatenate((np.geomspace(m[0], m[-1], EVEN_NODES), m[-1] - np.geomspace(1, m[-1] / 2, END_NODES)))
    return np.unique(np.concatenate((np.searchsorted(m, wanted).clip(0, m.size - 1), [0, m.size - 1])))


def _stretched(m: IntArray) -> FloatArray:
    return np.asarray(np.log(m / (m[-1] + 1.0 - m)))


def _at_nodes(points: CurvePoints) -> CurvePoints:
    return points._replace(m=points.m[np.concatenate([part.places[part.nodes] for part in _parts(points)])])


def _between(points: CurvePoints, values: FloatArray) -> FloatArray:
    """Values at the nodes, in their order, at all points, by their logarithm."""
    result, at = np.empty((*values.shape[:-1], points.m.size)), 0
    for places, nodes, smooth in _parts(points):
        m, here = points.m[places], np.log(values[..., at : at + nodes.size])
        at += nodes.size
        u = _stretched(m) if smooth else np.log(m)
        known, first = np.unique(u[nodes], return_index=True)
        if known.size == 1:
            result[..., places] = np.exp(here[..., :1])
        else:
            result[..., places] = np.exp(valued(known, (cubic if smooth else linear)(known, here[..., first]), u))
    return result
