"""Two torquers of one rotor: the rates about both axes from both currents, with cross-coupling."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from allanite.extending import DataError, Record, Recording, UsageError, say, unit_of

from .stage import Stage, demand_unclipped

NAMES = ("wx", "wy")
"""Channels of the rates about x and y."""


class Mixed(NamedTuple):
    """The current that a torquer of one axis would have needed, and its scale over that of a torquer.

    `clipped` counts the samples of both currents at the ends of each stage, which cannot be seen in their sum.
    """

    record: Record
    gain: float
    clipped: tuple[int, ...]


def demand_axes(axes: Sequence[float]) -> tuple[float, float, float, float]:
    """The matrix (xx, xy, yx, yy), once it is one that tells both rates."""
    if len(axes) != 4 or not all(math.isfinite(v) for v in axes):
        raise UsageError(
            f"the axes of two torquers are four numbers XX,XY,YX,YY, for example 0,-1,1,0, not {list(axes)!r}"
        )
    xx, xy, yx, yy = (float(v) for v in axes)
    if abs(xx * yy - xy * yx) <= 1e-9 * math.hypot(xx, xy) * math.hypot(yx, yy):
        raise UsageError(f"the axes {list(axes)!r} give both rates from the same current: the matrix is singular")
    return xx, xy, yx, yy


def mixed(currents: Recording, axes: Sequence[float], stages: Sequence[Stage] = ()) -> tuple[Mixed, Mixed]:
    r"""Combine the currents of the x and the y torquer.

    A torque about x turns the momentum of the rotor about y. With the scale K_i of one torquer

        (w_x, w_y)' = K_i [[xx, xy], [yx, yy]] (i_x, i_y)'

    where an ideal pair has 0, -1, 1, 0, signs by the winding, and cross-coupling stands in the diagonal. Each row is
    given as a current of unit weight and its length, so that rounding errors of both converters, which are independent
    and alike, are those of one converter of that scale.

    Examples
    --------
    >>> x = Record([1.0, 2.0, 3.0], rate=10.0, unit="mA", name="ix")
    >>> y = Record([0.5, 0.0, 0.5], rate=10.0, unit="mA", name="iy")
    >>> about_x, about_y = mixed(Recording((x, y)), (0, -1, 2, 0))
    >>> about_x.record.values.tolist(), about_y.record.values.tolist(), about_y.gain
    ([-0.5, 0.0, -0.5], [1.0, 2.0, 3.0], 2.0)
    """
    xx, xy, yx, yy = demand_axes(axes)
    names = ", ".join(repr(record.name) for record in currents)
    if len(currents.records) != 2:
        raise DataError(say("the axes of two torquers need two currents, but there are {channels}", channels=names))
    first, second = currents
    if first.signal is not second.signal or first.signal.inertial:
        raise DataError(say("the axes of two torquers need two currents of one kind, not {channels}", channels=names))
    clipped = tuple(demand_unclipped(first, stage) + demand_unclipped(second, stage) for stage in stages)
    x, y = (record.rate_values / unit_of(first.unit).factor for record in currents)
    found = []
    for name, row in zip(NAMES, ((xx, xy), (yx, yy)), strict=True):
        gain = math.hypot(*row)
        said = say("{x:.6g} of {first!r} and {y:.6g} of {second!r}", x=row[0], y=row[1], first=first.name,
                   second=second.name)  # fmt: skip
        values = np.asarray((row[0] * x + row[1] * y) / gain + 0.0)
        record = Record(values, first.rate, first.unit, name=name, start=first.start, history=(*first.history, said))
        found.append(Mixed(record, gain, clipped))
    return found[0], found[1]
