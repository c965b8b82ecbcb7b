"""Conversion of a field to plain data for JSON and back, by the type of the field, without loss.

What is read may come from anywhere: data that are not of the type of their field are refused, with the path of it.

JSON has no non-finite numbers: NaN becomes null, infinities become "inf" and "-inf"; NaN becomes "nan" where the field
may also be None.
"""

import math
import sys
import types
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple, Union, get_args, get_origin

import numpy as np

from .errors import AllaniteError, StoredError, given, unfit
from .limits import Stored, demand_level
from .units import Signal, signal_named

NOT_FINITE = ("nan", "inf", "-inf")


class Codec(NamedTuple):
    """How values of one kind of type are written and read."""

    # `write` takes the value, the arguments of the type and a confidence level, `read` the plain data and the
    # arguments; `holds` says whether a value, `written` whether plain data can be of this type, which distinguishes the
    # members of a union; `expected` are the words for such data, if they can be refused by what they are alone.
    write: Callable[[Any, tuple[Any, ...], float], Any]
    read: Callable[[Any, tuple[Any, ...]], Any]
    holds: Callable[[Any], bool]
    written: Callable[[Any], bool]
    expected: str = ""


def write_plain(value: Any, hint: Any, level: float) -> Any:
    """Plain data of a value of type `hint`, with limits at `level`."""
    origin, args = derived(hint)
    return _form(origin).write(value, args, level)


def read_plain(data: Any, hint: Any) -> Any:
    """The value of type `hint` that `write_plain` has written."""
    origin, args = derived(hint)
    form = _form(origin)
    if form.expected and not form.written(data):
        raise unfit(data, form.expected)
    return form.read(data, args)


def read_key(data: Mapping[str, Any], key: str, hint: Any) -> Any:
    """The value of type `hint` under a key; errors are those of `read_plain`, or that there is no such key."""
    if key not in data:
        kind = given(data.get("type", "value")).strip("'")
        raise StoredError(f"the stored {kind} has no {key!r}: the data are incomplete; store the result again")
    try:
        return read_plain(data[key], hint)
    except AllaniteError as error:
        raise StoredError.at(f".{key}", error) from None


def derived(hint: Any) -> tuple[Any, tuple[Any, ...]]:
    """What a type is derived from, and its arguments; the name of a type, such as NDArray of numpy 2.5, is resolved."""
    origin, args = get_origin(hint) or hint, get_args(hint)
    if hasattr(origin, "__value__"):
        return derived(origin.__value__[args] if args else origin.__value__)
    return origin, args


def _form(hint: Any) -> Codec:
    origin, _ = derived(hint)
    if origin in FORMS:
        return FORMS[origin]
    if isinstance(origin, type) and hasattr(origin, "to_dict"):
        kind: Any = origin
        return Codec(  # it writes itself, and is read by its own class or a subclass of it
            lambda value, _, level: value.to_dict(level), lambda data, _: kind.from_dict(data), _is(kind),
            lambda data: isinstance(data, dict) and data.get("type") == kind.__name__,
        )  # fmt: skip
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
    if array.dtype.kind != "f" or np.isfinite(array).all():
        return array.tolist()
    return _scalar(array.item()) if array.ndim == 0 else [_numbers(np.asarray(part)) for part in array]


def _array(data: Any, args: tuple[Any, ...]) -> Any:
    """The array from nested lists, with the number type given by the annotation."""
    named = get_args(args[1])[0] if len(args) > 1 and get_args(args[1]) else Any
    kinds, words = {np.bool_: ("b", "true and false"),
                    np.int64: ("iu", "whole numbers")}.get(named, ("biufUO", "numbers"))  # fmt: skip
    try:
        array = np.array(data)
        if array.dtype.kind in kinds or not array.size:
            wanted = named if isinstance(named, type) else None if array.dtype.kind in "biufU" else np.float64
            return np.array(data, dtype=wanted)
    except (TypeError, ValueError, OverflowError):
        pass
    raise StoredError(f"a list of {words} is expected, in rows of the same length")


def _hints(args: tuple[Any, ...], size: int) -> tuple[Any, ...]:
    """The types of the items of a tuple or list, of which there are so many."""
    if not args:
        return (Any,) * size
    return (args[0],) * size if len(args) == 1 or args[-1] is Ellipsis else args


