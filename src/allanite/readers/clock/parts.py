"""The clock of a file that is read in parts: the grid of each part follows that of the last one."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError
from allanite.core.validity import Finding
from allanite.phrases.phrase import say
from allanite.readers.columns.table import repeated

from .clocks import unwrapped
from .findings import DRIFT, PARTS, Holes, Places, SampleGrid, drifting
from .sampling_rate import Beat, Stamped, settled
from .stamps import Damage, fit, mended, seconds_since

LEAST_ROWS = 1024  # rows of a part whose interval is found anew; in fewer rows, that of the head is used
LONG = 1 << 16  # missing samples at one place that are passed over, not stored as NaN

Piece = tuple[int, list[NDArray[Any]]]  # missing samples before a piece, and the samples of each column


@dataclass
class Clock:
    """Places the rows of successive parts on one grid; `beat` is what the whole says at the end."""

    head: Stamped | Beat  # the time stamps of the first rows, or the beat where there are none
    interval: float = 0.0
    rows: int = 0
    place: int = 0
    elapsed: float = 0.0
    parts: int = 0

    def __post_init__(self) -> None:
        self._holes, self._damage = Holes(), Damage()
        self._last: list[NDArray[Any]] = []
        self._found: dict[str, tuple[Finding, int]] = {}
        self._marks: list[tuple[int, float]] = []
        self._trouble = ""

    @property
    def stamped(self) -> bool:
        """Whether there are time stamps."""
        return isinstance(self.head, Stamped)

    @property
    def size(self) -> int:
        """Number of samples so far, missing ones included."""
        return self.place + 1 if self.stamped and not self._trouble else self.rows

    def pieces(self, columns: list[NDArray[Any]]) -> Iterator[Piece]:
        """The samples of a part on the grid; with time stamps, these are the first of the columns."""
        self.parts += 1
        rows = len(columns[0])
        if isinstance(self.head, Beat):
            yield 0, columns
        else:
            yield from self._stamped(self.head, columns)
        self.rows += rows

    def beat(self) -> Beat:
        """The rate, start, notes and findings of the whole."""
        if isinstance(self.head, Beat):
            return self.head
        if self._trouble:
            return settled(self.head, SampleGrid(trouble=self._trouble), 0)
        interval = self.interval if self.parts == 1 else self.elapsed / self.place
        lost = (self._lost(interval),) if self._holes.count else ()
        findings = (*self._damage.findings(self.head.column.label), *lost,
                 *(self._words(*counted) for counted in self._found.values()), *self._drift())  # fmt: skip
        return settled(self.head, SampleGrid(interval, findings=findings), self._holes.lost)

    @property
    def history(self) -> tuple[str, ...]:
        """History entry of placing the rows on the grid."""
        return (say("{lost} missing samples marked as gaps", lost=self._holes.lost),) if self._holes.lost else ()

    def _stamped(self, head: Stamped, columns: list[NDArray[Any]]) -> Iterator[Piece]:
        if not self._last and len(columns[0]) < 2:
            raise DataError(say("the first part of the file has fewer than 2 rows"))
        joined = [np.concatenate(both) for both in zip(self._last, columns, strict=True)] if self._last else columns
        known = int(bool(self._last))
        grid = self._grid(head, joined)
        if grid is None:
            yield 0, columns[1:]
            return
        rows = np.arange(len(joined[0])) if grid.rows is None else grid.rows
        self._last = [values[rows[-1:]] for values in joined]
        places = np.arange(rows.size) if grid.places is None else grid.places
        yield from _pieces(grid, places, joined[1:], known)
        self.place += int(places[-1])
        self._marks.append((self.place, self.elapsed))

    def _grid(self, head: Stamped, columns: list[NDArray[Any]]) -> SampleGrid | None:
        """The grid of a part that begins with the last row before; None where the stamps give none and a rate does."""
        if self._trouble:
            return None
        known = int(bool(self._last))
        stamps, damaged = mended(columns[0], known)
        self._damage.add(damaged, columns[0], self.rows - known)
        columns[0] = stamps
        elapsed = seconds_since(unwrapped(stamps)[0], head.unit)
        grid = self._short(elapsed) or fit(elapsed, head.column.label, lambda: repeated(columns[1:]))
        first = grid.rows is None or not grid.rows.size or int(grid.rows[0]) == 0
        if not grid.trouble and not first:
            grid = replace(grid, trouble=say("rows are out of order over more than a part of the file"))
        for defect in grid.findings:
            if defect.name != "missing samples":
                before, count = self._found.get(defect.name, (self._at(defect), 0))
                self._found[defect.name] = (before, count + 1)
        if grid.trouble:
            self._trouble = say("from row {row} on: {what}", row=self.rows + 1, what=grid.trouble)
            self.beat()  # an error, unless the rate is given
            return None
        if grid.places is not None:
            self._holes.seen(grid.places, self.place)
        self.elapsed += float(elapsed[-1 if grid.rows is None else grid.rows[-1]])
        self.interval = self.interval or grid.interval
        return grid

    def _short(self, elapsed: NDArray[np.float64]) -> SampleGrid | None:
        """The grid of a few rows, whose interval is known."""
        steps = np.diff(elapsed)
        if len(elapsed) >= LEAST_ROWS or not self.interval or not np.all(steps > 0):
            return None
        places = np.concatenate(([0], np.cumsum(np.maximum(1, np.rint(steps / self.interval)))))
        return SampleGrid(self.interval, None, places.astype(np.int64))

    def _at(self, one: Finding) -> Finding:
        if self.parts == 1:
            return one
        return replace(one, what=say("from row {row} on: {what}", row=self.rows + 1, what=one.what))

    def _words(self, one: Finding, count: int) -> Finding:
        if self.parts == 1:
            return one
        what = say("{what} (in {count} of {parts} parts of the file)", what=one.what, count=count, parts=self.parts)
        return replace(one, what=what, place=None)

    def _lost(self, interval: float) -> Finding:
        label = self.head.column.label if isinstance(self.head, Stamped) else ""
        self._holes.size = self.place + 1
        return self._holes.finding(interval, say("according to the time stamps of {column}", column=label))

    def _drift(self) -> tuple[Finding, ...]:
        """A rate that differs between sixteenths of the file by more than the noise coefficients allow."""
        if len(self._marks) < PARTS + 1:
            return ()
        marks = np.array(self._marks, dtype=np.float64)  # of parts that may be short, where the file grows
        even = np.linspace(float(marks[0, 0]), float(marks[-1, 0]), PARTS + 1)
        places, elapsed = marks[np.unique(np.searchsorted(marks[:, 0], even, "right") - 1)].T
        rates = np.diff(places) / np.diff(elapsed)
        change = float(np.ptp(rates) / rates.mean())
        if change < DRIFT or isinstance(self.head, Beat):
            return ()
        return (drifting(self.head.column.label, change),)


def _pieces(grid: SampleGrid, places: Places, columns: Sequence[NDArray[Any]], known: int) -> Iterator[Piece]:
    """The samples between long gaps, without the first `known` row, with NaN for what is missing in short ones."""
    kept = columns if grid.rows is None else [values[grid.rows] for values in columns]
    if not grid.lost:
        yield 0, [values[known:] for values in kept]
        return
    gaps = np.diff(places)
    cuts = np.flatnonzero(gaps > LONG) + 1
    begin, lost = 0, 0
    for end in (*cuts.tolist(), places.size):
        where = places[begin:end] - places[begin]
        skip = known if begin == 0 else 0
        yield lost, [_put(values[begin:end], where)[skip:] for values in kept]
        lost = int(gaps[end - 1]) - 1 if end < places.size else 0
        begin = end


def _put(values: NDArray[Any], where: Places) -> NDArray[Any]:
    whole = np.full(int(where[-1]) + 1, np.nan)
    whole[where] = values
    return whole
