"""Containers: which of their tables, each with a clock of its own, or of their arrays is meant; else all are named."""

import math
import posixpath
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, chain, islice, repeat
from typing import Any

import numpy as np
from numpy.typing import NDArray

from allanite.core.errors import DataError, UsageError
from allanite.core.record import SHORTEST, Recording
from allanite.phrases.phrase import Phrase, join, say, spelled
from allanite.readers.options import Options

from . import headers
from .column import RATE_NAMES, FileColumn, column, some, split, turned, turned_note
from .table import FileTable, restored

MOST_LISTED = 30  # maximum number of streams that a message lists
WIDEST = 1000  # maximum number of columns of a dataset; anything wider is an image or a matrix, not a recording


@dataclass(frozen=True, eq=False)
class Stream:
    """One table of a log before it is loaded: a topic, a kind of message, a group of channels, a sheet."""

    name: str  # unique in the file, such as "sensor_gyro/1"
    count: int  # number of rows
    columns: tuple[str, ...]  # their names
    load: Callable[[], FileTable]
    rate: float | None = None  # Hz, only for messages; None: unknown
    likely: int = 1  # 0 if it holds no inertial signals; of the others, those with the largest are the likely ones
    type: str = ""  # that of its messages; empty for most formats
    why: str = ""  # its messages cannot be decoded; empty if they can

    @property
    def key(self) -> str:
        """Its name as keys are compared with it."""
        return self.name.strip("/").lower()

    @property
    def shown(self) -> Phrase:
        """Its name, type, number of rows and rate."""
        name = say("{name} of type {type}", name=self.name, type=self.type) if self.type else self.name
        if self.rate is None:
            return say("{name} ({count} rows)", name=name, count=self.count)
        return say("{name} ({count} rows at {rate:.4g} Hz)", name=name, count=self.count, rate=self.rate)


def mean_rate(count: int, span: float) -> float | None:
    """The rate in Hz of rows that begin within `span` seconds; None if it is unknown."""
    return (count - 1) / span if span > 0 and count > 1 else None


def any_inertial(names: Iterable[str], units: Iterable[str] = repeat("")) -> bool:
    """Whether one of these headers, which hold the units unless these are given, is that of an inertial sensor."""
    pairs = ((name, unit) if unit else headers.split(name) for name, unit in zip(names, units, strict=False))
    return any(headers.inertial(unit) or headers.sensor_by_name(name) for name, unit in pairs)


def stream_recording(streams: Sequence[Stream], options: Options, notes: Sequence[str] = ()) -> Recording:
    """The channels of the stream that ``options.channels`` names, or else of the only one with inertial signals."""
    # A key names a stream, a column as ``stream/column``, or a column that only one stream has.
    _, table, narrowed = arranged_stream(streams, options, notes)
    return table.recording(narrowed)


def arranged_stream(
    streams: Sequence[Stream], options: Options, notes: Sequence[str] = ()
) -> tuple[Stream, FileTable, Options]:
    """The stream that is wanted, its table, and the options for that; see `stream_recording`."""
    if not streams:
        raise DataError(say("the file contains no rows of numbers; check that the recording was saved"))
    stream, keys = _named(streams, options.channels) if options.channels else (_only(streams), None)
    if stream.why:
        raise UsageError(_undecoded(stream))
    rest = [other for other in streams if other is not stream and other.likely]
    table = stream.load()
    source = (say("samples of {stream}", stream=stream.shown),) if len(streams) > 1 or stream.type else ()
    omitted = (say("left out, other tables of the file: {names}", names=_listed(rest)),) if rest else ()
    told = replace(table, notes=(*source, *notes, *table.notes, *omitted))
    return stream, told, replace(options, channels=keys)


