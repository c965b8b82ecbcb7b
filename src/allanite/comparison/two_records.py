"""Two records of a channel become a pair: the verdict, the change of each coefficient, the ratio of the variances."""

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, cast

from allanite.core.errors import DataError
from allanite.core.fit import Fit
from allanite.core.limits import Remembered
from allanite.core.model import Model
from allanite.core.record import Record
from allanite.phrases.phrase import say
from allanite.study.channels import Inspected
from allanite.study.recipe import Recipe
from allanite.terms import TERMS

from .change import Change, alpha_of, changes_of
from .common_likelihood import Joint
from .comparison import Pair, Ratios
from .contrast import Contrast, homogeneity, partly_common
from .ramps import RampContrast, ramp_law
from .ratio import ratio_law, shared_curves
from .records_joined import join_records
from .resolving import with_needed
from .sinusoids import LineContrast, line_contrasts
from .synchronous import ALIKE, paired_homogeneity, paired_law, resemblance

if TYPE_CHECKING:
    import numpy as np


def _paired(correlation: float) -> str:
    return say(
        "both records contain the same noise, like raw and corrected samples (their correlation is "
        "{correlation:.3g}): they are compared as a pair; the intervals of the coefficients are those of independent "
        "records, wider than necessary",
        correlation=correlation,
    )


def compare_records(seen: Inspected, recipe: Recipe, rng: "np.random.Generator") -> Pair:
    """What has changed between two records.

    Raises
    ------
    DataError
        They cannot be compared.
    """
    records = cast(tuple[Record, Record], seen.records)
    joined = join_records(records, recipe)
    both, (first, second), alerts = joined.joint, joined.fits, (*joined.alerts, *seen.alerts)
    changes = _changes(both, (first, second), recipe.level, tuple(line_contrasts(records, (first, second))))
    each = partly_common(both, both.symbols)
    largest = {symbol: max(found[symbol] for found in each) for symbol in both.symbols}
    noise = [both.term(symbol, size) for symbol, size in largest.items() if size > 0]
    changes = with_needed(changes, noise, min(r.rate for r in records), min(r.size for r in records))
    alike = resemblance(records)
    alerts = (*alerts, _paired(alike)) if alike > ALIKE else alerts
    ratios = None
    try:
        clean = cast(tuple[Record, Record], joined.records)
        ratios = ratios_of(clean, (first, second), law_models(both, (first, second), changes), recipe)
    except DataError as error:
        alerts = (*alerts, str(error))
    return Pair(
        seen.name,
        test=paired_homogeneity(records) if alike > ALIKE else homogeneity(both, rng),
        changes=changes,
        ratios=ratios,
        band=both.band,
        fits=(first, second),
        explained=joined.explained,
        grades=joined.grades,
        records=records,
        alerts=alerts,
        alpha=alpha_of(recipe.level),
        paired=alike > ALIKE,
    )


def refuse_pair(seen: Inspected, why: str) -> Pair:
    """A pair without a result."""
    return Pair(seen.name, records=cast(tuple[Record, Record], seen.records), alerts=seen.alerts, refusal=why)


def _changes(both: Joint, fits: tuple[Fit, Fit], level: float, lines: tuple[LineContrast, ...]) -> tuple[Change, ...]:
    found: dict[str, Contrast | RampContrast] = {s: Contrast(both, i) for i, s in enumerate(both.symbols)}
    ramps = ramp_law(both, 0), ramp_law(both, 1)
    if ramps[0] is not None and ramps[1] is not None:
        found |= {e.symbol: RampContrast(ramps[0], ramps[1]) for e in fits[0] if TERMS[e.symbol].waveform is not None}
    kept = {e.symbol: found[e.symbol] for e in fits[0] if e.symbol in found}
    return changes_of(kept, fits, level, lines)


def law_models(both: Joint, fits: tuple[Fit, Fit], changes: Sequence[Change]) -> list[Model]:
    """What is supposed of each record for the law of the ratio: coefficients that are not distinguished are common.

    What scatters at the longest averaging times is hardly seen by one record alone.
    """
    apart = [change.symbol for change in changes if change.significant]
    found = []
    for fit, values in zip(fits, partly_common(both, apart), strict=True):
        noise = [both.term(symbol, value) for symbol, value in values.items() if value > 0]
        ramps = [term for term in fit.model if term.row.waveform is not None and term.row.scatters]
        found.append(Model((*noise, *ramps)))
    return found


def ratios_of(
    records: tuple[Record, Record], fits: tuple[Fit, Fit], supposed: Sequence[Model], recipe: Recipe
) -> Ratios:
    """The curves of both at the same averaging times, and the law of their ratio."""
    m, (before, after) = shared_curves(records, fits, recipe.statistic, recipe.taus)
    alike = resemblance(records) > ALIKE
    law = paired_law(records, (before, after)) if alike else ratio_law(records, recipe.statistic, m, supposed)
    ratio = after.variance / before.variance
    return Ratios(before, after, law.p(ratio), Remembered(partial(law.limits, ratio)))
