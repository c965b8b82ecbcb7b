"""The sums of a stream, to which stretches of samples and later parts of the stream are added (docs/derivations.md)."""

import math
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import FloatArray, stretches
from allanite.kernels import ladder, streamed
from allanite.statistics.row import Statistic

MOST = 512  # number of cells, an even one


@dataclass
class Cells:
    """Sums over `size` samples each, and how many of these there were; the first begins at sample `first` * size."""

    # gaps leave cells with few samples or none; a cell counts to 2^31, the whole to 10^12
    size: int = 1
    first: int = 0
    total: FloatArray = field(default_factory=lambda: np.zeros(MOST))
    count: NDArray[np.int32] = field(default_factory=lambda: np.zeros(MOST, np.int32))

    @property
    def used(self) -> int:
        """Number of cells up to the last one with samples."""
        return int(np.flatnonzero(self.count)[-1]) + 1 if self.count.any() else 0

    def add(self, values: FloatArray, constant: float, place: int) -> None:
        """Add finite samples, less a constant, the first of which is sample `place` of the stream."""
        if not self.count.any():
            self.first = place // self.size
        while (place + values.size - 1) // self.size - self.first >= MOST:
            self.halve()
        streamed.gathered(self.total, self.count, values, constant, (self.size, place - self.first * self.size))

    def halve(self) -> None:
        """Make the cells twice as long."""
        odd = self.first % 2
        for values in (self.total, self.count):
            both = np.zeros(2 * MOST, values.dtype)
            both[odd : odd + MOST] = values
            values[:] = 0
            values[:MOST] = both.reshape(MOST, 2).sum(axis=1)
        self.first, self.size = self.first // 2, 2 * self.size

    def merge(self, other: "Cells") -> None:
        """Add the cells of a later part of the stream, which are changed."""
        while self.size < other.size:
            self.halve()
        while other.size < self.size:
            other.halve()
        while other.first + other.used - self.first > MOST:
            self.halve()
            other.halve()
        here = slice(other.first - self.first, other.first - self.first + other.used)
        self.total[here] += other.total[: other.used]
        self.count[here] += other.count[: other.used]


@cache
def basis(hop: int) -> FloatArray:
    """Rows k = hop / 8 .. hop - 1 at the frequencies (k + 1/2) / (2 hop) per sample, shape (rows, 2 hop)."""
    # Each is freed from its mean and has the length 1: a constant, or a slow noise of any size, is not seen.
    rows = _window(hop) * _cosines(hop)
    rows = rows - rows.mean(axis=1, keepdims=True)
    return np.asarray(rows / np.sqrt((rows**2).sum(axis=1, keepdims=True)))


@cache
def folded(hop: int) -> FloatArray:
    """The window, and the basis as weights of the folded samples and of their sum."""
    # A segment (a, b, c, d) in quarters, times the window, is folded to (-c' - d, a - b'), a prime for reversed order:
    # of that the rows are those of a DCT-IV, and what frees them from their mean is a weight of the sum of the segment.
    # Shape (1 + rows, 2 hop), where a row has hop + 1 weights.
    k, j = np.arange(hop // 8, hop)[:, None] + 0.5, np.arange(hop) + 0.5
    raw = _window(hop) * _cosines(hop)
    mean = raw.mean(axis=1)
    length = np.sqrt(((raw - mean[:, None]) ** 2).sum(axis=1))
    weights = np.zeros((1 + len(raw), 2 * hop))
    weights[0] = _window(hop)
    weights[1:, :hop] = np.cos(np.pi / hop * k * j) / length[:, None]
    weights[1:, hop] = -mean / length
    return weights


def _window(hop: int) -> FloatArray:
    return np.asarray(np.sin(np.pi / (2 * hop) * (np.arange(2 * hop) + 0.5)))


def _cosines(hop: int) -> FloatArray:
    k, i = np.arange(hop // 8, hop)[:, None] + 0.5, np.arange(2 * hop) + 0.5
    return np.asarray(np.cos(np.pi / hop * k * (i + hop / 2)))


TAIL = {2: 32, 3: 48}
"""Cells that are kept of each end of a level, by the order of the differences: 15 of them, and a segment."""

BLOCK = 1 << 16  # samples that are taken at a time, while the cache has them


class Sums:
    """The sums of the differences of a statistic over samples `begins` .. `stop` of a stream."""

    def __init__(self, row: Statistic, start: int) -> None:
        self.row = row
        self.state = self._empty()
        self.shape = row.differences, folded(ladder.HOP)
        self.cells = Cells()  # sums over longer times that the coefficients need
        self.start = self.begins = self.stop = start
        self.size = 0  # number of samples without missing ones
        self.constant = 0.0  # the first sample, which is subtracted from all: the sums do not depend on it
        self.led = False  # a point before the first sample, with which differences of the running sum begin

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
                for a, b in stretches(np.isfinite(block)).tolist():
                    self.stop = begin + a
                    self._add(block[a:b])
                self.stop = begin + block.size

    def merge(self, other: "Sums") -> None:
        """Add those of a later part of the stream, which are changed."""
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
                    streamed.join(self.state, other.state, self.shape)
                else:
                    streamed.apart(self.state, other.state)
                self.cells.merge(other.cells)
            self.size += other.size
        self.stop = other.stop

    def _add(self, values: FloatArray) -> bool:
        """Add samples, if all of them are finite."""
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
            streamed.broken(self.state, place)
            self._lead(self.state, first)
        if not streamed.push(self.state, values, self.constant, self.shape):
            return False
        self.cells.add(values, self.constant, self.stop)
        self.size += values.size
        self.stop += values.size
        return True

    def _lead(self, state: "ladder.State", value: float) -> None:
        """Put a value before the next sample: the sum of the angle has one point more than the angle."""
        # That sample is missing, or before the record. No difference depends on the value.
        if self.row.summed:
            state.at[0] -= 1
            streamed.push(state, np.array([value]), self.constant, self.shape)

    def _led(self) -> None:
        """Put a value before the first sample, where what came before it is known to be missing."""
        if self.row.summed:
            state = self._empty()
            state.at[0] = self.begins + 1
            self._lead(state, float(self.state.head[0, 0, 0]) + self.constant)
            streamed.join(state, self.state, self.shape)
            self.state, self.led = state, True

    def _empty(self) -> "ladder.State":
        return ladder.empty(2 if self.row.summed else 1, TAIL[self.row.differences])

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
