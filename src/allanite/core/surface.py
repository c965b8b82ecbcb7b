"""Surface: a statistic as a function of time and averaging time."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from allanite.phrases.phrase import say

from .arrays import FloatArray, IntArray
from .curve import Curve, Law
from .encoding import plain
from .errors import UsageError
from .limits import demand_stored_rate
from .model import Model
from .plain import Value
from .units import convert


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
    _checks: ClassVar = {"rate": demand_stored_rate}

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
        there = np.isfinite(self.variance[i])
        if not there.any():
            raise UsageError(f"the window at {self.time[i]:g} s of {self.name!r} has no values")
        return Curve(
            statistic=self.statistic,
            m=self.m[there],
            tau=self.tau[there],
            variance=self.variance[i, there],
            count=self.count[i, there],
            factor=self.factor[i, there],
            unit=self.unit,
            rate=self.rate,
            name=self.name,
            history=(*self.history, say("window of {length:g} s at {time:g} s", length=self.window, time=self.time[i])),
            noise=self.noise,
            law=self.law if there.all() else None,
            supposes=self.supposes if there.all() else None,
        )

    def to(self, unit: str) -> "Surface":
        """The same surface in another unit."""
        factor = convert(1.0, self.unit, unit)
        return replace(self, variance=self.variance * factor**2, unit=unit)

    def rows(self) -> tuple[list[str], list[list[float]]]:
        """Headings and rows of a table: one row for each window and averaging time."""
        headings = ["time [s]", "m", "tau [s]", f"{self.statistic} [{self.unit}]", "count"]
        k, w = self.tau.size, self.time.size
        columns = [
            np.repeat(self.time, k), np.tile(self.m, w), np.tile(self.tau, w), self.deviation.ravel(),
            self.count.ravel(),
        ]  # fmt: skip
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
