"""A row of the papers: the claim, the command as anybody can type it, and where its number stands."""

import math
from collections.abc import Callable
from typing import NamedTuple


class Row(NamedTuple):
    """A claim, the command and its cells, the number that is printed, its relative tolerance, and ours.

    A cell is a column of the CSV output and the row it is read in, ``value @ term=N``, the last row, ``tau_s @ last``,
    ``rms value @ term=N`` of all channels, or, from ``/``, a path into the JSON output. Of several commands, each has
    its cell. `wrong`: the number of the paper is not ours.
    """

    item: str
    command: str | tuple[str, ...]
    cells: str | tuple[str, ...]
    published: float | Callable[[], float]
    tolerance: float
    ours: float | None = None
    wrong: bool = False
    read: Callable[..., float] = float


def ratio(one, other):
    return one / other


def arcsec(rad):
    return math.degrees(rad) * 3600
