"""Predicted errors and best filters against closed forms, Riccati equations and simulation."""

import math

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are
from tests.rows import refused, rows

import allanite as al
import vertical as benchmark
from allanite.applications.attitude import Loop, error_density, kalman, optimal_time_constant, predicted_error
from allanite.applications.attitude.loop import GRAVITY
from vertical import kalman_error

GYRO, TILT = al.Model("N 0.3 deg/sqrt(h)"), al.Model("N 100 ug/sqrt(Hz)")
N, A, K = GYRO["N"].value, TILT["N"].value / GRAVITY, al.K(20, "deg/h/sqrt(h)").value
ARCSEC = math.pi / 648_000
WHOLE = tuple(map(al.Model, benchmark.WHOLE))


def test_closed_form_of_white_noises_is_the_steady_kalman_filter():
    found = optimal_time_constant(GYRO, TILT)
    assert found.time_constant == pytest.approx(1.1459, abs=5e-5)
    assert found.first.to("arcsec") == pytest.approx(19.27, abs=0.005)
    assert [k for k, _ in found.detuning] == [0.25, 0.5, 1, 2, 4]
    for k, rms in found.detuning:
        assert rms / found.first.rms == pytest.approx(math.sqrt((k + 1 / k) / 2), rel=1e-7)
    assert (found.second, found.loss) == (None, 0)
    assert found.first.rms == pytest.approx(kalman_error(N, A), rel=1e-9)
    assert predicted_error(GYRO, TILT, kalman(N, A)).rms == pytest.approx(kalman_error(N, A), rel=1e-9)


@pytest.mark.slow("takes more than half a second")
def test_gains_of_second_order_solve_the_riccati_equation():
    P = solve_continuous_are(np.array([[0.0, -1.0], [0.0, 0.0]]).T, np.array([[1.0], [0.0]]),
                             np.diag([N**2, K**2]), np.array([[A**2]]))  # fmt: skip
    loop = kalman(N, A, K)
    assert (loop.k1, -loop.k2) == pytest.approx(P[:, 0] / A**2, rel=1e-9)
    assert (loop.frequency, loop.damping) == pytest.approx((0.1271, 3.50), rel=2e-3)
    assert kalman_error(N, A, K) == pytest.approx(math.sqrt(P[0, 0]), rel=1e-9)
    found = optimal_time_constant(GYRO + al.K(20, "deg/h/sqrt(h)"), TILT, duration=36_000)
    assert found.second.rms == pytest.approx(kalman_error(N, A, K), rel=2e-3)
    assert found.second.rms < found.first.rms


def test_a_bias_and_gauss_markov_noise():
    found = optimal_time_constant(GYRO, TILT, gyro_bias="10 deg/h")
    assert found.time_constant == pytest.approx(0.810, abs=5e-4)
    assert found.first.to("arcsec") == pytest.approx(21.43, abs=0.006)
    detuned = predicted_error(GYRO, TILT, 1.1459, gyro_bias="10 deg/h")
    assert detuned.to("arcsec") == pytest.approx(22.42, abs=0.02)
    slow = optimal_time_constant(*map(al.Model, ("GM 0.02 deg/s 5 s", "GM 0.0087266 g 0.5 s")))
    assert slow.time_constant == pytest.approx(8.06, abs=0.005)
    assert slow.first.to("deg") == pytest.approx(0.1567, abs=5e-5)
    assert slow.loss > 0.005


@rows("which", [0, 3, 7, 14, 16])
def test_predicted_against_simulated(which):
    models = benchmark.MODELS[which]
    simulated = benchmark.rms([benchmark.square((*models, 2.0, number)) for number in range(40)])
    assert simulated == pytest.approx(benchmark.predicted(models, 2.0, benchmark.HORIZON, benchmark.RATE), rel=0.05)


@pytest.mark.slow("seconds of analyses")
@rows("models", benchmark.MODELS)
def test_no_filter_is_better_than_the_bound(models):
    found = optimal_time_constant(*map(al.Model, models), duration=100.0, rate=10.0)
    assert found.bound <= found.first.rms * (1 + 1e-6)
    assert found.loss >= 0
    if found.second is not None:
        assert found.bound <= found.second.rms * 1.005
        assert found.second.rms < found.first.rms


def test_sources_add_by_the_formulas():
    found = predicted_error(*WHOLE, 1.0, duration=600.0, accelerometer_bias="20 ug")
    assert sum(s.rms**2 for s in found.sources) == pytest.approx(found.rms**2)
    assert [(s.sensor, s.symbol) for s in found.sources][-2:] == [("accelerometer", "B"), ("accelerometer", "bias")]
    slower = predicted_error(*WHOLE, 4.0, duration=600.0).floor
    assert slower == pytest.approx(math.sqrt(found.floor**2 - (20e-6) ** 2), rel=0.15)
    wave = predicted_error(GYRO + al.Sine(10, "deg/h", frequency=0.1), TILT, 2.0).sources[-1]
    gain = 2.0 / math.hypot(1, 2 * math.pi * 0.1 * 2.0)
    assert wave.rms == pytest.approx(10 * ARCSEC / math.sqrt(2) * gain, rel=1e-9)
    ramp = predicted_error(GYRO + al.R(10, "deg/h^2"), TILT, 2.0, duration=3600.0).sources[-1]
    assert ramp.rms == pytest.approx(10 * ARCSEC * 2.0 / math.sqrt(12), rel=1e-9)
    f = np.geomspace(1e-3, 10, 50)
    lines = error_density(predicted_error(GYRO, TILT, 2.0), f)
    whole = lines["gyro N"] ** 2 + lines["accelerometer N"] ** 2
    assert whole == pytest.approx(2 * (N**2 * 4 + A**2) / (1 + (4 * math.pi * f) ** 2), rel=1e-9)


@rows("call, said", [
    (lambda: predicted_error(GYRO, TILT, 0.0), "a time constant must be between 1e-15 and 1e.12 s, not 0"),
    (lambda: predicted_error(GYRO, TILT, 0.01, rate=100.0), "above the sample interval of 0.01 s, not 0.01 s"),
    (lambda: predicted_error(TILT, TILT, 1.0), "that of another sensor"),
    (lambda: predicted_error(GYRO + al.B(1, "deg/h"), TILT, 1.0), "give a horizon with duration"),
    (lambda: predicted_error(GYRO + al.Q(1, "arcsec"), TILT, 1.0), "depends on the sampling rate: give it with"),
    (lambda: predicted_error(GYRO, TILT, 1.0, gyro_bias="10"), "a bias has the form '10 deg/h'"),
    (lambda: predicted_error(GYRO, TILT, 1.0, gyro_bias="10 ug"), "is a unit of something else"),
    (lambda: optimal_time_constant(al.N(0, "deg/sqrt(h)"), TILT), "no time constant is best: the longest"),
    (lambda: Loop(-1.0), "k1 must be between 1e-30"),
])  # fmt: skip
def test_bad_input(call, said):
    refused(al.UsageError, said, call)
