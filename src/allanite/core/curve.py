"""Curve: a statistic as a function of averaging time. Surface: of time and averaging time."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from allanite.phrases.phrase import say

from .aliases import public
from .arrays import FloatArray, IntArray
from .encoding import plain
from .errors import StoredError, UsageError
from .limits import Stored, demand_level, demand_stored_positive, demand_stored_rate, demand_stored_square
from .model import Model
from .names import demand_name
from .plain import Portable, Value
from .units import convert

Law = Callable[[float], tuple[FloatArray, FloatArray, FloatArray]]
"""level -> (equivalent degrees of freedom, lower limit / variance, upper limit / variance)"""


@dataclass(frozen=True, eq=False)
class DerivedLaw(Portable):
    """The law of the points of a curve, whose numbers `points` makes of those of other laws, one after the other."""

    laws: tuple[Law, ...]
    points: Callable[[FloatArray], FloatArray] = np.asarray

    def __call__(self, level: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Degrees of freedom and limits over the variance."""
        each = zip(*(law(level) for law in self.laws), strict=True)
        edf, low, high = (self.points(np.concatenate(numbers)) for numbers in each)
        return edf, low, high


@dataclass(frozen=True, eq=False, repr=False)
class Curve(Value):
    """Values of one statistic as a function of averaging time.

    Attributes
    ----------
    statistic : str
        Its name in `STATISTICS`.
    m, tau, variance, count : arrays, shape (k,)
        Averaging factor, averaging time (s), variance (unit squared), number of terms in the sum.
    factor : array, shape (k,)
        Factor applied to the plain variance: the bias ratio kf of theobr and theoh, or the inverse of a bias.
    unit : str
        Unit of the deviation.
    name, rate, size, history
        Channel, sampling rate, number of sample intervals (missing ones included; 0 if unknown) and history of the
        record.
    noise : Model, optional
        The model assumed for the confidence intervals. If a fit was given, its own model, although the intervals are
        averaged over all models consistent with the record. None if the noise was identified for the intervals only.
    law : optional
        Computes the limits; called on first use.
    supposes : optional
        Gives the assumptions of the limits; see `supposed`.
    alpha : array, shape (k,), optional
        Exponent of the power law f^alpha of the rate's spectrum that the record follows at each averaging time.
    """

    _keys: ClassVar = {"supposes": "supposed"}
    _called: ClassVar = {"taus": "tau", "var": "variance", **dict.fromkeys(("dev", "devs", "adev", "ad"), "deviation")}
    _alike = ("m tau variance count factor alpha",)
    _checks: ClassVar = {"rate": demand_stored_rate, "tau": demand_stored_positive,
                         "variance": demand_stored_square, "law": demand_stored_square}  # fmt: skip

    statistic: str
    m: IntArray
    tau: FloatArray
    variance: FloatArray
    count: IntArray
    factor: FloatArray
    unit: str
    rate: float
    size: int = 0
    name: str = ""
    history: tuple[str, ...] = ()
    noise: Model | None = None
    law: Law | None = None
    supposes: Callable[[], str] | None = None
    alpha: IntArray | None = None

    @classmethod
    def _stored(cls, data: dict[str, Any]) -> Self:
        curve = super()._stored(data)
        if isinstance(curve.law, Stored) and any(len(part) != len(curve.tau) for part in curve.law.values):
            raise StoredError("the limits are as many as the averaging times, or the data were changed")
        return curve

    @property
    def supposed(self) -> str:
        """The noise assumed for the intervals, as text; empty without intervals."""
        return self.supposes() if self.supposes else ""

    @property
    def deviation(self) -> FloatArray:
        """Square root of the variance."""
        return np.sqrt(self.variance)

    def __iter__(self) -> Iterator[FloatArray]:
        """Averaging times and deviations: ``tau, deviation = curve``."""
        return iter((self.tau, self.deviation))

    def __getitem__(self, name: str) -> Any:
        """A column by its name: ``curve["tau"]``."""
        demand_name("column", name, ("tau", "deviation", "variance", "count", "m", "factor", "edf", *self._called))
        return getattr(self, name)

    def _limits(self, level: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        demand_level(level)
        if self.law is None:
            raise UsageError(f"this {self.statistic} has no confidence intervals: mtie and tierms never have any, "
                             "others need noise: deviation(record, ..., noise=allanite.identify(record))")  # fmt: skip
        return self.law(level)

    @property
    def edf(self) -> FloatArray:
        """Equivalent degrees of freedom of each variance under `noise`."""
        return self._limits(getattr(self.law, "level", None) or 0.95)[0]  # the same at every level

    def interval(self, level: float = 0.95) -> tuple[FloatArray, FloatArray]:
        """Two-sided confidence interval (low, high) of the deviation under `noise`.

        Uses the exact equivalent degrees of freedom of the model. Where they are few, the distribution of its largest
        eigenvalues replaces the single chi-square, whose upper limit can be several times too wide. For a fit, the
        distributions of all models consistent with the record are averaged.
        """
        _, low, high = self._limits(level)
        return np.sqrt(self.variance * low), np.sqrt(self.variance * high)

    def lower(self, level: float = 0.95) -> FloatArray:
        """One-sided lower confidence limit of the deviation; level above 0.5."""
        return self.interval(2 * level - 1)[0]

    def upper(self, level: float = 0.95) -> FloatArray:
        """One-sided upper confidence limit of the deviation; level above 0.5."""
        return self.interval(2 * level - 1)[1]

    @public
    def to(self, unit: str) -> "Curve":
        """The same curve in another unit."""
        factor = convert(1.0, self.unit, unit)
        return replace(self, variance=self.variance * factor**2, unit=unit)

    def rows(self, level: float = 0.95) -> tuple[list[str], list[list[float]]]:
        """Headings and rows of a table; limits are included if the noise is known."""
        shown = {"m": self.m, "tau [s]": self.tau, f"{self.statistic} [{self.unit}]": self.deviation,
                 "count": self.count} | ({"bias factor": self.factor} if np.any(self.factor != 1) else {})  # fmt: skip
        if self.law is not None:
            low, high = self.interval(level)
            shown |= {"edf": self.edf, f"low {level:.4g}": low, f"high {level:.4g}": high}
        shown |= {} if self.alpha is None else {"alpha": self.alpha}
        return list(shown), [list(row) for row in zip(*(c.tolist() for c in shown.values()), strict=True)]

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, with the limits as numbers."""
        data = super().to_dict(level) | {"deviation": plain(self.deviation)}
        if self.law is not None:
            low, high = self.interval(level)
            data |= {"level": level, "edf": plain(self._limits(level)[0]), "low": plain(low), "high": plain(high)}
        return data

    def _summary(self) -> str:
        span = f", {self.tau.min():.4g} to {self.tau.max():.4g} s" if self.tau.size else ""
        return f"{self.statistic} of {self.name!r}: {self.tau.size} averaging times{span}, {self.unit}"


@dataclass(frozen=True, eq=False, repr=False)
class Surface(Value):
    """A statistic in sliding windows of a record.

    Attributes
    ----------
    statistic : str
        Its name in `STATISTICS`.
    time : array, shape (w,)
        Centre of each window, s after the start of the record.
    m, tau : arrays, shape (k,)
        Averaging factor, averaging time (s).
    variance, count, factor : arrays, shape (w, k)
        Variance (unit squared), NaN if a window does not support it;
        number of terms in the sum; bias factor applied to the variance.
    window, step : float
        Length of the windows and distance between them, s.
    unit : str
        Unit of the deviation.
    name, rate, history
        Sampling rate, name and history of the record.
    noise : Model, optional
        The model assumed for the confidence intervals.
    law : optional
        Computes the limits of a window without missing samples; called on first use.
    supposes : optional
        Gives the assumptions of the limits; see `Curve.supposed`.
    """

    _keys: ClassVar = {"supposes": "supposed"}
    _alike = ("m tau", "time variance count factor")
    _checks: ClassVar = {"rate": demand_stored_rate, "variance": demand_stored_square, "law": demand_stored_square}

    statistic: str
    time: FloatArray
    m: IntArray
    tau: FloatArray
    variance: FloatArray
    count: IntArray
    factor: FloatArray
    window: float
    step: float
    unit: str
    rate: float
    name: str = ""
    history: tuple[str, ...] = ()
    noise: Model | None = None
    law: Law | None = None
    supposes: Callable[[], str] | None = None

    @property
    def deviation(self) -> FloatArray:
        """Square root of the variance, shape (w, k)."""
        return np.sqrt(self.variance)

    def curve(self, time: float) -> Curve:
        """The curve of the window whose centre is nearest to `time`, s."""
        i = int(np.abs(self.time - time).argmin())
        known = np.isfinite(self.variance[i])
        if not known.any():
            raise UsageError(f"the window at {self.time[i]:g} s of {self.name!r} has no values")
        return Curve(
            statistic=self.statistic, m=self.m[known], tau=self.tau[known], variance=self.variance[i, known],
            count=self.count[i, known], factor=self.factor[i, known], unit=self.unit, rate=self.rate, name=self.name,
            history=(*self.history, say("window of {length:g} s at {time:g} s", length=self.window, time=self.time[i])),
            noise=self.noise, law=self.law if known.all() else None, supposes=self.supposes if known.all() else None,
        )  # fmt: skip

    @public
    def to(self, unit: str) -> "Surface":
        """The same surface in another unit."""
        factor = convert(1.0, self.unit, unit)
        return replace(self, variance=self.variance * factor**2, unit=unit)

    def rows(self) -> tuple[list[str], list[list[float]]]:
        """Headings and rows of a table: one row for each window and averaging time."""
        headings = ["time [s]", "m", "tau [s]", f"{self.statistic} [{self.unit}]", "count"]
        k, w = self.tau.size, self.time.size
        columns = [np.repeat(self.time, k), np.tile(self.m, w), np.tile(self.tau, w), self.deviation.ravel(),
                   self.count.ravel()]  # fmt: skip
        return headings, [list(row) for row in zip(*(c.tolist() for c in columns), strict=True)]

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data; missing values are None. `low` and `high` are limits relative to the deviation."""
        data = super().to_dict(level) | {"deviation": plain(self.deviation)}
        if self.law is not None:
            edf, low, high = self.law(level)
            data |= {"level": level, "edf": plain(edf), "low": plain(np.sqrt(low)), "high": plain(np.sqrt(high))}
        return data

    def _summary(self) -> str:
        windows = f"{self.time.size} windows of {self.window:g} s"
        return f"{self.statistic} of {self.name!r}: {windows}, {self.tau.size} averaging times, {self.unit}"
