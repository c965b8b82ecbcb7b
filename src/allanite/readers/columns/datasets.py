"""Datasets, the arrays of a container: which share a clock, which are wanted, and the table that they form."""

import math
import posixpath
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, chain, islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError, UsageError
from allanite.core.record import Recording
from allanite.phrases.phrase import join, say, spelled
from allanite.readers.options import Options

from . import headers
from .arrays import RATE_NAMES, column, split, turned, turned_note
from .column import FileColumn, some
from .table import FileTable, restored

WIDEST = 1000
"""Maximum number of columns of a dataset; anything wider is an image or a matrix, not a recording."""


@dataclass(frozen=True, eq=False)
class Dataset:
    """An array in a container, before it is loaded.

    `path` is its location, such as ``"imu0/gyro"``, `shape` and `dtype` are declared by the container, `load` reads it.
    `unit`, `names` of columns and `rate` in Hz come from its attributes, `source` is the origin of the rate.
    """

    path: str
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    load: Callable[[], NDArray[Any]]
    unit: str = ""
    names: tuple[str, ...] = ()
    rate: float | None = None
    source: str = ""

    @property
    def length(self) -> int:
        """Samples: the longer side of a matrix."""
        return max(self.shape)

    @property
    def parent(self) -> str:
        """The path of the group that contains it."""
        return self.path.rpartition("/")[0]

    @property
    def leaf(self) -> str:
        """The last part of the path."""
        return self.path.rpartition("/")[2]

    @property
    def is_series(self) -> bool:
        """Whether it may hold samples: real numbers, one row per sample."""
        fields = [self.dtype[name] for name in self.dtype.names] if self.dtype.names else [self.dtype]
        flat = all(f.base.kind in "iufMm" and len(self.shape) + len(f.shape) <= 2 for f in fields)
        return flat and len(self.shape) in (1, 2) and self.length > 1 and 0 < len(self.headers) <= WIDEST

    @property
    def headers(self) -> tuple[str, ...]:
        """Names of its columns; at most one more than `WIDEST`."""
        standin = np.broadcast_to(np.zeros((), self.dtype), self.shape)  # the shape without the memory
        return tuple(header for header, _ in islice(split(self.path, standin, self.names), WIDEST + 1))

    @property
    def is_clock(self) -> bool:
        """Whether it holds time stamps, by its unit or its name."""
        return headers.is_time(self.unit) or headers.clock_rank(headers.split(self.leaf)[0]) < 2

    @property
    def is_sensor(self) -> bool:
        """Whether a unit or a name is that of an inertial sensor."""
        said = [headers.split(header) for header in (self.path, *self.headers)]
        units = [self.unit, *(unit for _, unit in said)]
        names = [text for name, _ in said for text in (name, name.rpartition("/")[2])]
        return any(map(headers.inertial, units)) or any(map(headers.sensor_by_name, names))

    def __str__(self) -> str:
        return f"{self.path} ({' x '.join(map(str, self.shape))})"


Family = list[Dataset]


def rated(found: Sequence[Dataset], numbers: Mapping[str, float]) -> list[Dataset]:
    """The datasets, each with the nearest sampling rate above it among the single `numbers` of the file."""
    rates = {
        path.rpartition("/")[0]: (value, say("{path!r} in the file", path=path))
        for path, value in numbers.items()
        if path.rpartition("/")[2].lower() in RATE_NAMES and 0 < value < math.inf
    }
    result = []
    for dataset in found:
        home = None if dataset.rate else _nearest(dataset, rates)
        result.append(dataset if home is None else replace(dataset, rate=rates[home][0], source=rates[home][1]))
    return result


def _nearest(dataset: Dataset, homes: Iterable[str]) -> str | None:
    """The group that is nearest above a dataset; None if there is none."""
    above = (home for home in homes if not home or f"{dataset.path}/".startswith(f"{home}/"))
    return max(above, key=len, default=None)


def recording(found: Sequence[Dataset], options: Options, notes: Sequence[str] = (), text: str = "") -> Recording:
    """The channels of the datasets that belong together; `text` is the output of `table.described`, if present."""
    table, narrowed, _ = arranged(found, options, notes, text)
    return table.recording(narrowed)


