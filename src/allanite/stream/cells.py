"""The whole stream as at most 512 sums over equal times, which become twice as long whenever there are more."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from allanite.core.arrays import FloatArray

MOST = 512
"""Number of cells, an even one."""


@dataclass
class Cells:
    """Sums over `size` samples each, and how many of these there were; the first one begins at sample `first` * size.

    Gaps leave cells with few samples or none, and the rest is not affected. A cell counts to 2^31, the whole to 10^12.
    """

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
        from allanite.kernels.streamed import gathered

        if not self.count.any():
            self.first = place // self.size
        while (place + values.size - 1) // self.size - self.first >= MOST:
            self.halve()
        gathered(self.total, self.count, values, constant, (self.size, place - self.first * self.size))

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
