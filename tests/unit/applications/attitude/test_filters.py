"""Filters against other libraries, coning against its closed form, scenarios against an independent prototype."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.rows import rows

import allanite as al
import vertical as benchmark
from allanite.applications.attitude import (
    FILTERS,
    SCENARIOS,
    Inertial,
    Loop,
    Setting,
    Trial,
    attitudes,
    compare_filters,
    rotation_vectors,
    simulate_motion,
)
from allanite.applications.attitude.filters import quaternion

CONE, CONE_RATE, CONE_SAMPLING = math.radians(1.0), 5.0, 200.0
CONING_FIGURES = {"1 sample": -4.05, "2 samples, without": -16.2, "2 samples": -0.0200}
"""Half angle of a cone, rad, its frequency and the sampling rate, Hz; drift, deg/h, by an independent prototype."""

NOISE = al.N(0.3, "deg/sqrt(h)"), al.N(100, "ug/sqrt(Hz)")


@pytest.fixture(scope="module")
def swaying():
    trial = Trial(*NOISE, benchmark.BIAS, duration=30.0)
    return simulate_motion(SCENARIOS["oscillation"], trial, rng=np.random.default_rng(1))


def angles_of(quaternions):
    matrix = Rotation.from_quat(quaternions, scalar_first=True).as_matrix()
    up = matrix[:, 2]
    return np.stack([np.arctan2(up[:, 1], up[:, 2]), np.arctan2(-up[:, 0], np.hypot(up[:, 1], up[:, 2]))], axis=1)


def test_mahony_is_that_of_ahrs(swaying):
    ahrs = pytest.importorskip("ahrs")
    data, _ = swaying
    own, _ = FILTERS["mahony"].run(data, Setting(Loop(0.5, 0.01)))
    theirs = ahrs.filters.Mahony(k_P=0.5, k_I=0.01, frequency=100.0)
    theirs.b = np.zeros(3)
    q, found = quaternion(data.start), []
    for rate, force in zip(data.gyro, data.force, strict=True):
        q = theirs.updateIMU(q, rate, force)
        found.append(q)
    assert own == pytest.approx(angles_of(np.array(found)), abs=1e-9)


def test_madgwick_is_that_of_ahrs(swaying):
    ahrs = pytest.importorskip("ahrs")
    data, _ = swaying
    own, _ = FILTERS["madgwick"].run(data, Setting(Loop(1.0), beta=0.033))
    theirs = ahrs.filters.Madgwick(gain=0.033, frequency=100.0)
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
    assert attitudes(steps, quaternion(data.start))[199] == pytest.approx(turn.as_quat(scalar_first=True), abs=1e-12)


def coning() -> dict[str, float]:
    """Drift that is left of a coning motion, deg/h, by algorithm."""
    w, dt, n = 2 * math.pi * CONE_RATE, 1 / CONE_SAMPLING, 12_000
    t = np.arange(n + 1) * dt
    # rates of the body whose rotation vector is (0, c cos wt, c sin wt)
    steady = -2 * w * math.sin(CONE / 2) ** 2 * np.diff(t)
    swing = math.sin(CONE)
    increments = np.stack([steady, swing * np.diff(np.cos(w * t)), swing * np.diff(np.sin(w * t))], axis=1)
    start = np.array([math.cos(CONE / 2), 0.0, math.sin(CONE / 2), 0.0])
    vectors = {"1 sample": (1, increments), "2 samples": (2, rotation_vectors(increments)),
               "2 samples, without": (2, increments.reshape(-1, 2, 3).sum(axis=1))}  # fmt: skip
    found = {}
    for name, (k, phi) in vectors.items():
        end = attitudes(phi, start)[-1]
        at = w * t[k * len(phi)]
        true = np.array([math.cos(CONE / 2), 0, math.sin(CONE / 2) * math.cos(at), math.sin(CONE / 2) * math.sin(at)])
        # x part of the quaternion of the error, end times the conjugate of the truth
        x = -end[0] * true[1] + end[1] * true[0] - end[2] * true[3] + end[3] * true[2]
        found[name] = 2 * x / (t[k * len(phi)]) / benchmark.HOUR
    return found


def test_residuals_of_coning():
    found = coning()
    for name, known in CONING_FIGURES.items():
        assert found[name] == pytest.approx(known, rel=0.2), name


@pytest.fixture(scope="module", params=[False, True], ids=["mean", "instant"])
def compared(request):
    gyro, tilt = al.Model(benchmark.GYRO), al.Model(benchmark.TILT)
    trial = Trial(gyro, tilt, benchmark.BIAS, instant=request.param)
    return compare_filters(trial, rng=np.random.default_rng(1))


LED = {("first order, 10 s", "oscillation"), ("madgwick, beta 0.001", "oscillation")}
"""Cells in which the lead of the prototype's sampled rates hides part of the error of the lever arm."""


