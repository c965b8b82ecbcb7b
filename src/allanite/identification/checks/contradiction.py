"""Coefficients that contradict the measured curve, whatever the likelihood says."""

import numpy as np

from allanite.core.arrays import BoolArray
from allanite.core.curve import Curve
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.language import say
from allanite.core.model import Model, Term
from allanite.statistics import expected
from allanite.terms import TERMS

SURE = 0.99
"""Confidence level of the curve's intervals in this test."""


def contradictions(fit: Fit, curve: Curve) -> dict[str, str]:
    """Why the curve contradicts coefficients, by symbol.

    A single term cannot exceed the whole curve: if the deviation given by the lower limit of a coefficient is larger
    than the upper limit of the measured one, at any averaging time in the scope of the fit, the coefficient is wrong.

    Parameters
    ----------
    fit : Fit
    curve : Curve
        Allan deviation of the same record, with limits.
    """
    inside = _inside(fit, curve)
    if not inside.any():
        return {}
    upper = np.where(inside, curve.upper(SURE), np.inf)
    filtered = fit.scope is not None and fit.scope.filter is not None
    # after a filter the curve does not show angle noise
    shown = (e for e in fit if e.claimed and not (filtered and TERMS[e.symbol].edge))
    reasons = ((e.symbol, _exceeds(e, curve, upper)) for e in shown)
    return {symbol: reason for symbol, reason in reasons if reason}


def _inside(fit: Fit, curve: Curve) -> BoolArray:
    """Averaging times at which the terms themselves are measured."""
    shortest, longest = (0.0, np.inf) if fit.scope is None else fit.scope.times
    return np.asarray((curve.tau >= shortest) & (curve.tau <= longest))


def _exceeds(estimate: Estimate, curve: Curve, upper: np.ndarray[tuple[int], np.dtype[np.float64]]) -> str:
    low = abs(estimate.value or 0.0) if estimate.limits is None else min(map(abs, estimate.interval()))
    if not low > 0 or (TERMS[estimate.symbol].waveform is not None and estimate.limits is None):
        return ""
    model = Model((Term(estimate.symbol, low, estimate.signal, estimate.shape),))
    own = np.sqrt(expected(model, "oadev", curve.tau, rate=curve.rate, size=curve.size))
    excess = own / upper
    at = int(excess.argmax())
    if not excess[at] > 1:
        return ""
    return say(
        "at {tau:.3g} s this term alone would give an Allan deviation of at least {excess:.3g} times the "
        "upper limit of the measured one",
        tau=curve.tau[at],
        excess=excess[at],
    )
