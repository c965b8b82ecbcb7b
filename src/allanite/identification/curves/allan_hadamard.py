"""Joint fit of Allan and Hadamard variance, which separates a ramp from a rate random walk."""

from collections.abc import Sequence

import numpy as np

from allanite.core.curve import Curve
from allanite.core.errors import DataError
from allanite.core.fit import Fit
from allanite.core.record import Record
from allanite.phrases.phrase import say
from allanite.statistics import deviation
from allanite.terms import TERMS

from .gls import Moments, iterated, variances
from .nonnegative import columns
from .reading import early, reported, result, signal_of

PAIR = ("oadev", "ohdev")

WALK = 0.5
"""Hadamard over Allan deviation of a rate random walk; only a ramp gives less."""


def joint(record: Record, symbols: Sequence[str]) -> Fit:
    """Non-negative squares of the coefficients that fit both variances at once, at octaves up to T/4.

    Each point is weighted by its degrees of freedom under the fit. The points are not independent, so there are no
    standard errors.
    """
    curves = [deviation(record, name, gaps="complete") for name in PAIR]
    signal = signal_of(curves[0], 1)
    early_ones = [early(curve, 0.25) for curve in curves]
    m = [curve.m[which].tolist() for curve, which in zip(curves, early_ones, strict=True)]
    variance = np.concatenate([c.variance[which] for c, which in zip(curves, early_ones, strict=True)])
    if variance.size < len(symbols) or not np.all(variance > 0):
        told = {"nonzero": np.count_nonzero(variance > 0), "size": variance.size, "terms": len(symbols)}
        raise DataError(say("{nonzero} of {size} points are nonzero; {terms} terms need as many, all nonzero", **told))
    X = np.concatenate(
        [columns([name] * len(k), symbols, k, record.size, record.rate) for name, k in zip(PAIR, m, strict=True)]
    )
    products = np.zeros((len(X), len(X), len(symbols), len(symbols)))
    first = len(m[0])
    products[:first, :first] = variances(PAIR[0], symbols, m[0], record.size, record.rate)
    products[first:, first:] = variances(PAIR[1], symbols, m[1], record.size, record.rate)
    theta, _ = iterated(Moments(X, products), variance)
    ramp = any(TERMS[s].waveform is not None and v > 0 for s, v in zip(symbols, theta.tolist(), strict=True))
    notes = [
        say("fitted to {count} points of {first} and {second}", count=variance.size, first=PAIR[0], second=PAIR[1]),
        *drift(*curves, fitted=ramp),
    ]
    estimates = reported(symbols, theta, X, signal=signal, method="joint")
    return result(curves[0], estimates, "joint", notes=notes)


def drift(allan: Curve, hadamard: Curve, *, fitted: bool) -> list[str]:
    """What the two curves say about a ramp, at the largest octave below a tenth of the record."""
    both = np.intersect1d(allan.m[early(allan, 0.1)], hadamard.m[early(hadamard, 0.1)])[-1]
    a, h = (float(curve.variance[curve.m == both][0]) for curve in (allan, hadamard))
    tau = float(both) / allan.rate
    found = say(
        "at {tau:g} s the Hadamard deviation is {ratio:.3f} of the Allan deviation", tau=tau, ratio=np.sqrt(h / a)
    )
    if h < WALK * a:
        size = np.sqrt(2 * (a - 2 * h)) / tau
        return [
            say(
                "{found}, below the 0.707 of a random walk: a ramp of about {size:.3g} {unit}/s if there is only a "
                "random walk besides it; a single record can be that low by chance",
                found=found,
                size=size,
                unit=allan.unit,
            )
        ]
    said = say(
        "a Hadamard deviation below the Allan deviation is no proof of a drift (a random walk alone gives 0.707, "
        "flicker 0.90), only a ratio below 0.707 requires a ramp"
    )
    if fitted:
        said = say("{said}, and the R of the fit is no evidence of a ramp", said=said)
    negative = say("2 (AVAR - 2 HVAR) / tau^2 is negative, so that R there is 0")
    return [say("{ratio}; {negative}: {conclusion}", ratio=found, negative=negative, conclusion=said)]