def _only(streams: Sequence[Stream]) -> Stream:
    """The only likely stream that can be analyzed: inertial signals, and if there are such, enough rows."""
    fitting = [stream for stream in streams if stream.likely]
    if not fitting:  # the longest of those that cannot be decoded may have signals
        first = max(streams, key=lambda stream: (bool(stream.why), stream.count))
        none = say("no table of the file has inertial signals by its name or units; it contains {names}; select one "
                   "with {option}",
                   names=_listed(streams), option=_option(first.name if first.why else "NAME"))  # fmt: skip
        raise UsageError(join("; ", (_undecoded(first), none) if first.why else (none,)))
    long = [stream for stream in fitting if stream.count >= SHORTEST] or fitting
    best = max(stream.likely for stream in long)
    return _one_of([stream for stream in long if stream.likely == best])


def _undecoded(stream: Stream) -> Phrase:
    return say("{stream} cannot be decoded: {why}", stream=stream.shown, why=stream.why)


def _named(streams: Sequence[Stream], keys: Sequence[str]) -> tuple[Stream, tuple[str, ...] | None]:
    """The stream named by the keys, and those of its columns that they name; None for all signals."""
    plain = [key.strip().strip("/") for key in keys]
    by_key = [_of_name(streams, key) for key in plain]
    for key, candidates in zip(keys, by_key, strict=True):
        if key.strip().startswith("/") and not candidates:
            raise _unknown(streams, key.strip())
    if not any(by_key):
        return _by_column(streams, plain), tuple(plain)
    named = _single(by_key)
    start = named.key + "/"
    columns = [key[len(start) :] if key.lower().startswith(start) else key for key in plain]
    whole = any(those and not key.lower().startswith(start) for key, those in zip(plain, by_key, strict=True))
    return named, None if whole else tuple(columns)


def _single(by_key: list[list[Stream]]) -> Stream:
    """The stream that keys name; refused if they name several."""
    named = list(dict.fromkeys(_one_of(candidates) for candidates in by_key if candidates))
    if len(named) > 1:
        raise UsageError(say("the channels belong to {number} tables of the file, each with its own clock ({names}); "
                             "analyze one after the other", number=len(named), names=_listed(named)))  # fmt: skip
    return named[0]


def _of_name(streams: Sequence[Stream], key: str) -> list[Stream]:
    """The streams that a key names: itself, one of its columns, or all instances of a name."""
    lower = key.lower()
    inner = [stream for stream in streams if lower.startswith(stream.key + "/")]
    return (
        [stream for stream in streams if stream.name.strip("/") == key]
        or [stream for stream in streams if stream.key == lower]
        or sorted(inner, key=lambda stream: (len(stream.key), key.startswith(stream.name.strip("/"))))[-1:]
        or [stream for stream in streams if stream.key.startswith(lower + "/")]
    )


def _by_column(streams: Sequence[Stream], keys: Sequence[str]) -> Stream:
    """The stream that has a column of one of these names."""
    wanted = {key.lower() for key in keys}
    having = [stream for stream in streams if wanted & {name.lower() for name in stream.columns}]
    if having:
        return _one_of([stream for stream in having if stream.likely] or having)
    fitting = [stream for stream in streams if stream.likely]
    if len(fitting) == 1 or len(streams) == 1:
        return (fitting or streams)[0]  # a position, or a name that the table refuses
    raise _unknown(streams, keys[0])


def _unknown(streams: Sequence[Stream], key: str) -> UsageError:
    every = sorted(streams, key=lambda stream: -stream.likely)
    return UsageError(say("no table or column {key!r} in the file; it contains {names}", key=key, names=_listed(every)))


def _one_of(streams: Sequence[Stream]) -> Stream:
    """The only one of these; refused if there are several."""
    if len(streams) == 1:
        return streams[0]
    raise UsageError(say("the file contains {number} tables that may be meant, each with its own clock ({names}); "
                         "select one with {option}",
                         number=len(streams), names=_listed(streams), option=_option(streams[0].name)))  # fmt: skip


def _option(name: str) -> str:
    quoted = f"'{name}'" if " " in name else name
    return spelled(f"--channels {quoted}", f"channels='{name}'")


