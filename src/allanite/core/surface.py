"""Surface: a statistic over time and averaging time."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .curve import Curve, Law
from .errors import UsageError
from .model import Model
from .units import convert

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Surface:
    """A statistic in windows that slide along a record.

    Attributes
    ----------
    statistic : str
        Its name in `STATISTICS`.
    time : array, shape (w,)
        Centre of each window, s after the start of the record.
    m, tau : arrays, shape (k,)
        Averaging factor, averaging time (s).
    variance, count, factor : arrays, shape (w, k)
        Variance (unit squared), NaN where a window does not support it; number of terms in the sum; the bias factor
        that is in the variance.
    window, step : float
        Length of the windows and distance between them, s.
    unit : str
        Unit of the deviation.
    name, rate, history
        Of the record.
    noise : Model, optional
        The model supposed for the confidence limits.
    law : optional
        Gives the limits of a window without lost samples; it is called when first asked.
    """

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
            history=(*self.history, f"window of {self.window:g} s at {self.time[i]:g} s"),
            noise=self.noise,
            law=self.law if there.all() else None,
        )

    def to(self, unit: str) -> "Surface":
        """The same surface in another unit."""
        factor = convert(1.0, self.unit, unit)
        return replace(self, variance=self.variance * factor**2, unit=unit)

    def rows(self) -> tuple[list[str], list[list[float]]]:
        """Headings and rows for any table: one row for each window and averaging time."""
        headings = ["time [s]", "m", "tau [s]", f"{self.statistic} [{self.unit}]", "count"]
        k, w = self.tau.size, self.time.size
        columns = [
            np.repeat(self.time, k), np.tile(self.m, w), np.tile(self.tau, w), self.deviation.ravel(),
            self.count.ravel(),
        ]  # fmt: skip
        return headings, [list(row) for row in zip(*(c.tolist() for c in columns), strict=True)]

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data; a value that is not there is None. `low` and `high` are limits over the deviation."""
        data: dict[str, Any] = {
            "allanite": 1,
            "type": "Surface",
            **{name: getattr(self, name) for name in _WORDS},
            "history": list(self.history),
            "time": self.time.tolist(),
            "m": self.m.tolist(),
            "tau": self.tau.tolist(),
            "deviation": _without_nan(self.deviation),
            "count": self.count.tolist(),
            "factor": _without_nan(self.factor),
        }
        if self.noise is not None:
            data["noise"] = self.noise.to_dict()
        if self.law is not None:
            edf, low, high = self.law(level)
            data |= {"level": level, "edf": edf.tolist()}
            data |= {"low": np.sqrt(low).tolist(), "high": np.sqrt(high).tolist()}
        return data

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> "Surface":
        """The surface that `to_dict` has written, without its law."""
        fields: dict[str, Any] = {name: data[name] for name in _WORDS}
        return cls(
            **fields,
            history=tuple(data["history"]),
            time=np.array(data["time"], dtype=np.float64),
            m=np.array(data["m"], dtype=np.int64),
            tau=np.array(data["tau"], dtype=np.float64),
            variance=np.array(data["deviation"], dtype=np.float64) ** 2,
            count=np.array(data["count"], dtype=np.int64),
            factor=np.array(data["factor"], dtype=np.float64),
            noise=Model.from_dict(data["noise"]) if "noise" in data else None,
        )


def _without_nan(values: FloatArray) -> list[list[float | None]]:
    return [[None if math.isnan(value) else value for value in row] for row in values.tolist()]


_WORDS = ("statistic", "window", "step", "unit", "rate", "name")
