"""Conversion of a field to plain data for JSON and back, by the type of the field, without loss.

JSON has no non-finite numbers: NaN becomes null, infinities become "inf"
and "-inf"; NaN becomes "nan" where the field may also be None.
"""

import math
import types
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple, Union, get_args, get_origin

import numpy as np

from .limits import Stored
from .units import Signal, signal_named

NOT_FINITE = ("nan", "inf", "-inf")


class Codec(NamedTuple):
    """How values of one kind of type are written and read.

    `write` takes the value, the arguments of the type and a confidence level, `read` the plain data and the arguments;
    `holds` says whether a value, `written` whether plain data can be of this type, which distinguishes the members of a
    union.
    """

    write: Callable[[Any, tuple[Any, ...], float], Any]
    read: Callable[[Any, tuple[Any, ...]], Any]
    holds: Callable[[Any], bool]
    written: Callable[[Any], bool]


def write_plain(value: Any, hint: Any, level: float) -> Any:
    """Plain data of a value of type `hint`, with limits at `level`."""
    origin, args = _derived(hint)
    return _form(origin).write(value, args, level)


def read_plain(data: Any, hint: Any) -> Any:
    """The value of type `hint` that `write` has written."""
    origin, args = _derived(hint)
    return _form(origin).read(data, args)


def _derived(hint: Any) -> tuple[Any, tuple[Any, ...]]:
    """What a type is derived from, and its arguments; the name of a type, such as NDArray of numpy 2.5, is resolved."""
    origin, args = get_origin(hint) or hint, get_args(hint)
    if hasattr(origin, "__value__"):
        return _derived(origin.__value__[args] if args else origin.__value__)
    return origin, args


def _form(hint: Any) -> Codec:
    origin, _ = _derived(hint)
    if origin in FORMS:
        return FORMS[origin]
    if isinstance(origin, type) and hasattr(origin, "to_dict"):
        kind: Any = origin
        return Codec(  # it writes itself, and is read by its own class or a subclass of it
            lambda value, _, level: value.to_dict(level),
            lambda data, _: kind.from_dict(data),
            lambda value: isinstance(value, kind),
            lambda data: isinstance(data, dict) and data.get("type") == kind.__name__,
        )
    raise TypeError(f"a field of type {hint} cannot be written as plain data")


def plain(value: Any, level: float = 0.95) -> Any:
    """Plain data of a value of any type, by what it is."""
    if hasattr(value, "to_dict"):
        return value.to_dict(level)
    if isinstance(value, dict):
        return {str(key): plain(item, level) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item, level) for item in value]
    if isinstance(value, np.ndarray):
        return _numbers(value)
    return str(value) if isinstance(value, Path) else _scalar(value)


def _scalar(value: Any) -> Any:
    value = value.item() if isinstance(value, np.generic) else value
    if not isinstance(value, float) or math.isfinite(value):
        return value
    return None if math.isnan(value) else str(value)


def finite(value: float) -> float | None:
    """The number, or None if it is not finite: for values that are not read again."""
    return value if math.isfinite(value) else None


def _numbers(array: Any) -> Any:
    """Nested lists of an array."""
    if array.dtype.kind == "c":
        return {"real": _numbers(array.real), "imag": _numbers(array.imag)}
    if array.dtype.kind != "f" or np.isfinite(array).all():
        return array.tolist()
    return _scalar(array.item()) if array.ndim == 0 else [_numbers(np.asarray(part)) for part in array]


def _array(data: Any, args: tuple[Any, ...]) -> Any:
    """The array from nested lists, with the number type given by the annotation."""
    if isinstance(data, dict):
        return _array(data["real"], ()) + 1j * _array(data["imag"], ())
    named = get_args(args[1])[0] if len(args) > 1 and get_args(args[1]) else Any
    if isinstance(named, type):
        return np.array(data, dtype=named)
    array = np.array(data)
    return array if array.dtype.kind in "biufU" else np.array(data, dtype=np.float64)


def _hints(args: tuple[Any, ...], size: int) -> tuple[Any, ...]:
    """The types of the items of a tuple or list, of which there are so many."""
    if not args:
        return (Any,) * size
    return (args[0],) * size if len(args) == 1 or args[-1] is Ellipsis else args


