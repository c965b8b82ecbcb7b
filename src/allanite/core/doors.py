"""What public functions take for a record: samples of other libraries."""

import os
from importlib import import_module
from typing import Any, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from .errors import UsageError, WrongTypeError, given
from .plain import Value
from .record import Record, Recording

NEEDED = {"rate": "a sampling rate", "unit": "a unit"}
EXAMPLE = {"rate": 100, "unit": "deg/s"}
"""What samples need to become a record, and what is typed."""

READERS = "allanite.readers"
"""The package that reads tables; it is imported when one is given."""

Samples = Record | ArrayLike
"""A record, or samples that become one: an array, or a column of pandas or polars."""


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
    known: dict[str, Any] = {**({"unit": unit} if unit else {}), **sampling}
    for key in known.keys() - Sampling.__annotations__:
        raise UsageError(f"{key} describes a file or a table, not an array")
    if missing := [key for key in NEEDED if key not in known]:
        typed = ", ".join(f"{key}={value!r}" for key, value in {**EXAMPLE, **known}.items())
        needed = " and ".join(NEEDED[key] for key in missing)
        raise UsageError(f"an array does not have {needed}: type al.{call}(x, {typed})")
    if np.ndim(source) == 2:
        columns = enumerate(np.asarray(source).T, 1)
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
    found = as_source(source, call, sampling, unit=unit)
    if isinstance(found, Recording):
        if len(found) > 1:
            names = ", ".join(found.channels)
            raise UsageError(f"{call} takes one channel, not {names}: choose one, e.g. [{found.channels[0]!r}]")
        return found[0]
    if not isinstance(found, Record):
        raise WrongTypeError(f"{call} takes a record or samples, not a {type(found).__name__}")
    return found
