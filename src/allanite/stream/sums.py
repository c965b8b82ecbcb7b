"""The sums of a stream, to which stretches of samples and later parts of the stream are added."""

import math
from typing import TYPE_CHECKING

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.statistics.estimator import stretches
from allanite.statistics.row import Statistic

from .cells import Cells
from .lapped import folded

if TYPE_CHECKING:
    from allanite.kernels.ladder import State

TAIL = {2: 32, 3: 48}
"""Cells that are kept of each end of a level, by the order of the differences: 15 of them, and a segment."""

BLOCK = 1 << 16
"""Samples that are taken at a time, while the cache has them."""


class Sums:
    """The sums of the differences of a statistic over samples `begins` .. `stop` of a stream.

    Samples are added less the first of them, `constant`, of which the sums do not depend. `size` is their number
    without missing ones; `cells` are the sums over longer times that the coefficients need. `led` says whether a point
    stands before the first sample, with which differences of the running sum of the angle begin.
    """

    def __init__(self, row: Statistic, start: int) -> None:
        from allanite.kernels.ladder import HOP

        self.row = row
        self.state = self._empty()
        self.shape = row.differences, folded(HOP)
        self.cells = Cells()
        self.start = self.begins = self.stop = start
        self.size = 0
        self.constant = 0.0
        self.led = False

    @property
    def nbytes(self) -> int:
        """Size of what is kept."""
        return sum(array.nbytes for array in (*self.state, self.cells.total, self.cells.count))

    def push(self, values: FloatArray) -> None:
        """Add samples, or the stretches of them without missing ones."""
        for at in range(0, values.size, BLOCK):
            block = values[at : at + BLOCK]
            if not self._add(block):
                begin = self.stop
                for a, b in stretches(block):
                    self.stop = begin + a
                    self._add(block[a:b])
                self.stop = begin + block.size

    def merge(self, other: "Sums") -> None:
        """Add those of a later part of the stream, which are changed."""
        from allanite.kernels.streamed import apart, join

        if other.size:
            end = int(self.state.at[0]) - self.row.summed  # after the last sample that is not missing
            joined = other.begins == (end if self.size else self.start)
            if not (joined or other.led):
                other._led()
            if not self.size:
                self.state, self.cells, self.constant = other.state, other.cells, other.constant
                self.begins, self.led = other.begins, other.led
            else:
                other._less(self.constant)
                if joined:
                    join(self.state, other.state, self.shape)
                else:
                    apart(self.state, other.state)
                self.cells.merge(other.cells)
            self.size += other.size
        self.stop = other.stop

    def _add(self, values: FloatArray) -> bool:
        """Add samples, if all of them are finite."""
        from allanite.kernels.streamed import broken, push

        place, first = self.stop + self.row.summed, float(values[0])
        if not self.size:
            if not math.isfinite(first):
                return False
            self.state = self._empty()  # without what has been put there, if only the first samples were finite
            self.state.at[0], self.begins, self.constant = place, self.stop, first
            self.led = self.stop == 0 or self.stop > self.start
            if self.led:
                self._lead(self.state, first)
        elif self.state.at[0] != place:
            broken(self.state, place)
            self._lead(self.state, first)
        if not push(self.state, values, self.constant, self.shape):
            return False
        self.cells.add(values, self.constant, self.stop)
        self.size += values.size
        self.stop += values.size
        return True

    def _lead(self, state: "State", value: float) -> None:
        """Put a value before the next sample: the sum of the angle has one point more than the angle.

        That sample is missing, or before the record. No difference depends on the value.
        """
        from allanite.kernels.streamed import push

        if self.row.summed:
            state.at[0] -= 1
            push(state, np.array([value]), self.constant, self.shape)

    def _led(self) -> None:
        """Put a value before the first sample, where what came before it is known to be missing."""
        from allanite.kernels.streamed import join

        if self.row.summed:
            state = self._empty()
            state.at[0] = self.begins + 1
            self._lead(state, float(self.state.head[0, 0, 0]) + self.constant)
            join(state, self.state, self.shape)
            self.state, self.led = state, True

    def _empty(self) -> "State":
        from allanite.kernels.ladder import empty

        return empty(2 if self.row.summed else 1, TAIL[self.row.differences])

    def _less(self, constant: float) -> None:
        """Count from another constant."""
        more, state = self.constant - constant, self.state
        width = 2.0 ** np.arange(len(state.at))
        each = np.stack((more * width, more * width * (width + 1) / 2))[: state.head.shape[1]].T
        state.head[:] += each[:, :, None]
        state.tail[:] += each[:, :, None]
        state.odd[:] += each
        state.even[:] += each
        self.cells.total += more * self.cells.count
        self.constant = constant
