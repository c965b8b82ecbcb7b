"""Arguments that have another name in other libraries, or are given in another form."""

from collections.abc import Callable
from functools import cache, wraps
from inspect import Parameter, signature
from itertools import chain
from numbers import Real
from typing import TYPE_CHECKING, Any, TypeVar

from allanite.phrases.phrase import spelled

from .errors import UsageError, WrongTypeError, given
from .habits import demand_own, renamed
from .ranges import RATE, SAMPLES, SEED, TIME, Range

if TYPE_CHECKING:
    import numpy as np

F = TypeVar("F", bound=Callable[..., Any])
T = TypeVar("T")


PLACED = (Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD)  # parameters that may be given by their place


def public(function: F) -> F:
    """The function as users call it, arguments by other names, too (`ARGUMENTS`), each of the type that is declared.

    >>> public(lambda rate: 1 / rate)(fs=100.0)
    0.01
    """

    @cache
    def declared() -> tuple[
        bool, list[str], list[str], dict[str, Any], dict[str, Range], Callable[..., str], Callable[..., None]
    ]:
        """Names and types, which may not be defined before the first call, and ranges: ``Annotated[float, TIME]``."""
        from .declared import demand_size, misfit, parameters  # with numpy, which help does without

        ranges = {name: within for name, hint in function.__annotations__.items()
                  for within in getattr(hint, "__metadata__", ())}  # fmt: skip
        known = signature(function).parameters
        open_ = any(parameter.kind is Parameter.VAR_KEYWORD for parameter in known.values())
        placed = [name for name, parameter in known.items() if parameter.kind in PLACED]
        return open_, list(known), placed, parameters(function), ranges, misfit, demand_size

    @wraps(function)
    def entered(*args: Any, **options: Any) -> Any:
        open_, names, placed, types, ranges, misfit, demand_size = declared()
        called = function.__qualname__.removesuffix(".__init__")
        options = renamed(options, names)
        demand_own(called, () if open_ else options.keys() - names)
        columns = args[0].columns if args and hasattr(type(args[0]), "columns") else ()
        try:
            for name, value in chain(zip(placed, args, strict=False), options.items()):
                hint = types.get(name, Any)
                if isinstance(value, str) and value in columns and name not in {*options, "channels"}:
                    raise WrongTypeError(f"{called}: {name} is {value!r}, a column: select it with channels={value!r}")
                if expected := misfit(value, hint):
                    rated = isinstance(value, Real) and "sampling" in names  # as the second argument of other libraries
                    raise WrongTypeError(
                        f"{called}: {name} must be {expected}, not {given(value)} ({type(value).__name__})"
                        + (f"; a sampling rate has its name: type al.{called}(x, rate={value})" if rated else "")
                    )
                if name in ranges:
                    ranges[name].demand(value, name)
                else:
                    demand_size(name, value, hint)
            return function(*args, **options)
        except OverflowError as error:
            raise UsageError(f"{called}: the numbers given are too large or too small: {error}") from error
        except MemoryError as error:
            raise UsageError(f"{called}: there is not enough memory for so many numbers") from error

    return entered  # type: ignore[return-value]


def constructed(cls: type[T]) -> type[T]:
    """The class, whose constructor is called as a `public` function is."""
    cls.__init__ = public(cls.__init__)  # type: ignore[method-assign]
    return cls


def generator(rng: "np.random.Generator | int | None") -> "np.random.Generator":
    """The source of randomness, which may be given by its seed; None for another one each time."""
    import numpy as np

    return np.random.default_rng(rng if isinstance(rng, np.random.Generator) else SEED.demand(rng))


def size_and_rate(size: int | None, rate: float | None, duration: float | str | None) -> tuple[int, float]:
    """Number of samples and sampling rate, Hz, of a record that is described by its size or its duration, s.

    >>> size_and_rate(None, 100.0, 60.0), size_and_rate(None, 100.0, "1 min")
    ((6000, 100.0), (6000, 100.0))
    """
    if isinstance(duration, str):
        from .units import seconds_of

        duration = seconds_of(duration)
    if rate is None:
        raise UsageError("the sampling rate is missing: give rate, in Hz, e.g. rate=100")
    RATE.demand(rate)
    TIME.demand(duration, "the duration")
    if (size is None) == (duration is None):
        how = spelled("--duration or --samples", "size, a number of samples, or duration, in s, e.g. duration=3600")
        raise UsageError(f"give either {how}")
    return SAMPLES.demand(size if size is not None else round((duration or 0.0) * rate), "the number of samples"), rate
