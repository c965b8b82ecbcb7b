"""Does the identification keep its word on this sensor, rate and length: simulate, identify, count."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from allanite.core.encoding import plain
from allanite.core.errors import UsageError
from allanite.core.fit import Estimate, Fit
from allanite.core.model import Model, Term
from allanite.core.plain import Value
from allanite.core.units import Signal
from allanite.identification import identify
from allanite.identification.likelihood.selection import quantile
from allanite.simulation.record import simulate
from allanite.terms import TERMS

from .bound import Bound, bound

FloatArray = NDArray[np.float64]

Measured = tuple[float, float]
"""A number and its Monte-Carlo standard error."""

MEASURED = ("bias", "spread", "coverage", "found")

Interval = Callable[[float], tuple[float, float]]

LINE = next(symbol for symbol, row in TERMS.items() if row.periodic)


@dataclass(frozen=True, eq=False, repr=False)
class TermCheck(Value):
    """What became of one term in all records.

    Attributes
    ----------
    symbol, signal
        The term; for a time constant with its name behind it.
    truth : float
        Its coefficient, SI; 0 where it is absent. Or the time constant, s.
    bound : float
        Least relative standard error (Cramer-Rao); NaN where it is absent.
    value : array, shape (records,)
        The coefficient in the model that describes each record best, SI; 0 where it is not in it. Or the time constant,
        NaN where there is none.
    low, high : arrays, shape (records,)
        The interval as printed; NaN where there is none.
    claimed : bool array, shape (records,)
        Whether the term was said to be there.
    """

    _keys: ClassVar = {"symbol": "term"}

    symbol: str
    signal: Signal
    truth: float
    bound: float
    value: FloatArray
    low: FloatArray
    high: FloatArray
    claimed: NDArray[np.bool_]

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
        """Share of the intervals that hold the truth; NaN where none was given."""
        given = np.isfinite(self.low)
        return _share(((self.low <= self.truth) & (self.truth <= self.high))[given])

    @property
    def found(self) -> Measured:
        """Share of the records in which the term was said to be there: of an absent term, falsely."""
        return _share(self.claimed)

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, with what was measured and its Monte-Carlo standard errors."""
        data = super().to_dict(level)
        for name in MEASURED:
            data[name], data[f"{name}_error"] = map(plain, getattr(self, name))
        return data

    @property
    def _relative(self) -> FloatArray:
        given = self.value[np.isfinite(self.value)]
        return np.asarray(given / self.truth - 1) if self.truth and given.size > 1 else np.full(2, math.nan)


def _share(hit: NDArray[np.bool_]) -> Measured:
    if not hit.size:
        return math.nan, math.nan
    # the error is that of one more hit and one more miss, so that it is not zero where all or none hit
    smooth = (hit.sum() + 1) / (hit.size + 2)
    return float(hit.mean()), math.sqrt(smooth * (1 - smooth) / hit.size)


@dataclass(frozen=True, eq=False, repr=False)
class SelfCheck(Value):
    """What the identification makes of simulated records of a known model.

    Attributes
    ----------
    model, size, rate
        What was simulated.
    records : int
    level : float
        Confidence level of the intervals.
    terms : tuple of TermCheck
        In the order of identification; absent ones too.
    unexplained : (share, error)
        Of the records of which it was said that no model explains them.
    notes : tuple of str
        Terms of the model that were not looked for, or cannot be told apart by their symbol.
    """

    model: Model
    size: int
    rate: float
    records: int
    level: float
    terms: tuple[TermCheck, ...]
    unexplained: Measured
    notes: tuple[str, ...] = ()

    def __getitem__(self, symbol: str) -> TermCheck:
        for check in self.terms:
            if check.symbol == symbol:
                return check
        raise UsageError(f"{symbol!r} was not looked for; there are {', '.join(check.symbol for check in self.terms)}")

    def rows(self) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows: each measured number is followed by its Monte-Carlo standard error."""
        headings = ["term", "truth", "bound", *(part for name in MEASURED for part in (name, "+-"))]
        measured = [[part for name in MEASURED for part in getattr(check, name)] for check in self.terms]
        return headings, [[c.symbol, c.truth, c.bound, *m] for c, m in zip(self.terms, measured, strict=True)]

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data; the intervals are at the check's own level, whatever `level` says."""
        share, error = self.unexplained
        return super().to_dict(level) | {"unexplained": plain(share), "unexplained_error": plain(error)}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> "SelfCheck":
        """The check that `to_dict` has written."""
        return super().from_dict(data | {"unexplained": [data["unexplained"], data["unexplained_error"]]})

    def _summary(self) -> str:
        return f"{self.records} records of {self.size} readings at {self.rate:g} Hz: {self.model}"

    def exceeded(
        self,
        *,
        bias: float = math.inf,
        coverage: float = 0.0,
        false: float = 1.0,
        missed: float = 1.0,
    ) -> list[str]:
        """Which limits are exceeded beyond chance, by more than two Monte-Carlo standard errors, in sentences.

        Parameters
        ----------
        bias : float
            Most, relative to the coefficient, for terms that are there.
        coverage : float
            Least share of intervals that hold the truth.
        false, missed : float
            Most shares of records in which a term is claimed that is absent, or not found though it is there.
        """
        return [
            f"{c.symbol}: {what} {100 * measured:.3g} +- {100 * error:.2g} %, beyond {100 * limit:.3g} %"
            for c in self.terms
            for what, (measured, error), limit, sign in _judged(c, bias, coverage, (false, missed))
            if sign * (measured - limit) > 2 * error
        ]


