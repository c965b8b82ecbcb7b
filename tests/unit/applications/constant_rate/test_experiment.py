"""The experiment's intervals and gaps, bias, reversal, the earth, north, and the simulated ring laser."""

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.reference.rate import turnaround_kick
from tests.rows import refused, rows

import allanite as al
from allanite.applications.constant_rate import EstimatorSettings, ExperimentSettings, estimate, experiment
from allanite.applications.constant_rate.campaign import measure_rates
from allanite.applications.constant_rate.earth import earth_rate, north
from allanite.applications.constant_rate.estimates import reversal, subtract_bias
from allanite.simulation.record import GL1, RingLaser

DEG_H = math.pi / 180 / 3600
MODEL = al.N(0.01, "deg/sqrt(h)") + al.Q(0.2, "arcsec")


def white(n=1000, mean=10.0, seed=1, rate=10.0):
    values = mean + 2.0 * np.random.default_rng(seed).standard_normal(n)
    return al.Record(values, rate=rate, unit="deg/h", name="z")


def test_intervals_fill_the_record_but_for_its_end():
    means = ExperimentSettings(interval=10.0, methods=("mean",))
    found = experiment(white(1050), MODEL, means)
    assert found.start.tolist() == [10.0 * i for i in range(10)]
    assert found.notes == ("5 s of 105 s do not fill an interval and are omitted",)
    np.testing.assert_allclose(found.rates[0] / DEG_H, white(1050).values[:1000].reshape(10, 100).mean(axis=1))
    found = experiment(white(100), MODEL, replace(means, interval=120.0, methods=("mean", "optimal")))
    assert (found.rates.shape, found.duration) == ((2, 1), 10.0)
    assert math.isnan(found.scatter("mean").deviation)
    single, triple = (
        experiment(white(), MODEL, replace(means, methods=("conditional",), options=EstimatorSettings(lines=lines)))
        for lines in (1, 3)
    )
    assert not np.allclose(triple.rates, single.rates, rtol=1e-12)


@rows("kind, unit", [("rate", "deg/h"), ("angle", "arcsec")])
def test_gaps_are_an_error_or_split_the_record(kind, unit):
    values = white().values.copy() if kind == "rate" else np.r_[0, np.cumsum(white().values) / 10]
    values[[250, 251, 700]] = np.nan
    broken = al.Record(values, rate=10.0, unit=unit, kind=kind, name="z")
    refused(al.DataError, r"first at sample 250", lambda: experiment(broken, MODEL, ExperimentSettings(interval=10.0)))
    found = experiment(broken, MODEL, ExperimentSettings(interval=10.0, methods=("mean",), gaps="split"))
    np.testing.assert_allclose(found.start, [0, 10, 25.2, 35.2, 45.2, 55.2, 70.1, 80.1])
    assert np.isfinite(found.rates).all()
    assert "3 samples missing" in found.notes[0]
    longer = ExperimentSettings(interval=60.0, gaps="split")
    refused(al.DataError, "no interval of 60 s", lambda: experiment(broken, MODEL, longer))


def test_errors_are_counted_from_the_reference_and_useless_methods_named():
    known = experiment(white(), MODEL, ExperimentSettings(interval=10.0, reference=9.0 * DEG_H, bias=0.5 * DEG_H))
    free = experiment(white(), MODEL, ExperimentSettings(interval=10.0))
    np.testing.assert_allclose(known.errors / DEG_H, free.rates / DEG_H - 9.5)
    assert free.errors[-1].mean() == pytest.approx(0.0, abs=1e-18)
    data = known.to_dict()
    assert (data["reference_known"], len(data["methods"][0]["rates"])) == (True, 10)
    found = experiment(white(), None, ExperimentSettings(interval=10.0))
    assert found.methods == ("mean", "hamming", "regression", "conditional")
    assert "noise model" in found.left_out["optimal"]
    assert "quantum" in found.left_out["staircase"]
    assert np.isnan(found.predicted).all()
    assert found.ranking is None
    optimal = ExperimentSettings(methods=("optimal",))
    refused(al.UsageError, "optimal: it needs a noise model", lambda: experiment(white(), None, optimal))


