"""From the records of several runs to a pooled channel: common coefficients, scatter, outlying runs."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.fit import Fit
from allanite.core.limits import Remembered
from allanite.identification.likelihood.selection import standard_error
from allanite.phrases.phrase import say
from allanite.study.channels import Inspected
from allanite.study.recipe import Recipe
from allanite.terms import TERMS

from .change import alpha_of, holm
from .common_likelihood import Joint
from .contrast import chi_square, homogeneity, outlying, spread
from .likelihoods import least
from .pooled import PooledChannel, PooledTerm
from .ramps import CommonRamp, ramp_law
from .ratio import shared_curves
from .records_joined import join_records


def pool_records(seen: Inspected, names: Sequence[str], recipe: Recipe, rng: "np.random.Generator") -> PooledChannel:
    """What the records of several runs have in common."""
    alpha = alpha_of(recipe.level)
    joined = join_records(seen.records, recipe)
    _, curves = shared_curves(joined.records, joined.fits, recipe.statistic, recipe.taus)
    edf, variance = (np.array(values) for values in zip(*((c.edf, c.variance) for c in curves), strict=True))
    whole = edf.sum(axis=0)
    curve = replace(
        curves[0], variance=(edf * variance).sum(axis=0) / whole, count=np.sum([c.count for c in curves], axis=0),
        name=say("all runs"), law=PooledLaw(whole), noise=None, history=(),
    )  # fmt: skip
    apart, left = _apart(joined.joint, names, alpha)
    test = homogeneity(joined.joint, rng)
    terms = [*_noise_terms(joined.joint, joined.fits), *_ramp_terms(joined.joint, joined.fits)]
    adjusted = holm([term.p for term in terms])
    return PooledChannel(
        seen.name,
        test=test,
        terms=tuple(replace(term, adjusted=p) for term, p in zip(terms, adjusted, strict=True)),
        curve=curve,
        curves=curves,
        p=bartlett(variance, edf),
        apart=apart,
        rest=(homogeneity(left, rng) if apart else test).p,
        fits=joined.fits,
        explained=joined.explained,
        grades=joined.grades,
        records=seen.records,
        band=joined.joint.band,
        alerts=(*joined.alerts, *seen.alerts, *([_of_two(recipe.level)] if len(names) == 2 else [])),
        alpha=alpha,
    )


def _of_two(level: float) -> str:
    """What two runs cannot show: their standard deviation is distributed as chi with one degree of freedom."""
    from scipy.special import chdtri

    low, high = (1 / math.sqrt(chdtri(1, p)) for p in ((1 - level) / 2, (1 + level) / 2))
    return say(
        "limits of a common coefficient hold if both runs have the same noise: two runs give the scatter between runs "
        "with one degree of freedom, and the true one is {low:.2f} to {high:.2g} times as large ({share:g} %)",
        low=low, high=high, share=100 * level,
    )  # fmt: skip


def _noise_terms(together: Joint, fits: Sequence[Fit]) -> Iterator[PooledTerm]:
    alone, _ = least(together.only(together.chosen.free))
    for i, symbol in enumerate(together.symbols):
        statistic, p = spread(together, i)
        theta = float(together.chosen.theta[i])
        # scatter of the runs' coefficients over the common one, and as expected of equal sensors
        between = within = math.nan
        if theta > 0:
            column = int(together.chosen.free[:i].sum())
            common = [replace(together.chosen, likelihood=part) for part in together.parts]
            errors = [standard_error(subset, i) / (2 * theta) for subset in common]
            between = float(np.sqrt([part[column] / theta for part in alone]).std(ddof=1))
            within = float(np.sqrt(np.mean(np.square(errors))))
        yield PooledTerm(
            symbol,
            together.signal,
            value=math.sqrt(together.chosen.theta[i]),
            limits=Remembered(partial(together.limits, i)),
            runs=tuple(fit[symbol] for fit in fits),
            between=between,
            within=within,
            statistic=statistic,
            dof=len(fits) - 1,
            p=p,
            adjusted=p,
        )


def _ramp_terms(together: Joint, fits: Sequence[Fit]) -> Iterator[PooledTerm]:
    """Ramps are no part of the noise model: each run has its own, and these are compared."""
    laws = [law for law in (ramp_law(together, i) for i in range(len(fits))) if law is not None]
    if len(laws) < len(fits):
        return
    common = CommonRamp(laws)
    known = common.limits(0.95)[0] * common.limits(0.95)[1] > 0
    size = abs(common.value) if known else math.nan
    p = chi_square(common.chi_square, common.dof)
    for symbol in (e.symbol for e in fits[0] if TERMS[e.symbol].waveform is not None):
        yield PooledTerm(
            symbol,
            together.signal,
            value=common.value,
            limits=Remembered(common.limits),
            runs=tuple(fit[symbol] for fit in fits),
            between=float(common.values.std(ddof=1)) / size,
            within=float(np.sqrt(np.mean(common.errors**2))) / size,
            statistic=common.chi_square,
            dof=common.dof,
            p=p,
            adjusted=p,
        )


def _apart(together: Joint, names: Sequence[str], alpha: float) -> tuple[dict[str, float], Joint]:
    """Runs that differ from all others, the worst one removed at a time, and what is left."""
    apart: dict[str, float] = {}
    left = list(range(len(names)))
    rest = together
    while len(left) > 2:
        p = holm(outlying(rest))
        worst = int(np.argmin(p))
        if p[worst] > alpha:
            break
        apart[names[left.pop(worst)]] = p[worst]
        rest = replace(
            together, parts=tuple(together.parts[i] for i in left), seen=tuple(together.seen[i] for i in left)
        )
    return apart, rest


@dataclass(frozen=True, eq=False)
class PooledLaw:
    """Chi-square limits of variances averaged by their degrees of freedom, whose sum is `edf`, shape (k,)."""

    edf: FloatArray

    def __call__(self, level: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Degrees of freedom and limits over the variance; see `Curve`."""
        from scipy.special import chdtri

        low, high = (self.edf / chdtri(self.edf, p) for p in ((1 - level) / 2, (1 + level) / 2))
        return self.edf, low, high


def bartlett(variance: FloatArray, edf: FloatArray) -> FloatArray:
    """Probability that variances of shape (runs, k) with these degrees of freedom differ as much by chance, shape (k,).

    References
    ----------
    M. S. Bartlett, Proc. Royal Society A 160 (1937) 268.

    Examples
    --------
    >>> bartlett(np.array([[1.0], [1.0], [1.0]]), np.full((3, 1), 9.0)).tolist()
    [1.0]
    """
    from scipy.special import chdtrc

    runs, whole = len(edf), edf.sum(axis=0)
    mean = (edf * variance).sum(axis=0) / whole
    statistic = whole * np.log(mean) - (edf * np.log(variance)).sum(axis=0)
    correction = 1 + ((1 / edf).sum(axis=0) - 1 / whole) / (3 * (runs - 1))
    return np.asarray(chdtrc(runs - 1, np.maximum(statistic, 0.0) / correction))
