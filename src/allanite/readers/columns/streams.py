"""Streams, the tables of a log with a clock each: which one is wanted."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import repeat

from allanite.core.errors import DataError, UsageError
from allanite.core.record import SHORTEST, Recording
from allanite.phrases.phrase import Phrase, join, say, spelled
from allanite.readers.options import Options

from . import headers
from .column import some
from .table import FileTable

MOST = 30
"""Maximum number of streams that a message lists."""


@dataclass(frozen=True, eq=False)
class Stream:
    """One table of a log before it is loaded: a topic, a kind of message, a group of channels, a sheet.

    `name` is unique in the file, such as ``"sensor_gyro/1"``; `count` is the number of rows, `rate` in Hz only for
    messages (None: unknown), `columns` are the names of its columns. `fits` is 0 if it holds no inertial signals; of
    the others, those with the largest are the likely ones. `type` is that of its messages, and `why` says why they
    cannot be decoded; both are empty for most formats.
    """

    name: str
    count: int
    columns: tuple[str, ...]
    table: Callable[[], FileTable]
    rate: float | None = None
    fits: int = 1
    type: str = ""
    why: str = ""

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


def inertial(names: Iterable[str], units: Iterable[str] = repeat("")) -> bool:
    """Whether one of these headers is that of an inertial sensor, by its unit or its name.

    The units are in the headers unless they are given.

    Examples
    --------
    >>> inertial(["time [s]", "gx [deg/s]"]), inertial(["gyro_x"]), inertial(["time [s]", "T [degC]"])
    (True, True, False)
    """
    said = ((name, unit) if unit else headers.split(name) for name, unit in zip(names, units, strict=False))
    return any(headers.inertial(unit) or headers.sensor_by_name(name) for name, unit in said)


def recording(streams: Sequence[Stream], options: Options, notes: Sequence[str] = ()) -> Recording:
    """The channels of the stream that ``options.channels`` names, or else of the only one with inertial signals.

    A key names a stream, a column as ``stream/column``, or a column that only one stream has.
    """
    _, table, narrowed = arranged(streams, options, notes)
    return table.recording(narrowed)


def arranged(
    streams: Sequence[Stream], options: Options, notes: Sequence[str] = ()
) -> tuple[Stream, FileTable, Options]:
    """The stream that is wanted, its table, and the options for that; see `recording`."""
    if not streams:
        raise DataError(say("the file contains no rows of numbers; check that the recording was saved"))
    stream, keys = _named(streams, options.channels) if options.channels else (_only(streams), None)
    if stream.why:
        raise UsageError(_undecoded(stream))
    rest = [other for other in streams if other is not stream and other.fits]
    table = stream.table()
    said = (say("samples of {stream}", stream=stream.shown),) if len(streams) > 1 or stream.type else ()
    left = (say("left out, other tables of the file: {names}", names=_listed(rest)),) if rest else ()
    told = replace(table, notes=(*said, *notes, *table.notes, *left))
    return stream, told, replace(options, channels=keys)


def _only(streams: Sequence[Stream]) -> Stream:
    """The only likely stream that can be analyzed: inertial signals, and if there are such, enough rows."""
    fitting = [stream for stream in streams if stream.fits]
    if not fitting:  # the longest of those that cannot be decoded may have signals
        first = max(streams, key=lambda stream: (bool(stream.why), stream.count))
        none = say(
            "no table of the file has inertial signals by its name or units; it contains {names}; select one with "
            "{option}",
            names=_listed(streams), option=_option(first.name if first.why else "NAME"),
        )  # fmt: skip
        raise UsageError(join("; ", (_undecoded(first), none) if first.why else (none,)))
    long = [stream for stream in fitting if stream.count >= SHORTEST] or fitting
    best = max(stream.fits for stream in long)
    likely = [stream for stream in long if stream.fits == best]
    if len(likely) > 1:
        raise _ambiguous(likely)
    return likely[0]


def _undecoded(stream: Stream) -> Phrase:
    return say("{stream} cannot be decoded: {why}", stream=stream.shown, why=stream.why)


def _named(streams: Sequence[Stream], keys: Sequence[str]) -> tuple[Stream, tuple[str, ...] | None]:
    """The stream named by the keys, and those of its columns that they name; None for all signals."""
    plain = [key.strip().strip("/") for key in keys]
    found = [_of_name(streams, key) for key in plain]
    for key, those in zip(keys, found, strict=True):
        if key.strip().startswith("/") and not those:
            raise _unknown(streams, key.strip())
    if not any(found):
        return _by_column(streams, plain), tuple(plain)
    named = _single(found)
    start = named.key + "/"
    columns = [key[len(start) :] if key.lower().startswith(start) else key for key in plain]
    whole = any(those and not key.lower().startswith(start) for key, those in zip(plain, found, strict=True))
    return named, None if whole else tuple(columns)


def _single(found: list[list[Stream]]) -> Stream:
    """The stream that keys name; refused if they name several."""
    for those in found:
        if len(those) > 1:
            raise _ambiguous(those)
    named = list(dict.fromkeys(stream for those in found for stream in those))
    if len(named) > 1:
        raise UsageError(
            say(
                "the channels belong to {number} tables of the file, each with its own clock ({names}); analyze one "
                "after the other",
                number=len(named),
                names=_listed(named),
            )
        )
    return named[0]


def _of_name(streams: Sequence[Stream], key: str) -> list[Stream]:
    """The streams that a key names: itself, one of its columns, or all instances of a name."""
    lower = key.lower()
    inner = [stream for stream in streams if lower.startswith(stream.key + "/")]
    return (
        [stream for stream in streams if stream.name.strip("/") == key]
        or [stream for stream in streams if stream.key == lower]
        or sorted(inner, key=lambda one: (len(one.key), key.startswith(one.name.strip("/"))))[-1:]
        or [stream for stream in streams if stream.key.startswith(lower + "/")]
    )


def _by_column(streams: Sequence[Stream], keys: Sequence[str]) -> Stream:
    """The stream that has a column of one of these names."""
    wanted = {key.lower() for key in keys}
    having = [stream for stream in streams if wanted & {name.lower() for name in stream.columns}]
    likely = [stream for stream in having if stream.fits] or having
    if len(likely) == 1:
        return likely[0]
    if likely:
        raise _ambiguous(likely)
    fitting = [stream for stream in streams if stream.fits]
    if len(fitting) == 1 or len(streams) == 1:
        return (fitting or streams)[0]  # a position, or a name that the table refuses
    raise _unknown(streams, keys[0])


def _unknown(streams: Sequence[Stream], key: str) -> UsageError:
    every = sorted(streams, key=lambda stream: -stream.fits)
    return UsageError(say("no table or column {key!r} in the file; it contains {names}", key=key, names=_listed(every)))


def _ambiguous(streams: Sequence[Stream]) -> UsageError:
    return UsageError(
        say(
            "the file contains {number} tables that may be meant, each with its own clock ({names}); select one with "
            "{option}",
            number=len(streams),
            names=_listed(streams),
            option=_option(streams[0].name),
        )
    )


def _option(name: str) -> str:
    quoted = f"'{name}'" if " " in name else name
    return spelled(f"--channels {quoted}", f"channels='{name}'")


def _listed(streams: Iterable[Stream]) -> Phrase:
    return some([stream.shown for stream in streams], MOST)