def arranged(
    found: Sequence[Dataset], options: Options, notes: Sequence[str] = (), text: str = ""
) -> tuple[FileTable, Options, Family]:
    """The table of the datasets that belong together, the options for it, and these datasets; see `recording`."""
    series = [dataset for dataset in found if dataset.is_series]
    if not series:
        none = say("the file contains no array of samples, with one row per sample")
        seen = [say("it contains {names}", names=some(list(map(str, found))))] if found else []
        raise DataError(join("; ", (none, *seen)))
    # the position of the first column of each, counted from 1 over all of them
    firsts = accumulate((len(dataset.headers) for dataset in series), initial=1)
    places = {dataset.path: place for dataset, place in zip(series, firsts, strict=False)}
    family = series if text else _chosen(_families(series), options, places)
    options, family = _narrowed(options, family)
    left = [str(dataset) for dataset in found if dataset not in family]
    notes = [
        *notes,
        *([say("left out, of different length, clock or shape: {names}", names=some(left))] if left else []),
    ]
    stem = posixpath.commonpath([dataset.parent.strip("/") or "." for dataset in family])
    columns = list[FileColumn]()
    for dataset in family:
        array = dataset.load()
        notes += [turned_note(dataset.path, array)] if turned(array) else []
        pieces = enumerate(split(dataset.path, array, dataset.names), places[dataset.path])
        columns += [_column(piece, position, dataset.unit, stem) for position, piece in pieces]
    rate, source = next(((d.rate, d.source) for d in family if d.rate), (None, ""))
    return restored(FileTable(tuple(columns), rate, source, tuple(notes)), text), options, family


def _column(piece: tuple[str, NDArray[Any]], position: int, unit: str, stem: str) -> FileColumn:
    header, values = piece
    short = header.removeprefix(f"{stem}/")
    made = column(short, values, position, unit=unit)
    return made if short == header else replace(made, header=header)


def _families(series: Sequence[Dataset]) -> list[Family]:
    """Datasets of one length; if several groups have a clock of that length, or a rate, each group separately."""
    families: dict[tuple[int, str, float | None], Family] = {}
    for dataset in series:
        alike = [d for d in series if d.length == dataset.length]
        homes = {d.parent for d in alike if d.is_clock}
        home = _nearest(dataset, homes) or "" if len(homes) > 1 else ""
        rates = {d.rate for d in alike} - {None}
        families.setdefault((dataset.length, home, dataset.rate if len(rates) > 1 else None), []).append(dataset)
    return list(families.values())


def _chosen(families: list[Family], options: Options, places: Mapping[str, int]) -> Family:
    """The family with a member named by the user, otherwise the only one that looks like a sensor's."""
    named = [family for family in families if _answers(family, options.channels or (), places)]
    if named:
        return list(chain.from_iterable(named))
    timed = [family for family in families if options.time and _answers(family, (options.time,), places)]
    families = timed or families
    likely = [family for family in families if any(dataset.is_sensor for dataset in family)] or families
    if len(likely) == 1:
        return likely[0]
    example = next(dataset.path for dataset in likely[0] if not dataset.is_clock or len(likely[0]) == 1)
    lists = "; ".join(some([str(one) for one in family]) for family in likely[:20])
    raise UsageError(
        f"the file contains {len(likely)} recordings, each with its own length or clock ({lists}); select one with "
        + spelled(f"--channels {example}", f"channels='{example}'")
    )


def _answers(family: Family, keys: Sequence[str], places: Mapping[str, int]) -> bool:
    """Whether one of `keys` may refer to a member of the family, or to one of its columns."""
    wanted = {key.strip(" /").lower() for key in keys} | {key.partition("[")[0].strip(" /").lower() for key in keys}
    for dataset in family:
        numbers = range(places[dataset.path], places[dataset.path] + len(dataset.headers))
        short = (header.rpartition("/")[2] for header in dataset.headers)
        names = (dataset.path, dataset.leaf, *dataset.headers, *short, *map(str, numbers))
        if wanted & {name.lower() for name in names}:
            return True
    return False


def _narrowed(options: Options, family: Family) -> tuple[Options, Family]:
    """Which columns to look for in which dataset: all possible signals of datasets that are named as a whole."""
    keys, whole = [key.strip("/") for key in options.channels or ()], list[Dataset | None]()
    for key in keys:
        named = [d for d in family if key in (d.path, d.leaf) and len(d.headers) > 1]
        whole.append(named[0] if len(named) == 1 else None)
    if keys and all(whole):
        return replace(options, channels=None), [d for d in family if d in whole or d.is_clock]
    if any(whole):  # some are named along with single columns
        names = ((key,) if found is None else found.headers for key, found in zip(keys, whole, strict=True))
        options = replace(options, channels=tuple(chain.from_iterable(names)))
    return options, family
