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
import scipy

from allanite.core.aliases import public
from allanite.core.arrays import FloatArray
from allanite.core.errors import DataError
from allanite.core.plain import Value
from allanite.phrases.phrase import say
from allanite.study.results import Study

from .batch import Batch, BatchUnit, unit_of
from .sources import DATE, TEMPERATURE, PathLike
from .specification import Specification, limits_of
from .store import Store
from .tables import DONE, OPEN, Coefficient, gathered

DAY = 86400.0
FALSE_ALARM = 0.05  # probability that a coefficient of a uniform lot has an outlying unit, or shows a trend
FEWEST = 4
"""Values from which on there are quantiles and outlying units; of three one would have to be 47 deviations away."""


@dataclass(frozen=True, eq=False, repr=False)
class Distribution(Coefficient):
    """The `values` of a coefficient, SI, of the units that have one, with their 10 %, 50 % and 90 % quantiles."""

    values: FloatArray
    low: float
    median: float
    high: float

    @property
    def tested(self) -> bool:
        """Whether units were tested for being outlying, by the logarithms of their values."""
        return self.values.size >= FEWEST and bool(self.values.all())


@dataclass(frozen=True, eq=False, repr=False)
class Trend(Coefficient):
    """A straight line through the values of a coefficient."""

    along: str  # One of "temperature", "date"
    # at, values: temperature in degrees Celsius, or time in seconds since 1970, and value in SI of the units that
    # have both
    at: FloatArray
    values: FloatArray
    # slope, low, high: change in SI for each kelvin or second, with its 95 % interval, from the scatter of the values
    # about the line
    slope: float
    low: float
    high: float

    @property
    def shown(self) -> bool:
        """Whether the interval excludes zero."""
        return self.low > 0 or self.high < 0

    @property
    def step(self) -> float:
        """The step of temperature or time that slopes are shown for, in kelvin or seconds."""
        return DAY if self.along == DATE else 1.0


@dataclass(frozen=True, repr=False)
class Outlying(Coefficient):
    """A unit whose value differs from the others more than chance explains; `median` is that of all, SI."""

    file: str
    value: float
    median: float


def slope_of(at: FloatArray, value: FloatArray) -> tuple[float, float, float]:
    """Slope of a straight line, with the interval in which it is by the scatter about the line."""
    scale = float(np.std(at))
    fit = scipy.stats.linregress((at - at.mean()) / scale, value)
    half = float(scipy.stats.t.ppf(1 - FALSE_ALARM / 2, at.size - 2)) * fit.stderr
    return fit.slope / scale, (fit.slope - half) / scale, (fit.slope + half) / scale


def detectable(count: int) -> float:
    """Distance of one of several values from the mean of the others, in their standard deviations, of an outlier."""
    return float(scipy.stats.t.isf(FALSE_ALARM / (2 * count), count - 2)) * math.sqrt(count / (count - 1))


def outliers(values: FloatArray) -> list[int]:
    """Places of the outliers of a normal sample, by Rosner's generalized extreme studentized deviate."""
    # One is looked for in fewer than 15 values, for which the test is exact, and at most a fifth of them in more. With
    # a probability of `FALSE_ALARM` one is found where there is none.
    n, kept, last, removed = values.size, np.arange(values.size), 0, list[int]()
    for i in range(1, (1 if n < 15 else n // 5) + 1):
        rest = values[kept]
        spread = float(rest.std(ddof=1))
        if not spread > 0:
            break
        at = int(np.argmax(np.abs(rest - rest.mean())))
        size = abs(float(rest[at] - rest.mean())) / spread
        t = float(scipy.stats.t.isf(FALSE_ALARM / (2 * (n - i + 1)), n - i - 1))
        removed.append(int(kept[at]))
        kept = np.delete(kept, at)
        if size > t * (n - i) / math.sqrt((n - i - 1 + t * t) * (n - i + 1)):
            last = i
    return removed[:last]


TREND = 6  # values from which on there is a trend
SHARE = 0.1  # share of the values below the lower and above the upper quantile of a distribution


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
        """What has no result, is not explained by its model, or has a limit that is not decided: file and channel."""
        return self.batch.rejected

    @property
    def level(self) -> float:
        """Of intervals."""
        return self.batch.level

    def _summary(self) -> str:
        return f"{self.batch._summary()}, {len(self.outlying)} outlying values"


class Spool:
    """A temporary file of studies, read again one at a time: of a lot of thousands, only one is in memory."""

    # only this process writes and reads it; it has no name and is gone when nothing refers to it

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
        distributions.append(Distribution(*of, values, *map(float, np.quantile(values, (SHARE, 0.5, 1 - SHARE)))))
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
        study = Study.from_dict(part["study"] | {"provenance": part["study"]["provenance"] | {"source": file}})
        return SpooledUnit(unit_of(file, study, limits), spool.put(study))
    error = say("not analyzed yet") if row["status"] == OPEN and not stored else part.get("error", row["error"])
    return BatchUnit(file, error=error, judged=limits is not None)


def _number(fact: Any) -> float:
    """A temperature or a time as a number, NaN if it is not known."""
    if isinstance(fact, datetime):
        return fact.replace(tzinfo=UTC).timestamp()
    return math.nan if fact is None else float(fact)
