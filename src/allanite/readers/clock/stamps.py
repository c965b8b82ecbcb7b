"""From time stamps to the grid of sampling times, and to their defects."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import FloatArray, complete
from allanite.core.units import unit_of
from allanite.core.validity import Finding
from allanite.phrases.phrase import say, say_count

from .findings import (  # isort: skip
    Places, SampleGrid, Stamps, bursty, drift, duplicates, duration, finding, largest, lost_samples, pace, unsteady
)  # fmt: skip

FAR = 3.0
"""Distance of a stamp from the middle of its neighbours, in intervals, above which it is damaged: no logger is so late
with one row and in time with the next."""

RARE = 0.01  # share of rows, at most, that are damaged: a clock with more of them is not one that is otherwise even
FEWEST_STAMPS = 10  # rows from which on it is known what the usual interval is


UNORDERED = 0.3  # share of steps that are negative, above which a column is no clock


@np.errstate(all="ignore")  # of stamps that no clock counts
def mended(stamps: NDArray[Any], known: int = 0) -> tuple[NDArray[Any], Places]:
    """The stamps with damaged ones set by their neighbours, and the rows of these; the `known` first are sound."""
    size, none = len(stamps), np.zeros(0, dtype=np.int64)
    if size < FEWEST_STAMPS:
        return stamps, none
    t = stamps.astype(np.float64, copy=False)
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
        what = say_count(self.count,
                         "{count} time stamp of {column} is damaged, {value} in row {row} of the data: its neighbours "
                         "are evenly spaced without it",
                         "{count} time stamps of {column} are damaged, the first, {value}, in row {row} of the data: "
                         "their neighbours are evenly spaced without them",
                         column=label, row=self.row + 1, value=self.value)  # fmt: skip
        return (finding("damaged time stamps", what),) if self.count else ()


EVEN = 0.5  # deviation from an even grid, in intervals, below which no gaps are looked for
BURSTY = 1.5  # ratio of the mean to the median interval, or its inverse, above which time stamps are called bursty
PAUSE = 20.0  # steps of a bursty clock, relative to its long ones (one in a hundred), that are gaps rather than bursts
TICKS = 0.2  # share of repeated time stamps above which rows are counted between changes

MOST_LOST = 0.9
"""Share of missing samples above which time stamps are not trusted: a clock that was set leaves such gaps."""

LONGEST_TIME = 1e15
"""Seconds by which the time stamps of a recording differ at most; beyond, no clock has counted them, nor float64."""


def seconds_since(stamps: NDArray[Any], unit: str) -> FloatArray:
    """Seconds since the first time stamp; integers are subtracted as such, since epoch nanoseconds exceed float64."""
    with np.errstate(all="ignore"):  # values that are not finite are refused by `fit`
        elapsed: FloatArray = (stamps - stamps[0]).astype(np.float64, copy=False)
        elapsed *= unit_of(unit).factor
        return elapsed


def fit(elapsed: FloatArray, label: str, repeated: Callable[[], NDArray[np.bool_]]) -> SampleGrid:
    """The grid of time stamps in seconds since the first, shape (n,); `label` is their column in messages."""
    # `repeated` marks rows with the same samples as the row before, shape (n - 1,) or (1,); called only if time stamps
    # repeat.
    if not complete(elapsed) and (bad := ~np.isfinite(elapsed)).any():
        where = say("the first in row {row} of the data", row=int(np.argmax(bad)) + 1)
        return SampleGrid(trouble=say("{column} has no time stamp in {count} of {size} rows, {where}", column=label,
                                      count=int(bad.sum()), size=bad.size, where=where))  # fmt: skip
    if largest(elapsed) > LONGEST_TIME:
        row = int(np.argmax(np.abs(elapsed[1:] / 2 - elapsed[:-1] / 2)))  # halves, whose difference is finite
        step = 2 * (elapsed[row + 1] / 2 - elapsed[row] / 2)
        return SampleGrid(trouble=say("the time stamps of {column} jump by {step:.3g} s before row {row} of the data",
                                      column=label, step=step, row=row + 2))  # fmt: skip
    stamps = Stamps(elapsed, label)
    if not stamps.steps.any():
        what = say("all time stamps of {column} are equal", column=label)
        return SampleGrid(findings=(finding("constant time stamps", what),), trouble=what)
    equal = stamps.equal
    if equal.any() and bool(np.broadcast_to(repeated(), equal.shape)[equal].all()):
        # some rows are written twice
        rows = np.flatnonzero(np.concatenate(([True], ~equal)))
        grid = fit(elapsed[rows], label, lambda: np.zeros(1, dtype=bool))
        first = int(np.argmin(np.append(rows, -1) == np.arange(rows.size + 1)))
        what = say_count(
            elapsed.size - rows.size,
            "{count} row is identical to the previous one, time stamp and samples, the first in row {row} of the data",
            "{count} rows are identical to the previous one, time stamp and samples, the first in row {row} of the "
            "data", row=first + 1,
        )  # fmt: skip
        duplicate = finding("duplicate time stamps", what, consequence=say("each is used once"))
        return replace(grid, rows=rows if grid.rows is None else rows[grid.rows], findings=(duplicate, *grid.findings))
    return _reversed(stamps) if stamps.steps.min() < 0 else _forward(stamps)


def _reversed(stamps: Stamps) -> SampleGrid:
    """Rows out of order, jitter beyond the interval, or a clock that was set."""
    back = stamps.steps < 0
    first = int(np.argmax(back))
    what = say_count(
        int(back.sum()),
        "{count} time stamp of {column} is earlier than the previous one, the first in row {row} of the data by {step}",
        "{count} time stamps of {column} are earlier than the previous one, the first in row {row} of the data by "
        "{step}",
        column=stamps.label, row=first + 2, step=duration(-float(stamps.steps[first])),
    )  # fmt: skip
    if back.all():
        what = say("the rows are in reverse order by the time stamps of {column}", column=stamps.label)
        return SampleGrid(findings=(finding("reversed time stamps", what),), trouble=what)
    order = np.argsort(stamps.elapsed, kind="stable")
    ordered = Stamps(stamps.elapsed[order] - stamps.elapsed[order[0]], stamps.label)
    grid = None if ordered.steps.min() < 0.3 * float(np.median(ordered.steps)) else _forward(ordered)
    doubtful = {"jitter", "bursty time stamps", "coarse time stamps"}
    # the grid may show that this order is right
    if grid is not None and not grid.trouble and doubtful.isdisjoint(defect.name for defect in grid.findings):
        sorted_rows = say("sorted, they are evenly spaced: the rows were out of order and have been sorted by time")
        reversed_stamps = finding("reversed time stamps", what, consequence=sorted_rows, remedy=say("check the logger"))
        return replace(grid, rows=order, findings=(reversed_stamps, *grid.findings))
    if stamps.mean > 0 and -stamps.steps.min() < 10 * stamps.mean and np.abs(stamps.departure).max() < 20:
        return SampleGrid(stamps.mean, findings=(finding("reversed time stamps", what),))
    why = say("{what}: a clock that was set, two recordings in one file, or rows out of order", what=what)
    if back.mean() > UNORDERED:
        why = say("{column} is a signal, not time", column=stamps.label)
    return SampleGrid(findings=(finding("reversed time stamps", why),), trouble=why)


def _forward(stamps: Stamps) -> SampleGrid:
    """The grid of time stamps that never decrease."""
    if stamps.equal.sum() >= TICKS * stamps.steps.size:
        return _in_ticks(stamps)
    again, mean = duplicates(stamps), stamps.mean
    even = SampleGrid(mean, findings=(*again, *unsteady(stamps, stamps.departure, mean)))
    if largest(stamps.departure) <= EVEN and stamps.steps.max() < (1 + EVEN) * mean:
        return even
    rows = np.arange(stamps.elapsed.size)
    fitted = pace(stamps.elapsed, rows, EVEN)
    if fitted.bursts or float((np.abs(fitted.residual) > EVEN).mean()) > 0.05:
        steady = 1 / BURSTY < mean / float(np.median(stamps.steps)) < BURSTY
        long = PAUSE * float(np.quantile(stamps.steps, 0.99))
        if steady or stamps.steps.max() <= long:
            return even if steady else SampleGrid(mean, findings=(*again, bursty(stamps, mean)))
        # the samples missing in pauses that bursts do not explain
        kept = pace(stamps.elapsed, rows, long / mean)
        return _with_losses(stamps, kept.interval, rows + kept.shift, (*again, bursty(stamps, kept.interval)))
    places = rows + fitted.shift
    wander = drift(stamps, stamps.elapsed / fitted.interval - places)
    scatter = tuple(defect for defect in unsteady(stamps, fitted.residual, fitted.interval) if defect.name == "jitter")
    return _with_losses(stamps, fitted.interval, places, (*again, *scatter, *wander))


def _in_ticks(stamps: Stamps) -> SampleGrid:
    """The grid of time stamps with many equal ones: the rows at which they change are counted."""
    elapsed, label = stamps.elapsed, stamps.label
    changes = np.flatnonzero(stamps.steps > 0) + 1
    if changes.size < 3:
        what = say("the time stamps of {column} change {count} times in {size} rows",
                   column=label, count=changes.size, size=elapsed.size)  # fmt: skip
        coarse = finding("coarse time stamps", what)
        return SampleGrid(findings=(coarse,), trouble=say("{what}: too coarse for the rate", what=what))
    fitted = pace(elapsed[changes], changes, 1 + EVEN)
    each = f"{elapsed.size / (changes.size + 1):.3g}"
    if stamps.resolution > 0.5 * fitted.interval and not fitted.bursts:
        what = say("time stamps with a resolution of {length} in {column}, {each} rows per step",
                   length=duration(stamps.resolution), column=label, each=each)  # fmt: skip
        coarse = finding("coarse time stamps", what)
    else:
        what = say("bursty time stamps in {column}: groups of {each} equal ones", column=label, each=each)
        coarse = finding("bursty time stamps", what)
    if fitted.bursts or float((np.abs(fitted.residual) > 1 + EVEN).mean()) > 0.05:
        span = float(elapsed[changes[-1]] - elapsed[changes[0]])
        return SampleGrid(span / int(changes[-1] - changes[0]), findings=(coarse,))
    ahead = np.zeros(elapsed.size, dtype=np.int64)
    ahead[changes] = np.diff(fitted.shift, prepend=0)
    places = np.arange(elapsed.size) + np.cumsum(ahead)
    wander = drift(stamps, elapsed[changes] / fitted.interval - places[changes])
    return _with_losses(stamps, fitted.interval, places, (coarse, *wander))


def _with_losses(stamps: Stamps, interval: float, places: Places, found: tuple[Finding, ...]) -> SampleGrid:
    """The grid with its gaps, unless they are implausible."""
    gaps = np.diff(places)
    if gaps.min() < 1:
        what = say("up to row {row} of the data there are more rows than the time stamps of {column} allow",
                   row=int(np.argmin(gaps)) + 2, column=stamps.label)  # fmt: skip
        return SampleGrid(findings=(*found, finding("duplicate time stamps", what)), trouble=what)
    lost, row = int(places[-1]) + 1 - places.size, int(np.argmax(gaps))
    if lost > MOST_LOST * places[-1]:
        what = say("the time stamps of {column} jump by {step:.6g} s before row {row} of the data, and {share:.4g} % "
                   "of all samples would be missing: the clock was set, or the logger was stopped", column=stamps.label,
                   step=stamps.steps[row], row=row + 2, share=100 * lost / int(places[-1]))  # fmt: skip
        ignored = say("the rows are assumed to be evenly spaced, the jump is ignored")
        return SampleGrid(findings=(*found, finding("missing samples", what, consequence=ignored)), trouble=what)
    if not lost:
        return SampleGrid(interval, findings=found)
    source = say("according to the time stamps of {column}", column=stamps.label)
    return SampleGrid(interval, None, places, (lost_samples(places, interval, source), *found))
