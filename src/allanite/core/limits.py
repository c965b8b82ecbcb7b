"""Functions of a confidence level that are values: they can be pickled, cached and stored."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from .arrays import LARGEST, RATES, FloatArray
from .errors import UsageError, unfit
from .ranges import demand_level as demand_level  # noqa: PLC0414 - of this module too
from .threads import one_thread

T = TypeVar("T")


def quantile(p: float) -> float:
    """Quantile of the standard normal distribution."""
    from scipy.special import ndtri

    return float(ndtri(p))


@dataclass(frozen=True, eq=False)
class Widened:
    """Limits of a coefficient that are `factor` times as far from its value, but not below zero."""

    limits: Callable[[float], tuple[float, float]]
    value: float
    factor: float

    def __call__(self, level: float) -> tuple[float, float]:
        """Two-sided limits."""
        low, high = self.limits(level)
        return max(self.value - self.factor * (self.value - low), 0.0), self.value + self.factor * (high - self.value)


@dataclass(frozen=True, eq=False)
class Stored:
    """Stored limits: `values` for one `level`; without a level, they are returned for any.

    `also` holds those for another level, if a verdict needs them.

    Examples
    --------
    >>> Stored((0.1, 0.3), 0.95)(0.95)
    (0.1, 0.3)
    """

    values: Any
    level: float | None = None
    also: "Stored | None" = None

    def __call__(self, level: float | None = None) -> Any:
        """The values; any other level is refused."""
        if level is None or self.level is None or math.isclose(level, self.level, rel_tol=1e-12):
            return self.values
        if self.also is not None:
            return self.also(level)
        raise UsageError(
            f"the limits were stored for level {self.level:g}, not {level:g}: recompute them for another level"
        )


@dataclass(frozen=True, eq=False)
class Below:
    """From zero to an upper limit: the interval of an absent coefficient."""

    upper: Callable[[float], float]

    def __call__(self, level: float) -> tuple[float, float]:
        """(0, upper limit)."""
        return 0.0, self.upper(level)


@dataclass(frozen=True, eq=False)
class Normal:
    """Two-sided limits of a positive quantity with a normally distributed estimate; the lower one is at least 0."""

    value: float
    error: float

    def __call__(self, level: float) -> tuple[float, float]:
        """The limits at a level."""
        reach = quantile((1 + level) / 2) * self.error
        return max(self.value - reach, 0.0), self.value + reach


@dataclass(frozen=True, eq=False)
class Remembered(Generic[T]):
    """A function of numbers, or without arguments, that is called once for each argument, with one thread.

    Examples
    --------
    >>> Remembered(math.sqrt)(4.0)
    2.0
    """

    function: Callable[..., T]
    known: dict[tuple[float, ...], T] = field(default_factory=dict, init=False, repr=False)

    def __call__(self, *at: float) -> T:
        """The result of the function."""
        if at not in self.known:
            with one_thread():
                self.known[at] = self.function(*at)
        return self.known[at]


def demand_stored_rate(value: float) -> None:
    """Refuse what is no sampling rate."""
    if not RATES[0] <= value <= RATES[1]:
        raise unfit(value, f"a rate between {RATES[0]:g} and {RATES[1]:g} Hz")


def demand_stored_size(value: float | Stored | None) -> None:
    """Refuse a number, or a limit, that is far beyond those of any record."""
    if isinstance(value, Stored):
        for limit in value.values:
            demand_stored_size(limit)
        return
    if value is not None and math.isfinite(value) and abs(value) >= LARGEST**2:
        raise unfit(value, f"a number below {LARGEST**2:g}")


def demand_stored_positive(values: FloatArray) -> None:
    """Refuse numbers that are divided by, where one is zero or negative."""
    if not (values > 0).all():
        raise unfit(float(values[~(values > 0)][0]), "a number above 0")
