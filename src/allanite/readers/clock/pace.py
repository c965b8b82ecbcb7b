"""The interval of a clock that loses samples, comes late or is read coarsely: intervals are counted, never guessed."""

import math
from typing import NamedTuple

import numpy as np

from allanite.core.arrays import FloatArray

from .findings import resolution
from .grid import Places

PART = 10_000
"""Stamps, either way from the middle, that decide between guesses of the interval."""

AHEAD = (16, 1024, 1024, 1024)
"""Stamps that must keep a departure: a guess that is off drifts away within a few, a refined one does not."""


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
    """The pace of stamps that rise.

    Parameters
    ----------
    elapsed : array, shape (n,)
        Stamps, s.
    rows : array of int, shape (n,)
        Numbers of their rows.
    slack : float
        Intervals by which a stamp may be off without a loss.
    """
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
