"""The even grid under the rows, and its interval where samples are lost, late or coarsely stamped.

Intervals are counted, never guessed.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import FloatArray
from allanite.core.finding import Finding

Places = NDArray[np.int64]

RESOLUTIONS = (60.0, 10.0, 1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6)
"""Steps, s, in which clocks are read or printed."""

PART = 10_000
"""Stamps, either way from the middle, that decide between guesses of the interval."""

AHEAD = (16, 1024, 1024, 1024)
"""Stamps that must keep a departure: a guess that is off drifts away within a few, a refined one does not."""


@dataclass(frozen=True, eq=False)
class Grid:
    """An even grid under the rows.

    `interval` is the time in s between the first stamp and the last over the intervals between them, lost ones
    counted. `rows` are those that are kept, in the order of time (None: all, in the order of the file), `places` where
    they stand on the grid (None: one after the other). `findings` say what is wrong with the stamps, `trouble` why
    they give no rate (empty: they do).

    Examples
    --------
    >>> grid = Grid(0.01, places=np.array([0, 1, 3]))
    >>> grid.lost, grid.put(np.array([5.0, 6.0, 7.0]))
    (1, array([ 5.,  6., nan,  7.]))
    """

    interval: float = 0.0
    rows: Places | None = None
    places: Places | None = None
    findings: tuple[Finding, ...] = ()
    trouble: str = ""

    @property
    def lost(self) -> int:
        """Number of places without a row."""
        return 0 if self.places is None else int(self.places[-1]) + 1 - self.places.size

    @property
    def history(self) -> tuple[str, ...]:
        """What putting rows on the grid does to a record."""
        lost = (f"{self.lost} lost readings marked as gaps",) if self.lost else ()
        if self.rows is None:
            return lost
        done = "repeated rows left out" if np.all(np.diff(self.rows) > 0) else "rows put in the order of their stamps"
        return (done, *lost)

    def put(self, values: NDArray[Any]) -> NDArray[Any]:
        """The readings on the grid, NaN where one is lost."""
        kept = values if self.rows is None else values[self.rows]
        if self.places is None or not self.lost:
            return kept
        whole = np.full(kept.size + self.lost, np.nan)
        whole[self.places] = kept
        return whole


ONE_AFTER_THE_OTHER = Grid()
"""What is supposed where nothing tells more."""


def resolution(steps: FloatArray) -> float:
    """The largest usual step of which all steps are multiples; 0 if there is none.

    Examples
    --------
    >>> resolution(np.array([0.002, 0.003, 0.0, 0.002])), resolution(np.ones(3) / 7)
    (0.001, 0.0)
    """
    ends = steps[steps > 0][:10_000]
    for step in RESOLUTIONS if ends.size else ():
        multiples = ends / step
        if multiples.min() > 0.5 and np.abs(multiples - np.rint(multiples)).max() < 1e-3:
            return step
    return 0.0


class Pace(NamedTuple):
    """An interval in s, how many intervals the clock is ahead of each row, and what is left of its departure."""

    interval: float
    shift: Places
    left: FloatArray

    @property
    def bursts(self) -> bool:
        """Whether bursts at a steady pace were taken for a finer grid, of which most is missing time and again."""
        size = self.shift.size + int(self.shift[-1])
        return bool(self.shift[-1] > 0.6 * size and (np.diff(self.shift) > 0).mean() > 0.02)


def pace(elapsed: FloatArray, rows: Places, slack: float) -> Pace:
    """The pace of rising stamps in s, shape (n,), of rows with those numbers; `slack` intervals off are no loss."""
    middle = slice(max(0, rows.size // 2 - PART), rows.size // 2 + PART)
    return _refined(elapsed, rows, _interval(elapsed[middle], rows[middle], slack), slack)


def _interval(elapsed: FloatArray, rows: Places, slack: float) -> float:
    """The interval by which stamps are described in the shortest way."""
    steps = np.diff(elapsed) / np.diff(rows)
    mean = float(elapsed[-1] - elapsed[0]) / int(rows[-1] - rows[0])
    # the mean of all is right where little is lost, that of the usual steps where much is, of the short where most is
    guesses = (mean, *(_mean_near(steps, float(np.quantile(steps, q))) for q in (0.5, 0.1)))
    found = [_refined(elapsed, rows, guess, slack) for guess in guesses if guess > 0]
    floor = resolution(steps) / math.sqrt(12)
    return min(found, key=lambda one: _length(one, rows, floor)).interval


def _length(found: Pace, rows: Places, floor: float) -> float:
    """Of a description of the stamps: what is left beyond their rounding, and which places of the grid are taken."""
    interval, shift, left = found
    lost, count = int(shift[-1]), int(rows[-1] - rows[0])
    # any stamps fit a grid of their own last digit; one step is then no more usual than two
    if lost > 0.4 * (count + lost) and np.bincount(np.clip(np.diff(rows + shift), 0, 9)).argmax() != 1:
        return math.inf
    off = np.where(np.diff(shift, prepend=0) < 0, 1.0, np.clip(left, -1, 1))
    residual = max(interval * float(np.sqrt(np.square(off).mean())), floor, 1e-9 * interval)
    return math.log(residual) + math.log(max(count + lost, 1))


def _mean_near(steps: FloatArray, usual: float) -> float:
    near = steps[(steps > 0.4 * usual) & (steps < 1.6 * usual)]
    return float(near.mean()) if near.size else usual


def _refined(elapsed: FloatArray, rows: Places, interval: float, slack: float) -> Pace:
    """From a guess of the interval to the one that the count of intervals gives."""
    from allanite.kernels.clock import followed

    span, count = float(elapsed[-1] - elapsed[0]), int(rows[-1] - rows[0])
    for ahead in AHEAD:
        shift, _ = followed(elapsed / interval, rows, ahead, slack)
        counted = count + int(shift[-1])
        if counted < 1 or interval == span / counted:
            break
        interval = span / counted
    return Pace(interval, *followed(elapsed / interval, rows, AHEAD[-1], slack))
