"""Two records of a channel as a pair: the verdict, the change of each coefficient, the ratio of their curves.

Two series of equal variance have a sum and a difference that do not correlate, whatever the correlation of the two
themselves (E. J. G. Pitman, W. A. Morgan, Biometrika 31 (1939) 9, 13). Independent records are distinguished by their
own scatter; these by that of their difference only.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, cast

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.curve import Curve
from allanite.core.errors import DataError
from allanite.core.fit import Fit
from allanite.core.limits import Remembered, quantile
from allanite.core.model import Model, Term
from allanite.core.record import Record
from allanite.phrases.phrase import say
from allanite.planning.bound import bound
from allanite.statistics import deviation
from allanite.study.channels import Inspected
from allanite.study.recipe import Recipe
from allanite.terms import TERMS

from .change import RESOLVED, Change, Homogeneity, alpha_of, changes_of
from .common_likelihood import Joint
from .comparison import Pair, Ratios
from .contrast import Contrast, chi_square, homogeneity, partly_common, shape_contrasts
from .ratio import RampContrast, line_contrasts, ramp_law, ratio_law, shared_curves
from .sources import join_records

ALIKE = 0.7  # correlation of the steps from which on two records are a pair
FEWEST = 8  # coefficients of the cosine transform in the lowest range of frequencies; the others are octaves above it

BLOCKS = (1, 8, 64, 512)
"""Samples of the means whose steps are correlated: records that share their noise only below some frequency, such as
raw and smoothed ones, are seen in the longer ones.
"""

MEANS = 100  # means that there must be: of so few independent ones, no correlation reaches `ALIKE`


def resemblance(records: tuple[Record, Record]) -> float:
    """Largest correlation of the steps of two records' means; 0 where they are not sample by sample."""
    # Steps, because levels correlate by chance: two random walks often do, two ramps always.
    if records[0].size != records[1].size or records[0].rate != records[1].rate:
        return 0.0
    first, second = _together(records)
    if first.size < FEWEST:
        return 0.0
    lengths = [m for m in BLOCKS if m == 1 or first.size // m >= MEANS]
    return max(float(np.corrcoef(_steps(first, m), _steps(second, m))[0, 1]) for m in lengths)


def _steps(values: FloatArray, m: int) -> FloatArray:
    """Differences of successive means over m samples."""
    return np.asarray(np.diff(values[: values.size // m * m].reshape(-1, m).mean(axis=1)))


def _together(records: tuple[Record, Record]) -> tuple[FloatArray, FloatArray]:
    """The rates of both where both are there."""
    first, second = (record.rate_values for record in records)
    both = np.isfinite(first) & np.isfinite(second)
    return first[both], second[both]


def paired_homogeneity(records: tuple[Record, Record]) -> Homogeneity:
    """Whether the two have equal power in every octave of frequency: the likelihood ratio of no correlation."""
    from scipy.fft import dct

    first, second = (dct(values - values.mean(), norm="ortho")[1:] for values in _together(records))
    total, gone = first + second, second - first
    edges = FEWEST * 2 ** np.arange(int(np.log2(total.size / FEWEST)))
    starts = np.concatenate(([0], edges))
    product, square, other = (np.add.reduceat(v, starts) for v in (total * gone, total**2, gone**2))
    count = np.diff(np.concatenate((starts, [total.size])))
    r2 = product**2 / np.maximum(square * other, np.finfo(float).tiny)
    # with this factor the mean is that of a chi-square down to few coefficients
    statistic = float(-((count - 1.5) * np.log1p(-np.minimum(r2, 1 - 1e-15))).sum())
    return Homogeneity(statistic, starts.size, chi_square(statistic, starts.size), 0)


@dataclass(frozen=True, eq=False)
class PairedLaw:
    """Law of the ratio of two variances that correlate by `correlation`, with `edf` degrees of freedom, shape (k,)."""

    correlation: FloatArray
    edf: FloatArray

    def p(self, ratio: FloatArray) -> FloatArray:
        """Two-sided probability of a ratio as far from 1."""
        from scipy.special import stdtr

        t = np.abs(ratio - 1) / np.sqrt(4 * ratio * self._apart / self._dof)
        return np.asarray(2 * stdtr(self._dof, -t))

    def limits(self, ratio: FloatArray, level: float) -> tuple[FloatArray, FloatArray]:
        """Limits of the ratio of the expectations, from a measured ratio."""
        from scipy.special import stdtrit

        K = 1 + 2 * self._apart * stdtrit(self._dof, (1 + level) / 2) ** 2 / self._dof
        wide = K + np.sqrt(K * K - 1)
        return ratio / wide, ratio * wide

    @property
    def _dof(self) -> FloatArray:
        return np.asarray(np.maximum(self.edf - 1, 0.5))

    @property
    def _apart(self) -> FloatArray:
        return np.asarray(np.maximum(1 - self.correlation**2, 1e-15))


def paired_law(records: tuple[Record, Record], curves: tuple[Curve, Curve]) -> PairedLaw:
    """The law of the ratio of two curves' variances, from the curves of the records' sum and difference."""
    first, second = (record.rate_values for record in records)
    before, after = curves
    both = []
    signal = records[0].signal
    for values in (first + second, first - second):
        record = replace(records[0], values=values, unit=signal.unit, kind=signal.kind, scale=None)
        both.append(deviation(record, before.statistic, m=before.m.tolist(), noise=None).variance)
    correlation = (both[0] - both[1]) / 4 / np.sqrt(before.variance * after.variance)
    return PairedLaw(np.clip(correlation, -1, 1), np.minimum(before.edf, after.edf))


STEP = 4.0  # factor between the lengths that are tried
LIKELY = 0.8  # probability with which records of the length that is named resolve the coefficient
LONGEST = 365 * 86400.0  # length, s, beyond which none is named


def compare_records(channel: Inspected, recipe: Recipe, rng: "np.random.Generator") -> Pair:
    """What has changed between two records."""
    records = cast(tuple[Record, Record], channel.records)
    joined = join_records(records, recipe)
    both, (first, second), alerts = joined.joint, joined.fits, (*joined.alerts, *channel.alerts)
    contrasts: dict[str, Any] = {s: Contrast(both, i) for i, s in enumerate(both.symbols)}
    ramps = ramp_law(both, 0), ramp_law(both, 1)
    drift = [e.symbol for e in first if TERMS[e.symbol].waveform is not None]
    if ramps[0] is not None and ramps[1] is not None:
        contrasts |= dict.fromkeys(drift, RampContrast(ramps[0], ramps[1]))
    elif drift:
        alerts += (say("the frequencies that all records have leave nothing of the ramp: it is not compared"),)
    kept = {(e.symbol, ""): contrasts[e.symbol] for e in first if e.symbol in contrasts}
    kept |= shape_contrasts(first, second)
    changes = changes_of(kept, (first, second), recipe.level, tuple(line_contrasts(records, (first, second))))
    each = partly_common(both, both.symbols)
    largest = {symbol: max(sizes[symbol] for sizes in each) for symbol in both.symbols}
    noise = [both.term(symbol, size) for symbol, size in largest.items() if size > 0]
    changes = with_needed(changes, noise, min(r.rate for r in records), min(r.size for r in records))
    alike = resemblance(records)
    if alike > ALIKE:
        alerts += (say("both records contain the same noise, like raw and corrected samples (their correlation is "
                       "{correlation:.3g}): they are compared as a pair; the intervals of the coefficients are those "
                       "of independent records, wider than necessary", correlation=alike),)  # fmt: skip
    ratios = None
    try:
        clean = cast(tuple[Record, Record], joined.records)
        ratios = ratios_of(clean, (first, second), law_models(both, (first, second), changes), recipe)
    except DataError as error:
        alerts += (str(error),)
    return Pair(channel.name, test=paired_homogeneity(records) if alike > ALIKE else homogeneity(both, rng),
                changes=changes, ratios=ratios, records=records, alerts=alerts, alpha=alpha_of(recipe.level),
                paired=alike > ALIKE, **joined.judged)  # fmt: skip


def law_models(both: Joint, fits: tuple[Fit, Fit], changes: Sequence[Change]) -> list[Model]:
    """What is supposed of each record for the law of the ratio: coefficients that are not distinguished are common."""
    # What scatters at the longest averaging times is hardly seen by one record alone.
    apart = [change.symbol for change in changes if change.significant]
    models = []
    for fit, values in zip(fits, partly_common(both, apart), strict=True):
        noise = [both.term(symbol, value) for symbol, value in values.items() if value > 0]
        ramps = [term for term in fit.model if term.row.waveform is not None and term.row.scatters]
        models.append(Model((*noise, *ramps)))
    return models


def ratios_of(records: tuple[Record, Record], fits: tuple[Fit, Fit], supposed: Sequence[Model],
              recipe: Recipe) -> Ratios:  # fmt: skip
    """The curves of both at the same averaging times, and the law of their ratio."""
    m, (before, after) = shared_curves(records, fits, recipe.statistic, recipe.taus)
    alike = resemblance(records) > ALIKE
    law = paired_law(records, (before, after)) if alike else ratio_law(records, recipe.statistic, m, supposed)
    ratio = after.variance / before.variance
    return Ratios(before, after, law.p(ratio), Remembered(partial(law.limits, ratio)))


def with_needed(changes: Sequence[Change], noise: Sequence[Term], rate: float, size: int) -> tuple[Change, ...]:
    """The changes, those that are not resolved with the length at which a change by a factor of 2 would be."""
    # The coefficient is taken to be as large as its upper limit: an estimate of what is not resolved may be anything
    # down to zero, and the length for it anything up to infinity.
    return tuple(replace(c, needed=_needed(c, noise, rate, size)) if c.outcome == "not resolvable" else c
                 for c in changes)  # fmt: skip


def _needed(change: Change, noise: Sequence[Term], rate: float, size: int) -> float | None:
    """Length of each record, s; None where these would do or no practical length does, or no limit is known."""
    estimates = [e for e in (change.before, change.after) if e.upper]
    if not estimates or change.frequency is not None or change.parameter:
        return None
    largest = max(estimates, key=lambda e: e.upper or 0.0)
    shape = next((t.shape for t in noise if t.symbol == change.symbol), largest.shape)
    own = Term(change.symbol, largest.upper or 0.0, change.signal, shape)
    model = Model((*(t for t in noise if t.symbol != change.symbol), own))
    if not any(t.row.waveform is None for t in model):
        return None
    wanted = math.log(RESOLVED) / (math.sqrt(2) * (quantile(1 - change.alpha / 2) + quantile(LIKELY)))
    before, n = math.inf, float(size)
    while n <= STEP * LONGEST * rate:
        error = bound(model, round(n), rate)[change.symbol]
        if error <= wanted:
            # between two lengths it falls as a power of the length
            back = math.log(wanted / error) / math.log(before / error) if math.isfinite(before) else 0.0
            length = float(n / STEP**back / rate)
            return length if size / rate < length <= LONGEST else None
        before, n = error, n * STEP
    return None