def _read_tuple(data: Any, args: tuple[Any, ...]) -> tuple[Any, ...]:
    hints, items = _hints(args, len(data)), list[Any]()
    if len(hints) != len(data):
        raise StoredError(f"a list of {len(hints)} is expected, not of {len(data)}")
    for i, (item, hint) in enumerate(zip(data, hints, strict=True)):
        try:
            items.append(read_plain(item, hint))
        except AllaniteError as error:
            raise StoredError.at(f"[{i}]", error) from None
    return tuple(items)


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
    if not fitting and len(members) > 1 and not isinstance(data, dict):
        raise unfit(data, " or ".join(_form(hint).expected or "a table" for hint in members))
    return read_plain(data, (fitting or members)[0])


def _write_call(value: Any, args: tuple[Any, ...], level: float) -> Any:
    """Limits are stored as numbers at one level; functions without a level as their result, and texts as they are."""
    if args[0]:
        return {"level": level, "values": write_plain(value(level), args[1], level)}
    return value() if args[1] is str else {"values": write_plain(value(), args[1], level)}


def _read_call(data: Any, args: tuple[Any, ...]) -> Any:
    if args[1] is str or isinstance(data, str):
        return Stored(read_plain(data, args[1]))
    level = read_plain(data.get("level"), float | None)
    if level is not None:
        demand_level(level)
    values, other = read_key(data, "values", args[1]), data.get("also")
    also = None if other is None else {key: item for key, item in read_plain(other, dict).items() if key != "also"}
    return Stored(values, level, None if also is None else _read_call(also, args))


def _no_type(_: Any) -> bool:
    return True


def _whole(data: Any) -> bool:
    return isinstance(data, int) and not isinstance(data, bool)


def _is(*kinds: type) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, kinds)


def _read_float(data: Any, _: tuple[Any, ...]) -> Any:
    if _whole(data) and abs(data) > sys.float_info.max:
        raise unfit(data, "a number that is not above 1.8e308")
    wide = _whole(data) and abs(data) >= 1 << 63  # more than an array of whole numbers can hold
    return math.nan if data is None else float(data) if isinstance(data, str) or wide else data


def _read_literal(data: Any, args: tuple[Any, ...]) -> Any:
    if not any(type(data) is type(word) and data == word for word in args):
        raise unfit(data, " or ".join(map(repr, args)))
    return data


_itself = Codec(lambda value, _, level: plain(value, level), lambda data, _: data, _no_type, _no_type)
_float_form = Codec(lambda value, _, level: _scalar(value), _read_float,
                    _is(int, float, np.floating, np.integer), lambda data: data is None or isinstance(data, float)
                    or _whole(data) or data in NOT_FINITE, "a number")  # fmt: skip
_union = Codec(_write_union, _read_union, _no_type, _no_type)
_dict = Codec(lambda value, args, level: {str(key): write_plain(item, args[1] if args else Any, level)
                                          for key, item in value.items()},
              lambda data, args: {key: read_key(data, key, args[1] if args else Any) for key in data},
              _is(dict), _is(dict), "a table")  # fmt: skip
_tuple = Codec(lambda value, args, level: [write_plain(item, hint, level)
                                           for item, hint in zip(value, _hints(args, len(value)), strict=True)],
               _read_tuple, _is(tuple, list), _is(list, tuple), "a list")  # fmt: skip

FORMS: dict[Any, Codec] = {
    Any: _itself, object: _itself, Literal: _itself._replace(read=_read_literal),
    bool: _itself._replace(holds=_is(bool, np.bool_), written=_is(bool), expected="true or false"),
    str: _itself._replace(holds=_is(str), written=_is(str), expected="a text"),
    int: _itself._replace(holds=_is(int, np.integer), written=_whole, expected="a whole number"),
    float: _float_form,
    Path: Codec(lambda value, _, level: str(value), lambda data, _: Path(data), _is(Path), _is(str), "a path"),
    Signal: Codec(lambda value, _, level: value.name, lambda data, _: signal_named(data), _is(Signal), _is(str),
        "the name of a quantity"),
    np.ndarray: Codec(lambda value, _, level: _numbers(np.asarray(value)), _array, _is(np.ndarray), _is(list, dict),
        "a list of numbers"),
    tuple: _tuple, list: _tuple._replace(read=lambda data, args: list(_read_tuple(data, args))), Sequence: _tuple,
    dict: _dict, Mapping: _dict, Union: _union, types.UnionType: _union,
    Callable: Codec(_write_call, _read_call, callable, _is(dict, str), "a table"),
}  # fmt: skip
"""The codec of a type, or of the type that it is derived from."""
