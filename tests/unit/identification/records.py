"""Records whose truth is known, for the tests of this folder and of what is done before: `unit/prepare`."""

import math

import numpy as np
from scipy.signal import lfilter

import allanite as al
from allanite.terms import TERMS

RATE = 100.0
N, B, K = al.N(0.005, "deg/sqrt(s)"), al.B(0.002, "deg/s"), al.K(3e-4, "deg/s/sqrt(s)")
POLE = math.exp(-2 * math.pi / 12)
RC = ([1 - POLE], [1, -POLE])  # a low-pass filter of the 1st order with a cut-off of a twelfth of the rate
SETTLING = 2048  # samples after which a filter has settled


def rates_of(model=N + B, n=2**13, seed=1):
    return al.simulate(al.Model(model), n, RATE, rng=np.random.default_rng(seed)).values.copy()


def settled(model=N + B, n=2**13, seed=1, behind=None):
    """Rates of a model without their beginning, behind a filter where one is given."""
    y = rates_of(model, n + SETTLING, seed)
    return (lfilter(*behind, y) if behind else y)[SETTLING:]


def record_of(y, unit="rad/s", rate=RATE, **more):
    return al.Record(y, rate, unit, **more)


def forms_of(counts, step, unit="arcsec", rate=RATE):
    """One record as each kind: counts, of so many steps of an angle."""
    angle = np.concatenate(([0], np.cumsum(counts))) * step
    return {
        "rate": al.Record(counts * step * rate, rate, f"{unit}/s"),
        "increment": al.Record(counts * step, rate, unit, kind="increment"),
        "count": al.Record(counts, rate, unit, kind="count", scale=step),
        "angle": al.Record(angle, rate, unit, kind="angle"),
    }


def covariance_of(symbol, at):
    """Covariance of the mean rates at the intervals `at` up to a constant, from the structure function alone."""
    lag = np.abs(np.subtract.outer(at, at)).astype(float)
    D = TERMS[symbol].structure
    return 0.5 * (D(lag + 1) - 2 * D(lag) + D(np.abs(lag - 1)))


def claimed(fit):
    return {e.symbol for e in fit if e.claimed}


def covers(fit, term, level=0.95):
    """Whether the limits of a coefficient hold its true value."""
    low, high = fit[term.symbol].interval(level)
    return low < term.value < high
