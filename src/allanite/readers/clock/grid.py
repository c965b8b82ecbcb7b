"""Grid: where the rows of a file stand in time."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.finding import Finding

Places = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Grid:
    """An even grid under the rows.

    Attributes
    ----------
    interval : float
        Of the grid, s: the time between the first stamp and the last over the intervals between them, lost ones
        counted.
    rows : array of int, optional
        The rows that are kept, in the order of time; None for all in the order of the file.
    places : array of int, optional
        Where they stand on the grid; None for one after the other.
    findings : tuple of Finding
        What is wrong with the stamps.
    trouble : str
        Why the stamps give no rate; empty if they do.

    Examples
    --------
    >>> grid = Grid(0.01, places=np.array([0, 1, 3]))
    >>> grid.lost, grid.put(np.array([5.0, 6.0, 7.0]))
    (1, array([ 5.,  6., nan,  7.]))
    """

    interval: float = 0.0
    rows: Places | None = None
    places: Places | None = None
    findings: tuple[Finding, ...] = ()
    trouble: str = ""

    @property
    def lost(self) -> int:
        """Number of places without a row."""
        return 0 if self.places is None else int(self.places[-1]) + 1 - self.places.size

    @property
    def history(self) -> tuple[str, ...]:
        """What putting rows on the grid does to a record."""
        lost = (f"{self.lost} lost readings marked as gaps",) if self.lost else ()
        if self.rows is None:
            return lost
        done = "repeated rows left out" if np.all(np.diff(self.rows) > 0) else "rows put in the order of their stamps"
        return (done, *lost)

    def put(self, values: NDArray[Any]) -> NDArray[Any]:
        """The readings on the grid, NaN where one is lost."""
        kept = values if self.rows is None else values[self.rows]
        if self.places is None or not self.lost:
            return kept
        whole = np.full(kept.size + self.lost, np.nan)
        whole[self.places] = kept
        return whole


ONE_AFTER_THE_OTHER = Grid()
"""What is supposed where nothing tells more."""
