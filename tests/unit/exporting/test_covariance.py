"""What each target makes of its file: its covariance, or its simulated errors, grow as those of the sensor."""

import math

import numpy as np
import pytest
from tests.rows import paired, rows
from tests.unit.exporting.parsers import PARSERS, propagated, simulated

import allanite as al
from allanite.exporting.content import number

DURATION = 100.0
RATES = (100.0, 200.0)
COEFFICIENTS = {"gyro": (2e-4, 3e-6), "accelerometer": (6e-3, 1.2e-4)}
"""N and K in SI, whose angle errors are about equal after the duration, within the ranges that autopilots accept."""


def noise():
    units = {"gyro": ("rad/s/sqrt(Hz)", "rad/s^2/sqrt(Hz)"), "accelerometer": ("m/s^2/sqrt(Hz)", "m/s^3/sqrt(Hz)")}
    return [al.N(n, units[s][0]) + al.K(k, units[s][1]) for s, (n, k) in COEFFICIENTS.items()]


def with_fields():
    return [name for name, row in al.EXPORTS.items() if row.fields]


@pytest.fixture(scope="module")
def ensembles():
    """Simulated variances after the duration: of both terms, and of white noise alone."""
    rng = np.random.default_rng(7)
    return {
        (s, with_bias): simulated(n, k if with_bias else 0.0, 0.02, duration=DURATION, rng=rng)
        for s, (n, k) in COEFFICIENTS.items()
        for with_bias in (True, False)
    }


def test_every_target_has_a_parser():
    assert set(with_fields()) == set(PARSERS)


@rows("name, rate, sensor", paired(list(PARSERS), RATES, list(COEFFICIENTS)))
def test_the_angle_grows_as_that_of_the_sensor(name, rate, sensor, ensembles):
    row = al.EXPORTS[name]
    step = PARSERS[name](al.export(noise(), name, rate=rate).text)[sensor]
    dt = row.step or 1 / rate
    has_bias = step(dt)[2] is not None
    n, k = COEFFICIENTS[sensor]
    expected = n**2 * DURATION + (k**2 * DURATION**3 / 3 if has_bias else 0.0)
    found = propagated(step, dt, DURATION)
    assert found == pytest.approx(expected, rel=1e-3)
    measured, error = ensembles[sensor, has_bias]
    assert abs(measured / found - 1) < 4 * error


def test_the_test_tells_the_conventions_apart():
    """The densities of kalibr in the fields of VINS are too small by sqrt(2 f)."""
    held = al.export(noise(), "kalibr", rate=200.0)
    walk, density = (number(held[f"gyroscope_{field}"]) for field in ("random_walk", "noise_density"))
    wrong = f"%YAML:1.0\ngyr_n: {density}\ngyr_w: {walk}\nacc_n: 1.0\nacc_w: 1.0\n"
    n, k = COEFFICIENTS["gyro"]
    found = propagated(PARSERS["vins-mono"](wrong)["gyro"], 1 / 200, DURATION)
    assert found == pytest.approx(n**2 * DURATION / 400 + k**2 * DURATION**3 / 3 / 200, rel=1e-3)


@rows("rate", [400.0, 50.0])
def test_a_filter_at_another_rate(rate):
    found = al.export(noise(), "px4", rate=200.0, filter_rate=rate)
    step = PARSERS["px4"](found.text)["gyro"]
    n, k = COEFFICIENTS["gyro"]
    expected = n**2 * DURATION + k**2 * DURATION**3 / 3
    assert propagated(step, 1 / rate, DURATION) == pytest.approx(expected, rel=1e-3)


@rows("name", [name for name in PARSERS if al.EXPORTS[name].markov])
def test_a_gauss_markov_process_keeps_its_size_and_time(name):
    markov = [al.N(1e-4, "rad/s/sqrt(Hz)") + al.GM(2e-5, "rad/s", time_constant=500.0),
              al.N(1e-3, "m/s^2/sqrt(Hz)") + al.GM(3e-4, "m/s^2", time_constant=900.0)]  # fmt: skip
    steps = PARSERS[name](al.export(markov, name, rate=100.0).text)
    for sensor, size, time in (("gyro", 2e-5, 500.0), ("accelerometer", 3e-4, 900.0)):
        _, decay, walk = steps[sensor](0.01)
        assert walk / (1 - decay**2) == pytest.approx(size**2, rel=1e-4)
        assert decay == pytest.approx(math.exp(-0.01 / time), rel=1e-8)


def test_state_space_matrices():
    import io

    found = al.export(noise(), "statespace", rate=100.0)
    held = np.load(io.BytesIO(found.data))
    for i, (n, k) in enumerate(COEFFICIENTS.values(), 1):

        def step(dt, i=i):
            return held[f"axis{i}_R"][0, 0] * dt**2, held[f"axis{i}_Phi"][0, 0], held[f"axis{i}_Qd"][0, 0]

        expected = n**2 * DURATION + k**2 * DURATION**3 / 3
        assert propagated(step, 0.01, DURATION) == pytest.approx(expected, rel=1e-3)
