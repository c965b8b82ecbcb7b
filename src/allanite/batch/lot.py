"""A lot: the stored results of a batch, with distributions, trends and units that differ from the others."""

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, NamedTuple

import numpy as np

from allanite.core.errors import DataError
from allanite.core.plain import Value
from allanite.core.units import Signal
from allanite.phrases.phrase import say
from allanite.study.results import Study

from .batch import Batch, BatchUnit
from .judgement import judge_study
from .manifest import DATE, TEMPERATURE
from .scatter import Distribution, Outlying, Trend, outliers, slope_of
from .sources import PathLike
from .specification import Specification
from .status import DONE, OPEN
from .store import Store
from .study_cache import Spool, spooled
from .summary import known

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


class _Value(NamedTuple):
    """The value of a coefficient of one unit, and its temperature and time, NaN if unknown."""

    file: str
    value: float
    temperature: float
    date: float


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
    >>> from pathlib import Path
    >>> from allanite.core.model import N
    >>> from allanite.readers import write
    >>> from allanite.simulation.record import simulate
    >>> from allanite.batch.records import run_batch
    >>> folder = tempfile.TemporaryDirectory()
    >>> for i, size in enumerate((0.1, 0.2)):
    ...     record = simulate(N(size, "deg/sqrt(h)"), 4096, 10.0, rng=np.random.default_rng(i))
    ...     write(record, Path(folder.name, f"unit{i}.csv"))
    >>> _ = run_batch(folder.name, Path(folder.name, "results"))
    >>> read_lot(Path(folder.name, "results"))
    <Lot 2 units, 0 failed, 0 exceed a limit, 0 outlying values>
    >>> folder.cleanup()
    """
    wanted = limits if limits is None or isinstance(limits, Specification) else Specification.load(limits)
    store = Store.opened(results)
    rows, about = store.files()
    spool = Spool()
    units = tuple(spooled(_unit(row, store, wanted), spool) for row in rows)
    if all(unit.error for unit in units):
        raise DataError(f"no file has a result in {str(store.folder)!r}; the first one: {units[0].file}: "
                        f"{units[0].error}")  # fmt: skip
    choices = json.loads(about[b"recipe"])
    batch = Batch(units, choices, choices["level"], wanted, (), {"allanite": about[b"allanite"].decode()})
    found = _values(batch, {row["file"]: row for row in rows})
    distributions = tuple(_distribution(of, ones) for of, ones in found)
    tested = [each for each, known in zip(found, distributions, strict=True) if known.tested]
    return Lot(
        batch,
        distributions,
        tuple(trend for of, ones in found for trend in _trends(of, ones)),
        tuple(one for of, ones in tested for one in _outlying(of, ones)),
    )


def _unit(row: dict[str, Any], store: Store, wanted: Specification | None) -> BatchUnit:
    file, judged = row["file"], wanted is not None
    if row["status"] == OPEN and not store.has(row["key"]):
        return BatchUnit(file, error=say("not analyzed yet"), judged=judged)
    part = store.get(row["key"]) if row["status"] in (DONE, OPEN) or store.has(row["key"]) else {}
    if "study" not in part:
        return BatchUnit(file, error=part.get("error", row["error"]), judged=judged)
    study = Study.from_dict(part["study"] | {"provenance": part["study"]["provenance"] | {"source": file}})
    return BatchUnit(file, study, () if wanted is None else judge_study(study, wanted), judged=judged)


_Of = tuple[str, str, Signal]


def _values(batch: Batch, rows: dict[str, dict[str, Any]]) -> list[tuple[_Of, list[_Value]]]:
    """The values of each coefficient."""
    found: dict[tuple[str, str, str], tuple[_Of, list[_Value]]] = {}
    for unit in batch:
        row = rows[unit.file]
        place = [math.nan if at is None else at for at in (row.get(TEMPERATURE), _seconds(row.get(DATE)))]
        for channel in unit.channels:
            name, signal = channel.record.name, channel.record.signal
            for symbol, value, _ in known(channel, batch.level):
                if value is not None:
                    of = found.setdefault((name, signal.name, symbol), ((name, symbol, signal), []))
                    of[1].append(_Value(unit.file, value, *place))
    return list(found.values())


def _seconds(date: datetime | None) -> float | None:
    return None if date is None else date.replace(tzinfo=UTC).timestamp()


def _distribution(of: _Of, ones: Sequence[_Value]) -> Distribution:
    values = np.array([one.value for one in ones])
    return Distribution(*of, values, *map(float, np.quantile(values, (SHARE, 0.5, 1 - SHARE))))


def _trends(of: _Of, ones: Sequence[_Value]) -> Iterator[Trend]:
    value = np.array([one.value for one in ones])
    for along in (TEMPERATURE, DATE):
        at = np.array([getattr(one, along) for one in ones])
        there = np.isfinite(at)
        if there.sum() >= TREND and np.ptp(at[there]) > 0:
            yield Trend(*of, along, at[there], value[there], *slope_of(at[there], value[there]))


def _outlying(of: _Of, ones: Sequence[_Value]) -> Iterator[Outlying]:
    value = np.array([one.value for one in ones])
    for i in outliers(np.log(np.abs(value))):
        yield Outlying(*of, ones[i].file, ones[i].value, float(np.median(value)))