def _read_tuple(data: Any, args: tuple[Any, ...]) -> tuple[Any, ...]:
    return tuple(read_plain(item, hint) for item, hint in zip(data, _hints(args, len(data)), strict=True))


def _write_dict(value: Any, args: tuple[Any, ...], level: float) -> dict[str, Any]:
    hint = args[1] if args else Any
    return {str(key): write_plain(item, hint, level) for key, item in value.items()}


def _read_dict(data: Any, args: tuple[Any, ...]) -> dict[Any, Any]:
    key_of, hint = args or (str, Any)
    return {key if key_of is Any else key_of(key): read_plain(item, hint) for key, item in data.items()}


def _write_union(value: Any, args: tuple[Any, ...], level: float) -> Any:
    if value is None:
        return None
    for hint in args:
        if hint is not types.NoneType and _form(hint).holds(value):
            data = write_plain(value, hint, level)
            return "nan" if data is None and types.NoneType in args else data
    raise TypeError(f"{type(value).__name__} is none of {', '.join(map(str, args))}")


def _read_union(data: Any, args: tuple[Any, ...]) -> Any:
    if data is None and types.NoneType in args:
        return None
    members = [hint for hint in args if hint is not types.NoneType]
    fitting = [hint for hint in members if _form(hint).written(data)]
    return read_plain(data, fitting[0] if fitting else members[0])


def _write_call(value: Any, args: tuple[Any, ...], level: float) -> Any:
    """Limits are stored as numbers at one level; functions without a level as their result, and texts as they are."""
    if args[0]:
        return {"level": level, "values": write_plain(value(level), args[1], level)}
    return value() if args[1] is str else {"values": write_plain(value(), args[1], level)}


def _read_call(data: Any, args: tuple[Any, ...]) -> Any:
    if isinstance(data, str):
        return Stored(data)
    also = _read_call(data["also"], args) if "also" in data else None
    return Stored(read_plain(data["values"], args[1]), data.get("level"), also)


def _no_type(_: Any) -> bool:
    return True


def _is(*kinds: type) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, kinds)


_itself = Codec(lambda value, _, level: plain(value, level), lambda data, _: data, _no_type, _no_type)
_float_form = Codec(
    lambda value, _, level: _scalar(value),
    lambda data, _: math.nan if data is None else float(data) if isinstance(data, str) else data,
    _is(int, float, np.floating, np.integer),
    lambda data: data is None or (isinstance(data, (int, float)) and not isinstance(data, bool)) or data in NOT_FINITE,
)
_union = Codec(_write_union, _read_union, _no_type, _no_type)
_dict = Codec(_write_dict, _read_dict, _is(dict), _is(dict))
_tuple = Codec(
    lambda value, args, level: [
        write_plain(item, hint, level) for item, hint in zip(value, _hints(args, len(value)), strict=True)
    ],
    _read_tuple, _is(tuple, list), _is(list, tuple),
)  # fmt: skip

FORMS: dict[Any, Codec] = {
    Any: _itself,
    object: _itself,
    Literal: _itself,
    bool: _itself._replace(holds=_is(bool, np.bool_), written=_is(bool)),
    str: _itself._replace(holds=_is(str), written=_is(str)),
    int: _itself._replace(holds=_is(int, np.integer), written=_is(int)),
    float: _float_form,
    Path: Codec(lambda value, _, level: str(value), lambda data, _: Path(data), _is(Path), _is(str)),
    Signal: Codec(lambda value, _, level: value.name, lambda data, _: signal_named(data), _is(Signal), _is(str)),
    np.ndarray: Codec(lambda value, _, level: _numbers(np.asarray(value)), _array, _is(np.ndarray), _is(list, dict)),
    tuple: _tuple,
    list: _tuple._replace(read=lambda data, args: list(_read_tuple(data, args))),
    Sequence: _tuple,
    dict: _dict,
    Mapping: _dict,
    Union: _union,
    types.UnionType: _union,
    Callable: Codec(_write_call, _read_call, callable, _is(dict)),
}
"""The codec of a type, or of the type that it is derived from."""
