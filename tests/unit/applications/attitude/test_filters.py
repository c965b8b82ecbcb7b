"""Filters against other libraries, coning against its closed form, scenarios against an independent prototype."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.rows import rows

import allanite as al
import vertical as benchmark
from allanite.applications.attitude import FILTERS, SCENARIOS, Inertial, Loop, Setting, Trial, simulate_motion
from allanite.applications.attitude.filters import quaternion

NOISE = al.N(0.3, "deg/sqrt(h)"), al.N(100, "ug/sqrt(Hz)")


@pytest.fixture(scope="module")
def swaying():
    trial = Trial(*NOISE, benchmark.BIAS, duration=30.0)
    return simulate_motion(SCENARIOS["oscillation"], trial, rng=np.random.default_rng(1))


def angles_of(quaternions):
    matrix = Rotation.from_quat(quaternions, scalar_first=True).as_matrix()
    up = matrix[:, 2]
    return np.stack([np.arctan2(up[:, 1], up[:, 2]), np.arctan2(-up[:, 0], np.hypot(up[:, 1], up[:, 2]))], axis=1)


@rows("name, setting, choices", [
    ("Mahony", Setting(Loop(0.5, 0.01)), {"k_P": 0.5, "k_I": 0.01}),
    ("Madgwick", Setting(Loop(1.0), beta=0.033), {"gain": 0.033}),
])  # fmt: skip
def test_a_filter_is_that_of_ahrs(swaying, name, setting, choices):
    ahrs = pytest.importorskip("ahrs")
    data, _ = swaying
    own, _ = FILTERS[name.lower()].run(data, setting)
    theirs = getattr(ahrs.filters, name)(frequency=100.0, **choices)
    theirs.b = np.zeros(3)
    q, found = quaternion(data.start), []
    for rate, force in zip(data.gyro, data.force, strict=True):
        q = theirs.updateIMU(q, rate, force)
        found.append(q)
    assert own == pytest.approx(angles_of(np.array(found)), abs=1e-9)


def test_mahony_is_that_of_imufusion(swaying):
    # its gain is 1 / time constant of half the cross product's sine: alike at small errors
    imufusion = pytest.importorskip("imufusion")
    data, _ = swaying
    own, _ = FILTERS["mahony"].run(data, Setting(Loop(0.5)))
    settings = imufusion.AhrsSettings()
    settings.sample_rate, settings.gain, settings.gyroscope_range = 100.0, 0.5, 0.0
    settings.convention, settings.acceleration_rejection = imufusion.CONVENTION_NWU, 90.0
    theirs = imufusion.Ahrs()
    theirs.set_settings(settings)
    theirs.skip_startup()
    theirs.set_quaternion(quaternion(data.start))
    found = []
    for rate, force in zip(np.degrees(data.gyro), data.force / 9.80665, strict=True):
        theirs.update_no_magnetometer(rate, force)
        found.append(np.array(theirs.get_quaternion()))
    errors = np.degrees(own - angles_of(np.array(found)))
    assert np.abs(errors).max() < 0.05
    assert np.degrees(own).std() > 5


def test_bortz_through_scipy(swaying):
    data, truth = swaying
    own, held = FILTERS["bortz"].run(data, Setting(Loop(1.0)))
    assert held == len(truth)
    turn = Rotation.from_quat(quaternion(data.start), scalar_first=True)
    steps = al.attitude.rotation_vectors(data.gyro * data.interval)
    for step in steps[:200]:
        turn = turn * Rotation.from_rotvec(step)
    assert own[399] == pytest.approx(angles_of(turn.as_quat(scalar_first=True)[None])[0], abs=1e-12)
    last = al.attitude.attitudes(steps, quaternion(data.start))[199]
    assert last == pytest.approx(turn.as_quat(scalar_first=True), abs=1e-12)


def test_residuals_of_coning():
    """A cone of half an angle of 1 deg at 5 Hz, sampled at 200 Hz; drift, deg/h, by an independent prototype."""
    cone, w, dt, n = math.radians(1.0), 10 * math.pi, 1 / 200, 12_000
    t = np.arange(n + 1) * dt
    # rates of the body whose rotation vector is (0, c cos wt, c sin wt)
    steady = -2 * w * math.sin(cone / 2) ** 2 * np.diff(t)
    swing = math.sin(cone)
    increments = np.stack([steady, swing * np.diff(np.cos(w * t)), swing * np.diff(np.sin(w * t))], axis=1)
    start = np.array([math.cos(cone / 2), 0.0, math.sin(cone / 2), 0.0])
    pairs, turns = increments.reshape(-1, 2, 3).sum(axis=1), al.attitude.rotation_vectors(increments)
    for k, phi, known in ((1, increments, -4.05), (2, turns, -0.0200), (2, pairs, -16.2)):
        end, at = al.attitude.attitudes(phi, start)[-1], w * t[k * len(phi)]
        true = [math.cos(cone / 2), 0, math.sin(cone / 2) * math.cos(at), math.sin(cone / 2) * math.sin(at)]
        # x part of the quaternion of the error, end times the conjugate of the truth
        x = -end[0] * true[1] + end[1] * true[0] - end[2] * true[3] + end[3] * true[2]
        assert 2 * x / t[k * len(phi)] / benchmark.HOUR == pytest.approx(known, rel=0.2)


@pytest.fixture(scope="module", params=[False, True], ids=["mean", "instant"])
def compared(request):
    gyro, tilt = al.Model(benchmark.GYRO), al.Model(benchmark.TILT)
    trial = Trial(gyro, tilt, benchmark.BIAS, instant=request.param)
    return al.attitude.compare_filters(trial, rng=np.random.default_rng(1))


def test_scenarios_against_a_prototype(compared):
    known = np.array(list(benchmark.SCENARIO_FIGURES.values()))
    own = np.degrees(compared.rms[[compared.filters.index(name) for name in benchmark.SCENARIO_FIGURES]])
    off = {(list(benchmark.SCENARIO_FIGURES)[i], compared.scenarios[j])
           for i, j in np.argwhere(np.abs(own / known - 1) > 0.2)}  # fmt: skip
    # the lead of the prototype's sampled rates hides part of the error of the lever arm
    led = {("first order, 10 s", "oscillation"), ("madgwick, beta 0.001", "oscillation")}
    assert off == (set() if compared.trial.instant else led)
    for a, b in zip(own.T, known.T, strict=True):
        # where two filters of the prototype differ by more than 20 %, they are in the same order
        apart = np.subtract.outer(np.log(b), np.log(b)) > math.log(1.2)
        assert (np.subtract.outer(a, a)[apart] > 0).all()


@rows("instant", [False, True])
def test_the_oscillation_in_closed_form(instant):
    quiet = Trial(al.N(1e-6, "deg/sqrt(h)"), al.N(1e-3, "ug/sqrt(Hz)"), instant=instant)
    filters = {f"{tau:g}": ("complementary", Setting(Loop.of(tau))) for tau in (1.0, 3.0, 10.0)}
    found = al.attitude.compare_filters(quiet, rng=np.random.default_rng(1), filters=filters)
    derived = [benchmark.swaying(tau, instant=instant) for tau in (1.0, 3.0, 10.0)]
    assert found.rms[:, 2] == pytest.approx(derived, rel=0.03)
    if instant:  # lever arm and lead cancel
        assert benchmark.swaying(2 / 9.80665 * 100, instant=True) == pytest.approx(0, abs=1e-12)


def test_a_norm_gate_does_not_see_an_acceleration_and_an_angle_gate_does(compared):
    rms = dict(zip(compared.filters, compared.rms[:, 1:], strict=True))
    plain, norm = rms["first order, 100 s"][0], rms["100 s, norm gate 0.02 g"][0]
    assert norm == plain
    assert math.degrees(plain) == pytest.approx(0.3281, rel=0.05)
    # a gate below the 1.6 deg by which the oscillation tilts the accelerometers costs there, a wider one does not
    names = ("first order, 10 s", "10 s, angle gate 1 deg", "10 s, angle gate 2 deg")
    ungated, narrow, wide = (rms[name] for name in names)
    assert narrow[0] == wide[0] < 0.1 * ungated[0]
    assert narrow[1] > 5 * ungated[1]
    assert wide[1] == ungated[1]


@rows("name", FILTERS)
def test_free_fall_is_held(name):
    data, _ = simulate_motion(SCENARIOS["fixed base"], Trial(*NOISE, duration=10.0), rng=np.random.default_rng(1))
    force = data.force.copy()
    force[300:400] = 0.0
    found, held = FILTERS[name].run(replace(data, force=force), Setting(Loop.of(5.0)))
    assert np.isfinite(found).all()
    assert held in (100, len(force)) if name != "accelerometer" else held == 0


def test_a_steep_pitch_is_refused_by_angles_and_not_by_quaternions():
    n = 2000
    rates = np.zeros((n, 3))
    rates[:, 1] = math.radians(90) / 10
    pitch = rates[:, 1].cumsum() / 100
    data = Inertial(rates, 9.8 * np.stack([-np.sin(pitch), 0 * pitch, np.cos(pitch)], axis=1), 100.0)
    with pytest.raises(al.DataError, match=r"within 1 degree of 90 at 9\.\d+ s.*method='mahony'|method=\.\.\."):
        FILTERS["complementary"].run(data, Setting(Loop.of(5.0)))
    found, _ = FILTERS["mahony"].run(data, Setting(Loop.of(5.0)))
    assert math.degrees(found[:, 1].max()) > 89
