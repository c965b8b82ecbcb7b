"""Test of the identification for a sensor, rate and length by simulated records."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from allanite.core.aliases import generator, public, size_and_rate
from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.encoding import plain
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.kinds import title_of
from allanite.core.limits import quantile
from allanite.core.model import Model, ModelLike, Term, usable_model
from allanite.core.names import row_of
from allanite.core.plain import Value
from allanite.core.ranges import LEVEL, Range
from allanite.core.units import Signal
from allanite.core.validity import Band
from allanite.identification.front import identify
from allanite.phrases.phrase import join, say
from allanite.simulation.record import simulate
from allanite.terms import TERMS

from .bound import Bound, bound

Measured = tuple[float, float]  # a number and its Monte Carlo standard error

RECORDS = Range(2, 1_000_000, what="the number of records")

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
        return share(((self.low <= self.truth) & (self.truth <= self.high))[np.isfinite(self.low)])

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
        values, intervals, claimed = zip(*(_seen(symbol, fit, true.get(symbol), duration) for fit in fits), strict=True)
        limits = np.array([(math.nan, math.nan) if interval is None else interval(level) for interval in intervals])
        own = true.get(symbol) or Term(symbol, 0.0, truth.signal)
        known = least[symbol] if own.value else math.nan
        columns = np.array(values), limits[:, 0], limits[:, 1], np.array(claimed)
        yield TermCheck(symbol, own.signal, own.value, known, *columns)
    for t in true.values():
        for i in range(max((len(e.shape) for fit in fits for e in fit if _shaped(e, t)), default=0)):
            yield _shape_check(t, i, fits, level, least)


def sought(fits: Sequence[Fit]) -> list[str]:
    """Symbols of the terms that were looked for; sinusoids where one was found."""
    return list(dict.fromkeys([e.symbol for fit in fits for e in fit] + [LINE for fit in fits if fit.lines]))


def compared(truth: Model) -> dict[str, Term]:
    """The terms of a model that can be told by their symbol."""
    symbols = [t.symbol for t in truth]
    return {t.symbol: t for t in truth if symbols.count(t.symbol) == 1}


def _shaped(e: Estimate, true: Term) -> bool:
    return e.symbol == true.symbol and e.value is not None and e.shape_limits is not None


def _shape_check(true: Term, which: int, fits: Sequence[Fit], level: float, least: Bound) -> TermCheck:
    """A time constant: of the records in which its term was found."""
    name = join(" ", (true.symbol, true.row.parameters[which].title))
    estimates = [next((e for e in fit if _shaped(e, true)), None) for fit in fits]
    nothing = (math.nan, math.nan)
    limits = np.array([e.shape_limits(level)[which] if e and e.shape_limits else nothing for e in estimates])
    value = np.array([e.shape[which] if e else math.nan for e in estimates])
    claimed = np.array([e is not None for e in estimates])
    return TermCheck(name, true.signal, true.shape[which], least[name], value, limits[:, 0], limits[:, 1], claimed)


def _seen(symbol: str, fit: Fit, true: Term | None, duration: float) -> tuple[float, Interval | None, bool]:
    """The coefficient in the model, its interval if one was given, and whether the term was said to be there."""
    if symbol == LINE:
        # the sinusoid nearest to the true one, if it is within two steps of the spectrum; without a true one any
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


@dataclass(frozen=True, eq=False, repr=False)
class SelfCheck(Value):
    """Results of the identification on simulated records of a known model.

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
        Share of records that no model explains, and its standard error.
    notes : tuple of str
        Terms of the model that were not looked for, or cannot be distinguished by their symbol.
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
        return row_of("term", symbol, {check.symbol: check for check in self.terms}, where=" of this check")

    def rows(self) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows: each measured number is followed by its Monte Carlo standard error."""
        headings = ["term", "truth", "bound", *(part for name in MEASURED for part in (name, "+-"))]
        measured = [[part for name in MEASURED for part in getattr(check, name)] for check in self.terms]
        return headings, [[c.symbol, c.truth, c.bound, *m] for c, m in zip(self.terms, measured, strict=True)]

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data; the intervals are at the check's own level, whatever `level` says."""
        share, error = self.unexplained
        return super().to_dict(level) | {"unexplained": plain(share), "unexplained_error": plain(error)}

    @classmethod
    def _stored(cls, data: dict[str, Any]) -> "SelfCheck":
        pair = [data.get(key) for key in ("unexplained", "unexplained_error")]
        return super()._stored(data | {"unexplained": pair})

    def _summary(self) -> str:
        return f"{self.records} records of {self.size} samples at {self.rate:g} Hz: {self.model}"

    def exceeded(
        self, *, bias: float = math.inf, coverage: float = 0.0, false: float = 1.0, missed: float = 1.0
    ) -> list[str]:
        """Which limits are exceeded by more than two Monte Carlo standard errors, in sentences.

        Parameters
        ----------
        bias : float
            Largest bias, relative to the coefficient, for terms that are present.
        coverage : float
            Smallest share of intervals that contain the true value.
        false, missed : float
            Largest shares of records in which an absent term is reported, or a present term is missed.
        """
        sentences: list[str] = []
        for c in self.terms:
            share, error = c.found
            # what is measured, its limit, and on which side of it (1: above, -1: below) it is wrong
            judged = [(say("coverage"), c.coverage, coverage, -1)]
            if c.truth:
                size, its = c.bias
                judged.append((say("bias of the estimate"), (abs(size), its), bias, 1))
                judged.append((say("missed in"), (1 - share, error), missed, 1))
            else:
                judged.append((say("falsely found in"), (share, error), false, 1))
            sentences += [say("{term}: {what} {measured:.3g} +- {error:.2g} %, limit {limit:.3g} %",
                              term=c.symbol, what=what, measured=100 * measured, error=100 * scatter, limit=100 * limit)
                          for what, (measured, scatter), limit, sign in judged
                          if sign * (measured - limit) > 2 * scatter]  # fmt: skip
        return sentences


