"""An angle error like that of a gyro stabilizer: white noise, a process of its control loop and drift of the platform.

Gazaryan, Tairov, Ponomarev (Izvestiya of Tula State University, pp. 143-153) take the Allan deviation of the platform's
angle, 40 Hz for an hour. Their data are not published: the coefficients here are those of a record like it.
"""

import numpy as np
import pytest
from tests.rows import rows

import allanite as al

MODEL = al.N(0.28, "arcsec*sqrt(s)") + al.GM(1.2, "arcsec", time_constant=2.0) + al.R(0.5, "arcsec/s")


@pytest.fixture(scope="module")
def angle():
    made = al.simulate(MODEL, 48_000, 40.0, rng=np.random.default_rng(5), unit="arcsec", name="azimuth")
    return al.Record(made.values / 60, 40.0, "arcmin", kind="value", name="azimuth")


@pytest.fixture(scope="module")
def fit(angle):
    return al.identify(angle)


@rows(
    "symbol, unit, error",
    [("N", "arcsec*sqrt(s)", 0.03), ("GM", "arcsec", 0.15), ("R", "arcsec/s", 0.02)],
)
def test_the_coefficients_come_back_in_units_of_the_angle(fit, symbol, unit, error):
    found, true = fit[symbol], MODEL[symbol].to(unit)
    assert (fit.validity, found.status, found.sheet_unit) == ("explained", "identified", unit)
    assert found.to(unit) == pytest.approx(true, rel=error)
    low, high = found.interval(0.999)
    assert low <= MODEL[symbol].value <= high


def test_the_time_constant_comes_back(fit):
    assert fit["GM"].shape[0] == pytest.approx(2.0, rel=0.3)


def test_the_deviation_is_equation_8_of_the_paper(angle):
    x, m = angle.values, 40
    y = np.concatenate(([0.0], np.cumsum(x))) / 40
    second = y[2 * m :] - 2 * y[m:-m] + y[: -2 * m]
    by_paper = np.sqrt(np.sum(second**2) / (2 * (m / 40) ** 2 * (len(y) - 2 * m)))
    curve = al.deviation(angle, "oadev", m=[m], noise=None)
    assert curve.to("arcmin").deviation[0] == pytest.approx(by_paper, rel=1e-12)


def test_another_kind_gives_another_quantity(angle):
    """What was read as increments was explained, with N forty times larger: the numbers times the rate."""
    wrong = al.Record(angle.values, 40.0, "arcmin", kind="increment", name="azimuth")
    assert wrong.rate_values == pytest.approx(40 * angle.rate_values)
    assert (wrong.signal.name, angle.signal.name) == ("gyro", "angle")
