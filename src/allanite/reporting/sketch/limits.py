"""Where this room ends: what only matplotlib draws."""

import inspect
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

Class = TypeVar("Class", bound=type)


class Unsketched(NotImplementedError):  # noqa: N818 - no error, but the way to matplotlib
    """A figure asks for what only matplotlib draws."""


def demanding(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function, whose arguments that it does not have raise `Unsketched`.

    Examples
    --------
    >>> demanding(round)(1.25, digits=1)
    Traceback (most recent call last):
    allanite.reporting.sketch.limits.Unsketched: round: got an unexpected keyword argument 'digits'
    """
    signature = inspect.signature(function)

    @wraps(function)
    def call(*arguments: Any, **named: Any) -> Any:
        try:
            signature.bind(*arguments, **named)
        except TypeError as error:
            raise Unsketched(f"{function.__name__}: {error}") from None
        return function(*arguments, **named)

    return call


def limited(kind: Class) -> Class:
    """A class whose methods are `demanding`, and whose attributes that it does not have raise `Unsketched`."""
    for name, method in vars(kind).copy().items():
        if inspect.isfunction(method) and not name.startswith("_"):
            setattr(kind, name, demanding(method))

    def missing(self: Any, name: str) -> Any:
        # names with underscores are asked for by libraries, to learn what an object is
        raise AttributeError(name) if name.startswith("_") else Unsketched(name)

    kind.__getattr__ = missing  # type: ignore[attr-defined]
    return kind
