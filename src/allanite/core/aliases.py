"""Arguments that have another name in other libraries, or are given in another form."""

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

from .errors import UsageError

ALIASES = {"fs": "rate"}
"""Names of arguments in other libraries: the name here."""

F = TypeVar("F", bound=Callable[..., Any])


def aliased(function: F) -> F:
    """The function, which takes arguments by their `ALIASES`, too.

    Examples
    --------
    >>> aliased(lambda rate: 1 / rate)(fs=100.0)
    0.01
    """

    @wraps(function)
    def entered(*args: Any, **options: Any) -> Any:
        for alias in ALIASES.keys() & options.keys():
            name = ALIASES[alias]
            if name in options:
                raise UsageError(f"{name} and {alias} are the same: give one of them")
            options[name] = options.pop(alias)
        return function(*args, **options)

    return entered  # type: ignore[return-value]


def size_and_rate(size: int | None, rate: float | None, duration: float | None) -> tuple[int, float]:
    """Number of samples and sampling rate, Hz, of a record that is described by its size or its duration, s.

    Examples
    --------
    >>> size_and_rate(None, 100.0, 60.0)
    (6000, 100.0)
    """
    if rate is None:
        raise UsageError("the sampling rate is missing: give rate, in Hz, e.g. rate=100")
    if (size is None) == (duration is None):
        raise UsageError("give either size, a number of samples, or duration, in s, e.g. duration=3600")
    return (size if size is not None else round((duration or 0.0) * rate)), rate
