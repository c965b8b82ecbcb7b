"""Where an experiment works best: the plans of all starts."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.errors import UsageError
from allanite.core.plain import Value

from .geometry import QUARTER
from .plans import AnglePlan, AngleSettings, plan

STEP = 300.0
"""Between the starts of a scan, s: finer than anybody schedules, and than the total changes."""


@dataclass(frozen=True, eq=False, repr=False)
class Scan(Value):
    """Expected accuracy by the start of the interval: starts, totals, conditions, shape (k,); h, shape (k, 2), rad.

    `best` is the plan of the window with the smallest total.
    """

    _keys: ClassVar[dict[str, str]] = {"starts": "start", "totals": "total", "conditions": "condition"}

    starts: FloatArray
    totals: FloatArray
    conditions: FloatArray
    h: FloatArray
    best: AnglePlan

    def rows(self) -> tuple[list[str], list[list[float]]]:
        """Headings and rows."""
        columns = (self.starts, *self.h.T, self.totals, self.conditions)
        headings = ["start [s]", "h low [rad]", "h high [rad]", "total", "condition"]
        return headings, [list(row) for row in zip(*(c.tolist() for c in columns), strict=True)]


def scan(settings: AngleSettings, starts: Sequence[float] | None = None) -> Scan:
    """Expected accuracy of every start of the interval, and the best one.

    Parameters
    ----------
    settings : AngleSettings
    starts : sequence of float, optional
        s after h = 0; if left out, every five minutes (half a duration, if that is less) from there until the interval
        reaches the extreme of h, or begins there if it is longer than a quarter of the earth's turn.

    Raises
    ------
    DataError, UnitError, UsageError
        As of `plan`.

    Examples
    --------
    >>> day = scan(AngleSettings(np.radians(60), duration=3600.0, interval=10.0, q_law="linear"))
    >>> np.degrees(day.best.h).round(1).tolist()
    [13.4, 19.8]
    """
    grid = _starts(settings.duration) if starts is None else np.asarray(starts, dtype=np.float64)
    if grid.ndim != 1 or not grid.size or not np.isfinite(grid).all():
        raise UsageError(f"starts are times in s after h = 0, not {starts!r}")
    thin = settings.thinned()
    plans = [plan(thin, float(start)) for start in grid]
    totals = np.array([p.total for p in plans])
    return Scan(
        starts=grid,
        totals=totals,
        conditions=np.array([p.condition for p in plans]),
        h=np.array([p.h for p in plans]),
        best=plan(settings, float(grid[int(totals.argmin())])),
    )


def _starts(duration: float) -> FloatArray:
    step = min(STEP, duration / 2)
    # the last window is the first that reaches the extreme of h
    last = math.ceil((QUARTER - duration) / step) if duration < QUARTER else math.ceil(QUARTER / step)
    return np.asarray(step * np.arange(last + 1), dtype=np.float64)