def _judged(
    check: TermCheck, bias: float, coverage: float, wrong: tuple[float, float]
) -> list[tuple[str, Measured, float, int]]:
    """What is measured, its limit, and on which side of it (1: above, -1: below) it is wrong."""
    found, error = check.found
    judged = [("coverage", check.coverage, coverage, -1)]
    if not check.truth:
        return [*judged, ("falsely found in", (found, error), wrong[0], 1)]
    size, its = check.bias
    return [*judged, ("bias", (abs(size), its), bias, 1), ("missed in", (1 - found, error), wrong[1], 1)]


def selfcheck(
    model: Model | Term | Fit,
    n: int,
    rate: float,
    *,
    records: int = 100,
    rng: "np.random.Generator",
    terms: str = "auto",
    level: float = 0.95,
    progress: Callable[[str, float], None] | None = None,
) -> SelfCheck:
    """Simulate records of a model, identify each, and compare with the truth and with the Cramer-Rao bound.

    Parameters
    ----------
    model : Model, Term or Fit
        The sensor; of a fit, its model.
    n : int
        Readings of each record.
    rate : float
        Sampling rate, Hz.
    records : int
        How many are simulated, at least 2.
    rng : numpy.random.Generator
        The source of randomness.
    terms : str
        As for `identify`.
    level : float
        Confidence level of the intervals.
    progress : callable, optional
        Called with what is being done and the fraction that is finished.

    Returns
    -------
    SelfCheck

    Raises
    ------
    UsageError
        Fewer than two records are asked for.
    DataError
        The records are too short to identify anything.

    Examples
    --------
    >>> from allanite.core.model import N
    >>> check = selfcheck(N(0.1, "deg/sqrt(h)"), 2000, 100.0, records=20, rng=np.random.default_rng(1))
    >>> check["N"].found[0], abs(check["N"].bias[0]) < 0.02, round(check["N"].bound, 4)
    (1.0, True, 0.0158)
    """
    truth = model.model if isinstance(model, Fit) else model if isinstance(model, Model) else Model((model,))
    if records < 2:
        raise UsageError(f"a check needs at least 2 records, not {records}")
    tell = progress or (lambda what, fraction: None)
    fits = []
    for i, child in enumerate(rng.spawn(records)):
        tell(f"record {i + 1} of {records}", i / records)
        fits.append(identify(simulate(truth, n, rate, rng=child), terms=terms))
    least = bound(truth, n, rate)
    present = {t.symbol: t for t in truth if sum(other.symbol == t.symbol for other in truth) == 1}
    sought = dict.fromkeys(
        [*(e.symbol for fit in fits for e in fit), *([LINE] if any(fit.lines for fit in fits) else [])]
    )
    seen = {symbol: [_seen(symbol, fit, present.get(symbol), n / rate) for fit in fits] for symbol in sought}
    checks = tuple(
        _checked(present.get(symbol) or Term(symbol, 0.0, truth.signal), rows, level, least)
        for symbol, rows in seen.items()
    )
    doubted = np.array([fit.goodness is not None and not fit.goodness.explained for fit in fits])
    checks += tuple(_shape_check(t, i, fits, level, least) for t in present.values() for i in _found_shapes(t, fits))
    notes = tuple(
        f"{TERMS[s].title} ({s}) is in the model, but "
        + ("stands in it several times" if s in sought else "was not found in any record")
        for s in dict.fromkeys(t.symbol for t in truth)
        if s not in sought or s not in present
    )
    return SelfCheck(truth, n, rate, records, level, checks, _share(doubted), notes)


def _found_shapes(true: Term, fits: list[Fit]) -> range:
    """Which parameters of a term's shape are estimated."""
    return range(max((len(e.shape) for fit in fits for e in fit if _shaped(e, true)), default=0))


def _shaped(e: Estimate, true: Term) -> bool:
    return e.symbol == true.symbol and e.value is not None and e.shape_limits is not None


def _shape_check(true: Term, which: int, fits: list[Fit], level: float, least: Bound) -> TermCheck:
    """A time constant: of the records in which its term was found."""
    name = f"{true.symbol} {true.row.parameters[which].name.replace('_', ' ')}"
    found = [next((e for e in fit if _shaped(e, true)), None) for fit in fits]
    nothing = (math.nan, math.nan)
    limits = np.array([e.shape_limits(level)[which] if e and e.shape_limits else nothing for e in found])
    value = np.array([e.shape[which] if e else math.nan for e in found])
    claimed = np.array([e is not None for e in found])
    return TermCheck(name, true.signal, true.shape[which], least[name], value, limits[:, 0], limits[:, 1], claimed)


def _seen(symbol: str, fit: Fit, true: Term | None, duration: float) -> tuple[float, Interval | None, bool]:
    """The coefficient in the model, its interval if one was given, and whether the term was said to be there."""
    if symbol == LINE:
        return _line_seen(fit, true, duration)
    estimate = next((e for e in fit if e.symbol == symbol), None)
    value = next((t.value for t in fit.model if t.symbol == symbol), 0.0)
    return (value, None, False) if estimate is None else (value, estimate.interval, estimate.claimed)


def _line_seen(fit: Fit, true: Term | None, duration: float) -> tuple[float, Interval | None, bool]:
    """The sinusoid nearest to the true one, if it is within two steps of the spectrum; without a true one any."""
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


def _checked(true: Term, seen: list[tuple[float, Interval | None, bool]], level: float, least: Bound) -> TermCheck:
    limits = np.array([(math.nan, math.nan) if interval is None else interval(level) for _, interval, _ in seen])
    return TermCheck(
        true.symbol,
        true.signal,
        true.value,
        least[true.symbol] if true.value else math.nan,
        np.array([value for value, _, _ in seen]),
        limits[:, 0],
        limits[:, 1],
        np.array([claimed for _, _, claimed in seen]),
    )
