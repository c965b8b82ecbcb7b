"""Pool: what several runs of one type of sensor have in common, how they scatter, and which of them is apart."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, ClassVar

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.curve import Curve
from allanite.core.encoding import finite
from allanite.core.estimate import TERM, Estimate
from allanite.core.fit import Fit, chance
from allanite.core.kinds import title_of
from allanite.core.limits import NormalMixture, Remembered, demand_level
from allanite.core.model import coefficient_factor
from allanite.core.plain import Value
from allanite.core.units import Signal
from allanite.identification.likelihood.law import standard_error
from allanite.phrases.phrase import join, say
from allanite.study.channels import Inspected
from allanite.study.recipe import Recipe
from allanite.terms import TERMS

from .change import ComparedChannel, Together, alpha_of, holm, of_symbol
from .common_likelihood import Joint, least
from .contrast import chi_square, homogeneity, outlying, spread
from .ratio import ramp_law, shared_curves
from .runs import CommonValue, PooledLaw, bartlett
from .sources import join_records


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
    """One channel of all runs."""

    _keys: ClassVar = {"rest": "p_rest"}
    _also = ("verdict",)

    terms: tuple[PooledTerm, ...] = ()
    curve: Curve | None = None  # variances averaged by their degrees of freedom, which add up
    curves: tuple[Curve, ...] = ()  # of each run, at the same averaging times
    p: FloatArray | None = None  # shape (k,); of equal variances at each averaging time, by Bartlett's test
    apart: dict[str, float] = field(default_factory=dict)  # outlying runs with the adjusted p, as they were removed
    rest: float = 1.0  # p of one common model for the runs that are left

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
    def of_axes(self) -> bool:
        """Whether the records are axes, each with a name of its own, and not runs of one."""
        names = {record.name for record in self.records or ()}
        return len(names) == len(self.records or ()) > 0 and all(names)

    @property
    def verdict(self) -> str:
        """What the runs have in common and what not, in a sentence or two."""
        if self.refusal or self.test is None:
            return say("not pooled: {reason}", reason=self.refusal)
        kind = say("axes") if self.of_axes else say("runs")
        every: dict[str, Any] = {"count": len(self.fits), "runs": kind, "p": chance(self.test.p)}
        parts: list[str] = [say("the {count} {runs} do not have the same noise ({p})", **every)]
        if self._one_noise:
            parts = [say("one noise model describes the {count} {runs} ({p})", **every) if self.apart
                     else say("one noise model describes all {count} {runs} ({p})", **every)]  # fmt: skip
        if self.apart:
            runs_apart = join(", ", [join("", (name, f" ({chance(p)})")) for name, p in self.apart.items()])
            parts.append(say("different from the others: {runs}", runs=runs_apart))
            rest = {"runs": kind, "p": chance(self.rest)}
            parts.append(say("the remaining {runs} have the same noise ({p})", **rest) if self.rest > self.alpha
                         else say("the remaining {runs} still differ ({p})", **rest))  # fmt: skip
        named = [t.symbol for t in self.terms if t.adjusted <= self.alpha]
        if named:
            parts.append(say("the scatter between {runs} exceeds that within them in {terms}", runs=kind,
                             terms=", ".join(named)))  # fmt: skip
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


def pool_records(inspected: Inspected, names: Sequence[str], recipe: Recipe,
                 rng: "np.random.Generator") -> PooledChannel:  # fmt: skip
    """What the records of several runs have in common."""
    alpha = alpha_of(recipe.level)
    joined = join_records(inspected.records, recipe)
    _, curves = shared_curves(joined.records, joined.fits, recipe.statistic, recipe.taus)
    edf, variance = (np.array(values) for values in zip(*((c.edf, c.variance) for c in curves), strict=True))
    whole = edf.sum(axis=0)
    curve = replace(curves[0], variance=(edf * variance).sum(axis=0) / whole,
                    count=np.sum([c.count for c in curves], axis=0), name=say("all runs"), law=PooledLaw(whole),
                    noise=None, history=())  # fmt: skip
    apart, rest = _apart(joined.joint, names, alpha)
    test = homogeneity(joined.joint, rng)
    terms = [*_noise_terms(joined.joint, joined.fits), *_ramp_terms(joined.joint, joined.fits)]
    adjusted = holm([term.p for term in terms])
    return PooledChannel(
        inspected.name,
        test=test, terms=tuple(replace(term, adjusted=p) for term, p in zip(terms, adjusted, strict=True)),
        curve=curve, curves=curves, p=bartlett(variance, edf), apart=apart,
        rest=(homogeneity(rest, rng) if apart else test).p, records=inspected.records, **joined.judged,
        alerts=(*joined.alerts, *inspected.alerts, *([_of_two(recipe.level)] if len(names) == 2 else [])), alpha=alpha,
    )  # fmt: skip


def _of_two(level: float) -> str:
    """What two runs cannot show: their standard deviation is distributed as chi with one degree of freedom."""
    from scipy.special import chdtri

    low, high = (1 / math.sqrt(chdtri(1, p)) for p in ((1 - level) / 2, (1 + level) / 2))
    return say("limits of a common coefficient hold if both runs have the same noise: two runs give the scatter "
               "between runs with one degree of freedom, and the true one is {low:.2f} to {high:.2g} times as large "
               "({share:g} %)", low=low, high=high, share=100 * level)  # fmt: skip


def _noise_terms(together: Joint, fits: Sequence[Fit]) -> Iterator[PooledTerm]:
    alone, _ = least(together.only(together.chosen.free))
    for i, symbol in enumerate(together.symbols):
        root, law = math.sqrt(together.chosen.theta[i]), partial(together.limits, i)
        statistic, p = spread(together, i)
        tested = partial(PooledTerm, symbol, together.signal, runs=tuple(fit[symbol] for fit in fits),
                         statistic=statistic, dof=len(fits) - 1, p=p, adjusted=p)  # fmt: skip
        if not root:
            yield tested(value=0.0, limits=Remembered(law), between=math.nan, within=math.nan)
            continue
        column = int(together.chosen.free[:i].sum())
        subsets = [replace(together.chosen, likelihood=part) for part in together.parts]
        errors = np.array([standard_error(subset, i) for subset in subsets]) / (2 * root)
        common = CommonValue(np.sqrt([theta[column] for theta in alone]), errors, root, law, least=0.0)
        yield tested(**_scatter(common, common.value))


def _scatter(common: CommonValue, size: float) -> dict[str, Any]:
    """The common coefficient, its limits, and the scatter between and within runs over its size."""
    between, within = float(common.values.std(ddof=1)) / size, math.sqrt(np.mean(common.errors**2)) / size
    return {"value": common.value, "limits": Remembered(common.limits), "between": between, "within": within}


def _ramp_terms(together: Joint, fits: Sequence[Fit]) -> Iterator[PooledTerm]:
    """Ramps are no part of the noise model: each run has its own, and these are compared."""
    laws = [law for law in (ramp_law(together, i) for i in range(len(fits))) if law is not None]
    if len(laws) < len(fits):
        return
    values, errors = np.array([(law.value, law.error) for law in laws]).T
    error = float((errors**-2).sum()) ** -0.5
    alike = NormalMixture(np.array([np.average(values, weights=errors**-2)]), np.array([error]), np.ones(1))
    common = CommonValue(values, errors, alike.value, alike)
    low, high = common.limits(0.95)
    p = chi_square(common.chi_square, common.dof)
    for symbol in (e.symbol for e in fits[0] if TERMS[e.symbol].waveform is not None):
        yield PooledTerm(symbol, together.signal, runs=tuple(fit[symbol] for fit in fits),
                         statistic=common.chi_square, dof=common.dof, p=p, adjusted=p,
                         **_scatter(common, abs(common.value) if low * high > 0 else math.nan))  # fmt: skip


def _apart(together: Joint, names: Sequence[str], alpha: float) -> tuple[dict[str, float], Joint]:
    """Runs that differ from all others, the worst one removed at a time, and what is left."""
    apart: dict[str, float] = {}
    runs = list(range(len(names)))
    rest = together
    while len(runs) > 2:
        p = holm(outlying(rest))
        worst = int(np.argmin(p))
        if p[worst] > alpha:
            break
        apart[names[runs.pop(worst)]] = p[worst]
        parts, spectra = zip(*((together.parts[i], together.spectra[i]) for i in runs), strict=True)
        rest = replace(together, parts=parts, spectra=spectra)
    return apart, rest