def mean_rate(mean=10.0, seed=1):
    return estimate(white(mean=mean, seed=seed), "mean", model=MODEL)


def test_a_bias_is_subtracted():
    """12.335042 less a bias of -0.0948 is 12.4298; the vertical earth rate there is that of Moscow."""
    raw = replace(mean_rate(), value=12.335042 * DEG_H, limits=(12.33 * DEG_H, 12.34 * DEG_H))
    found = subtract_bias(raw, -0.0948, "deg/h")
    assert (found.to("deg/h"), found.limits[0] / DEG_H) == (pytest.approx(12.429842), pytest.approx(12.4248))
    assert "bias of -0.0948 deg/h subtracted" in found.history
    worse = subtract_bias(raw, -0.0948, "deg/h", standard_error=0.001)
    assert worse.standard_error == pytest.approx(math.hypot(raw.standard_error, 0.001 * DEG_H))
    assert worse.limits is None
    refused(al.UsageError, "bias must be between", lambda: subtract_bias(raw, math.nan, "deg/h"))
    with pytest.raises(al.UnitError):
        subtract_bias(raw, 1.0, "deg")


def test_a_bias_is_removed_by_reversal():
    up, down = mean_rate(12.4 + 0.7, 1), mean_rate(-12.4 + 0.7, 2)
    rate, bias = reversal(up, down)
    assert rate.to("deg/h") == pytest.approx(12.4, abs=4 * rate.standard_error / DEG_H)
    assert bias.to("deg/h") == pytest.approx(0.7, abs=4 * rate.standard_error / DEG_H)
    assert rate.standard_error == pytest.approx(up.standard_error / math.sqrt(2))
    assert rate.duration == 200.0
    refused(al.UsageError, "one target", lambda: reversal(up, replace(down, target="start")))


def test_earth_rate():
    assert earth_rate(90.0) == pytest.approx(15.041067 * DEG_H, rel=1e-6)
    assert earth_rate(-90.0) == -earth_rate(90.0)
    assert earth_rate(60.0, "north") == pytest.approx(earth_rate(30.0))
    assert earth_rate(0.0) == 0.0


def position(heading, latitude, bias=0.0, error=1e-3):
    value = earth_rate(latitude, "north") * math.cos(math.radians(heading)) + bias * DEG_H
    return replace(mean_rate(), value=value, standard_error=error * DEG_H)


@rows("heading", [10.0, 60.0, 90.0, 135.0, 225.0, 300.0, 350.0])
@rows("latitude", [0.0, 55.8, -70.0])
def test_one_position_finds_north(heading, latitude):
    found = north(position(heading, latitude), latitude, near=heading + 5)
    assert found.heading == pytest.approx(heading, abs=1e-6)
    assert found.other == pytest.approx(360 - heading, abs=1e-6)
    sensitive = earth_rate(latitude, "north") * abs(math.sin(math.radians(heading)))
    assert found.standard_error == pytest.approx(math.degrees(1e-3 * DEG_H / sensitive), rel=1e-6)
    assert found.low < heading < found.high
    assert found.positions == 1


@pytest.mark.slow("takes more than half a second")
def test_limits_of_north_hold_beside_the_largest_rate():
    """Where the cosine bends, too: 95 % of 2000 draws within 1.5 % (three standard errors)."""
    rng, error, held = np.random.default_rng(571), 0.002, []
    H, model = earth_rate(50.0, "north"), mean_rate()
    for heading in (0.0, 1.0, 3.0, 20.0, 179.0):
        for z in error * rng.standard_normal(400):
            value = np.clip(math.cos(math.radians(heading)) + z, -1 - 1.9 * error, 1 + 1.9 * error)
            limits = north(replace(model, value=H * value, standard_error=error * H), 50.0, near=heading)
            held.append(any(limits.low <= psi <= limits.high for psi in (heading, heading + 360)))
        assert np.mean(held[-400:]) > 0.92, heading
    assert np.mean(held) == pytest.approx(0.95, abs=0.015)