def test_scenarios_against_a_prototype(compared):
    known = np.array(list(benchmark.SCENARIO_FIGURES.values()))
    own = np.degrees(compared.rms[[compared.filters.index(name) for name in benchmark.SCENARIO_FIGURES]])
    off = {
        (name, scenario)
        for name, a, b in zip(benchmark.SCENARIO_FIGURES, own, known, strict=True)
        for scenario, x, y in zip(compared.scenarios, a, b, strict=True) if x != pytest.approx(y, rel=0.2)
    }  # fmt: skip
    assert off == (set() if compared.trial.instant else LED)
    for a, b in zip(own.T, known.T, strict=True):
        # where two filters of the prototype differ by more than 20 %, they are in the same order
        apart = np.subtract.outer(np.log(b), np.log(b)) > math.log(1.2)
        assert (np.subtract.outer(a, a)[apart] > 0).all()


@rows("instant", [False, True])
def test_the_oscillation_in_closed_form(instant):
    quiet = Trial(al.N(1e-6, "deg/sqrt(h)"), al.N(1e-3, "ug/sqrt(Hz)"), instant=instant)
    filters = {f"{tau:g}": ("complementary", Setting(Loop.of(tau))) for tau in (1.0, 3.0, 10.0)}
    found = compare_filters(quiet, rng=np.random.default_rng(1), filters=filters)
    derived = [benchmark.swaying(tau, instant=instant) for tau in (1.0, 3.0, 10.0)]
    assert found.rms[:, 2] == pytest.approx(derived, rel=0.03)
    if instant:  # lever arm and lead cancel
        assert benchmark.swaying(2 / 9.80665 * 100, instant=True) == pytest.approx(0, abs=1e-12)


def test_no_filter_of_first_order_wins_everywhere(compared):
    firsts = [compared.filters.index(f"first order, {tau} s") for tau in (1, 10, 100)]
    assert compared.rms[firsts].argmin(axis=0).tolist() == [0, 2, 1]


def test_a_norm_gate_does_not_see_an_acceleration_and_an_angle_gate_does(compared):
    names, rms = compared.filters, compared.rms[:, 1]
    plain, norm = rms[names.index("first order, 100 s")], rms[names.index("100 s, norm gate 0.02 g")]
    assert norm == plain
    assert math.degrees(plain) == pytest.approx(0.3281, rel=0.05)
    # a gate below the 1.6 deg by which the oscillation tilts the accelerometers costs there, a wider one does not
    ungated, narrow, wide = (
        compared.rms[names.index(name), 1:]
        for name in ("first order, 10 s", "10 s, angle gate 1 deg", "10 s, angle gate 2 deg")
    )
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


@rows("k1, k2", [(0.5, 0.0), (0.5, 0.04), (2.0, 3.0), (0.02, 1e-5)])
def test_a_short_interval_makes_the_response_of_continuous_time(k1, k2):
    loop, f = Loop(k1, k2), np.geomspace(1e-5, 1.0, 25)
    errors = []
    for interval in (2e-4, 1e-4):
        pairs = zip(loop.responses(f, interval), loop.responses(f), strict=True)
        errors.append(max(np.abs(sampled / exact - 1).max() for sampled, exact in pairs))
    assert errors[0] < 2e-3
    assert errors[1] == pytest.approx(errors[0] / 2, rel=0.05)  # of first order in the interval
