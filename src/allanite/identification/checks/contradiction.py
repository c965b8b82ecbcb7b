"""Coefficients that contradict the measured curve, whatever the likelihood says."""

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.curve import Curve
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.language import say
from allanite.core.model import Model, Term
from allanite.core.record import Record
from allanite.statistics import deviation, expected
from allanite.terms import TERMS

SURE = 0.99
"""Confidence level of the curve's intervals in this test."""


def contradictions(fit: Fit, record: Record) -> dict[str, str]:
    """Why the Allan deviation of the record contradicts coefficients, by symbol.

    A single term cannot exceed the whole curve: if the deviation given by the lower limit of a coefficient is larger
    than the upper limit of the measured one, at any averaging time in the scope of the fit, the coefficient is wrong.
    """
    curve = deviation(record, "oadev", taus="octave", noise=None)
    inside = _inside(fit, curve)
    filtered = fit.scope is not None and fit.scope.filter is not None
    # after a filter the curve does not show angle noise
    shown = [e for e in fit if e.claimed and not (filtered and TERMS[e.symbol].edge)]
    alone = {e.symbol: own for e in shown if (own := _alone(e, curve)) is not None}
    # an upper limit is above what was measured: it is computed only where a term exceeds that
    above = inside & np.any([own > curve.deviation for own in alone.values()], axis=0)
    if not above.any():
        return {}
    # a point of which the joints over gaps leave nothing is omitted: it contradicts nothing
    limited = deviation(record, "oadev", m=curve.m[above].tolist(), noise=fit, omit=True)
    above &= np.isin(curve.m, limited.m)
    upper = limited.upper(SURE) if above.any() else np.empty(0)
    excess = {symbol: own[above] / upper for symbol, own in alone.items()}
    return {symbol: _words(ratio, curve.tau[above]) for symbol, ratio in excess.items() if (ratio > 1).any()}


def _inside(fit: Fit, curve: Curve) -> BoolArray:
    """Averaging times at which the terms themselves are measured."""
    shortest, longest = (0.0, np.inf) if fit.scope is None else fit.scope.times
    return np.asarray((curve.tau >= shortest) & (curve.tau <= longest))


def _alone(estimate: Estimate, curve: Curve) -> FloatArray | None:
    """The deviation that the lower limit of a term gives, without any other noise; None where there is no limit."""
    low = abs(estimate.value or 0.0) if estimate.limits is None else min(map(abs, estimate.interval()))
    if not low > 0 or (TERMS[estimate.symbol].waveform is not None and estimate.limits is None):
        return None
    model = Model((Term(estimate.symbol, low, estimate.signal, estimate.shape),))
    return np.sqrt(expected(model, "oadev", curve.tau, rate=curve.rate, size=curve.size))


def _words(excess: FloatArray, tau: FloatArray) -> str:
    at = int(excess.argmax())
    return say(
        "at {tau:.3g} s this term alone would give an Allan deviation of at least {excess:.3g} times the "
        "upper limit of the measured one",
        tau=tau[at],
        excess=excess[at],
    )
