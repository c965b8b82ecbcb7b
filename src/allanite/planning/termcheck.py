"""Results for one term in all records of a check of the identification."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.encoding import plain
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.limits import quantile
from allanite.core.model import Model, Term
from allanite.core.plain import Value
from allanite.core.units import Signal
from allanite.phrases.phrase import join
from allanite.terms import TERMS

from .bound import Bound, title_of

Measured = tuple[float, float]
"""A number and its Monte Carlo standard error."""

MEASURED = ("bias", "spread", "coverage", "found")

Interval = Callable[[float], tuple[float, float]]

LINE = next(symbol for symbol, row in TERMS.items() if row.periodic)


@dataclass(frozen=True, eq=False, repr=False)
class TermCheck(Value):
    """Results for one term in all records."""

    _keys: ClassVar = {"symbol": "term"}

    # symbol, signal: the term; for a time constant with its name behind it
    symbol: str
    signal: Signal
    truth: float  # its coefficient, SI; 0 where it is absent. Or the time constant, s.
    bound: float  # least relative standard error (Cramer-Rao); NaN where it is absent
    # shape (records,); the coefficient in the model that describes each record best, SI; 0 where it is not in it. Or
    # the time constant, NaN where there is none.
    value: FloatArray
    # low, high: shape (records,); the interval as printed; NaN where there is none
    low: FloatArray
    high: FloatArray
    claimed: BoolArray  # shape (records,); whether the term was reported as present

    @property
    def bias(self) -> Measured:
        """Mean error, relative to the truth; NaN where the term is absent."""
        error = self._relative
        return float(error.mean()), float(error.std(ddof=1) / math.sqrt(error.size))

    @property
    def spread(self) -> Measured:
        """Standard deviation, relative to the truth; NaN where the term is absent."""
        error = self._relative
        deviation = float(error.std(ddof=1))
        return deviation, deviation / math.sqrt(2 * (error.size - 1))

    @property
    def coverage(self) -> Measured:
        """Share of the intervals that contain the true value; NaN if there are none."""
        given = np.isfinite(self.low)
        return share(((self.low <= self.truth) & (self.truth <= self.high))[given])

    @property
    def found(self) -> Measured:
        """Share of the records in which the term was reported as present: for an absent term, falsely."""
        return share(self.claimed)

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, with the measured values and their Monte Carlo standard errors."""
        data = super().to_dict(level)
        for name in MEASURED:
            data[name], data[f"{name}_error"] = map(plain, getattr(self, name))
        return data

    @property
    def _relative(self) -> FloatArray:
        given = self.value[np.isfinite(self.value)]
        return np.asarray(given / self.truth - 1) if self.truth and given.size > 1 else np.full(2, math.nan)


def share(hit: BoolArray) -> Measured:
    """Share of the true ones and its standard error; NaN of none."""
    if not hit.size:
        return math.nan, math.nan
    # the error is that of one more hit and one more miss, so that it is not zero where all or none hit
    smooth = (hit.sum() + 1) / (hit.size + 2)
    return float(hit.mean()), math.sqrt(smooth * (1 - smooth) / hit.size)


def term_checks(truth: Model, fits: Sequence[Fit], least: Bound, level: float) -> Iterator[TermCheck]:
    """The check of each term that was looked for, then of each time constant that was found."""
    true, duration = compared(truth), least.size / least.rate
    for symbol in sought(fits):
        seen = [_seen(symbol, fit, true.get(symbol), duration) for fit in fits]
        values, intervals, claimed = zip(*seen, strict=True)
        limits = np.array([(math.nan, math.nan) if interval is None else interval(level) for interval in intervals])
        own = true.get(symbol) or Term(symbol, 0.0, truth.signal)
        known = least[symbol] if own.value else math.nan
        found = np.array(values), limits[:, 0], limits[:, 1], np.array(claimed)
        yield TermCheck(symbol, own.signal, own.value, known, *found)
    for t in true.values():
        for i in range(max((len(e.shape) for fit in fits for e in fit if _shaped(e, t)), default=0)):
            yield _shape_check(t, i, fits, level, least)


def sought(fits: Sequence[Fit]) -> list[str]:
    """Symbols of the terms that were looked for; sinusoids where one was found."""
    symbols = [e.symbol for fit in fits for e in fit] + [LINE for fit in fits if fit.lines]
    return list(dict.fromkeys(symbols))


def compared(truth: Model) -> dict[str, Term]:
    """The terms of a model that can be told by their symbol."""
    symbols = [t.symbol for t in truth]
    return {t.symbol: t for t in truth if symbols.count(t.symbol) == 1}


def _shaped(e: Estimate, true: Term) -> bool:
    return e.symbol == true.symbol and e.value is not None and e.shape_limits is not None


def _shape_check(true: Term, which: int, fits: Sequence[Fit], level: float, least: Bound) -> TermCheck:
    """A time constant: of the records in which its term was found."""
    name = join(" ", (true.symbol, title_of(true.row.parameters[which])))
    found = [next((e for e in fit if _shaped(e, true)), None) for fit in fits]
    nothing = (math.nan, math.nan)
    limits = np.array([e.shape_limits(level)[which] if e and e.shape_limits else nothing for e in found])
    value = np.array([e.shape[which] if e else math.nan for e in found])
    claimed = np.array([e is not None for e in found])
    return TermCheck(name, true.signal, true.shape[which], least[name], value, limits[:, 0], limits[:, 1], claimed)


def _seen(symbol: str, fit: Fit, true: Term | None, duration: float) -> tuple[float, Interval | None, bool]:
    """The coefficient in the model, its interval if one was given, and whether the term was said to be there."""
    if symbol == LINE:
        # the sinusoid nearest to the true one, if it is within two steps of the spectrum; without a true one
        # any
        if not fit.lines:
            return 0.0, None, False
        if true is None:
            return fit.lines[0].amplitude, None, True
        line = min(fit.lines, key=lambda line: abs(line.frequency - true.shape[0]))
        if abs(line.frequency - true.shape[0]) > 2 / duration:
            return 0.0, None, False

        def interval(level: float) -> tuple[float, float]:
            half = quantile((1 + level) / 2) * line.standard_error
            return line.amplitude - half, line.amplitude + half

        return line.amplitude, interval, True
    estimate = next((e for e in fit if e.symbol == symbol), None)
    value = next((t.value for t in fit.model if t.symbol == symbol), 0.0)
    return (value, None, False) if estimate is None else (value, estimate.interval, estimate.claimed)
