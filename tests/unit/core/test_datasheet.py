"""The data sheet of a channel against conversions by hand."""

import math

import numpy as np
import pytest
from tests.rows import rows

from allanite.core.estimate import Estimate
from allanite.core.fit import Fit
from allanite.core.model import Model, term
from allanite.core.readings import Means, Reading, Readings, data_sheet
from allanite.core.units import signal_named
from allanite.core.validity import LowPass, Scope


def estimate(part, low, high, status="identified"):
    value, limits = part.value, lambda level: (low * part.value, high * part.value)
    return Estimate(part.symbol, part.signal, value, 0.1 * value, status, None, "whittle", limits)


def absent(part):
    return Estimate(part.symbol, part.signal, None, None, "absent", part.value, "whittle")


def fit_of(*estimates, behind=None):
    signal = estimates[0].signal
    scope = Scope("all", (0.0, 50.0), (), behind, 0.0, 0.0, np.array([0.1, 50.0]), np.ones(2))
    return Fit(estimates, "whittle", signal, Model((term("N", 1.0, "rad/sqrt(s)"),)), scope=scope)


def readings_of(signal, deviation, *, inside=True):
    point = Reading(300.0, deviation, lambda level: (0.9 * deviation, 1.2 * deviation))
    return Readings(signal, point, None, point, inside, (), (Means(10.0, 2 * deviation, 36),))


def lines(entries):
    return {(e.quantity, e.unit): e for e in entries}


@pytest.fixture(scope="module")
def gyro():
    signal = signal_named("gyro")
    fit = fit_of(absent(term("Q", 0.3, "arcsec")), estimate(term("N", 0.12, "deg/sqrt(h)"), 0.98, 1.03),
                 estimate(term("B", 3.0, "deg/h"), 0.8, 1.3, "weak"),
                 estimate(term("K", 40.0, "deg/h/sqrt(h)"), 0.8, 1.25),
                 estimate(term("R", -58.0, "deg/h^2"), 1.2, 0.8))  # fmt: skip
    return lines(data_sheet(fit, readings_of(signal, math.radians(1.5) / 3600), 100.0))


def checked(entries, *wanted):
    """Quantity, unit, and some of the attributes that it must have."""
    for quantity, unit, values in wanted:
        entry = entries[quantity, unit]
        assert {name: getattr(entry, name) for name in values} == pytest.approx(values), (quantity, unit)


def test_the_quantities_of_a_gyro(gyro):
    checked(
        gyro,
        # 0.12 deg/sqrt(h): / 60 sqrt(s) per sqrt(h) = 0.002 deg/s/sqrt(Hz); x 3600 s per h = 7.2 deg/h/sqrt(Hz)
        ("angle random walk N", "deg/sqrt(h)", {"value": 0.12, "low": 0.1176, "high": 0.1236}),
        ("noise density, two-sided", "deg/s/sqrt(Hz)", {"value": 0.002, "low": 0.00196, "high": 0.00206}),
        ("noise density, two-sided", "deg/h/sqrt(Hz)", {"value": 7.2}),
        ("noise density, one-sided", "deg/s/sqrt(Hz)", {"value": 0.0028284271, "low": 0.0027718586}),
        ("noise density, one-sided", "deg/h/sqrt(Hz)", {"value": 10.182338}),
        ("in-run bias stability", "deg/h", {"value": 1.5, "low": 1.35, "high": 1.8, "tau": 300.0}),
        ("bias instability B", "deg/h", {"remark": "weak"}),
        ("flicker floor, 0.664 B", "deg/h", {"value": 3 * 0.6642825}),
        ("rate random walk K", "deg/h/sqrt(h)", {"high": 50.0}),
        ("rate ramp R", "deg/h^2", {"value": -58.0, "low": -69.6, "high": -46.4}),
        ("10 s stability", "deg/h", {"value": 3.0}),
        ("bandwidth (-3 dB)", "", {"remark": "no roll-off up to 50 Hz"}),
        ("quantization noise Q", "arcsec", {"value": None, "low": None, "remark": "not identified", "high": 0.3}),
    )


def test_the_quantities_of_an_accelerometer():
    signal = signal_named("accelerometer")
    walk = estimate(term("N", 0.06, "m/s/sqrt(h)"), 0.95, 1.05)
    cutoff = LowPass("rc", "1st-order low-pass", 25.0, 24.0, 26.0, 100.0)
    found = data_sheet(fit_of(walk, behind=cutoff), readings_of(signal, 9.80665e-5, inside=False), 100.0)
    checked(
        lines(found),
        # 0.06 m/s/sqrt(h) / 60 = 0.001 m/s^2/sqrt(Hz) = 0.001 / 9.80665e-6 ug/sqrt(Hz) = 101.97 ug/sqrt(Hz)
        ("velocity random walk N", "m/s/sqrt(h)", {"value": 0.06}),
        ("noise density, two-sided", "m/s^2/sqrt(Hz)", {"value": 0.001}),
        ("noise density, two-sided", "ug/sqrt(Hz)", {"value": 101.971621}),
        ("noise density, one-sided", "ug/sqrt(Hz)", {"value": 144.209649}),
        ("in-run bias stability", "ug", {"value": 10.0, "remark": "still falling"}),
        ("bandwidth (-3 dB)", "Hz", {"value": 25.0, "low": 24.0, "high": 26.0}),
    )


def test_a_model_that_explains_nothing_gives_no_numbers():
    walk = estimate(term("N", 0.12, "deg/sqrt(h)"), 0.98, 1.03).invalid("the model does not explain the record")
    for entry in data_sheet(fit_of(walk), None, 100.0):
        assert (entry.value, entry.low, entry.high) == (None, None, None)
    assert data_sheet(fit_of(walk), None, 100.0)[0].remark == "not valid"


@rows(("ramp", "told"), [(60.0, False), (190.0, True), (-190.0, True)])
def test_a_stability_that_a_ramp_makes_says_so(ramp, told):
    """Means over 36 x 10 s of a ramp scatter by R x 360 s / sqrt(12): 5.5 deg/h of 190 deg/h^2."""
    signal = signal_named("gyro")
    fit = fit_of(estimate(term("N", 0.12, "deg/sqrt(h)"), 0.98, 1.03), estimate(term("R", ramp, "deg/h^2"), 0.9, 1.1))
    found = lines(data_sheet(fit, readings_of(signal, math.radians(3.0) / 3600), 100.0))
    remark = found["10 s stability", "deg/h"].remark
    assert remark == "36 means" + "; mostly the ramp R" * told
