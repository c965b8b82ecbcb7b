"""Test of the identification for a sensor, rate and length by simulated records."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from allanite.core.aliases import generator, public, size_and_rate
from allanite.core.encoding import plain
from allanite.core.errors import UsageError
from allanite.core.fit import Fit
from allanite.core.limits import demand_level
from allanite.core.model import Model, ModelLike, usable_model
from allanite.core.plain import Value
from allanite.core.titles import title_of
from allanite.core.validity import Band
from allanite.identification.front import identify
from allanite.phrases.phrase import say
from allanite.simulation.record import simulate

from .bound import bound
from .termcheck import MEASURED, Measured, TermCheck, compared, share, sought, term_checks


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
        for check in self.terms:
            if check.symbol == symbol:
                return check
        raise UsageError(f"{symbol!r} was not looked for; terms: {', '.join(check.symbol for check in self.terms)}")

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
            found, error = c.found
            # what is measured, its limit, and on which side of it (1: above, -1: below) it is wrong
            judged = [(say("coverage"), c.coverage, coverage, -1)]
            if c.truth:
                size, its = c.bias
                judged.append((say("bias of the estimate"), (abs(size), its), bias, 1))
                judged.append((say("missed in"), (1 - found, error), missed, 1))
            else:
                judged.append((say("falsely found in"), (found, error), false, 1))
            sentences += [
                say(
                    "{term}: {what} {measured:.3g} +- {error:.2g} %, limit {limit:.3g} %",
                    term=c.symbol,
                    what=what,
                    measured=100 * measured,
                    error=100 * scatter,
                    limit=100 * limit,
                )
                for what, (measured, scatter), limit, sign in judged
                if sign * (measured - limit) > 2 * scatter
            ]
        return sentences


@public
def selfcheck(  # noqa: PLR0913 - the choices of the identification among its own
    model: ModelLike,
    size: int | None = None,
    rate: float | None = None,
    *,
    duration: float | None = None,
    records: int = 100,
    rng: "np.random.Generator | int",
    terms: str | Sequence[str] = "auto",
    method: str | None = None,
    band: Band | None = None,
    level: float = 0.95,
    progress: Callable[[str, float], None] | None = None,
) -> SelfCheck:
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
    rng : numpy.random.Generator or int
        The source of randomness, or its seed.
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
    demand_level(level)
    if records < 2:
        raise UsageError(f"a check needs at least 2 records, not {records}")
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
            yield say(
                "{term} ({symbol}) is in the model, but was not identified in any record", term=term, symbol=symbol
            )
        elif symbol not in known:
            yield say("{term} ({symbol}) is in the model, but occurs in it several times", term=term, symbol=symbol)
    if any(e.status == "reported" for fit in fits for e in fit):
        yield say(
            "method {method!r} gives no evidence for a term: none is counted as identified", method=fits[0].method
        )
