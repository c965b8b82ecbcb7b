"""The table of statistics, and the points of a curve."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

from allanite.core.arrays import IntArray
from allanite.core.names import row_alike
from allanite.plugins import Registry

from .differences import ADEV, HAAR, HDEV, MDEV, OADEV, OHDEV, TDEV
from .moments.means import Places
from .row import Statistic
from .theo import MTIE, PDEV, THEO1, THEOBR, THEOH, TIERMS
from .total import HTOTDEV, MTOTDEV, TOTDEV, TTOTDEV

_OWN = (
    *(ADEV, OADEV, MDEV, TDEV, HDEV, OHDEV, TOTDEV, MTOTDEV, TTOTDEV, HTOTDEV),
    *(THEO1, THEOBR, THEOH, PDEV, HAAR, MTIE, TIERMS),
)

STATISTICS = Registry({row.name: row for row in _OWN}, "allanite.statistics", kind=Statistic, key="name")


def statistic_named(name: str) -> Statistic:
    """The row of `STATISTICS`, in upper case or lower; an unknown name is an error that lists the known ones."""
    where = ": curves are deviations, square roots of variances" if str(name).lower().endswith("var") else ""
    return row_alike("statistic", name, STATISTICS, where=where, choice="statistic")


class CurvePoints(NamedTuple):
    """The points of a curve: averaging factors of a row, in a record of `size` samples at `rate` Hz cut into `runs`."""

    # `scattered` says whether a hybrid carries its own bias ratio, which scatters, or one that is computed; `places`
    # where the runs lie, if windows with missing samples count too.
    row: Statistic
    m: IntArray
    runs: Sequence[tuple[int, int]]
    size: int
    rate: float
    scattered: bool = True
    places: Places = ()

    @classmethod
    def of(cls, name: str, *rest: Any, join: float = 0.2) -> "CurvePoints":
        """The points of the statistic called `name`, of a hybrid with this joint."""
        return cls(statistic_named(name).joined(join), *rest)

    def __reduce__(self) -> tuple[Callable[..., "CurvePoints"], tuple[Any, ...]]:
        """With the name of the row: what comes back from another process has the row of `STATISTICS` itself."""
        return partial(CurvePoints.of, join=self.row.join), (self.row.name, *self[1:])
