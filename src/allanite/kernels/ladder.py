"""What is kept of a stream: levels of cells, and sums of their squared differences and of powers of segments.

A cell of level k is the sum of 2^k samples; a pair of cells makes one of the next level. At level k the differences
over m = 8 .. 15 times 2^k are taken at every cell (at level 0 over m = 1 .. 15), and segments of 32 cells, one every
16, are transformed for the octave of their frequencies that no other level reads, from 1/16 to 1/8 of the rate of the
cells (at level 0 up to 1/2). What differences need of the past are the last cells of each level; what another part
needs that ends where this one begins are the first. Every angle is summed from its own level's last cells: no sum grows
with the length of the stream.

The second channel of a cell, for differences of the running sum of the angle, is the sum of the angle over its samples
from where the cell begins, by which the sum of the angle grows beside 2^k times the angle there.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

LEVELS = 32
"""Averaging factors reach to 15 * 2^31."""

HOP = 16
"""Cells from one segment to the next; a segment is twice as long."""

OCTAVE = 8
"""Averaging factors of a level: q = 8 .. 15."""

FIRST = 15
"""Averaging factors of level 0: 1 .. 15."""

UPPER, BAND = 14, 2
"""Coefficients of a segment, at level 0 and above."""


class State(NamedTuple):
    """What is kept: sums, first and last cells, and what pairs are waiting for."""

    # sums, counts: shape (15 + 8 * 31,); of the squared differences, level by level
    sums: NDArray[np.float64]
    counts: NDArray[np.int64]
    powers: NDArray[np.float64]  # shape (14 + 2 * 31,); sums of the squared coefficients
    segments: NDArray[np.int64]  # shape (levels,)
    # head, tail: shape (levels, channels, cells); first cells of the first run, last cells of the last one, of
    # `filled`, shape (levels, 2), of them
    head: NDArray[np.float64]
    tail: NDArray[np.float64]
    filled: NDArray[np.int64]
    # odd, even: shape (levels, channels); a first cell whose partner would be before it, and a last one whose partner
    # is to come; `has`, shape (levels, 2), says whether there are
    odd: NDArray[np.float64]
    even: NDArray[np.float64]
    has: NDArray[np.bool_]
    at: NDArray[np.int64]  # shape (levels,); place of the next cell
    runs: NDArray[np.int64]  # shape (1,); 1 while no sample is missing, then 2


def empty(channels: int, cells: int) -> State:
    """The state of a stream of which nothing has come; so many `cells` are kept of each end of a level."""
    points, powers = FIRST + OCTAVE * (LEVELS - 1), UPPER + BAND * (LEVELS - 1)
    return State(
        sums=np.zeros(points),
        counts=np.zeros(points, np.int64),
        powers=np.zeros(powers),
        segments=np.zeros(LEVELS, np.int64),
        head=np.zeros((LEVELS, channels, cells)),
        tail=np.zeros((LEVELS, channels, cells)),
        filled=np.zeros((LEVELS, 2), np.int64),
        odd=np.zeros((LEVELS, channels)),
        even=np.zeros((LEVELS, channels)),
        has=np.zeros((LEVELS, 2), np.bool_),
        at=np.zeros(LEVELS, np.int64),
        runs=np.ones(1, np.int64),
    )
