"""What is read off a curve without a model, and the deviation of means."""

import math

import numpy as np
import pytest
from tests.rows import refused, rows

import allanite as al
from allanite.core.readings import FLICKER, Slope

NOISE = {"N": al.N(1.0, "rad/sqrt(s)"), "B": al.B(1.0, "rad/s"), "K": al.K(0.1, "rad/s^1.5")}


def record_of(y, rate=10.0):
    return al.Record(y, rate=rate, unit="rad/s", kind="rate", name="z")


def white(seed, n=2000, rate=10.0):
    return record_of(np.random.default_rng(seed).standard_normal(n), rate)


def test_the_usual_point_is_that_of_the_curve_at_one_second_and_stability_that_of_the_means():
    record = white(1)
    found, curve = al.readings(record), al.deviation(record, taus=(1.0,), noise="auto")
    assert (found.usual.tau, found.usual.deviation) == (1.0, curve.deviation[0])
    assert found.usual.interval(0.9) == tuple(v[0] for v in curve.interval(0.9))
    assert found.random_walk == found.usual.deviation
    assert found.white
    (means,) = found.means
    assert (means.seconds, means.count) == (10.0, 20)
    assert means.value == al.averaging_stability(record, 10.0).value


@rows(("rate", "n", "tau"), [(0.1, 2000, 10.0), (99.317, 2000, 99 / 99.317), (1000.0, 500, 0.05)])
def test_where_there_is_no_second_the_nearest_is_taken(rate, n, tau):
    found = al.readings(white(2, n, rate))
    assert found.usual.tau == pytest.approx(tau)
    assert found.random_walk == pytest.approx(found.usual.deviation * math.sqrt(found.usual.tau))
    assert f"deviation at {found.usual.tau:.4g} s" in [q.title for q in found.quantities()]


def test_a_curve_of_another_slope_gives_no_random_walk():
    found = al.readings(record_of(np.cumsum(np.random.default_rng(3).standard_normal(5000))))
    assert not found.white
    assert found.around.value == pytest.approx(0.5, abs=0.1)
    remark = next(q.remark for q in found.quantities() if q.title == "as angle random walk")
    assert remark.endswith("there, not -0.5: not valid")


def test_the_minimum_is_that_of_the_crossing_or_only_a_limit():
    model = al.N(1.0, "rad/sqrt(s)") + al.K(0.05, "rad/s^1.5")
    record = al.simulate(model, 200_000, 1.0, rng=np.random.default_rng(1))
    found = al.minimum(al.deviation(record, "oadev", taus="log", noise=model))
    assert found.inside
    assert found.tau == pytest.approx(math.sqrt(3) / 0.05, rel=0.5)
    assert found.value == pytest.approx(math.sqrt(2 * 0.05 / math.sqrt(3)) * FLICKER, rel=0.1)
    assert al.readings(record).inside
    assert not al.minimum(al.deviation(white(1, 5000, 1.0), noise=NOISE["N"] + NOISE["B"])).inside
    falling = al.readings(white(12))
    assert not falling.inside
    assert falling.bias_instability == pytest.approx(falling.minimum.deviation / 0.66428, rel=1e-5)
    assert "still falling" in falling.quantities()[2].remark


def test_slopes_go_by_decades_of_seconds_with_limits_around_them():
    found = al.readings(white(6, 50_000, 40.0))
    assert [slope.start for slope in found.slopes] == [0.025, 0.1, 1.0, 10.0]
    assert [slope.end for slope in found.slopes[:-1]] == [slope.start for slope in found.slopes[1:]]
    low, high = Slope(1.0, 4.0, -0.5, 0.1).interval(0.95)
    assert (low, high) == pytest.approx((-0.5 - 1.96 * 0.1, -0.5 + 1.96 * 0.1), abs=1e-4)


