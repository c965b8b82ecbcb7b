"""The sums of a stream, to which stretches of samples and later parts of the stream are added."""

import math

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.statistics.estimator import stretches
from allanite.statistics.row import Statistic

from .cells import Cells
from .lapped import folded

TAIL = {2: 32, 3: 48}
"""Cells that are kept of each end of a level, by the order of the differences: 15 of them, and a segment."""

BLOCK = 1 << 15
"""Samples that are taken at a time, while the cache has them."""


class Sums:
    """The sums of the differences of a statistic over samples `begins` .. `stop` of a stream.

    Samples are added less the first of them, `constant`, of which the sums do not depend. `size` is their number
    without missing ones; `cells` are the sums over longer times that the coefficients need.
    """

    def __init__(self, row: Statistic, start: int) -> None:
        from allanite.kernels.ladder import HOP, empty

        self.row = row
        self.state = empty(2 if row.summed else 1, TAIL[row.differences])
        self.shape = row.differences, folded(HOP)
        self.cells = Cells()
        self.begins = self.stop = start
        self.size = 0
        self.constant = 0.0

    @property
    def nbytes(self) -> int:
        """Size of what is kept."""
        return sum(array.nbytes for array in (*self.state, self.cells.total, self.cells.count))

    def push(self, values: FloatArray) -> None:
        """Add samples, or the stretches of them without missing ones."""
        for at in range(0, values.size, BLOCK):
            self._push(values[at : at + BLOCK])

    def merge(self, other: "Sums") -> None:
        """Add those of a later part of the stream, which are changed."""
        from allanite.kernels.streamed import apart, join

        if other.size:
            other._less(self.constant)
            if other.begins == self.stop:
                join(self.state, other.state, self.shape)
            else:
                apart(self.state, other.state)
            self.cells.merge(other.cells)
            self.size += other.size
        self.stop = other.stop

    def _push(self, values: FloatArray) -> None:
        """Add a block, or the stretches of it without missing samples."""
        if not self._add(values):
            begin = self.stop
            for a, b in stretches(values):
                self.stop = begin + a
                self._add(values[a:b])
            self.stop = begin + values.size

    def _add(self, values: FloatArray) -> bool:
        """Add samples, if all of them are finite."""
        from allanite.kernels.streamed import broken, push

        state, place = self.state, self.stop + self.row.summed
        if not self.size:
            if not math.isfinite(values[0]):
                return False
            self.begins, self.constant = self.stop, float(values[0])
            state.at[0] = place
            if self.row.summed and not self.stop:
                # the sum of the angle has one point more than the angle: its first window begins a sample before
                state.at[0] = 0
                push(state, values[:1], self.constant, self.shape)
        elif state.at[0] != place:
            broken(state, place)
        if not push(state, values, self.constant, self.shape):
            return False
        self.cells.add(values, self.constant, self.stop)
        self.size += values.size
        self.stop += values.size
        return True

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
