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
    scale = part.value
    return Estimate(
        part.symbol, part.signal, part.value, 0.1 * scale, status, None, "whittle",
        lambda level: (low * scale, high * scale),
    )  # fmt: skip


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


def test_the_angle_random_walk_in_the_units_in_use_and_as_a_density(gyro):
    # 0.12 deg/sqrt(h): / 60 sqrt(s) per sqrt(h) = 0.002 deg/s/sqrt(Hz); x 3600 s per h = 7.2 deg/h/sqrt(Hz)
    walk = gyro["angle random walk N", "deg/sqrt(h)"]
    assert (walk.value, walk.low, walk.high) == pytest.approx((0.12, 0.1176, 0.1236))
    two = gyro["noise density, two-sided", "deg/s/sqrt(Hz)"]
    assert (two.value, two.low, two.high) == pytest.approx((0.002, 0.00196, 0.00206))
    assert gyro["noise density, two-sided", "deg/h/sqrt(Hz)"].value == pytest.approx(7.2)
    one = gyro["noise density, one-sided", "deg/s/sqrt(Hz)"]
    assert (one.value, one.low) == pytest.approx((0.0028284271, 0.0027718586))
    assert gyro["noise density, one-sided", "deg/h/sqrt(Hz)"].value == pytest.approx(10.182338)


def test_the_other_quantities_of_a_gyro(gyro):
    minimum = gyro["in-run bias stability", "deg/h"]
    assert (minimum.value, minimum.low, minimum.high, minimum.tau) == pytest.approx((1.5, 1.35, 1.8, 300.0))
    assert gyro["bias instability B", "deg/h"].remark == "weak"
    assert gyro["flicker floor, 0.664 B", "deg/h"].value == pytest.approx(3 * 0.6642825)
    assert gyro["rate random walk K", "deg/h/sqrt(h)"].high == pytest.approx(50.0)
    ramp = gyro["rate ramp R", "deg/h^2"]
    assert (ramp.value, ramp.low, ramp.high) == pytest.approx((-58.0, -69.6, -46.4))
    assert gyro["10 s stability", "deg/h"].value == pytest.approx(3.0)
    assert gyro["bandwidth (-3 dB)", ""].remark == "no roll-off up to 50 Hz"
    q = gyro["quantization noise Q", "arcsec"]
    assert (q.value, q.low, q.remark, q.high) == (None, None, "not identified", pytest.approx(0.3))


def test_the_quantities_of_an_accelerometer():
    signal = signal_named("accelerometer")
    walk = estimate(term("N", 0.06, "m/s/sqrt(h)"), 0.95, 1.05)
    cutoff = LowPass("rc", "1st-order low-pass", 25.0, 24.0, 26.0, 100.0)
    found = lines(data_sheet(fit_of(walk, behind=cutoff), readings_of(signal, 9.80665e-5, inside=False), 100.0))
    # 0.06 m/s/sqrt(h) / 60 = 0.001 m/s^2/sqrt(Hz) = 0.001 / 9.80665e-6 ug/sqrt(Hz) = 101.97 ug/sqrt(Hz)
    assert found["velocity random walk N", "m/s/sqrt(h)"].value == pytest.approx(0.06)
    assert found["noise density, two-sided", "m/s^2/sqrt(Hz)"].value == pytest.approx(0.001)
    assert found["noise density, two-sided", "ug/sqrt(Hz)"].value == pytest.approx(101.971621)
    assert found["noise density, one-sided", "ug/sqrt(Hz)"].value == pytest.approx(144.209649)
    minimum = found["in-run bias stability", "ug"]
    assert (minimum.value, minimum.remark) == (pytest.approx(10.0), "still falling")
    band = found["bandwidth (-3 dB)", "Hz"]
    assert (band.value, band.low, band.high) == (25.0, 24.0, 26.0)


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