def _listed(streams: Iterable[Stream]) -> Phrase:
    return some([stream.shown for stream in streams], MOST_LISTED)


@dataclass(frozen=True, eq=False)
class Dataset:
    """An array in a container, before it is loaded."""

    path: str  # its location, such as "imu0/gyro"
    shape: tuple[int, ...]  # as the container declares it
    dtype: np.dtype[Any]
    load: Callable[[], NDArray[Any]]
    unit: str = ""  # from its attributes, as are the names of columns and the rate in Hz
    names: tuple[str, ...] = ()
    rate: float | None = None
    source: str = ""  # the origin of the rate

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
        stated = [headers.split(header) for header in (self.path, *self.headers)]
        units = [self.unit, *(unit for _, unit in stated)]
        names = [text for name, _ in stated for text in (name, name.rpartition("/")[2])]
        return any(map(headers.inertial, units)) or any(map(headers.sensor_by_name, names))

    def __str__(self) -> str:
        return f"{self.path} ({' x '.join(map(str, self.shape))})"


Family = list[Dataset]


def rated(datasets: Sequence[Dataset], numbers: Mapping[str, float]) -> list[Dataset]:
    """The datasets, each with the nearest sampling rate above it among the single `numbers` of the file."""
    rates = {
        path.rpartition("/")[0]: (value, say("{path!r} in the file", path=path))
        for path, value in numbers.items()
        if path.rpartition("/")[2].lower() in RATE_NAMES and 0 < value < math.inf
    }
    result = []
    for dataset in datasets:
        home = None if dataset.rate else _nearest(dataset, rates)
        result.append(dataset if home is None else replace(dataset, rate=rates[home][0], source=rates[home][1]))
    return result


def _nearest(dataset: Dataset, homes: Iterable[str]) -> str | None:
    """The group that is nearest above a dataset; None if there is none."""
    above = (home for home in homes if not home or f"{dataset.path}/".startswith(f"{home}/"))
    return max(above, key=len, default=None)


def arranged_datasets(
    datasets: Sequence[Dataset], options: Options, notes: Sequence[str] = (), text: str = ""
) -> tuple[FileTable, Options, Family]:
    """The table of the datasets that belong together, the options for it, and these datasets."""
    # `text` is the output of `table.described`, if present.
    series = [dataset for dataset in datasets if dataset.is_series]
    if not series:
        none = say("the file contains no array of samples, with one row per sample")
        contents = [say("it contains {names}", names=some(list(map(str, datasets))))] if datasets else []
        raise DataError(join("; ", (none, *contents, *notes)))
    # the position of the first column of each, counted from 1 over all of them
    firsts = accumulate((len(dataset.headers) for dataset in series), initial=1)
    places = {dataset.path: place for dataset, place in zip(series, firsts, strict=False)}
    family = series if text else _chosen(_families(series), options, places)
    options, family = _narrowed(options, family)
    taken = set(map(id, family))
    rest = [str(dataset) for dataset in datasets if id(dataset) not in taken]
    omitted = [say("left out, of different length, clock or shape: {names}", names=some(rest))] if rest else []
    notes = [*notes, *omitted]
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
    clocks, paces = defaultdict[int, set[str]](set), defaultdict[int, set[float]](set)
    for dataset in series:
        clocks[dataset.length] |= {dataset.parent} if dataset.is_clock else set()
        paces[dataset.length] |= set() if dataset.rate is None else {dataset.rate}
    for dataset in series:
        homes, rates = clocks[dataset.length], paces[dataset.length]
        home = _nearest(dataset, homes) or "" if len(homes) > 1 else ""
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
    lists = "; ".join(some(list(map(str, family))) for family in likely[:20])
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
        names = ((key,) if dataset is None else dataset.headers for key, dataset in zip(keys, whole, strict=True))
        options = replace(options, channels=tuple(chain.from_iterable(names)))
    return options, family