@rows("turned", [180.0, 90.0, -90.0, 150.0])
@rows("heading", [75.0, 100.0, 200.0, 290.0])
def test_two_positions_find_north_whatever_the_bias(heading, turned):
    def positions(heading):
        return [position(h, 55.8, bias=0.7) for h in (heading, heading + turned)]

    first, second = positions(heading)
    found = north(first, 55.8, second=second, turned=turned, near=heading)
    assert (found.heading, found.positions) == (pytest.approx(heading, abs=1e-6), 2)
    more, other = positions(heading + 1e-4)
    slope = abs((more.value - other.value) - (first.value - second.value)) / 1e-4
    assert found.standard_error == pytest.approx(math.sqrt(2) * 1e-3 * DEG_H / slope, rel=1e-3)


def test_what_gives_no_heading_is_refused():
    refused(al.UsageError, "at a pole there is no north", lambda: north(position(30.0, 90.0), 90.0))
    refused(al.DataError, "earth turns", lambda: north(position(0.0, 55.8, bias=1.0), 55.8))
    here = position(30.0, 50.0)
    refused(al.UsageError, "is no rotation", lambda: north(here, 50.0, second=here, turned=360.0))
    flat = north(replace(here, value=earth_rate(55.8, "north")), 55.8, near=0.0)
    assert flat.standard_error == math.inf
    assert flat.low < flat.high
    accelerometer = estimate(al.Record(np.ones(9), rate=1.0, unit="ug"), "mean")
    refused(al.UsageError, "a gyro", lambda: north(accelerometer, 50.0))


@pytest.mark.slow("ensemble")
def test_lock_in_makes_the_random_walk_that_is_claimed():
    """The kick at a turning point by Runge-Kutta over 2000 phases: rms within 3 % of Omega_L' sqrt(pi / psi'')."""
    K, f = math.radians(0.32795 / 3600), 400.0
    lock_in, dither = 46.0 * DEG_H, 100.0 * math.pi / 180
    phases = 2 * math.pi * np.arange(2000) / 2000
    kicks = turnaround_kick((K, lock_in, dither, 2 * math.pi * f), phases, steps=12_000)
    bend = 2 * math.pi / K * dither * 2 * math.pi * f
    size = 2 * math.pi / K * lock_in * math.sqrt(math.pi / bend)
    assert np.sqrt(np.square(kicks).mean()) == pytest.approx(size, rel=0.03)
    # two independent kicks a period, K / 2 pi of angle each
    gyro = RingLaser(pulse=0.32795, lock_in=46.0, dither_rate=100.0)
    assert gyro.model["N"].value == pytest.approx(K / (2 * math.pi) * size * math.sqrt(2 * f), rel=1e-6)


def test_the_bias_of_a_ring_laser_warms_up_and_wanders_as_told():
    quiet = RingLaser(pulse=0.001, lock_in=0.0, warm_up=-5.0, settling=10.0)
    record = al.simulation.simulate_ring_laser(quiet, 100.0, 10_000, 200.0, rng=1)
    t = np.arange(10_001) / 200
    angle = np.r_[0, np.cumsum(record.values)] * 0.001
    np.testing.assert_allclose(angle, 100 * t - 50 * (1 - np.exp(-t / 10)), atol=0.002)
    gyro = RingLaser(pulse=0.001, lock_in=0.0, swing=al.Model("K 100 deg/h/sqrt(h)"))
    assert [t.symbol for t in gyro.model] == ["Q", "K"]
    fit = al.identify(al.simulation.simulate_ring_laser(gyro, 0.0, 20_000, 200.0, rng=1), terms="QNK")
    assert fit["K"].to("deg/h/sqrt(h)") == pytest.approx(100.0, rel=0.5)


