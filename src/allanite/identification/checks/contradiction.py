"""Coefficients that contradict the measured curve, whatever the likelihood says."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.curve import Curve
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.model import Model, Term
from allanite.core.record import Record
from allanite.phrases.phrase import say
from allanite.prepare.rounding import grid
from allanite.statistics import deviation, expected
from allanite.terms import TERMS

SURE = 0.99
"""Confidence level of the curve's intervals in this test."""

AGREES, STRICT = 1.5, 1.1
"""Factor beyond the limits of the measured deviation up to which that of the model agrees with it, and where a slow
term was struck out.
"""

ROUNDED = 3.0
"""Quantization noise over that of the step of the samples, at most."""


@dataclass(frozen=True)
class MeasuredCurve:
    """The measured Allan deviation: at octaves, and with its limits under a fit at the averaging factors asked for."""

    octaves: Curve
    limited: Callable[[IntArray], Curve]


def measured(fit: Fit, record: Record) -> MeasuredCurve:
    """The deviation of a record; a point of which the joints over gaps leave nothing contradicts nothing."""
    return MeasuredCurve(
        deviation(record, "oadev", taus="octave", noise=None),
        lambda m: deviation(record, "oadev", m=m.tolist(), noise=fit, omit=True),
    )


def contradictions(fit: Fit, seen: MeasuredCurve) -> dict[str, str]:
    """Why the measured curve contradicts coefficients, by symbol.

    A single term cannot exceed the whole curve: if the deviation given by the lower limit of a coefficient is larger
    than the upper limit of the measured one, at any averaging time in the scope of the fit, the coefficient is wrong.
    """
    curve = seen.octaves
    # averaging times at which the terms themselves are measured
    shortest, longest = (0.0, np.inf) if fit.scope is None else fit.scope.times
    inside = np.asarray((curve.tau >= shortest) & (curve.tau <= longest))
    filtered = fit.scope is not None and fit.scope.filter is not None
    # after a filter the curve does not show angle noise
    shown = [e for e in fit if e.claimed and not (filtered and TERMS[e.symbol].edge)]
    alone = {e.symbol: own for e in shown if (own := _alone(e, curve)) is not None}
    # an upper limit is above what was measured: it is computed only where a term exceeds that
    above = inside & np.any([own > curve.deviation for own in alone.values()], axis=0)
    if not above.any():
        return {}
    limited = seen.limited(curve.m[above])
    above &= np.isin(curve.m, limited.m)
    upper = limited.upper(SURE) if above.any() else np.empty(0)
    excess = {symbol: own[above] / upper for symbol, own in alone.items()}
    return {
        symbol: say(
            "at {tau:.3g} s this term alone would give an Allan deviation of at least {excess:.3g} times the "
            "upper limit of the measured one",
            tau=curve.tau[above][ratio.argmax()],
            excess=ratio.max(),
        )
        for symbol, ratio in excess.items()
        if (ratio > 1).any()
    }


def held(fit: Fit, seen: MeasuredCurve) -> float | None:
    """The longest averaging time, s, at which the deviation of the valid terms agrees with the measured one.

    None if it agrees at all within the scope of the fit.
    """
    if fit.valid is None:
        return None
    curve = seen.octaves
    own = np.sqrt(expected(fit.complete(fit.valid), "oadev", curve.tau, rate=curve.rate, size=curve.size))
    # without a term that was struck out, the rest is not to be drawn below the curve
    agrees = STRICT if any(e.status == "not valid" and not TERMS[e.symbol].edge for e in fit) else AGREES
    holds = np.ones(curve.tau.size, dtype=bool) if fit.scope is None else fit.scope.holds(curve.tau)
    far = holds & ((own > agrees * curve.deviation) | (own < curve.deviation / agrees))
    limited = seen.limited(curve.m[far]) if far.any() else None
    if limited is None or not limited.m.size:
        return None
    far &= np.isin(curve.m, limited.m)
    low, high = limited.interval(0.95)
    wrong = curve.tau[far][(own[far] > agrees * high) | (own[far] < low / agrees)]
    before = curve.tau[curve.tau < wrong.min(initial=math.inf)]
    return float(before.max(initial=0.0)) if wrong.size else None


def not_rounding(fit: Fit, record: Record) -> dict[str, str]:
    """Why angle noise is not the rounding of the samples, by symbol: it exceeds that of their step."""
    step = grid(record.values[np.isfinite(record.values)])[1] * record.factor
    if not step:
        return {}
    angle = step if record.kind == "angle" else step / record.rate
    most = ROUNDED * angle / math.sqrt(12)
    return {
        e.symbol: say(
            "it is {ratio:.3g} times what the steps of the samples can cause: noise that rises near half the sampling "
            "rate, of vibration, differentiation or interpolation",
            ratio=ROUNDED * e.value / most,
        )
        for e in fit
        if TERMS[e.symbol].edge and e.claimed and e.value is not None and e.value > most
    }


def _alone(estimate: Estimate, curve: Curve) -> FloatArray | None:
    """The deviation that the lower limit of a term gives, without any other noise; None where there is no limit."""
    low = abs(estimate.value or 0.0) if estimate.limits is None else min(map(abs, estimate.interval()))
    if not low > 0 or (TERMS[estimate.symbol].waveform is not None and estimate.limits is None):
        return None
    model = Model((Term(estimate.symbol, low, estimate.signal, estimate.shape),))
    return np.sqrt(expected(model, "oadev", curve.tau, rate=curve.rate, size=curve.size))
