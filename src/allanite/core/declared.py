"""Values against the types that parameters declare."""

import math
import re
import types
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import cache
from importlib import import_module
from itertools import islice
from numbers import Integral, Real
from os import PathLike
from typing import Any, Literal, NamedTuple, Union, get_args, get_type_hints

import numpy as np

from .arrays import LARGEST
from .encoding import derived
from .errors import UsageError, given
from .ranges import RATE, Range

MAX_ITEMS = 1000  # items of a sequence that are looked at
MAX_RANGE = 10_000_000  # items of a range, which become numbers of Python of some 40 bytes each

SIZES: dict[str, Range] = {"rate": RATE}
"""The numbers of a name whose type states none; of other names, what is beyond any computation is refused."""

CONVERTED = ("__array__", "to_numpy", "magnitude", "to_value")
"""What arrays, columns and quantities of other libraries have, of which `samples` makes arrays."""


class Kind(NamedTuple):
    """A phrase for the values of a type, and whether a value is one, given the arguments of the type."""

    words: Callable[[tuple[Any, ...]], str]
    holds: Callable[[Any, tuple[Any, ...]], bool]


class _Public(dict[str, Any]):
    """Public names, for annotations in modules that do not import them at run time."""

    def __missing__(self, name: str) -> Any:
        public = getattr(import_module("allanite"), name, None)
        if not isinstance(public, type):
            raise KeyError(name)
        return public


def misfit(value: Any, hint: Any) -> str:
    """A phrase for the values of the type `hint` if the given one is none; empty if it is one."""
    return "" if _holds(value, hint) else _words(hint)


def demand_size(name: str, value: Any, hint: Any) -> None:
    """Refuse a number, or a range, of a size that none of its name and type can have."""
    if isinstance(value, range) and value[MAX_RANGE:]:
        raise UsageError(f"{name} must have at most {MAX_RANGE} items, not {given(value)}")
    members = get_args(hint) or (hint,)
    if not isinstance(value, Real) or np.random.Generator in members or not {int, float} & set(members):
        return
    # compared as it is, for an integer need not have a float; single precision would not hold the limits
    number: Any = value.item() if isinstance(value, np.floating) else value
    size, low, high = abs(number), 1 / LARGEST**2, LARGEST**2
    if name in SIZES:
        SIZES[name].demand(number, name)
    elif isinstance(number, Integral) and size >= 2**63:
        raise UsageError(f"{name} must be below 2^63, not {given(number)}")
    elif size and math.isfinite(size) and not (isinstance(number, Integral) or low <= size <= high):
        raise UsageError(f"{name} must be between {low:g} and {high:g} in size, not {given(number)}")


def demand_fields(settings: Any, but: Collection[str] = ()) -> None:
    """Refuse a field of another type than its class declares."""
    for name, hint in fields_of(type(settings)).items():
        if name not in but and (expected := misfit(getattr(settings, name), hint)):
            what = given(getattr(settings, name))
            raise UsageError(f"{type(settings).__name__}: {name} must be {expected}, not {what}")


def parameters(function: Callable[..., Any]) -> dict[str, Any]:
    """The declared type of each parameter of a function."""
    declared = {name: hint for name, hint in function.__annotations__.items() if name != "return"}
    named = types.SimpleNamespace(__annotations__=declared)
    return get_type_hints(named, getattr(function, "__globals__", {}), _Public())


def fields_of(cls: type) -> dict[str, Any]:
    """The declared type of each field of a dataclass; none if one names what only type checkers import."""
    try:
        return parameters(cls.__init__)  # type: ignore[misc]
    except NameError:
        return {}


def _holds(value: Any, hint: Any) -> bool:
    kind, args = _kind(hint)
    return kind.holds(value, args)


def _words(hint: Any) -> str:
    kind, args = _kind(hint)
    return kind.words(args)


@cache
def _kind(hint: Any) -> tuple[Kind, tuple[Any, ...]]:
    origin, args = derived(hint)
    if origin in TYPE_KINDS:
        return TYPE_KINDS[origin], args
    unchecked = getattr(origin, "_is_protocol", False) and not getattr(origin, "_is_runtime_protocol", False)
    if unchecked or not isinstance(origin, type):
        return TYPE_KINDS[Any], ()  # whatever converts it says what it takes
    if origin.__module__.startswith("numpy._typing"):
        return ARRAY_LIKE, ()
    return Kind(lambda _: _named(origin), lambda value, _: isinstance(value, origin)), ()


def _named(cls: type) -> str:
    """The class by its name, a protocol as it is described."""
    if getattr(cls, "_is_protocol", False):
        return re.split("[.,:]", cls.__doc__ or "")[0].lower()
    return f"a{'n' * (cls.__name__[0] in 'AEIOU')} {cls.__name__}"


