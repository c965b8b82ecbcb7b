"""A lot: the stored results of a batch, with distributions, trends and units that differ from the others."""

import math
import pickle
import tempfile
import weakref
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

import numpy as np

from allanite.core.aliases import public
from allanite.core.errors import DataError
from allanite.core.plain import Value
from allanite.phrases.phrase import say
from allanite.study.results import Study

from .batch import Batch, BatchUnit, unit_of
from .scatter import Distribution, Outlying, Trend, outliers, slope_of
from .sources import DATE, TEMPERATURE, PathLike
from .specification import Specification, limits_of
from .status import DONE, OPEN
from .store import Store
from .summary import gathered

TREND = 6
"""Values from which on there is a trend."""

SHARE = 0.1
"""Share of the values below the lower and above the upper quantile of a distribution."""


@dataclass(frozen=True, eq=False, repr=False)
class Lot(Value):
    """The stored results of a batch.

    Attributes
    ----------
    batch : Batch
        The units, held against limits if some are given.
    distributions, trends, outlying : tuple
        Of each coefficient that has values.
    """

    batch: Batch
    distributions: tuple[Distribution, ...] = ()
    trends: tuple[Trend, ...] = ()
    outlying: tuple[Outlying, ...] = ()

    @property
    def rejected(self) -> tuple[str, ...]:
        """What has no result, is not explained by its model, or was not shown to keep a limit: file and channel."""
        return self.batch.rejected

    @property
    def level(self) -> float:
        """Of intervals."""
        return self.batch.level

    def _summary(self) -> str:
        return f"{self.batch._summary()}, {len(self.outlying)} outlying values"


class Spool:
    """A temporary file of studies, read again one at a time: of a lot of thousands, only one is in memory.

    Only this process writes and reads it; it has no name and is gone when nothing refers to it.

    Examples
    --------
    >>> from allanite import Recipe
    >>> load = Spool().put(Study((), Recipe(), (), (), {}))
    >>> len(load().channels)
    0
    """

    def __init__(self) -> None:
        self._file = tempfile.TemporaryFile(prefix="allanite-")  # noqa: SIM115 - closed with the spool
        weakref.finalize(self, self._file.close)
        self._last: tuple[int, Study] | None = None

    def put(self, study: Study) -> Callable[[], Study]:
        """Store a study; what reads it again."""
        begin = self._file.seek(0, 2)
        size = self._file.write(zlib.compress(pickle.dumps(study), 1))

        def get() -> Study:
            if self._last is None or self._last[0] != begin:
                self._file.seek(begin)
                self._last = begin, pickle.loads(zlib.decompress(self._file.read(size)))  # noqa: S301 - our own
            return self._last[1]

        return get


class SpooledUnit(BatchUnit):
    """A unit that reads its study whenever it is asked for it; stored and pickled as any other unit."""

    def __init__(self, unit: BatchUnit, load: Callable[[], Study]) -> None:
        super().__init__(unit.file, None, unit.judgements, unit.error, unit.judged)
        object.__setattr__(self, "_load", load)

    def __getattribute__(self, name: str) -> Any:
        return object.__getattribute__(self, "_load")() if name == "study" else object.__getattribute__(self, name)

    def __reduce__(self) -> tuple[Any, ...]:
        return BatchUnit, (self.file, self.study, self.judgements, self.error, self.judged)

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Those of the unit."""
        return BatchUnit(*self.__reduce__()[1]).to_dict(level)


@public
def read_lot(results: PathLike, limits: Specification | PathLike | None = None) -> Lot:
    """The results that `run_batch` has stored.

    Parameters
    ----------
    results : path
        The folder of results; a batch that is still running shows what it has done so far.
    limits : Specification or path, optional
        What the coefficients must not exceed.

    Raises
    ------
    UsageError
        It is not a folder of results, or the limits are wrong.
    DataError
        A table or a part is damaged, or no file has a result.

    Examples
    --------
    >>> import tempfile
    >>> from allanite import Record, run_batch, write
    >>> folder = tempfile.TemporaryDirectory()
    >>> for i in range(2):
    ...     write(Record(np.random.default_rng(i).normal(size=4096), 10.0, "deg/h"), f"{folder.name}/unit{i}.csv")
    >>> _ = run_batch(folder.name, f"{folder.name}/results")
    >>> read_lot(f"{folder.name}/results")
    <Lot 2 units, 0 failed, 0 exceed a limit, 0 outlying values>
    >>> folder.cleanup()
    """
    specification = limits_of(limits)
    store = Store.opened(results)
    table, choices, version = store.files()
    spool, rows = Spool(), {row["file"]: row for row in table}
    units = tuple(_unit(row, store, specification, spool) for row in table)
    if all(unit.error for unit in units):
        raise DataError(f"no file has a result in {str(store.folder)!r}; the first one: {units[0].file}: "
                        f"{units[0].error}")  # fmt: skip
    batch = Batch(units, choices, choices["level"], specification, (), {"allanite": version})
    distributions, trends, outlying = list[Distribution](), list[Trend](), list[Outlying]()
    for of, known in gathered(batch.results(), batch.level, valued=True):
        values = np.array([unit.value for unit in known], dtype=np.float64)
        quantiles = map(float, np.quantile(values, (SHARE, 0.5, 1 - SHARE)))
        distributions.append(Distribution(*of, values, *quantiles))
        for along in (TEMPERATURE, DATE):
            at = np.array([_number(rows[unit.file].get(along)) for unit in known])
            given = np.isfinite(at)
            if given.sum() >= TREND and np.ptp(at[given]) > 0:
                trends.append(Trend(*of, along, at[given], values[given], *slope_of(at[given], values[given])))
        if distributions[-1].tested:
            median = float(np.median(values))
            places = outliers(np.log(np.abs(values)))
            outlying += [Outlying(*of, known[i].file, float(values[i]), median) for i in places]
    return Lot(batch, tuple(distributions), tuple(trends), tuple(outlying))


def _unit(row: dict[str, Any], store: Store, limits: Specification | None, spool: Spool) -> BatchUnit:
    """The unit of a file, as far as it was analyzed, without its study in memory."""
    file, stored = row["file"], row["status"] == DONE or store.has(row["key"])
    part = store.get(row["key"]) if stored else {}
    if "study" in part:
        data = part["study"] | {"provenance": part["study"]["provenance"] | {"source": file}}
        study = Study.from_dict(data)
        return SpooledUnit(unit_of(file, study, limits), spool.put(study))
    error = say("not analyzed yet") if row["status"] == OPEN and not stored else part.get("error", row["error"])
    return BatchUnit(file, error=error, judged=limits is not None)


def _number(fact: Any) -> float:
    """A temperature or a time as a number, NaN if it is not known."""
    if isinstance(fact, datetime):
        return fact.replace(tzinfo=UTC).timestamp()
    return math.nan if fact is None else float(fact)
