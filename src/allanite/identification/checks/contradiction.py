"""Coefficients that contradict the measured curve, whatever the likelihood says."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.curve import Curve
from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.model import Model, Term
from allanite.core.record import Record
from allanite.identification.search.components import QUICKEST_MARKOV
from allanite.phrases.phrase import say
from allanite.prepare.outliers import marked, outliers
from allanite.prepare.rounding import step_of
from allanite.statistics import deviation, expected
from allanite.terms import TERMS, WHITE

FALSE = 0.01
"""Probability that the curve of a record contradicts a right coefficient, over all octaves that are compared."""

AGREES, STRICT = 1.5, 1.1
"""Factor beyond the limits of the measured deviation up to which that of the model agrees with it, and where a slow
term was struck out.
"""

STRAIGHT = 0.1
"""Largest difference of the slope from -1/2 over two octaves: other noise is then a fifth of the variance at most."""

ROUNDED = 3.0  # quantization noise over that of the step of the samples, at most


@dataclass(frozen=True)
class MeasuredCurve:
    """The measured Allan deviation: at octaves, and with its limits under a fit at the averaging factors asked for."""

    # `marked` is that of the record without its outliers, which are no white noise but have its slope.
    octaves: Curve
    limited: Callable[[IntArray], Curve]
    marked: Callable[[], "MeasuredCurve"] | None = None


def measured(fit: Fit, record: Record) -> MeasuredCurve:
    """The deviation of a record; a point of which the joints over gaps leave nothing contradicts nothing."""
    return MeasuredCurve(deviation(record, "oadev", taus="octave", noise=None),
                         lambda m: deviation(record, "oadev", m=m.tolist(), noise=fit, omit=True),
                         lambda: measured(fit, marked(record, outliers(record))))  # fmt: skip


def contradictions(fit: Fit, curves: MeasuredCurve) -> dict[str, str]:
    """Why the measured curve contradicts coefficients, by symbol."""
    # A single term cannot exceed the whole curve: if the deviation given by the lower limit of a coefficient is larger
    # than the upper limit of the measured one, at any averaging time in the scope of the fit, the coefficient is wrong.
    # Nor can white noise lie below a curve of its slope.
    below = _below(fit, curves)
    return _above(fit, curves) | (_below(fit, curves.marked()) if below and curves.marked else below)


def _above(fit: Fit, curves: MeasuredCurve) -> dict[str, str]:
    """Terms that alone exceed the curve."""
    curve = curves.octaves
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
    limited = curves.limited(curve.m[above])
    above &= np.isin(curve.m, limited.m)
    upper = limited.upper(1 - FALSE / inside.sum()) if above.any() else np.empty(0)
    excess = {symbol: own[above] / upper for symbol, own in alone.items()}
    return {
        symbol: say("at {tau:.3g} s this term alone would give an Allan deviation of at least {excess:.3g} times "
                    "the upper limit of the measured one", tau=curve.tau[above][ratio.argmax()], excess=ratio.max())
        for symbol, ratio in excess.items()
        if (ratio > 1).any()
    }  # fmt: skip


def _below(fit: Fit, curves: MeasuredCurve) -> dict[str, str]:
    """White noise whose upper limit lies below the curve where that falls as white noise, less the most of the rest."""
    # Noise that is correlated over a few samples is white noise that a filter changed: it is not subtracted.
    curve = curves.octaves
    if any(c.name == "resonance" and c.claimed for c in fit.components):  # which has such a slope beyond its period
        return {}
    white = [e for e in fit if TERMS[e.symbol].slope == WHITE and e.limits and _most(e) < math.inf]
    slope = np.full(curve.tau.size, np.inf)
    slope[1:-1] = np.log(curve.deviation[2:] / curve.deviation[:-2]) / np.log(curve.tau[2:] / curve.tau[:-2])
    inside = abs(slope - WHITE) < STRAIGHT
    if fit.scope is not None:
        inside &= fit.scope.holds(curve.tau)
    if not white or not inside.any():
        return {}
    beside = [
        Term(e.symbol, size, e.signal, e.shape)
        for e in fit
        if e not in white and _memory(e) * curve.rate > QUICKEST_MARKOV and 0 < (size := _most(e)) < math.inf
    ]
    beside += [line.term for line in fit.lines]
    other = _deviation(fit, beside, curve) ** 2
    reasons: dict[str, str] = {}
    for e in white:
        most = STRICT * _most(e) / np.sqrt(curve.tau)
        far = inside & (curve.deviation**2 - other > most**2)
        limited = curves.limited(curve.m[far]) if far.any() else None
        if limited is None or not limited.m.size:
            continue
        far &= np.isin(curve.m, limited.m)
        excess = np.sqrt(np.maximum(limited.interval(1 - 2 * FALSE / inside.sum())[0] ** 2 - other[far], 0)) / most[far]
        if excess.max() > 1:
            reasons[e.symbol] = say("at {tau:.3g} s the measured curve falls as white noise of at least "
                                    "{excess:.3g} times its upper limit", tau=curve.tau[far][excess.argmax()],
                                    excess=STRICT * excess.max())  # fmt: skip
    return reasons


def _most(estimate: Estimate) -> float:
    """The upper limit of the size of a coefficient, or its value where it has none; infinite where nothing is known."""
    if estimate.limits is None:
        return abs(estimate.value or math.inf)
    return max(map(abs, estimate.interval())) if estimate.claimed else estimate.upper or math.inf


def _memory(estimate: Estimate) -> float:
    """The time constant of a term, s; infinite without one, 0 where it is not known."""
    parameters = TERMS[estimate.symbol].parameters
    shape = estimate.shape or (0.0,) * len(parameters)
    return min((v for p, v in zip(parameters, shape, strict=True) if p.time > 0 or not v), default=math.inf)


def held(fit: Fit, curves: MeasuredCurve) -> float | None:
    """The longest averaging time, s, at which the deviation of the valid terms agrees with the measured one."""
    # None if it agrees at all within the scope of the fit.
    if fit.valid is None:
        return None
    curve = curves.octaves
    filtered = fit.scope is not None and fit.scope.filter is not None
    own = _deviation(fit, fit.valid, curve)
    # behind a filter angle noise is less than it was
    least = _deviation(fit, [t for t in fit.valid if not (filtered and t.row.edge)], curve)
    # without a term that was struck out, the rest is not to be drawn below the curve, and may be of shorter times only
    struck = any(e.status == "not valid" and not TERMS[e.symbol].edge for e in fit)
    agrees = STRICT if struck else AGREES
    holds = np.ones(curve.tau.size, dtype=bool) if fit.scope is None else fit.scope.holds(curve.tau)
    far = holds & ((least > agrees * curve.deviation) | (own < curve.deviation / agrees))
    limited = curves.limited(curve.m[far]) if far.any() else None
    if limited is None or not limited.m.size:
        return None
    far &= np.isin(curve.m, limited.m)
    low, high = limited.interval(0.95)
    wrong = curve.tau[far][(least[far] > agrees * high) | (own[far] < low / agrees)]
    before = curve.tau[(holds | struck) & (curve.tau < wrong.min(initial=math.inf))]
    return float(before.max(initial=0.0)) if wrong.size else None


def _deviation(fit: Fit, terms: Iterable[Term], curve: Curve) -> FloatArray:
    """The deviation of some terms of a fit, and of its warm-up."""
    noise = tuple(terms)
    if not noise:
        return np.zeros(curve.tau.size)
    return np.sqrt(expected(fit.complete(Model(noise)), "oadev", curve.tau, rate=curve.rate, size=curve.size))


def not_rounding(fit: Fit, record: Record) -> dict[str, str]:
    """Why angle noise is not the rounding of the samples, by symbol: it exceeds that of their step."""
    angular = {e.symbol: e.value for e in fit if TERMS[e.symbol].edge and e.claimed and e.value is not None}
    step = step_of(record) * record.factor if angular else 0.0
    if not step:
        return {}
    angle = step if record.kind == "angle" else step / record.rate
    most = ROUNDED * angle / math.sqrt(12)
    return {
        symbol: say("it is {ratio:.3g} times what the steps of the samples can cause: noise that rises near half the "
                    "sampling rate, of vibration, differentiation or interpolation", ratio=ROUNDED * value / most)
        for symbol, value in angular.items() if value > most
    }  # fmt: skip


def _alone(estimate: Estimate, curve: Curve) -> FloatArray | None:
    """The deviation that the lower limit of a term gives, without any other noise; None where there is no limit."""
    low = abs(estimate.value or 0.0) if estimate.limits is None else min(map(abs, estimate.interval()))
    if not low > 0 or (TERMS[estimate.symbol].waveform is not None and estimate.limits is None):
        return None
    model = Model((Term(estimate.symbol, low, estimate.signal, estimate.shape),))
    return np.sqrt(expected(model, "oadev", curve.tau, rate=curve.rate, size=curve.size))
