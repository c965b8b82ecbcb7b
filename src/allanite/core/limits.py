"""Functions of a confidence level that are values: they can be pickled, cached and stored."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

import numpy as np

from .arrays import LARGEST, FloatArray
from .errors import UsageError, unfit
from .ranges import POSITIVE, RATE, Range, demand_level as demand_level  # noqa: PLC0414 - of this module too
from .threads import one_thread

T = TypeVar("T")


def quantile(p: float) -> float:
    """Quantile of the standard normal distribution."""
    from scipy.special import ndtri

    return float(ndtri(p))


PASS, FAIL, NOT_DECIDED = "pass", "fail", "not decided"


def held(low: float, high: float, most: float) -> str:
    """Whether what lies between `low` and `high` keeps a limit; not decided where the interval contains the limit."""
    return PASS if high <= most else FAIL if low > most else NOT_DECIDED


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
    """Stored limits: `values` for one `level`; without a level, they are returned for any."""

    # `also` holds those for another level, if a verdict needs them.
    values: Any
    level: float | None = None
    also: "Stored | None" = None

    def __call__(self, level: float | None = None) -> Any:
        """The values; any other level is refused."""
        if level is None or self.level is None or math.isclose(level, self.level, rel_tol=1e-12):
            return self.values
        if self.also is not None:
            return self.also(level)
        raise UsageError(f"the limits were stored for level {self.level:g}, not {level:g}: recompute them for another "
                         "level")  # fmt: skip


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
    """A function of numbers, or without arguments, that is called once for each argument, with one thread."""

    function: Callable[..., T]
    known: dict[tuple[float, ...], T] = field(default_factory=dict, init=False, repr=False)

    def __call__(self, *at: float) -> T:
        """The result of the function."""
        if at not in self.known:
            with one_thread():
                self.known[at] = self.function(*at)
        return self.known[at]


@dataclass(frozen=True, eq=False)
class NormalMixture:
    """A law that is a mixture of normal ones."""

    # centre, spread, weight: shape (laws,)
    centre: FloatArray
    spread: FloatArray
    weight: FloatArray

    def __call__(self, level: float) -> tuple[float, float]:
        """Two-sided limits."""
        return self.quantile((1 - level) / 2), self.quantile((1 + level) / 2)

    def upper(self, level: float) -> float:
        """One-sided limit of the size."""
        return max(abs(limit) for limit in self(2 * level - 1))

    @property
    def value(self) -> float:
        """The mean."""
        return float(self.weight @ self.centre)

    @property
    def error(self) -> float:
        """The standard deviation."""
        return self.error_of(self.value)

    def error_of(self, value: float) -> float:
        """Root of the mean square of the distance from a value."""
        return math.sqrt(float(self.weight @ (self.spread**2 + (self.centre - value) ** 2)))

    def below(self, value: float) -> float:
        """Probability of less than a value."""
        from scipy.special import ndtr

        return float(self.weight @ ndtr((value - self.centre) / self.spread))

    @property
    def p(self) -> float:
        """Two-sided probability of zero."""
        return min(1.0, 2 * min(self.below(0.0), 1 - self.below(0.0)))

    def quantile(self, p: float) -> float:
        """The value below which it lies with probability p: its sixteenth of an interval, 15 times."""
        from scipy.special import ndtr

        low, high = float((self.centre - 40 * self.spread).min()), float((self.centre + 40 * self.spread).max())
        for _ in range(15):
            ends = low + (high - low) / 16 * np.arange(17)
            at = int((self.weight @ ndtr((ends[1:-1] - self.centre[:, None]) / self.spread[:, None]) < p).sum())
            low, high = float(ends[at]), float(ends[at + 1])
        return (low + high) / 2

    def minus(self, other: "NormalMixture", factor: float = 1.0) -> "NormalMixture":
        """The law of the difference from `factor` times another, independent one."""
        return NormalMixture(np.subtract.outer(self.centre, factor * other.centre).ravel(),
                             np.hypot.outer(self.spread, factor * other.spread).ravel(),
                             np.multiply.outer(self.weight, other.weight).ravel())  # fmt: skip


def demanded(within: Range, *infinite: float, missing: bool = False) -> Callable[[Any], None]:
    """What refuses stored numbers outside a range, alone, in arrays or in limits; NaN where none may be `missing`."""

    def demand(values: Any) -> None:
        parts = [part for part in (values.values if isinstance(values, Stored) else [values]) if part is not None]
        x = np.concatenate([np.zeros(0), *map(np.ravel, parts)])
        right = (x >= within.low) & (x <= within.high) | np.isin(x, infinite) | np.isnan(x) & missing
        if not right.all():
            raise unfit(float(x[~right][0]), f"a number {within.words()}")

    return demand


demand_stored_rate = demanded(RATE)
demand_stored_size = demanded(Range(-(LARGEST**2), LARGEST**2), math.inf, -math.inf, missing=True)
demand_stored_square = demanded(Range(0, LARGEST**4), math.inf, missing=True)
demand_stored_positive = demanded(POSITIVE, math.inf)  # what is divided by
