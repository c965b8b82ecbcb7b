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


def with_needed(changes: Sequence[Change], noise: Sequence[Term], rate: float, size: int) -> tuple[Change, ...]:
    """The changes, those that are not resolved with the length at which a change by a factor of 2 would be.

    The coefficient is taken to be as large as its upper limit: an estimate of what is not resolved may be anything down
    to zero, and the length for it anything up to infinity.

    Parameters
    ----------
    changes : sequence of Change
    noise : sequence of Term
        What may be in both records.
    rate : float
        Sampling rate, Hz.
    size : int
        Samples of the shorter record.
    """
    return tuple(
        replace(c, needed=_needed(c, noise, rate, size)) if c.outcome == "not resolvable" else c for c in changes
    )


def _needed(change: Change, noise: Sequence[Term], rate: float, size: int) -> float | None:
    """Length of each record, s; None where these would do or no practical length does, or no limit is known."""
    estimates = [e for e in (change.before, change.after) if e.upper]
    if not estimates or change.frequency is not None:
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