@pytest.mark.slow("ensemble")
def test_intervals_hold_what_is_expected():
    """The deviation at 1 s and the slopes of white noise, in 300 records."""
    held = np.zeros(3)
    for seed in range(300):
        found = al.readings(white(100 + seed))
        limits = [found.usual.interval(0.9), *(slope.interval(0.9) for slope in found.slopes[:2])]
        held += [
            low <= wanted <= high for (low, high), wanted in zip(limits, (math.sqrt(0.1), -0.5, -0.5), strict=True)
        ]
    assert np.all(held / 300 > 0.86)
    assert np.all(held / 300 < 0.97)


def test_lost_readings_do_not_end_the_curve():
    y = np.random.default_rng(8).standard_normal(3000)
    whole = al.readings(record_of(y))
    y[::150] = np.nan
    assert al.readings(record_of(y)).minimum.tau > whole.minimum.tau / 2


@pytest.mark.slow("long records")
def test_lost_readings_in_every_mean_end_nothing_but_the_means():
    y = np.random.default_rng(8).standard_normal(60_000)
    y[::50] = np.nan
    record = al.Record(y, rate=100.0, unit="deg/h")
    assert al.readings(record).means == ()
    assert al.analyze(record).channels[0].noise is not None
    refused(al.DataError, "touches a gap", lambda: al.averaging_stability(record, 10.0))
    assert al.averaging_stability(record, 0.25).blocks == 1200


def test_numbers_are_in_units_of_data_sheets_and_in_si():
    data = al.readings(white(9)).to_dict(0.9)
    first, second = data["shown"][:2]
    assert first["unit"] == "deg/h"
    assert first["value"] == pytest.approx(math.degrees(data["usual"]["deviation"]) * 3600)
    assert (second["unit"], second["value"]) == ("deg/sqrt(h)", pytest.approx(math.degrees(data["random_walk"]) * 60))
    assert first["low"] == pytest.approx(math.degrees(data["usual"]["low"]) * 3600)


def test_stability_is_the_standard_deviation_of_whole_block_means():
    y = np.random.default_rng(1).standard_normal(1003)
    found = al.averaging_stability(record_of(y), 2.5)
    assert found.value == pytest.approx(y[:1000].reshape(40, 25).mean(axis=1).std(ddof=1))
    assert (found.blocks, found.duration, found.seconds) == (40, 100.3, 2.5)
    y = np.random.default_rng(1).standard_normal(100)
    y[33] = np.nan
    found = al.averaging_stability(record_of(y, 1.0), 10.0, model=NOISE["N"] + NOISE["K"])
    means = np.delete(y.reshape(10, 10).mean(axis=1), 3)
    assert (found.value, found.blocks) == (pytest.approx(means.std(ddof=1)), 9)
    record = record_of(np.arange(30.0), 1.0)
    refused(al.UsageError, "not a multiple of the sample interval", lambda: al.averaging_stability(record, 2.5))
    refused(al.DataError, "longest possible time is 15 s", lambda: al.averaging_stability(record, 20.0))


@rows(("symbol", "exact"), [("N", 1 / 10), ("K", 0.01 * 10 / 3 * 36 / 2)])
def test_the_expectation_of_stability_has_its_closed_forms(symbol, exact):
    """White noise: N^2/tau; random walk: K/2 of the Allan variance, K the number of means."""
    found = al.averaging_stability(record_of(np.arange(360.0), 1.0), 10.0, model=al.Model((NOISE[symbol],)))
    assert found.expected**2 == pytest.approx(exact, rel=1e-9)


@rows("symbols", ["N", "B", "NK"])
def test_stability_agrees_with_its_expectation(symbols):
    """400 records, seeds 1..400: the mean square within 5 standard errors, missed once in a million tests."""
    model, squares = al.Model(tuple(NOISE[s] for s in symbols)), []
    for seed in range(1, 401):
        record = al.simulate(model, 320, 1.0, rng=np.random.default_rng(seed))
        found = al.averaging_stability(record, 10.0, model=model)
        squares.append((found.value / found.expected) ** 2)
    assert abs(np.mean(squares) - 1) < 5 * np.std(squares) / 20
