"""An axis of a panel: its scale, limits, ticks and their labels."""

import inspect
import math
from collections.abc import Callable, Sequence
from functools import wraps
from itertools import pairwise
from typing import Any, NamedTuple, TypeVar

import numpy as np
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from allanite.core.arrays import FloatArray

Class = TypeVar("Class", bound=type)


class Unsketched(NotImplementedError):  # noqa: N818 - no error, but the way to matplotlib
    """A figure asks for what only matplotlib draws."""


def demanding(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function, whose arguments that it does not have raise `Unsketched`."""

    @wraps(function)
    def call(*arguments: Any, **named: Any) -> Any:
        try:
            return function(*arguments, **named)
        except TypeError:
            try:
                inspect.signature(function).bind(*arguments, **named)
            except TypeError as error:
                raise Unsketched(f"{function.__name__}: {error}") from None
            raise

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


MAX_VALUE = 1e300  # beyond it values, and beyond its inverse those on a logarithmic axis, are not in sight
MARGIN = 0.05  # room beside the data where no limits are given
MAX_TICK_EXCESS = 1e-10  # a tick so far outside of the view, relative to its width, is drawn

FORMATTERS, LOCATORS = (FuncFormatter, NullFormatter), (FixedLocator, LogLocator, MaxNLocator)
"""What needs no axis of matplotlib."""

MIN_MINOR_DISTANCE = 1e-6  # part of the view by which minor ticks are away from major ones

STEPS, FINE = [1, 2, 2.5, 5, 10], [2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]
"""Steps of ticks in a decade, and minor ticks of one on a logarithmic axis."""

MIN_LONG_DIGITS = 5
"""Digits of a label from which on a common power of ten, or a common value, stands at the end of the axis."""


class Ticks(NamedTuple):
    """Places and labels of major and minor ticks, and what the labels are to be multiplied by or added to."""

    major: list[float]
    labels: list[str]
    minor: list[float]
    minor_labels: list[str]
    beside: str

    @property
    def labelled(self) -> tuple[tuple[str, list[str]], ...]:
        """Labels of major and of minor ticks."""
        return ("major", self.labels), ("minor", self.minor_labels)


@limited
class Side:
    """The abscissa of panels that share it, or the ordinate of one."""

    def __init__(self, *, across: bool) -> None:
        self.across, self.label, self.scale = across, "", "linear"
        self.limits: tuple[float, float] | None = None
        self.known: list[FloatArray] = []
        self._locator: Any = None
        self._formatters: list[Callable[[float, int | None], str] | None] = [None, None]
        self._fixed: list[float] | None = None
        self.beside = "left"
        self._ends: tuple[float, float] | None = None
        self._made: dict[int, Ticks] = {}

    def settle(self) -> None:
        """Nothing is added any more: the limits stay, and ticks are made once for each number of them."""
        self.limits = self.get_view_interval()
        self._ends = tuple(self.place(np.array(self.limits)).tolist())
        self._made = {}

    def set_major_formatter(self, formatter: Callable[[float, int | None], str]) -> None:
        """How labels of major ticks read."""
        _demand(formatter, FORMATTERS)
        self._formatters[0] = formatter

    def set_minor_formatter(self, formatter: Callable[[float, int | None], str]) -> None:
        """How labels of minor ticks read."""
        _demand(formatter, FORMATTERS)
        self._formatters[1] = formatter

    def set_major_locator(self, locator: Any) -> None:
        """Where major ticks are."""
        _demand(locator, LOCATORS)
        self._locator = locator

    def set_ticks(self, places: Sequence[float]) -> None:
        """Major ticks at these places only."""
        self._fixed = [float(at) for at in places]

    def set_offset_position(self, position: str) -> None:
        """At which end of the top what labels are to be multiplied by stands."""
        self.beside = position

    def get_view_interval(self) -> tuple[float, float]:
        """The limits: those given, or around the data."""
        if self.limits:
            return self.limits
        known = np.concatenate([np.empty(0), *self.known, np.array(self._fixed or [])])
        inside = known[(np.abs(known) < MAX_VALUE) & ((known > 1 / MAX_VALUE) | (self.scale == "linear"))]
        if not inside.size:
            return (1.0, 10.0) if self.scale == "log" else (0.0, 1.0)
        low, high = float(self.place(inside.min())), float(self.place(inside.max()))
        room = MARGIN * (high - low)
        if not room:
            room = 0.5 if self.scale == "log" else abs(low) * MARGIN or MARGIN
        if self._fixed is not None:
            ends = self.place(np.array([min(self._fixed), max(self._fixed)]))
            low, high = min(low - room, float(ends[0])), max(high + room, float(ends[1]))
        else:
            low, high = low - room, high + room
        most = math.log10(MAX_VALUE)
        return (10.0 ** max(low, -most), 10.0 ** min(high, most)) if self.scale == "log" else (low, high)

    def place(self, values: Any) -> Any:
        """Values on the scale, on which equal lengths are equal; NaN where it has none."""
        if self.scale == "linear":
            return np.asarray(values, dtype=float)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.log10(np.where(np.asarray(values, dtype=float) > 0, values, np.nan))

    def share(self, values: Any) -> FloatArray:
        """Values as fractions of the view."""
        low, high = self._ends or self.place(np.array(self.get_view_interval()))
        return np.asarray((self.place(values) - low) / (high - low))

    def ticks(self, length: float, size: float) -> Ticks:
        """Ticks of an axis of so many points, with letters of a size."""
        most = int(length / (size * (3.0 if self.across else 2.0)))
        if self._ends is None:
            return self._ticks(most)
        if most not in self._made:
            self._made[most] = self._ticks(most)
        return self._made[most]

    def _ticks(self, most: int) -> Ticks:
        low, high = self.get_view_interval()
        decades = min(max(most, 2), 9)
        places: Any = self._fixed
        minor: list[float] = []
        with np.errstate(over="ignore"):  # ticks beyond the largest number are not in sight
            if self._fixed is None and self._locator is not None:
                places = self._locator.tick_values(low, high)
            elif self._fixed is None and self.scale == "log":
                places = LogLocator(numticks=decades).tick_values(low, high)
            elif self._fixed is None:
                places = MaxNLocator(min(max(most, 1), 9), steps=STEPS).tick_values(low, high)
            major = self._seen(places)
            if self.scale != "linear":
                minor = self._seen(LogLocator(subs=FINE, numticks=decades).tick_values(low, high), major)
        form = self._formatters[0]
        if form is None and self.scale == "log":
            form = lambda value, _: f"$10^{{{round(math.log10(value))}}}$"  # noqa: E731 - as matplotlib's formatters
        labels, beside = ([form(at, None) for at in major], "") if form else plain(major)
        form = self._formatters[1]
        return Ticks(major, labels, minor, [form(at, None) if form else "" for at in minor], beside)

    def _seen(self, places: Any, taken: Sequence[float] = ()) -> list[float]:
        """Places within the view that are not taken."""
        at = np.unique(np.asarray(places, dtype=float))
        share = self.share(at)
        free = np.abs(np.subtract.outer(share, self.share(list(taken)))).min(axis=1, initial=1.0) > MIN_MINOR_DISTANCE
        return [float(value) for value in at[(share >= -MAX_TICK_EXCESS) & (share <= 1 + MAX_TICK_EXCESS) & free]]


def _demand(given: Any, known: tuple[type, ...]) -> None:
    if not isinstance(given, known):
        raise Unsketched(type(given).__name__)


def plain(places: Sequence[float]) -> tuple[list[str], str]:
    """Labels of evenly spaced ticks, and what stands at the end of the axis."""
    if not places:
        return [], ""
    largest, wide = max(map(abs, places)) or 1.0, max(places) - min(places)
    if 0 < wide < largest / 10.0 ** (MIN_LONG_DIGITS - 1):
        base = round(places[0], -math.floor(math.log10(wide)))
        rest, beside = plain([at - base for at in places])
        return rest, f"{beside} {base:+.12g}".strip()
    order = math.floor(math.log10(largest) + 1e-6)  # places are differences, with their rounding
    if not -MIN_LONG_DIGITS < order < MIN_LONG_DIGITS:
        return plain([at / 10.0**order for at in places])[0], f"$×10^{{{order}}}$"
    step = min((b - a for a, b in pairwise(places)), default=largest)
    decimals = next((d for d in range(12) if all(abs(round(at, d) - at) < 1e-3 * step for at in places)), 12)
    exact = (at if abs(at) > step * 1e-6 else 0.0 for at in places)
    return [f"{at:.{decimals}f}".replace("-", "\N{MINUS SIGN}") for at in exact], ""
