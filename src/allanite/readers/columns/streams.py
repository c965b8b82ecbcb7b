"""Streams, the tables of a log with a clock each: which one is wanted."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

from allanite.core.errors import DataError, UsageError
from allanite.core.language import Phrase, join, say
from allanite.core.record import SHORTEST, Recording
from allanite.core.wording import spelled
from allanite.readers.options import Options

from . import headers
from .table import Table

MOST = 30
"""Maximum number of streams that a message lists."""


@dataclass(frozen=True, eq=False)
class Stream:
    """One table of a log before it is loaded: a topic, a kind of message, a group of channels, a sheet.

    `name` is unique in the file, such as ``"sensor_gyro/1"``; `count` is the number of rows, `rate` in Hz only for
    messages (None: unknown), `columns` are the names of its columns, `fits` says whether it may hold inertial signals.
    """

    name: str
    count: int
    columns: tuple[str, ...]
    table: Callable[[], Table]
    rate: float | None = None
    fits: bool = True

    @property
    def shown(self) -> Phrase:
        """Its name, number of rows and rate."""
        if self.rate is None:
            return say("{name} ({count} rows)", name=self.name, count=self.count)
        return say("{name} ({count} rows at {rate:.4g} Hz)", name=self.name, count=self.count, rate=self.rate)


def inertial(names: Iterable[str]) -> bool:
    """Whether one of these headers is that of an inertial sensor, by its unit or its name.

    Examples
    --------
    >>> inertial(["time [s]", "gx [deg/s]"]), inertial(["gyro_x"]), inertial(["time [s]", "T [degC]"])
    (True, True, False)
    """
    said = [headers.split(name) for name in names]
    return any(headers.inertial(unit) or headers.sensor_by_name(name) for name, unit in said)


def recording(streams: Sequence[Stream], options: Options, notes: Sequence[str] = ()) -> Recording:
    """The channels of the stream that ``options.channels`` names, or else of the only one with inertial signals.

    A key names a stream, a column as ``stream/column``, or a column that only one stream has.
    """
    if not streams:
        raise DataError(say("the file contains no rows of numbers; check that the recording was saved"))
    stream, keys = _named(streams, options.channels) if options.channels else (_only(streams), None)
    rest = [other.shown for other in streams if other is not stream and other.fits]
    table = stream.table()
    said = (say("samples of {stream}", stream=stream.shown),) if len(streams) > 1 else ()
    left = (say("left out, other tables of the file: {names}", names=_listed(rest)),) if rest else ()
    return replace(table, notes=(*said, *notes, *table.notes, *left)).recording(replace(options, channels=keys))


def _only(streams: Sequence[Stream]) -> Stream:
    """The only stream that can be analyzed: inertial signals, and if there are such, enough rows."""
    fitting = [stream for stream in streams if stream.fits]
    if not fitting:
        names = _listed([stream.shown for stream in streams])
        raise DataError(
            say(
                "no table of the file has inertial signals by its name or units; it contains {names}; select one with "
                "{option}",
                names=names,
                option=_option(streams[0].name),
            )
        )
    long = [stream for stream in fitting if stream.count >= SHORTEST] or fitting
    return long[0] if len(long) == 1 else _refuse(long)


def _named(streams: Sequence[Stream], keys: Sequence[str]) -> tuple[Stream, tuple[str, ...] | None]:
    """The stream named by the keys, and those of its columns that they name; None for all signals."""
    plain = [key.strip().strip("/") for key in keys]
    found = [_of_name(streams, key) for key in plain]
    told = [stream for those in found for stream in those]
    if not told:
        return _by_column(streams, plain), tuple(plain)
    for those in found:
        if len(those) > 1:
            _refuse(those)
    named = list(dict.fromkeys(told))
    if len(named) > 1:
        raise UsageError(
            say(
                "the channels belong to {number} tables of the file, each with its own clock ({names}); analyze one "
                "after the other",
                number=len(named),
                names=_listed([stream.shown for stream in named]),
            )
        )
    start = named[0].name.lower() + "/"
    columns = [key[len(start) :] if key.lower().startswith(start) else key for key in plain]
    whole = any(those and not key.lower().startswith(start) for key, those in zip(plain, found, strict=True))
    return named[0], None if whole else tuple(columns)


def _of_name(streams: Sequence[Stream], key: str) -> list[Stream]:
    """The streams that a key names: itself, one of its columns, or all instances of a name."""
    lower = key.lower()
    names = [(stream.name.lower(), stream) for stream in streams]
    exact = [stream for name, stream in names if name == lower]
    inner = [stream for name, stream in names if lower.startswith(name + "/") and lower != name]
    return (
        exact
        or max(([stream] for stream in inner), key=lambda one: len(one[0].name), default=[])
        or [stream for name, stream in names if name.startswith(lower + "/")]
    )


def _by_column(streams: Sequence[Stream], keys: Sequence[str]) -> Stream:
    """The stream that has a column of one of these names."""
    wanted = {key.lower() for key in keys}
    having = [stream for stream in streams if wanted & {name.lower() for name in stream.columns}]
    likely = [stream for stream in having if stream.fits] or having
    if len(likely) == 1:
        return likely[0]
    if likely:
        return _refuse(likely)
    fitting = [stream for stream in streams if stream.fits]
    if len(fitting) == 1 or len(streams) == 1:
        return (fitting or streams)[0]  # a position, or a name that the table refuses
    raise UsageError(
        say(
            "no table or column {key!r} in the file; it contains {names}",
            key=keys[0],
            names=_listed([stream.shown for stream in fitting or streams]),
        )
    )


def _refuse(streams: Sequence[Stream]) -> Stream:
    raise UsageError(
        say(
            "the file contains {number} tables that may be meant, each with its own clock ({names}); select one with "
            "{option}",
            number=len(streams),
            names=_listed([stream.shown for stream in streams]),
            option=_option(streams[0].name),
        )
    )


def _option(name: str) -> str:
    quoted = f"'{name}'" if " " in name else name
    return spelled(f"--channels {quoted}", f"channels='{name}'")


def _listed(names: Iterable[str]) -> Phrase:
    every = list(names)
    more = [say("{number} more", number=len(every) - MOST)] if len(every) > MOST else []
    return join(", ", [*every[:MOST], *more])