REFUSED = [
    (lambda: ExperimentSettings(gaps="fill"), "'error' or 'split'"),
    (lambda: ExperimentSettings(methods=("median",)), "unknown rate estimator"),
    (lambda: replace(GL1, pulse=0.0), "pulse must be between 1e-30"),
    (lambda: replace(GL1, lock_in=-1.0), "lock_in must be between 0"),
    (lambda: replace(GL1, residual_band=(40.0, 30.0)), "ascending"),
    (lambda: al.simulation.simulate_ring_laser(GL1, 1.0, 100, 50.0, rng=1), "needs more than 50 Hz"),
    (lambda: al.simulation.simulate_ring_laser(GL1, 1.0, 1, 400.0, rng=1), "between 2 and"),
    *((lambda wrong=wrong: earth_rate(wrong), "between -90 and 90") for wrong in (91.0, -100.0, math.nan)),
    (lambda: earth_rate(0.0, "east"), "known directions: vertical, north"),
]  # fmt: skip


@rows("call, words", REFUSED)
def test_impossible_plans_and_gyros_are_refused(call, words):
    refused(al.UsageError, words, call)


@pytest.mark.slow("takes more than half a second")
def test_a_record_too_short_for_its_noise_is_measured_with_care():
    (channel,) = measure_rates(al.simulation.simulate_ring_laser(GL1, 12.4392, 48_000, 400.0, rng=1)).channels
    assert any("assumed at their upper limits" in alert for alert in channel.alerts)
    best = channel.estimates[-1]
    assert best.method == "optimal"
    low, high = (v / DEG_H for v in best.interval())
    assert low < 12.3444 < high
    assert (high - low) / 2 < 0.02


def scattered(deviations, k, rng):
    """An experiment whose methods have these standard deviations, and errors that are correlated by half."""
    common = rng.standard_normal(k)
    rates = np.array([d * (common + rng.standard_normal(k)) / math.sqrt(2) for d in deviations])
    methods = ("mean", "hamming", "regression", "conditional")[: len(deviations)]
    times, nan = np.arange(float(k)), np.full(len(deviations), math.nan)
    return al.constant_rate.Experiment("z", white().signal, methods, times, 1.0, 1.0, rates, 0.0, True, nan)


def test_what_the_scatter_says_holds_for_the_method_that_it_chose():
    """Of 400 experiments at 95 %: the best called worse, and an error beyond the bound of the chosen, in 35 at most."""
    rng = np.random.default_rng(1)
    for k, deviations in ((5, (1, 1, 1, 1)), (15, (1.1, 1, 1, 1.02)), (15, (1, 1))):
        wrong = beyond = 0
        best = int(np.argmin(deviations))
        for _ in range(400):
            found = scattered(deviations, k, rng)
            standings = {s.method: s for s in found.standings()}
            wrong += standings[found.methods[best]].verdict == "worse"
            error = deviations[found.methods.index(found.chosen)] * rng.standard_normal()
            beyond += abs(error) > standings[found.chosen].half
        assert max(wrong, beyond) <= 35, (k, deviations, wrong, beyond)


def test_the_recommendation_of_the_scatter():
    rng = np.random.default_rng(1)
    apart = scattered((1, 5, 4), 15, rng)
    assert [s.verdict for s in apart.standings()] == ["least scatter", "worse", "worse"]
    assert apart.verdict.startswith("use mean: in 15 intervals no other scatters less by more than 2 %; ")
    assert "not certain against" in scattered((1, 1, 1), 15, rng).verdict
    assert scattered((1, 1), 2, rng).verdict.endswith("(interval=0.2)")
    assert [s.verdict for s in scattered((0, 0), 5, rng).standings()] == ["", ""]
    # Student's t of 14 degrees of freedom, at 95 %, and for three methods at once
    alone, three = (apart.half_width("mean", of=m) / apart.scatter("mean").deviation for m in (1, 3))
    assert (alone, three) == (pytest.approx(2.1448, abs=1e-4), pytest.approx(2.7178, abs=1e-4))