@public
def selfcheck(  # noqa: PLR0913 - the choices of the identification among its own
    model: ModelLike, size: int | None = None, rate: float | None = None, *, duration: float | str | None = None,
    records: Annotated[int, RECORDS] = 100, rng: "np.random.Generator | int | None" = None,
    terms: str | Sequence[str] = "auto", method: str | None = None, band: Band | None = None,
    level: Annotated[float, LEVEL] = 0.95, progress: Callable[[str, float], None] | None = None,
) -> SelfCheck:  # fmt: skip
    """Simulate records of a model, identify each, and compare with the true values and the Cramer-Rao bound.

    Parameters
    ----------
    model : Model, Term or Fit
        The sensor; of a fit, its model.
    size : int
        Number of samples of each record; or `duration`, s.
    rate : float
        Sampling rate, Hz.
    records : int
        Number of records to simulate, at least 2.
    rng : numpy.random.Generator or int, optional
        The source of randomness, or its seed; by default another one each time.
    terms, method, band
        As for `identify`. The bound is that of the whole record, whatever the method and the band.
    level : float
        Confidence level of the intervals.
    progress : callable, optional
        Called with a description of the current step and the fraction completed.

    Returns
    -------
    SelfCheck

    Raises
    ------
    UsageError
        There are fewer than two records.
    DataError
        The records are too short to identify anything.

    Examples
    --------
    >>> from allanite import N
    >>> check = selfcheck(N(0.1, "deg/sqrt(h)"), 2000, 100.0, records=20, rng=np.random.default_rng(1))
    >>> check["N"].found[0], abs(check["N"].bias[0]) < 0.02, round(check["N"].bound, 4)
    (1.0, True, 0.0158)
    """
    truth, (n, rate) = usable_model(model), size_and_rate(size, rate, duration)
    tell = progress or (lambda what, fraction: None)
    fits = []
    for i, child in enumerate(generator(rng).spawn(records)):
        tell(f"record {i + 1} of {records}", i / records)
        fits.append(identify(simulate(truth, n, rate, rng=child), method, terms=terms, band=band))
    checks = tuple(term_checks(truth, fits, bound(truth, n, rate), level))
    judged = [fit.goodness for fit in fits if fit.goodness is not None]
    # a record whose fit is not judged is not doubted, unless none is
    doubted = np.array([not good.explained for good in judged] + [False] * (len(fits) - len(judged)))
    unexplained = share(doubted if judged else doubted[:0])
    return SelfCheck(truth, n, rate, records, level, checks, unexplained, tuple(_notes(truth, fits)))


def _notes(truth: Model, fits: list[Fit]) -> Iterator[str]:
    looked, known = sought(fits), compared(truth)
    for symbol in dict.fromkeys(t.symbol for t in truth):
        term = title_of(symbol, truth.signal)
        if symbol not in looked:
            yield say("{term} ({symbol}) is in the model, but was not identified in any record", term=term,
                      symbol=symbol)  # fmt: skip
        elif symbol not in known:
            yield say("{term} ({symbol}) is in the model, but occurs in it several times", term=term, symbol=symbol)
    if any(e.status == "reported" for fit in fits for e in fit):
        yield say("method {method!r} gives no evidence for a term: none is counted as identified",
                  method=fits[0].method)  # fmt: skip
