"""Lone time stamps that are far off, as by a lost digit, while their neighbours are evenly spaced without them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.finding import Finding
from allanite.phrases.phrase import say_count

from .findings import finding
from .grid import Places
from .stamps import EVEN

FAR = 3.0
"""Distance of a stamp from the middle of its neighbours, in intervals, above which it is damaged: no logger is so late
with one row and in time with the next."""

RARE = 0.01
"""Share of rows, at most, that are damaged: a clock with more of them is not one that is otherwise even."""

FEWEST = 10
"""Rows from which on it is known what the usual interval is."""


@np.errstate(all="ignore")  # of stamps that no clock counts
def mended(stamps: NDArray[Any], known: int = 0) -> tuple[NDArray[Any], Places]:
    """The stamps with damaged ones set by their neighbours, and the rows of these, from 0; the `known` first are sound.

    Examples
    --------
    >>> mended(np.array([10, 20, 30, 40, 5, 60, 70, 80, 90, 100]))
    (array([ 10,  20,  30,  40,  50,  60,  70,  80,  90, 100]), array([4]))
    """
    size, none = len(stamps), np.zeros(0, dtype=np.int64)
    if size < FEWEST:
        return stamps, none
    t = stamps.astype(np.float64)
    steps = np.diff(t)
    back = np.flatnonzero(steps < 0)
    # the first step and the last may be gaps, unless they are longer than the rest
    jumps = [0] * bool(steps[0] > t[-1] - t[1]) + [size - 1] * bool(steps[-1] > t[-2] - t[0])
    k = np.unique(np.concatenate((back, back + 1, np.array(jumps, dtype=np.int64))))
    k = k[k >= known]
    if not k.size or back.size > max(2, RARE * size):
        return stamps, none
    typical = np.argpartition(steps, steps.size // 2)[steps.size // 2]
    usual, end = steps[typical], (k == 0) | (k == size - 1)
    near = np.where(k == 0, 1, k - 1)
    other = np.where(end, 2 * near - k, k + 1)
    even = np.abs(np.abs(t[other] - t[near]) - np.where(end, 1, 2) * usual) <= EVEN * usual
    expected = np.where(end, 2 * t[near] - t[other], (t[near] + t[other]) / 2)
    k = k[even & (np.abs(t[k] - expected) > FAR * usual)]
    step, whole = stamps[typical + 1] - stamps[typical], stamps.copy()  # a step that the clock can show
    whole[k] = np.where(k == 0, stamps[1] - step, stamps[k - 1] + step)
    return whole, k


class Damage:
    """Damaged stamps of a file that is read in parts: how many, the row of the first, from 0, and what it was."""

    def __init__(self) -> None:
        self.count = self.row = 0
        self.value: Any = None

    def add(self, rows: Places, stamps: NDArray[Any], begin: int = 0) -> "Damage":
        """Add those in these rows of a part, whose first row is number `begin`."""
        if rows.size and not self.count:
            self.row, self.value = begin + int(rows[0]), stamps[rows[0]]
        self.count += rows.size
        return self

    def findings(self, label: str) -> tuple[Finding, ...]:
        """The finding about them, if there are any."""
        what = say_count(
            self.count,
            "{count} time stamp of {column} is damaged, {value} in row {row} of the data: its neighbours are evenly "
            "spaced without it",
            "{count} time stamps of {column} are damaged, the first, {value}, in row {row} of the data: their "
            "neighbours are evenly spaced without them",
            column=label, row=self.row + 1, value=self.value,
        )  # fmt: skip
        return (finding("damaged time stamps", what),) if self.count else ()