def _union(args: tuple[Any, ...]) -> str:
    """The members, each once and None last; what an array can be made of, in one."""
    if any(_kind(hint)[0] is ARRAY_LIKE for hint in args):
        args = tuple(hint for hint in args if hint not in (complex, bytes, str))
    words = dict.fromkeys(_words(hint) for hint in sorted(args, key=lambda hint: hint is types.NoneType))
    *first, last = words
    return f"{', '.join(first)} or {last}" if first else last


def _of(words: str, args: tuple[Any, ...]) -> str:
    """A container and what is in it: ``a sequence of numbers``."""
    plain = [item for item in map(_words, args[-1:]) if item.startswith(("a ", "an ")) and " or " not in item]
    return words + "".join(f" of {item.split(' ', 1)[1]}s" for item in plain if " of " not in item)


def _items(value: Any, hints: Iterable[Any]) -> bool:
    return all(_holds(item, hint) for item, hint in zip(islice(value, MAX_ITEMS), hints, strict=False))


def _sequence(value: Any, args: tuple[Any, ...]) -> bool:
    if isinstance(value, np.ndarray):
        differing = MAX_ITEMS if value.dtype.hasobject else 1
        return value.ndim > 0 and (not args or (value.ndim == 1 and _items(value.flat, args[:1] * differing)))
    kinds = Sequence if args[:1] in ((float,), (int,)) else (Sequence, set, frozenset)
    many = isinstance(value, kinds) or (hasattr(value, "__len__") and hasattr(value, "iloc"))
    return many and not isinstance(value, (str, bytes)) and (not args or _items(value, (args[0],) * MAX_ITEMS))


def _array(value: Any, args: tuple[Any, ...]) -> bool:
    """Whether it is an array, or can be made one of the type of number that is declared."""
    if not isinstance(value, np.ndarray) and any(hasattr(value, name) for name in CONVERTED):
        return True
    if not _sequence(value, ()):
        return False
    (declared,) = get_args(args[1]) if len(args) > 1 else (Any,)
    kinds = {np.float64: "biuf", np.int64: "iu"}.get(declared)
    try:
        return not kinds or isinstance(value, range) or np.asarray(value).dtype.kind in kinds
    except (ValueError, TypeError, OverflowError):
        return False


def _regular(value: Any, _: tuple[Any, ...]) -> bool:
    """Whether the rows of a list of lists are equally long; whatever converts other values says what it takes."""
    if not isinstance(value, (list, tuple)) or not any(isinstance(row, (list, tuple)) for row in value):
        return True
    try:
        return np.asarray(value).ndim > 0
    except ValueError:
        return False


def _tuple(value: Any, args: tuple[Any, ...]) -> bool:
    if not isinstance(value, (tuple, list)):
        return False
    if not args or args[-1] is Ellipsis:
        return _sequence(value, args[:1])
    return len(value) == len(args) and _items(value, args)


def _tuple_words(args: tuple[Any, ...]) -> str:
    if not args or args[-1] is Ellipsis:
        return _of("a tuple", args[:1])
    return f"({', '.join(_words(hint) for hint in args)})"


def _is(words: str, *kinds: type, but: tuple[type, ...] = ()) -> Kind:
    return Kind(lambda _: words, lambda value, _: isinstance(value, kinds) and not isinstance(value, but))


UNCOUNTED = (bool, np.timedelta64)  # what Python takes for an integer

ARRAY_LIKE = Kind(lambda _: "an array", _regular)
_anything = Kind(lambda _: "", lambda value, _: True)
_alternatives = Kind(_union, lambda value, args: any(_holds(value, hint) for hint in args))
_many = Kind(lambda args: _of("a sequence", args), _sequence)
_table = Kind(lambda args: _of("a mapping", args), lambda value, args: isinstance(value, Mapping)
              and (not args or _items(value.values(), args[1:] * MAX_ITEMS)))  # fmt: skip

TYPE_KINDS: dict[Any, Kind] = {
    Any: _anything, object: _anything, types.NoneType: _is("None", types.NoneType),
    bool: _is("True or False", bool, np.bool_), int: _is("an integer", Integral, but=UNCOUNTED),
    float: _is("a number", Real, but=UNCOUNTED), str: _is("a string", str), PathLike: _is("a path", PathLike),
    Literal: Kind(lambda args: f"one of {', '.join(map(repr, args))}", lambda value, _: isinstance(value, str)),
    np.ndarray: Kind(lambda _: "an array", _array),
    Callable: Kind(lambda _: "a function", lambda value, _: callable(value)),
    tuple: Kind(_tuple_words, _tuple), list: _many, Sequence: _many, dict: _table, Mapping: _table,
    Iterable: Kind(lambda args: _of("an iterable", args),
                   lambda value, _: np.iterable(value) and not isinstance(value, (str, bytes))),
    Union: _alternatives, types.UnionType: _alternatives,
}  # fmt: skip
"""The kind of a type, or of the type that it is derived from; any other class has its instances."""
