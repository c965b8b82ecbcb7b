"""How long two records would have to be to resolve a coefficient that these do not."""

import math
from collections.abc import Sequence
from dataclasses import replace

from allanite.core.limits import quantile
from allanite.core.model import Model, Term
from allanite.planning.bound import bound

from .change import RESOLVED, Change

STEP = 4.0
"""Factor between the lengths that are tried."""

LIKELY = 0.8
"""Probability with which records of the length that is named resolve the coefficient."""

LONGEST = 365 * 86400.0
"""Length, s, beyond which none is named."""


def with_needed(changes: Sequence[Change], common: Sequence[Term], rate: float, size: int) -> tuple[Change, ...]:
    """The changes, those that are not resolved with the length at which a change by a factor of 2 would be.

    Parameters
    ----------
    changes : sequence of Change
    common : sequence of Term
        The noise of both records; of a term that is not in it the best guess counts, or half its limit.
    rate : float
        Sampling rate, Hz.
    size : int
        Samples of the shorter record.
    """
    return tuple(
        replace(c, needed=_needed(c, common, rate, size)) if c.outcome == "not resolvable" else c for c in changes
    )


def _needed(change: Change, common: Sequence[Term], rate: float, size: int) -> float | None:
    """Length of each record, s; None where no length of a practical kind does it, or nothing is known of the term."""
    terms = [t for t in common if t.symbol == change.symbol]
    if not terms:
        sizes = [e.median or e.upper / 2 for e in (change.before, change.after) if e.upper]
        if not sizes or any(t.row.waveform is not None for t in terms):
            return None
        shape = next((e.shape for e in (change.before, change.after) if e.shape), ())
        terms = [Term(change.symbol, min(sizes), change.signal, shape)]
    model = Model((*(t for t in common if t.symbol != change.symbol), *terms))
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
            return length if length <= LONGEST else None
        before, n = error, n * STEP
    return None
