"""The variance of a drift against sums of weights and distances as its definition says, and against closed forms."""

import math

import numpy as np
import pytest
from tests.rows import rows

import allanite as al
from allanite.planning.drift import GRAVITY, RADIUS, drift_variance, flat, schuler

TERMS = {
    "Q": al.Q(1, "rad"), "N": al.N(1, "rad/sqrt(s)"), "B": al.B(1, "rad/s"), "K": al.K(1, "rad/s^1.5"),
    "R": al.R(1, "rad/s^2"), "F": al.F(1, "rad"), "GM": al.GM(1, "rad/s", time_constant=5.0),
    "GMA": al.GMA(1, "rad", time_constant=5.0), "GM2": al.GM2(1, "rad/s", frequency=0.1, damping=0.1),
    "Sine": al.Sine(1, "rad/s", frequency=0.07),
}  # fmt: skip
T, TIME = 20.0, 30.0
W = math.sqrt(GRAVITY / RADIUS)
KERNELS = {
    (flat, 0): np.ones_like, (flat, 1): lambda a: a, (flat, 2): lambda a: a**2 / 2,
    (schuler, 0): lambda a: np.cos(W * a), (schuler, 1): lambda a: np.sin(W * a) / W,
    (schuler, 2): lambda a: (1 - np.cos(W * a)) / W**2,
}  # fmt: skip
"""What a rate of 1 at an age makes of the quantity."""


def summed(D, kernel, t, window, steps):
    """Of rates constant over short intervals: -1/2 times the sum over all pairs of the weights of the angles and D."""
    h = t / steps
    middle = (np.arange(steps) + 0.5) * h
    weights = {0.0: 0.0, -window: 0.0}  # place of an angle -> its weight
    gains = kernel(t - middle)  # of the mean rate of each interval, (x(s + h) - x(s)) / h times h
    for k, gain in enumerate(gains.tolist()):
        weights[k * h] = weights.get(k * h, 0.0) - gain
        weights[(k + 1) * h] = weights.get((k + 1) * h, 0.0) + gain
    bias = float(gains.sum() * h)  # what a constant rate makes
    weights[0.0] -= bias / window
    weights[-window] += bias / window
    place, weight = (np.array(list(of)) for of in (weights.keys(), weights.values()))
    return float(-0.5 * weight @ D(np.abs(place[:, None] - place)) @ weight)


@rows("symbol", TERMS)
@rows(("make", "order"), KERNELS)
def test_the_variance_is_the_sum_of_all_pairs(symbol, make, order):
    term, kernel = TERMS[symbol], KERNELS[make, order]
    coarse, fine = (summed(term.sampled(1.0).structure, kernel, TIME, T, steps) for steps in (150, 300))
    found = drift_variance(term, make(order), np.array([TIME]), calibration=T)[0]
    # sums err by a power of the interval
    assert found == pytest.approx(fine, rel=max(3e-3 if symbol in "QFN" else 3e-4, 2 * abs(fine / coarse - 1)))
    assert abs(fine / coarse - 1) < 0.03


def flicker(t, window):
    """For B = 1, with the bias of a mean over a window before."""
    r = t / window
    return t**2 / math.pi * ((1 + r) ** 2 / r * np.log1p(r) - (1 + r) * np.log(r))


@rows("symbol, order, calibration, expected", [
    ("N", 0, 0.0, lambda t: t), ("N", 1, 0.0, lambda t: t**3 / 3), ("N", 2, 0.0, lambda t: t**5 / 20),
    ("N", 0, T, lambda t: t + t**2 / T), ("N", 2, T, lambda t: t**5 / 20 + t**6 / 36 / T),
    ("K", 0, 0.0, lambda t: t**3 / 3), ("K", 1, 0.0, lambda t: t**5 / 20), ("K", 2, 0.0, lambda t: t**7 / 252),
    ("K", 0, T, lambda t: t**2 * (t + T) / 3), ("R", 0, 0.0, lambda t: t**4 / 4), ("R", 2, 0.0, lambda t: t**8 / 576),
    ("R", 0, T, lambda t: (t * (t + T) / 2) ** 2), ("Q", 0, 0.0, lambda t: 2 + 0 * t),
    ("Q", 0, T, lambda t: (1 + t / T) ** 2 + 1 + (t / T) ** 2),
    ("GM", 0, 0.0, lambda t: 2 * 25 * (t / 5 - 1 + np.exp(-t / 5))),
    ("Sine", 0, 0.0, lambda t: (1 - np.cos(2 * math.pi * 0.07 * t)) / (2 * math.pi * 0.07) ** 2),
    ("B", 0, T, lambda t: flicker(t, T)), ("B", 0, 0.0, lambda t: flicker(t, 1.0)),
])  # fmt: skip
def test_closed_forms(symbol, order, calibration, expected):
    t = np.array([0.1, 1.0, 10.0, 60.0, 600.0, 3600.0])
    found = drift_variance(TERMS[symbol], flat(order), t, calibration=calibration)
    np.testing.assert_allclose(
        found, expected(t), rtol=1e-4 if symbol in "KR" and not calibration else 1e-7, atol=1e-20
    )


def test_a_bias_swings_on_the_round_earth():
    t = np.array([600.0, 3600.0, 2 * math.pi / W])
    w = np.array([W])
    expected = RADIUS * (t - np.sin(w * t) / w)  # a gyro's bias: position R (t - sin(w t) / w)
    np.testing.assert_allclose(schuler(2, GRAVITY).bias(t), expected, rtol=1e-8)


def test_fast_vibration_and_weak_damping_are_not_aliased():
    """A sinusoid of 180 000 periods; a resonance with hardly any damping is one of random size."""
    t, w = np.array([3600.0]), 2 * math.pi * 50.0
    angle = drift_variance(al.Sine(1, "rad/s", frequency=50.0), flat(1), t)[0]
    assert angle == pytest.approx(t[0] ** 2 / w**2 / 2, rel=1e-3)  # cos(phase) t / w
    alike = al.GM2(1, "rad/s", frequency=1.0, damping=1e-5), al.Sine(math.sqrt(2), "rad/s", frequency=1.0)
    resonance, sine = (drift_variance(term, flat(1), np.array([20.25]))[0] for term in alike)
    assert resonance == pytest.approx(sine, rel=3e-3)


def test_noise_of_the_samples_depends_on_the_rate():
    slow, fast = (
        drift_variance(al.F(1, "rad"), flat(0), np.array([60.0]), calibration=T, rate=r) for r in (1.0, 100.0)
    )
    assert fast[0] > slow[0]


@rows("order, variance", [
    (0, lambda t: t / 2 + np.sin(2 * W * t) / (4 * W)),
    (1, lambda t: (t / 2 - np.sin(2 * W * t) / (4 * W)) / W**2),
    (2, lambda t: (1.5 * t - 2 * np.sin(W * t) / W + np.sin(2 * W * t) / (4 * W)) / W**4),
])  # fmt: skip
def test_many_schuler_periods_do_not_spoil_the_drift(order, variance):
    t = np.array([3e3, 6e4, 1e5, 2e5, 1e6])
    np.testing.assert_allclose(drift_variance(TERMS["N"], schuler(order), t), variance(t), rtol=1e-6)
