"""Storable values: every result can be pickled, written as plain data and read again, and has a one-line form."""

import importlib
import os
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, fields
from functools import cache, partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any, ClassVar, Self, cast, get_type_hints

from .aliases import public
from .encoding import plain, read_key, write_plain
from .errors import StoredError, UsageError, given, unfit
from .habits import REMEDIES, remedy
from .kinds import KINDS
from .limits import demand_stored_rate
from .names import demand_name, nearest, unknown
from .units import Signal

VERSION = 1  # version of the plain data, stored under "allanite"
MAX_REPR = 120  # maximum length of a `repr`

TYPES: "dict[str, type[Value]]" = {}
"""Every kind of value that is imported, by its "type"; a class is here as soon as it is defined."""

RESULTS = "allanite.reporting"
"""The package that knows all results; it is imported when a stored type is not known yet, or a notebook shows one."""


class Portable:
    """A value that is pickled by its fields alone; cached results are computed again."""

    def __getstate__(self) -> dict[str, Any]:
        return {f.name: getattr(self, f.name) for f in fields(self)}  # type: ignore[arg-type]  # a dataclass inherits it

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)


class Value(Portable):
    """A frozen dataclass that can be stored and read again; declared with ``repr=False`` to keep the short `repr`.

    The form of the plain data follows from the types of the fields. `_keys` names fields stored under another key,
    `_also` properties that are written for readers but not read again, `_called` attributes by their names in other
    libraries. Of data that are read, the fields of each text
    of `_alike` must have as many items, and `_checks` refuse what else a field cannot be.

    >>> from dataclasses import dataclass
    >>> @dataclass(frozen=True, repr=False)
    ... class Offset(Value):
    ...     size: float
    ...     unit: str = "deg/h"
    >>> Offset(0.5).to_dict(), Offset.from_dict({"size": 0.5})
    ({'allanite': 1, 'type': 'Offset', 'size': 0.5, 'unit': 'deg/h'}, <Offset size=0.5 unit='deg/h'>)
    """

    _keys: ClassVar[dict[str, str]] = {}
    _also: ClassVar[tuple[str, ...]] = ()
    _called: ClassVar[Mapping[str, str]] = {}
    _alike: ClassVar[tuple[str, ...]] = ()
    _checks: ClassVar[Mapping[str, Callable[[Any], None]]] = {}

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        TYPES.setdefault(cls.__name__, cls)

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data that JSON can hold, with confidence limits at `level`."""
        data: dict[str, Any] = {"allanite": VERSION, "type": type(self).__name__}
        data |= {self._keys.get(n, n): write_plain(getattr(self, n), hint, level)
                 for n, hint in stored_fields(type(self))}  # fmt: skip
        return data | {name: plain(getattr(self, name), level) for name in self._also}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Self:
        """The value written by `to_dict`; its limits are known for the stored level only.

        Raises
        ------
        UsageError
            The data are of another type or version, or lack a field, or it is not of its type; the message begins with
            the path of the field.
        """
        if not isinstance(data, dict):
            raise unfit(data, f"a table of a {cls.__name__}")
        if data.get("type", cls.__name__) != cls.__name__ and issubclass(class_of(data), cls):
            return cast(Self, class_of(data).from_dict(data))
        demand_type(data, cls.__name__)
        return cls._stored(data)

    @classmethod
    def _stored(cls, data: dict[str, Any]) -> Self:
        """The value of data of this type."""
        value = cls(**read_fields(cls, data))
        for names in cls._alike:
            parts = (attrgetter(name)(value) for name in names.split())
            if len({len(part) for part in parts if part is not None}) > 1:
                raise StoredError(f"{', '.join(names.split())} must have as many items: the data were changed")
        return value

    def __repr__(self) -> str:
        text = f"<{type(self).__name__} {self._summary()}".rstrip().replace("\n", "; ")
        return (text if len(text) < MAX_REPR else text[: MAX_REPR - 5] + " ...") + ">"

    def _summary(self) -> str:
        """The content of `repr`: the fields that are words or numbers."""
        shown = ((f.name, getattr(self, f.name)) for f in fields(self) if f.repr)  # type: ignore[arg-type]
        named = sorted(((n, short(item)) for n, item in shown if short(item)), key=lambda pair: pair[0] != "name")
        return " ".join(f"{name}={text}" for name, text in named)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """What is called otherwise in other libraries; functions of `allanite` with this value."""
            cls = type(self)
            if hasattr(own := getattr(cls, name, None), "__get__"):  # a property that has raised the error
                return own.__get__(self, cls)
            if not name.startswith("_") and name not in {f.name for f in fields(self)}:
                if name in cls._called:
                    return getattr(self, cls._called[name])
                if name in ("report", "export"):
                    return partial(getattr(importlib.import_module("allanite"), name), self)
                if (part := self._named(name)) is not None:
                    return part
            call = remedy(REMEDIES, name).format(value=cls.__name__.lower())
            parts = self.__dict__.get("channels", ())  # which are reached by their names
            named = [part.name for part in parts if hasattr(part, "name")] if isinstance(parts, tuple) else []
            known = [*(f.name for f in fields(self)), *dir(cls), *named]
            meant = "" if call or name.startswith("_") else nearest(name, [word for word in known if word[:1] != "_"])
            more = f": type {call}" * bool(call) + f"; did you mean {meant}?" * bool(meant)
            raise AttributeError(f"a {cls.__name__} has no {name}{more}", name=name, obj=self)

    def _named(self, name: str) -> Any:
        """A part by its name, as of a study a channel; None if there is none of this name."""

    def plot(self, *args: Any, **options: Any) -> Any:
        """Draw the value; arguments are those of `allanite.plot`, or the path alone."""
        if "ax" in options:
            raise UsageError("plot makes a figure of its own; in other axes draw a curve by ax.loglog(*curve)")
        if args and isinstance(args[0], str | os.PathLike):
            options["path"], args = args[0], args[1:]
        return importlib.import_module(RESULTS).plot(self, *args, **options)

    def summary(self, **options: Any) -> str:
        """The value as text, as at the terminal; `level`, `width` (120), `color` and `lang` are its options."""
        return str(importlib.import_module(RESULTS).table(self, **options))

    def to_dataframe(self, **options: Any) -> Any:
        """The numbers as a DataFrame of pandas, with the columns of the CSV file; `level` is that of the limits.

        Of a study its coefficients, and with ``coefficients=False`` its curves.
        """
        headings, rows = importlib.import_module(RESULTS).numbers(self, **{"coefficients": None, **options})
        return importlib.import_module("pandas").DataFrame(rows, columns=list(headings))

    def _repr_html_(self) -> str:
        """What a notebook shows; the renderer is imported only then."""
        return str(importlib.import_module(RESULTS).html_of(self))


def short(item: object) -> str:
    """A word or number for a `repr`; empty for anything larger or missing."""
    if isinstance(item, bool):
        return str(item)
    if isinstance(item, (int, float)):
        return f"{item:g}" if isinstance(item, float) else str(item)
    return repr(item) if isinstance(item, str) and item else ""


def stored_fields(cls: type[Value], beyond: type[Value] | None = None) -> tuple[tuple[str, Any], ...]:
    """Name and type of each field of a value; only those `beyond` a base class, if one is given."""
    common = set() if beyond is None else {name for name, _ in _fields(cast(Any, beyond))}
    return tuple((name, hint) for name, hint in _fields(cast(Any, cls)) if name not in common)


@cache
def _fields(cls: Any) -> tuple[tuple[str, Any], ...]:
    hints = get_type_hints(cls)
    return tuple((f.name, hints[f.name]) for f in fields(cls) if f.init)


def read_fields(cls: type[Value], data: dict[str, Any], *apart: str) -> dict[str, Any]:
    """The fields of a class, but those `apart`, from plain data; what has a default may be missing."""
    optional = {f.name for f in fields(cls) if f.default is not MISSING or f.default_factory is not MISSING}  # type: ignore[arg-type]
    keys = {name: cls._keys.get(name, name) for name, _ in stored_fields(cls) if name not in apart}
    values = {name: read_key(data, keys[name], hint) for name, hint in stored_fields(cls) if name in keys
              and (keys[name] in data or name not in optional)}  # fmt: skip
    for name in cls._checks.keys() & values.keys():
        try:
            cls._checks[name](values[name])
        except UsageError as error:
            raise StoredError.at(f".{keys[name]}", error) from None
    return values


def demand_type(data: dict[str, Any], name: str) -> None:
    """Check that plain data are of this version and, if they state it, of this type."""
    if data.get("type", name) != name:
        kind = given(data["type"]).strip("'")
        raise StoredError(f"these data are a {kind}, not a {name}; use allanite.from_dict, which reads both")
    if data.get("allanite", VERSION) != VERSION:
        raise StoredError(f"these data have version {given(data['allanite'])}; this program reads version {VERSION}")


@public
def from_dict(data: Any) -> Any:
    """Any result, from the data written by its `to_dict`.

    Parameters
    ----------
    data : dict
        Plain data; "type" names the class.

    Raises
    ------
    UsageError
        The type is unknown, or the data are incomplete.

    Examples
    --------
    >>> import allanite as al
    >>> from_dict(al.N(0.01, "deg/sqrt(h)").to_dict()) == al.N(0.01, "deg/sqrt(h)")
    True
    """
    return class_of(data).from_dict(data)


def class_of(data: dict[str, Any]) -> type[Value]:
    """The class of a stored value, by its "type"."""
    name = read_key(data, "type", str) if isinstance(data, dict) and "type" in data else None
    if name is not None and name not in TYPES:
        importlib.import_module(f"{RESULTS}.views").import_type(name)
    if name is None or name not in TYPES:
        known = sorted(known for known, cls in TYPES.items() if not cls.__subclasses__())
        nothing = UsageError("stored data without a type cannot be read: they are no result of allanite")
        raise nothing if name is None else unknown("type", name, known, where=" of stored data", listed=False)
    return TYPES[name]


@dataclass(frozen=True, repr=False)
class Header(Value):
    """The properties of a record without its samples; the attributes are those of `Record`.

    Results that were stored and read again hold it instead of the record.
    """

    _checks: ClassVar = {"rate": demand_stored_rate, "kind": lambda kind: demand_name("kind", kind, KINDS)}

    name: str
    rate: float
    size: int
    unit: str
    kind: str
    scale: float | None
    start: float | None
    history: tuple[str, ...]
    signal: Signal

    @property
    def duration(self) -> float:
        """Length, s."""
        return self.size / self.rate

    def _summary(self) -> str:
        return f"{self.name!r}: {self.kind} in {self.unit}, {self.size} intervals at {self.rate:g} Hz"


def header_from(data: dict[str, Any]) -> Header:
    """The header that `header_dict` has written, among other keys."""
    return Header.from_dict({**data, "type": "Header"})
