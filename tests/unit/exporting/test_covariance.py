"""What targets make of their files: angles that grow as those of the sensor, errors as the filter predicts."""

from table import coefficients

import math

import numpy as np
import pytest
from tests.reference.aided import drift, judge
from tests.rows import paired, rows
from tests.unit.exporting.parsers import PARSERS, propagated

import allanite as al
import judge as simulator
from allanite.exporting.imported import noise_in
from consistency import AIDED, BEFORE, OUTAGES, best, errors, filters, stationary, target

DURATION = 100.0
RATES = (100.0, 200.0)
COEFFICIENTS = {"gyro": (2e-4, 3e-6), "accelerometer": (6e-3, 1.2e-4)}
"""N and K in SI, whose angle errors are about equal after the duration, within the ranges that autopilots accept."""


def noise():
    units = {"gyro": ("rad/s/sqrt(Hz)", "rad/s^2/sqrt(Hz)"), "accelerometer": ("m/s^2/sqrt(Hz)", "m/s^3/sqrt(Hz)")}
    return [al.N(n, units[s][0]) + al.K(k, units[s][1]) for s, (n, k) in COEFFICIENTS.items()]


def test_every_target_has_a_parser():
    assert {name for name, row in al.exporting.EXPORTS.items() if row.fields} == set(PARSERS)


@rows("name, rate, sensor", paired(list(PARSERS), RATES, list(COEFFICIENTS)))
def test_the_angle_grows_as_that_of_the_sensor(name, rate, sensor):
    step = PARSERS[name](al.export(noise(), name, rate=rate).text)[sensor]
    dt = al.exporting.EXPORTS[name].step or 1 / rate
    has_bias = step(dt)[2] is not None
    n, k = COEFFICIENTS[sensor]
    expected = n**2 * DURATION + has_bias * k**2 * DURATION**3 / 3
    assert propagated(step, dt, DURATION) == pytest.approx(expected, rel=1e-3)


@rows("rate", [400.0, 50.0])
def test_a_filter_at_another_rate(rate):
    step = PARSERS["px4"](al.export(noise(), "px4", rate=200.0, filter_rate=rate).text)["gyro"]
    n, k = COEFFICIENTS["gyro"]
    assert propagated(step, 1 / rate, DURATION) == pytest.approx(n**2 * DURATION + k**2 * DURATION**3 / 3, rel=1e-3)


@rows("name", [name for name in PARSERS if al.exporting.EXPORTS[name].markov])
def test_a_gauss_markov_process_keeps_its_size_and_time(name):
    markov = [al.N(1e-4, "rad/s/sqrt(Hz)") + al.GM(2e-5, "rad/s", time_constant=500.0),
              al.N(1e-3, "m/s^2/sqrt(Hz)") + al.GM(3e-4, "m/s^2", time_constant=900.0)]  # fmt: skip
    steps = PARSERS[name](al.export(markov, name, rate=100.0).text)
    for sensor, size, time in (("gyro", 2e-5, 500.0), ("accelerometer", 3e-4, 900.0)):
        _, decay, walk = steps[sensor](0.01)
        assert walk / (1 - decay**2) == pytest.approx(size**2, rel=1e-4)
        assert decay == pytest.approx(math.exp(-0.01 / time), rel=1e-8)


GYRO = al.N(0.3, "deg/sqrt(h)") + al.B(7.2, "deg/h")
BOTH = [GYRO, al.Model("N 60 ug/sqrt(Hz), K 20 ug/sqrt(h)")]
RATE, AID = 100.0, math.radians(0.1)
UNAIDED = {"ros-imu", "robot-localization"}  # targets that do not estimate a bias: no white noise stands for one


@pytest.fixture(scope="module")
def truth():
    """The covariance of the gyro's mean rates, and the errors of the best filter."""
    N, B = GYRO["N"].value, GYRO["B"].value
    n = AIDED + OUTAGES[-1]
    flicker = drift(lambda t: -((B * t) ** 2) * np.log(np.where(t > 0, t, 1.0)) / np.pi, n)
    least = errors(GYRO, filters([best(GYRO)], AID), AID)[0]
    return flicker + N**2 * np.eye(n), least


def judged(name, cover, truth):
    """Predicted and actual standard deviations of the angle with the file of a target, as its filter reads it."""
    row = al.exporting.EXPORTS[name]
    text = al.export(BOTH, name, rate=RATE, cover=cover).text
    model = noise_in(text, row, RATE).gyro
    if any(t.symbol == "B" for t in model):
        found = filters([target(model)], AID)
        return found[0][0], errors(GYRO, found, AID)[0]
    dt = row.step or 1 / RATE
    white, decay, walk = PARSERS[name](text)["gyro"](dt)
    time = -dt / math.log(decay) if decay < 1 else math.inf
    return judge(math.sqrt(white / dt), math.sqrt(walk / dt), truth[0], time=time, aid=AID, outages=OUTAGES)


@pytest.mark.slow("seconds of analyses")
@rows("name", sorted(set(PARSERS) - UNAIDED))
def test_a_file_that_covers_is_neither_over_confident_nor_much_too_cautious(name, truth):
    predicted, actual = judged(name, (1, 1000), truth)
    ratio = actual / predicted
    assert ((ratio >= 0.7) & (ratio <= 1.1)).all(), ratio.round(2)
    assert (actual / truth[1])[:2].max() <= 1.1


@rows("time", [math.inf, 200.0])
def test_filters_of_the_benchmark_are_those_of_the_referee(time, truth):
    N, K = GYRO["N"], al.K(40, "deg/h/sqrt(h)")
    decaying = al.Term("GM", K.value * math.sqrt(time / 2), K.signal, (time,))
    found = filters([target(al.Model((N, K if time == math.inf else decaying)))], AID)
    predicted, actual = judge(N.value, K.value, truth[0], time=time, aid=AID, outages=OUTAGES)
    assert found[0][0] == pytest.approx(predicted, rel=1e-9)
    assert errors(GYRO, found, AID)[0] == pytest.approx(actual, rel=1e-9)


def simulated_rates(model, runs, rng):
    """Mean rates while aided, shape (runs, AIDED), and angles at the end of each outage, (runs, outages)."""
    n = BEFORE + AIDED + OUTAGES[-1]
    still, moving = (coefficients(t for t in model if stationary(t) == kind) for kind in (True, False))
    y = np.empty((runs, n))
    for i in range(runs):
        drifting = simulator.sensor(n, 1.0, rng, **moving)
        y[i] = simulator.sensor(n, 1.0, rng, **still) + drifting - drifting[:BEFORE].mean()
    return y[:, BEFORE : BEFORE + AIDED], np.cumsum(y[:, BEFORE + AIDED :], axis=1)[:, np.array(OUTAGES) - 1]


@pytest.mark.slow("takes more than half a second")
def test_simulated_errors_are_those_of_the_covariance():
    """Of 1 000 runs within four standard errors, for a drift, a stationary noise, and an accurate aid."""
    model = GYRO + al.GM(10, "deg/h", time_constant=100.0)
    rng, found = np.random.default_rng(11), filters([target(GYRO)], AID)
    rates, angles = simulated_rates(model, 1000, rng)
    _, past, aid = found
    made = angles + rates @ past[0].T + AID * rng.standard_normal(rates.shape) @ aid[0].T
    ratio = np.sqrt(np.mean(made**2, axis=0)) / errors(model, found, AID)[0]
    assert abs(ratio - 1).max() < 4 / math.sqrt(2000)
