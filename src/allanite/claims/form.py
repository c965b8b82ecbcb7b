"""The likelihood of a record under the terms that are claimed of it, under others beside them, and other times."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from allanite.comparison.common_likelihood import common_band, part_of
from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.fit import Fit
from allanite.core.limits import quantile
from allanite.core.model import Model, Term
from allanite.core.record import Record
from allanite.identification.likelihood.likelihood import Likelihood
from allanite.identification.likelihood.selection import Subset, ThetaProfile
from allanite.identification.likelihood.spectrum import BinnedSpectrum, spectrum
from allanite.identification.likelihood.whittle import column, likelihood, with_warm_up
from allanite.prepare.outliers import treated
from allanite.terms import TERMS

WIDTH = 4.0
"""Coefficients of the transform to either side of a sinusoid that are left out."""

BESIDE = tuple(s for s, row in TERMS.items() if row.automatic and row.waveform is None)
"""Noise that is looked for beside what is claimed."""

RAMP = next(s for s, row in TERMS.items() if row.automatic and row.waveform is not None)
"""The ramp, which is looked for, too."""


@dataclass(frozen=True, eq=False)
class Form:
    """The likelihood of squared coefficients, SI, of one record; each column has its term.

    The first columns are the terms that are claimed, with their coefficients; then come those that may be beside them
    (`BESIDE`), the first claimed term with a time constant, for other time constants, and a ramp, if none is claimed.
    """

    terms: tuple[Term, ...]
    likelihood: Likelihood
    claimed: int

    def having(self, columns: Sequence[int]) -> Subset:
        """The likelihood with these columns free, at its minimum."""
        free = np.isin(np.arange(len(self.terms)), columns)
        return Subset(self.likelihood, free, *self.likelihood.minimise(free))

    def settled(self, columns: Sequence[int]) -> Subset:
        """The same; a ramp among them, which was not claimed, may have any size and is no column any more."""
        ramps = [i for i in columns if self.terms[i].symbol == RAMP]
        free = np.isin(np.arange(len(self.terms)), columns)
        free[ramps] = False
        part = replace(self.likelihood, flat=self.likelihood.flat | self.likelihood.W[:, ramps].any(axis=1))
        return Subset(part, free, *part.minimise(free))

    def ratio(self, subset: Subset, which: int, alpha: float) -> tuple[float, float, float]:
        """A coefficient over what is claimed, and its profile limits at 1 - alpha."""
        profile, drop = ThetaProfile(subset, which), quantile(1 - alpha / 2) ** 2
        size = self.terms[which].value
        best, low, high = (math.sqrt(theta) / size for theta in
                           (profile.best, profile.lower(drop), profile.upper(drop)))  # fmt: skip
        return best, low, high

    def beside(self, held: Sequence[int], alpha: float) -> tuple[int, ...]:
        """Columns of noise that is there beside the columns `held`, with a chance of alpha that one is found falsely.

        A coefficient is not negative, so that its gain in 2 L is zero for half of all records without it.
        """
        others = [i for i in range(self.claimed, len(self.terms)) if not self.terms[i].shape]
        found, value = tuple[int, ...](), self.having(held).value
        for count in range(1, len(others) + 1):
            values = {more: self.having((*held, *more)).value for more in combinations(others, count)}
            best = min(values, key=values.__getitem__)
            if 2 * (value - values[best]) <= quantile(1 - alpha / len(others)) ** 2:
                break
            found, value = best, values[best]
        return found


def form_of(record: Record, model: Model, fit: Fit, times: FloatArray) -> Form:
    """The likelihood of a record under claimed noise."""
    record, claimed = treated(record, "mark"), [t for t in model if t.row.waveform is None]
    symbols = [t.symbol for t in claimed]
    plain = [t for t in claimed if not t.shape]
    plain += [Term(s, 1.0, record.signal) for s in BESIDE if s not in symbols]
    first = next((t for t in claimed if t.shape), None)
    shaped = [t for t in claimed if t.shape]
    shaped += [replace(first, shape=(float(time), *first.shape[1:])) for time in times] if first else []
    seen = spectrum(record, detrend=True)
    whole = likelihood(seen, [*(t.symbol for t in plain), RAMP])
    warm = next((t for t in model if t.row.transient), None)
    if warm is not None:
        whole = with_warm_up(whole, seen, np.ones_like(seen.first, dtype=bool), warm.shape[0] * record.rate)
    for term in shaped:
        whole = whole.with_more(column(term.sampled(record.rate), seen))
    scope, lines = fit.scope, [line.frequency for line in fit.lines]
    lines += [t.shape[0] for t in model if not t.row.scatters and not t.row.transient]
    if scope is not None and lines:
        near = WIDTH * record.rate / (2 * record.size)
        scope = replace(scope, masks=(*scope.masks, *((line - near, line + near) for line in lines)))
    every = [*plain, *shaped]
    band = common_band([record], None, [scope])
    part = part_of(whole, seen, [t.symbol for t in every], scope, band=band, scopes=[scope])
    if part.flat.any() and not model.drifts:
        ramp = Term(RAMP, abs(seen.slope) * seen.rate * seen.unit_factor or 1.0, record.signal)
        part, every = _with_ramp(part, seen, ramp), [*every, ramp]
    order = sorted(range(len(every)), key=lambda i: every[i] not in claimed)
    moved = replace(part, S=part.S[:, order], W=part.W[:, order])
    return Form(tuple(every[i] for i in order), moved, len(claimed))


def _with_ramp(part: Likelihood, seen: BinnedSpectrum, term: Term) -> Likelihood:
    """A likelihood whose ramp, its last direction, has a size that is drawn at random: one more term beside the others.

    Its squared coefficient, over that of `term`, then gains in 2 L as a random walk does, which may be in its place.
    """
    ramp = np.arange(part.flat.size) == part.flat.size - 1
    slope = seen.slope * ramp  # what was subtracted before comes back
    squares = (part.UU @ slope) @ slope + 2 * part.Uc @ slope
    return replace(
        part,
        S=np.column_stack((part.S, np.zeros(part.power.size))),
        W=np.column_stack((part.W, ramp * (term.value / (seen.rate * seen.unit_factor)) ** 2)),
        power=part.power + squares / part.count,
        Uc=part.Uc + part.UU @ slope,
        flat=part.flat & ~ramp,
    )


def time_excess(forms: Sequence[Form], which: int) -> tuple[FloatArray, FloatArray]:
    """Time constants, s, and 2 L of several records at each, less its minimum: one that all have in common.

    `which` is the column of the term with the claimed time constant, which is among them.
    """
    columns = [which, *(i for i in range(forms[0].claimed, len(forms[0].terms)) if forms[0].terms[i].shape)]
    times = np.array([forms[0].terms[i].shape[0] for i in columns])
    others = [i for i in range(forms[0].claimed) if i != which]
    value = np.array([sum(2 * form.having((*others, i)).value for form in forms) for i in columns])
    order = np.argsort(times)
    return times[order], (value - value.min())[order]


def inside(times: FloatArray, excess: FloatArray, alpha: float) -> tuple[float, float]:
    """Limits of a time constant at 1 - alpha; 0 or infinity where the times that were tried do not reach them."""
    kept: BoolArray = excess <= quantile(1 - alpha / 2) ** 2
    first, last = int(kept.argmax()), int(kept.size - 1 - kept[::-1].argmax())
    edge = [np.interp(quantile(1 - alpha / 2) ** 2, *part) for part in _flanks(times, excess, first, last)]
    return (float(np.exp(edge[0])) if first else 0.0), (float(np.exp(edge[1])) if last < times.size - 1 else np.inf)


def _flanks(times: FloatArray, excess: FloatArray, first: int, last: int) -> list[tuple[FloatArray, FloatArray]]:
    """Excess and log time at the ends of an interval, for the interpolation between the last two times."""
    low, high = [max(first - 1, 0), first], [last, min(last + 1, times.size - 1)]
    return [(excess[low][::-1], np.log(times[low])[::-1]), (excess[high], np.log(times[high]))]
