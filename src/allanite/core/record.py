"""Record: one evenly sampled channel. Recording: several. What public functions take for them."""

import os
from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from importlib import import_module
from typing import Annotated, Any, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from allanite.phrases.phrase import join, say

from .aliases import constructed, public
from .arrays import LARGEST, FloatArray, samples, unmasked
from .errors import DataError, UsageError, WrongTypeError, given
from .habits import demand_own
from .kinds import KINDS, explain_kinds, offered, signal_of_kind
from .names import demand_name
from .plain import Header, Value
from .ranges import POSITIVE
from .units import Signal, convert, unit_of
from .validity import Finding

MOMENTS = ("mean", "std", "var", "median", "min", "max")
"""Functions of numpy that are methods of a record; they omit missing samples."""

SCALE = POSITIVE._replace(what="the scale")

SHORTEST = 200  # number of samples below which no noise coefficient is reported


def header_dict(record: "Record | Header", kind: str) -> dict[str, Any]:
    """The first keys of a stored channel: its type and the properties of its record."""
    header = record if isinstance(record, Header) else record.header
    return header.to_dict() | {"type": kind}


@constructed
@dataclass(frozen=True, eq=False, repr=False)
class Record(Value):
    """One evenly sampled channel of an inertial sensor.

    Attributes
    ----------
    values : array, shape (n,)
        Samples in `unit`; integers for ``kind="count"``. NaN marks a missing sample and is kept.
    rate : float
        Sampling rate, Hz: number of intervals, missing ones included, over the time between the first and last time
        stamp.
    unit : str
        Unit of `values` (of `scale` for counts).
    kind : {"rate", "increment", "angle", "count", "value"}
        What a sample represents; "angle" has n + 1 points for n intervals. Of a "value" the noise of the quantity
        itself is wanted: of an angle error in arcsec, a voltage, a temperature.
    scale : float, optional
        Size of one step of `values` in `unit`; needed for counts.
    name, start, history
        Name of the channel; time of the first sample, s; processing steps, oldest first.
    cut : float
        Time cut off before the first sample, s. Messages give times of the whole recording, as ``--from`` and
        ``--until`` take them.
    signal : Signal
        The type of sensor, from the unit and the kind; not given.
    factor : float
        Size of one step of `values` in SI; not given.

    Raises
    ------
    UsageError
        The rate, unit, kind or scale is missing or impossible, or they contradict each other.
    DataError
        The values are not a one-dimensional array of real numbers with at least 2 intervals.

    Examples
    --------
    >>> record = Record([1.0, 3.0, 2.0], rate=100.0, unit="deg/h", kind="rate", name="z")
    >>> record.size, record.duration, record.signal.name
    (3, 0.03, 'gyro')
    """

    values: NDArray[Any]
    rate: float
    unit: str
    kind: str = "rate"
    scale: Annotated[float | None, SCALE] = None
    name: str = ""
    start: float | None = None
    history: tuple[str, ...] = ()
    cut: float = 0.0
    factor: float = field(init=False, repr=False)
    signal: Signal = field(init=False, repr=False)

    def __post_init__(self) -> None:
        demand_name("kind", self.kind, KINDS)
        if self.kind == "count" and self.scale is None:
            raise UsageError("counts need the size of one pulse, for example scale=0.1 with unit='arcsec' "
                             f"({self.name})")  # fmt: skip
        unit, signal = unit_of(self.unit), signal_of_kind(self.unit, self.kind)
        if signal is None:
            known = offered(self.unit)
            remedy = f"choose what a sample is: {known}" if known else explain_kinds()
            raise UsageError(f"unit {self.unit!r} does not fit kind {self.kind!r} of {self.name!r}; {remedy}")
        object.__setattr__(self, "values", samples(self.values, self.unit, self.kind, self.name))
        object.__setattr__(self, "rate", float(self.rate))
        object.__setattr__(self, "factor", unit.factor * (1.0 if self.scale is None else float(self.scale)))
        object.__setattr__(self, "signal", signal)

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, which: int | slice) -> Any:
        """A sample, or with ``record[first:last]`` the record of these samples."""
        if not isinstance(which, slice):
            return self.values[which]
        first, last, step = which.indices(len(self.values))
        if step != 1:
            raise UsageError(f"a record has every sample: type al.prepare.decimate(record, {step})")
        part = self.with_values(self.values[first:last], say("samples {first} to {last}", first=first, last=last - 1),
                                start=(self.start or 0.0) + first / self.rate)  # fmt: skip
        return replace(part, cut=self.cut + first / self.rate)

    @property
    def time(self) -> FloatArray:
        """Time of each sample, s."""
        return (self.start or 0.0) + np.arange(len(self.values)) / self.rate

    @public
    def to(self, unit: str) -> "Record":
        """The same record in another unit."""
        factor = convert(1.0, self.unit, unit)
        if self.scale is not None:
            return replace(self, unit=unit, scale=self.scale * factor)
        return replace(self, unit=unit, values=self.values * factor)

    def _named(self, name: str) -> Any:
        return partial(getattr(np, f"nan{name}"), self.values) if name in MOMENTS else None

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self.values, dtype=dtype, copy=copy)

    @property
    def size(self) -> int:
        """Number of sample intervals."""
        return len(self.values) - KINDS[self.kind][1]

    @property
    def interval(self) -> float:
        """Sample interval tau0, s."""
        return 1.0 / self.rate

    @property
    def duration(self) -> float:
        """Length, s."""
        return self.size / self.rate

    @property
    def constant(self) -> float | int:
        """A constant to subtract before integrating: the median of 101 values spread over the record.

        It is one of the record's own values, so that quantized differences stay exact, and a bias of a million standard
        deviations costs no digit of a statistic that is insensitive to it.
        """
        sample = self.values[np.linspace(0, len(self.values) - 1, 101).astype(np.int64)]
        finite = np.sort(sample[np.isfinite(sample)])
        return finite[len(finite) // 2].item() if len(finite) else 0

    @cached_property
    def bounds(self) -> tuple[Any, Any]:
        """Least and largest value; NaN where one is missing."""
        return self.values.min(), self.values.max()

    @property
    def complete(self) -> bool:
        """Whether all values are finite."""
        return bool(np.isfinite(self.bounds).all())

    @cached_property
    def extent(self) -> tuple[float, float]:
        """Least and largest finite value; NaN where there is none."""
        low, high = self.bounds
        if not self.complete:
            finite = self.values[np.isfinite(self.values)]
            low, high = (finite.min(), finite.max()) if finite.size else (np.nan, np.nan)
        return float(low), float(high)

    @property
    def integrated(self) -> bool:
        """Whether a sample is the signal integrated over time, not the signal itself."""
        return KINDS[self.kind][0] != 0

    @property
    def steps(self) -> NDArray[Any]:
        """The unscaled output in each interval, shape (size,): the values, or the differences of an angle."""
        return np.diff(self.values) if self.kind == "angle" else self.values

    @property
    def rate_factor(self) -> float:
        """Factor that converts `steps` to rates in SI."""
        return self.factor * (self.rate if self.integrated else 1.0)

    @property
    def rate_values(self) -> FloatArray:
        """Mean rate over each interval in SI, shape (size,)."""
        return np.asarray(self.steps * self.rate_factor, dtype=np.float64)

    @property
    def angle(self) -> FloatArray:
        """Angle in SI, shape (size + 1,), zero at the start."""
        if self.kind == "angle":
            return np.asarray((self.values - self.values[0]) * self.factor, dtype=np.float64)
        steps = self.rate_values * self.interval
        return np.concatenate(([0.0], np.cumsum(steps)))

    @property
    def header(self) -> Header:
        """All properties except the samples."""
        own = {f.name: getattr(self, f.name) for f in fields(Header)}
        return Header(**own)

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data of the `header`: samples are not stored."""
        return self.header.to_dict(level)

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Any:
        """The `Header` of the record: samples are not stored."""
        return Header.from_dict(data)

    def _summary(self) -> str:
        return self.header._summary()

    @cached_property
    def out_of_range(self) -> str:
        """Why squares of the values, or of their differences, cannot be computed; empty if they can."""
        infinite = np.zeros(0, bool) if self.complete else np.isinf(self.values)
        if infinite.any():
            return say("{infinite} of {size} samples are infinite, the first at sample {first}; if they are "
                       "missing, replace them by NaN", infinite=infinite.sum(), size=infinite.size,
                       first=int(infinite.argmax()))  # fmt: skip
        low, high = self.extent
        largest, spread = max(-low, high) * self.rate_factor, (high - low) * self.rate_factor
        if largest > LARGEST:
            return say("values of up to {largest:.3g} {unit} are too large for any sensor (at most {most:g}): check "
                       "the unit, the scale and the type of the numbers", largest=largest, unit=self.signal.si[0],
                       most=LARGEST)  # fmt: skip
        if 0 < spread < 1 / LARGEST:
            return say("values differ by {spread:.3g} {unit} at most, less than can be computed with ({least:g}): "
                       "check the unit, the scale and the type of the numbers", spread=spread, unit=self.signal.si[0],
                       least=1 / LARGEST)  # fmt: skip
        return ""

    def demand_range(self) -> None:
        """Refuse values that are `out_of_range`, as DataError."""
        if self.out_of_range:
            raise DataError(join(": ", (self.name or say("the record"), self.out_of_range)))

    def with_values(self, values: NDArray[Any], what: str, *, start: float | None = None) -> "Record":
        """Another record of the same channel, with `what` added to its history.

        Counts that are no longer integers become increments of the same size.
        """
        kind = "increment" if self.kind == "count" and values.dtype.kind == "f" else self.kind
        return replace(self, values=values, kind=kind, start=start, history=(*self.history, what))


@dataclass(frozen=True, eq=False, repr=False)
class Recording(Value):
    """Records with common sample times, by name and in channel order.

    Attributes
    ----------
    records : tuple of Record
    source, digest : str
        Origin of the data: path and sha256.
    notes : tuple of str
        Assumptions made when reading.
    findings : tuple of Finding
        Defects of the common clock.
    others : tuple of Record
        Columns of the same file that are not channels but may explain them: temperatures, supply voltages.

    Examples
    --------
    >>> z = Record([1.0, 3.0, 2.0], rate=100.0, unit="deg/h", kind="rate", name="z")
    >>> recording = Recording((z,))
    >>> recording["z"] is recording[0], recording.channels
    (True, ('z',))
    """

    records: tuple[Record, ...]
    source: str = ""
    digest: str = ""
    notes: tuple[str, ...] = ()
    findings: tuple[Finding, ...] = ()
    others: tuple[Record, ...] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.records, (tuple, list)) or not all(
            isinstance(r, (Record, Header)) for r in self.records
        ):
            raise WrongTypeError(f"Recording: records must be a tuple of Records, not {given(self.records)}")
        names = self.channels
        if not names:
            raise DataError(say("a recording needs at least one channel"))
        if len(set(names)) < len(names):
            raise UsageError(f"channel names must differ: {', '.join(names)}")

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels."""
        return tuple(record.name for record in self.records)

    def __getitem__(self, key: str | int) -> Record:
        if isinstance(key, int):
            return self.records[key]
        demand_name("channel", key, self.channels)
        return self.records[self.channels.index(key)]

    def __iter__(self) -> Iterator[Record]:
        return iter(self.records)

    def __len__(self) -> int:
        return len(self.records)

    def _summary(self) -> str:
        first = self.records[0]
        return f"of {first.size} intervals at {first.rate:g} Hz: {', '.join(self.channels)}"


NEEDED = {"rate": "a sampling rate", "unit": "a unit"}
EXAMPLE = {"rate": 100, "unit": "deg/s"}  # what samples need to become a record, and what is typed
READERS = "allanite.readers"  # the package that reads tables; it is imported when one is given

Samples = Record | ArrayLike  # a record, or samples that become one: an array, or a column of pandas or polars


class Sampling(TypedDict, total=False):
    """What an array does not say of its samples: arguments of `Record`."""

    rate: float
    fs: float
    unit: str
    kind: str
    scale: float
    name: str


def as_source(source: Any, call: str, sampling: Sampling, *, unit: str = "") -> Any:
    """The record of an array or column, the recording of a table or of a two-dimensional array; a result as it is."""
    if isinstance(source, Value):
        demand_own(call, sampling)
        if sampling:
            raise UsageError(f"a {type(source).__name__} has its own {' and '.join(sampling)}: omit what was given")
        return source
    if isinstance(source, str | os.PathLike):
        path = os.fspath(source)
        raise UsageError(f"{call} takes samples, not a file; read it first: al.{call}(al.read({given(path)})[0])")
    if hasattr(source, "to_frame") and _describes_itself(source, sampling):
        return import_module(READERS).read(source.to_frame(), **sampling)[0]
    if hasattr(source, "columns"):
        return import_module(READERS).read(source, **sampling)
    if not np.ndim(source):
        raise WrongTypeError(f"{call} takes a record or samples, not {given(source)} ({type(source).__name__})")
    demand_own(call, sampling)
    known: dict[str, Any] = {**({"unit": unit} if unit else {}), **sampling}
    for key in known.keys() - Sampling.__annotations__:
        raise UsageError(f"{key} describes a file or a table, not an array")
    if missing := [key for key in NEEDED if key not in known]:
        typed = ", ".join(f"{key}={value!r}" for key, value in {**EXAMPLE, **known}.items())
        needed = " and ".join(NEEDED[key] for key in missing)
        raise UsageError(f"an array does not have {needed}: type al.{call}(x, {typed})")
    if np.ndim(source) == 2:
        columns = enumerate(unmasked(source).T, 1)
        return Recording(tuple(Record(column, **{**known, "name": str(i)}) for i, column in columns))
    name = getattr(source, "name", None)
    return Record(source, **{"name": "" if name is None else str(name), **known})


def _describes_itself(column: Any, sampling: Sampling) -> bool:
    """Whether what is not given is in the name of a column, as ``gx [deg/s]``, or in its index of times."""
    index = getattr(getattr(column, "index", None), "dtype", None)
    timed = "rate" not in sampling and getattr(index, "kind", "") in ("M", "m")
    return timed or ("unit" not in sampling and "[" in str(column.name))


def as_record(source: Any, call: str, sampling: Sampling, *, unit: str = "") -> Record:
    """The record of what is one channel; parameters and errors are those of `as_source`."""
    record = as_source(source, call, sampling, unit=unit)
    if isinstance(record, Recording):
        if len(record) > 1:
            names = ", ".join(record.channels)
            raise UsageError(f"{call} takes one channel, not {names}: choose one, e.g. [{record.channels[0]!r}]")
        return record[0]
    if not isinstance(record, Record):
        raise WrongTypeError(f"{call} takes a record or samples, not a {type(record).__name__}")
    return record
