"""Datasets of a container by their paths: which share a clock, which are wanted, and the table that these make."""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.errors import DataError, UsageError
from allanite.record import Recording

from . import headers
from .arrays import column, split, turned, turned_note
from .column import Column
from .options import Options
from .table import Table


@dataclass(frozen=True, eq=False)
class Dataset:
    """An array in a container, before it is loaded.

    Parameters
    ----------
    path : str
        Where it is, as ``"imu0/gyro"``.
    shape, dtype
        As the container declares them.
    load : callable
        Reads it.
    unit, names, rate
        What its attributes say: unit, names of its columns, sampling rate in Hz.
    source : str
        Where the rate is known from.
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
    def leaf(self) -> str:
        """The last part of the path."""
        return self.path.rpartition("/")[2]

    @property
    def headers(self) -> tuple[str, ...]:
        """Names of the columns that it makes."""
        standin = np.broadcast_to(np.zeros((), self.dtype), self.shape)  # the shape without the memory
        return tuple(header for header, _ in split(self.path, standin, self.names))

    def answers(self, key: str) -> bool:
        """Whether a user who writes `key` may mean this dataset, or a column of it."""
        wanted = key.strip().strip("/").lower()
        return wanted in {text.lower() for text in (self.path, self.leaf, *self.headers)}

    def __str__(self) -> str:
        return f"{self.path} ({' x '.join(map(str, self.shape))})"


def recording(found: Sequence[Dataset], options: Options, notes: Sequence[str] = ()) -> Recording:
    """The channels of the datasets that belong together.

    Raises
    ------
    UsageError
        Several recordings with clocks of their own are in the file and none is chosen; the message lists them.
    DataError
        There is no array of readings.
    """
    series = [dataset for dataset in found if len(dataset.shape) in (1, 2) and dataset.length > 1]
    if not series:
        raise DataError("the file holds no array of readings")
    family = _chosen(_families(series), options)
    left = [str(dataset) for dataset in series if dataset not in family]
    notes = [*notes, *([f"left out, of other length or clock: {', '.join(left[:20])}"] if left else [])]
    stem = os.path.commonpath([os.path.dirname(dataset.path) or "." for dataset in family]) if len(family) > 1 else ""
    columns = list[Column]()
    places = _places(series)
    for dataset in family:
        array = dataset.load()
        notes += [turned_note(dataset.path, array)] if turned(array) else []
        pieces = split(dataset.path, array, dataset.names)
        columns += [_column(piece, places[dataset.path] + i, dataset, stem) for i, piece in enumerate(pieces)]
    rate, source = next(((d.rate, d.source) for d in family if d.rate), (None, ""))
    return Table(tuple(columns), rate, source, tuple(notes)).recording(_spelled_out(options, family))


def _column(piece: tuple[str, NDArray[Any]], position: int, dataset: Dataset, stem: str) -> Column:
    header, values = piece
    short = header.removeprefix(f"{stem}/") if stem else header
    made = column(short, values, position, unit=dataset.unit)
    return made if short == header else replace(made, header=header)


def _places(series: Sequence[Dataset]) -> dict[str, int]:
    """The place of the first column of each dataset, counted from 1 over all of them."""
    counts = [len(dataset.headers) for dataset in series]
    return {dataset.path: 1 + sum(counts[:i]) for i, dataset in enumerate(series)}


def _families(series: Sequence[Dataset]) -> list[list[Dataset]]:
    """Datasets of one length; where several groups keep a clock of that length, each with its own."""
    families: dict[tuple[int, str], list[Dataset]] = {}
    for dataset in series:
        homes = {_parent(d) for d in series if d.length == dataset.length and _is_clock(d)}
        above = [home for home in homes if not home or f"{dataset.path}/".startswith(f"{home}/")]
        home = max(above, key=len, default="") if len(homes) > 1 else ""
        families.setdefault((dataset.length, home), []).append(dataset)
    return list(families.values())


def _parent(dataset: Dataset) -> str:
    return dataset.path.rpartition("/")[0]


def _is_clock(dataset: Dataset) -> bool:
    return headers.is_time(dataset.unit) or headers.clock_rank(headers.split(dataset.leaf)[0]) < 2


def _chosen(families: list[list[Dataset]], options: Options) -> list[Dataset]:
    """The family that the user names a member of, or else the only one that looks like a sensor's."""
    for keys in (options.channels, [options.time] if options.time else None):
        named = [family for family in families if any(d.answers(key) for d in family for key in keys or ())]
        if named and keys is options.channels:
            return [dataset for family in named for dataset in family]
        families = named or families
    likely = [family for family in families if any(map(_is_sensor, family))] or families
    if len(likely) == 1:
        return likely[0]
    example = next(dataset.path for dataset in likely[0] if not _is_clock(dataset) or len(likely[0]) == 1)
    lists = "; ".join(", ".join(map(str, family[:20])) for family in likely[:20])
    raise UsageError(
        f"the file holds {len(likely)} recordings, each of its own length or clock ({lists}); choose one with "
        f"channels='{example}' (--channels {example})"
    )


def _is_sensor(dataset: Dataset) -> bool:
    said = [headers.split(header) for header in (dataset.path, *dataset.headers)]
    units = [dataset.unit, *(unit for _, unit in said)]
    return any(headers.inertial(unit) for unit in units) or any(
        headers.sensor_by_name(text) for name, _ in said for text in (name, name.rpartition("/")[2])
    )


def _spelled_out(options: Options, family: Sequence[Dataset]) -> Options:
    """The options with the columns of each dataset that is named as a whole."""
    if options.channels is None:
        return options
    names = list[str]()
    for key in options.channels:
        whole = [d for d in family if key.strip("/") in (d.path, d.leaf) and len(d.headers) > 1]
        names += whole[0].headers if len(whole) == 1 else [key]
    return replace(options, channels=tuple(names))
