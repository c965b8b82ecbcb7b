"""Where an experiment works best: the plans of all starts."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import UsageError

from .design import USUAL, Orders
from .estimate import Prior
from .gimbals import QUARTER
from .plan import Plan, Setup, planned
from .sway import Sway, sway_of

FloatArray = NDArray[np.float64]

STEP = 300.0
"""Between the starts of a scan, s: finer than anybody schedules, and than the total changes."""


@dataclass(frozen=True, eq=False)
class Scan:
    """Expected accuracy by the start of the interval: starts, totals, conditions, shape (k,); h, shape (k, 2), rad.

    `best` is the plan of the window with the smallest total.
    """

    starts: FloatArray
    totals: FloatArray
    conditions: FloatArray
    h: FloatArray
    best: Plan

    def rows(self) -> tuple[list[str], list[list[float]]]:
        """Headings and rows."""
        columns = (self.starts, *self.h.T, self.totals, self.conditions)
        headings = ["start [s]", "h low [rad]", "h high [rad]", "total", "condition"]
        return headings, [list(row) for row in zip(*(c.tolist() for c in columns), strict=True)]

    def to_dict(self) -> dict[str, Any]:
        """Plain data; angles in rad, times in s."""
        return {
            "allanite": 1,
            "type": "Scan",
            "start": self.starts.tolist(),
            "total": self.totals.tolist(),
            "condition": self.conditions.tolist(),
            "h": self.h.tolist(),
            "best": self.best.to_dict(),
        }


def scan(  # noqa: PLR0913 - every choice of an experiment, each with its name
    *,
    latitude: float,
    duration: float,
    interval: float,
    starts: Sequence[float] | None = None,
    sigma: float = 1.0,
    q_law: str = "exact",
    turn_period: float | None = 300.0,
    sway: Sway | tuple[float, float] | None = None,
    prior: Prior | None = (3.0, 10.0),
    orders: Orders = (128, 256),
    nuisance: Sequence[str] = USUAL,
) -> Scan:
    """Expected accuracy of every start of the interval, and the best one.

    Parameters
    ----------
    starts : sequence of float, optional
        s after h = 0; if left out, every five minutes (half a duration, if that is less) from there until the interval
        reaches the extreme of h, or begins there if it is longer than a quarter of the earth's turn.

    The others, and the errors, are those of `plan`.

    Examples
    --------
    >>> day = scan(latitude=np.radians(60), duration=3600.0, interval=10.0, q_law="linear")
    >>> np.degrees(day.best.h).round(1).tolist()
    [13.4, 19.8]
    """
    setup = Setup(latitude, duration, interval, sigma, q_law, turn_period, sway_of(sway), prior, orders, nuisance)
    grid = _starts(duration) if starts is None else np.asarray(starts, dtype=np.float64)
    if grid.ndim != 1 or not grid.size or not np.isfinite(grid).all():
        raise UsageError(f"starts are times in s after h = 0, not {starts!r}")
    thin = setup.thinned()
    plans = [planned(thin, float(start)) for start in grid]
    totals = np.array([p.total for p in plans])
    return Scan(
        starts=grid,
        totals=totals,
        conditions=np.array([p.condition for p in plans]),
        h=np.array([p.h for p in plans]),
        best=planned(setup, float(grid[int(totals.argmin())])),
    )


def _starts(duration: float) -> FloatArray:
    step = min(STEP, duration / 2)
    # the last window is the first that reaches the extreme of h
    last = math.ceil((QUARTER - duration) / step) if duration < QUARTER else math.ceil(QUARTER / step)
    return np.asarray(step * np.arange(last + 1), dtype=np.float64)
