"""The even grid of the rows, and its interval if samples are missing, late or coarsely stamped.

Intervals are counted, never guessed.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import FloatArray
from allanite.core.validity import Finding
from allanite.phrases.phrase import say

Places = NDArray[np.int64]

RESOLUTIONS = (60.0, 10.0, 1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6)  # time steps, s, in which clocks are read or printed
PART = 10_000  # number of time stamps around the middle of the record that decide between estimates of the interval

STAMPS_AHEAD = (16, 1024, 1024, 1024)
"""Number of time stamps that must stay close to the grid: a wrong interval drifts away within a few."""


@dataclass(frozen=True, eq=False)
class SampleGrid:
    """An even grid of sampling times."""

    interval: float = 0.0  # s, between the first and the last time stamp over the intervals, missing ones included
    rows: Places | None = None  # those kept, in order of time; None: all, in the order of the file
    places: Places | None = None  # of the rows on the grid; None: consecutive
    findings: tuple[Finding, ...] = ()  # defects of the time stamps
    trouble: str = ""  # why they give no rate; empty if they do

    @property
    def lost(self) -> int:
        """Number of grid points without a row."""
        return 0 if self.places is None else int(self.places[-1]) + 1 - self.places.size

    @property
    def history(self) -> tuple[str, ...]:
        """History entries of placing the rows on the grid."""
        lost = (say("{lost} missing samples marked as gaps", lost=self.lost),) if self.lost else ()
        if self.rows is None:
            return lost
        done = say("repeated rows removed") if np.all(np.diff(self.rows) > 0) else say("rows sorted by time stamp")
        return (done, *lost)

    def put(self, values: NDArray[Any]) -> NDArray[Any]:
        """The samples on the grid, NaN where one is missing."""
        kept = values if self.rows is None else values[self.rows]
        if self.places is None or not self.lost:
            return kept
        whole = np.full(kept.size + self.lost, np.nan)
        whole[self.places] = kept
        return whole


ONE_AFTER_THE_OTHER = SampleGrid()  # the default grid, if nothing else is known


def resolution(steps: FloatArray) -> float:
    """The largest typical step of which all steps are multiples; 0 if there is none."""
    ends = steps[steps > 0][:10_000]
    for step in RESOLUTIONS if ends.size else ():
        multiples = ends / step
        if multiples.min() > 0.5 and np.abs(multiples - np.rint(multiples)).max() < 1e-3:
            return step
    return 0.0


class Pace(NamedTuple):
    """An interval in s, the grid position of each row relative to its number, and the remaining deviation."""

    interval: float
    shift: Places
    residual: FloatArray

    @property
    def bursts(self) -> bool:
        """Whether bursts at a steady pace were mistaken for a finer grid, most of which would be missing."""
        size = self.shift.size + int(self.shift[-1])
        return bool(self.shift[-1] > 0.6 * size and (np.diff(self.shift) > 0).mean() > 0.02)


def pace(elapsed: FloatArray, rows: Places, slack: float) -> Pace:
    """The grid of increasing time stamps in s, shape (n,), of rows with these numbers."""
    # Deviations of up to `slack` intervals are not gaps.
    middle = slice(max(0, rows.size // 2 - PART), rows.size // 2 + PART)
    near, where = elapsed[middle], rows[middle]
    steps = np.diff(near) / np.diff(where)
    # the mean of all steps is right if little is missing, that of typical steps if much is, of short ones if most is
    guesses = [float(near[-1] - near[0]) / int(where[-1] - where[0])]
    for usual in (float(np.quantile(steps, share)) for share in (0.5, 0.1)):
        typical = steps[(steps > 0.4 * usual) & (steps < 1.6 * usual)]
        guesses.append(float(typical.mean()) if typical.size else usual)
    paces = [_refined(near, where, guess, slack) for guess in guesses if guess > 0]
    floor = resolution(steps) / math.sqrt(12)
    shortest = min(paces, key=lambda one: _length(one, where, floor))
    return _refined(elapsed, rows, shortest.interval, slack)


def _length(found: Pace, rows: Places, floor: float) -> float:
    """For a description of the time stamps: the deviation beyond their rounding, and the occupied grid points."""
    interval, shift, residual = found
    lost, count = int(shift[-1]), int(rows[-1] - rows[0])
    # any time stamps fit a grid of their own last digit; one step is then no more frequent than two
    if lost > 0.4 * (count + lost) and np.bincount(np.clip(np.diff(rows + shift), 0, 9)).argmax() != 1:
        return math.inf
    off = np.where(np.diff(shift, prepend=0) < 0, 1.0, np.clip(residual, -1, 1))
    scatter = max(interval * float(np.sqrt(np.square(off).mean())), floor, 1e-9 * interval)
    return math.log(scatter) + math.log(max(count + lost, 1))


def _refined(elapsed: FloatArray, rows: Places, interval: float, slack: float) -> Pace:
    """Refine an estimate of the interval with the number of intervals."""
    from allanite.kernels.passing import followed

    span, count = float(elapsed[-1] - elapsed[0]), int(rows[-1] - rows[0])
    for ahead in STAMPS_AHEAD:
        shift, _ = followed(elapsed / interval, rows, ahead, slack)
        counted = count + int(shift[-1])
        if counted < 1 or interval == span / counted:
            break
        interval = span / counted
    return Pace(interval, *followed(elapsed / interval, rows, STAMPS_AHEAD[-1], slack))
