"""Pool: what several runs of one type of sensor have in common, how they scatter, and which of them is an outlier."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar

from allanite.core.arrays import FloatArray
from allanite.core.curve import Curve
from allanite.core.encoding import finite
from allanite.core.estimate import TERM, Estimate
from allanite.core.fit import chance
from allanite.core.limits import demand_level
from allanite.core.model import coefficient_factor
from allanite.core.plain import Value
from allanite.core.titles import title_of
from allanite.core.units import Signal
from allanite.phrases.phrase import join, say
from allanite.terms import TERMS

from .together import ComparedChannel, Together, of_symbol


@dataclass(frozen=True, eq=False, repr=False)
class PooledTerm(Value):
    """One coefficient of all runs."""

    _keys: ClassVar = {"statistic": "chi_square", "adjusted": "p_holm"}

    _checks = TERM

    symbol: str
    signal: Signal
    value: float  # the coefficient that all runs have in common, SI, with its sign for a ramp; 0 where they show none
    limits: Callable[[float], tuple[float, float]]  # interval of the common coefficient, if there is one
    runs: tuple[Estimate, ...]  # estimates of each run by itself
    between: float  # standard deviation of the runs' coefficients, over the common one; NaN where that may be 0
    within: float  # the same to be expected of runs of equal sensors, from the standard errors
    # statistic, dof, p, adjusted: chi-square of the coefficient being the same in all runs, and its p, also after
    # Holm's correction
    statistic: float
    dof: int
    p: float
    adjusted: float

    def interval(self, level: float = 0.95) -> tuple[float, float]:
        """Confidence limits (low, high) of the common coefficient, SI."""
        demand_level(level)
        return self.limits(level)

    @property
    def sheet_unit(self) -> str:
        """Unit of data sheets."""
        return self.signal.sheet[TERMS[self.symbol].power]

    def row(self, level: float = 0.95) -> list[Any]:
        """Symbol, name, common coefficient and its limits, unit, scatter in percent, chi-square, dof, p, adjusted p."""
        factor = coefficient_factor(self.symbol, self.sheet_unit, self.signal)
        values = [v / factor for v in (self.value, *self.interval(level))]
        title = title_of(self.symbol, self.signal)
        return [self.symbol, title, *values, self.sheet_unit, 100 * self.between, 100 * self.within, self.statistic,
                self.dof, self.p, self.adjusted]  # fmt: skip

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data."""
        low, high = self.interval(level)
        unit = self.signal.si[TERMS[self.symbol].power]
        return super().to_dict(level) | {"unit": unit, "low": finite(low), "high": finite(high), "level": level}

    def _summary(self) -> str:
        factor = coefficient_factor(self.symbol, self.sheet_unit, self.signal)
        return f"{self.symbol} {self.value / factor:.4g} {self.sheet_unit}, {len(self.runs)} runs, {chance(self.p)}"


@dataclass(frozen=True, eq=False, repr=False)
class PooledChannel(ComparedChannel):
    """One channel of all runs.

    Attributes
    ----------
    terms : tuple of PooledTerm
    curve : Curve or None
        Variances averaged by their degrees of freedom, which add up.
    curves : tuple of Curve
        Curves of each run, at the same averaging times.
    p : array, shape (k,)
        p-value of equal variances at each averaging time (Bartlett's test with the degrees of freedom).
    apart : dict
        Outlying runs with the adjusted p, in the order in which they were removed.
    rest : float
        p of one common model for the runs that are left.
    name, test, band, fits, explained, grades, records, alerts, refusal, alpha
        See `ComparedChannel`.
    """

    _keys: ClassVar = {"rest": "p_rest"}
    _also = ("verdict",)

    terms: tuple[PooledTerm, ...] = ()
    curve: Curve | None = None
    curves: tuple[Curve, ...] = ()
    p: FloatArray | None = None
    apart: dict[str, float] = field(default_factory=dict)
    rest: float = 1.0

    def __getitem__(self, symbol: str) -> PooledTerm:
        return of_symbol(self.terms, symbol, "pooled")

    @property
    def alike(self) -> bool:
        """Whether the runs differ by no more than chance, in their noise and in their ramps."""
        ramps = (t for t in self.terms if TERMS[t.symbol].waveform is not None)
        return self._one_noise and all(t.adjusted > self.alpha for t in ramps)

    @property
    def _one_noise(self) -> bool:
        return self.test is not None and self.test.p > self.alpha

    @property
    def verdict(self) -> str:
        """What the runs have in common and what not, in a sentence or two."""
        if self.refusal or self.test is None:
            return say("not pooled: {reason}", reason=self.refusal)
        runs, p = len(self.fits), chance(self.test.p)
        if self._one_noise and not self.apart:
            first: str = say("one noise model describes all {runs} runs ({p})", runs=runs, p=p)
        elif self._one_noise:
            first = say("one noise model describes the {runs} runs ({p})", runs=runs, p=p)
        else:
            first = say("the {runs} runs do not have the same noise ({p})", runs=runs, p=p)
        parts = [first]
        if self.apart:
            runs_apart = join(", ", [join("", (name, f" ({chance(p)})")) for name, p in self.apart.items()])
            parts.append(say("different from the others: {runs}", runs=runs_apart))
            if self.rest > self.alpha:
                parts.append(say("the remaining runs have the same noise ({p})", p=chance(self.rest)))
            else:
                parts.append(say("the remaining runs still differ ({p})", p=chance(self.rest)))
        named = [t.symbol for t in self.terms if t.adjusted <= self.alpha]
        if named:
            parts.append(say("the scatter between runs exceeds that within them in {terms}", terms=", ".join(named)))
        return join("; ", parts)


@dataclass(frozen=True, eq=False, repr=False)
class Pool(Together[PooledChannel]):
    """Every channel of several recordings; ``pool["z"]`` is that of a channel.

    Attributes
    ----------
    channels : tuple of PooledChannel
    names : tuple of str
        Names of the recordings.
    recipe, findings, notes, provenance
        As for `Study`; ``source 2`` and so on are the other recordings.
    """

    _channel = PooledChannel

    @property
    def terms(self) -> tuple[PooledTerm, ...]:
        """The coefficients, channel after channel."""
        return tuple(term for channel in self.channels for term in channel.terms)

    def rows(self, level: float | None = None) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows: the common coefficient, its limits, and how the runs scatter about it, in percent."""
        level = level or self.level
        headings = ["channel", "term", "", "common", f"low {level:.4g}", f"high {level:.4g}", "unit", "between %",
                    "within %", "chi-square", "dof", "p", "p (Holm)"]  # fmt: skip
        return headings, [[channel.name, *term.row(level)] for channel in self.channels for term in channel.terms]

    def _summary(self) -> str:
        return f"{len(self.names)} runs: {self.verdict}"
