"""What is read off a curve without a model."""

import math

import numpy as np
import pytest
from tests.rows import refused, rows

import allanite as al
from allanite.core.readings import Slope


def record_of(y, rate=10.0):
    return al.Record(y, rate=rate, unit="rad/s", kind="rate", name="z")


def white(seed, n=2000, rate=10.0):
    return record_of(np.random.default_rng(seed).standard_normal(n), rate)


def test_the_usual_point_is_that_of_the_curve_at_one_second_and_stability_that_of_the_means():
    record = white(1)
    found = al.readings(record)
    curve = al.deviation(record, taus=(1.0,), noise="auto")
    assert (found.usual.tau, found.usual.deviation) == (1.0, curve.deviation[0])
    assert found.usual.interval(0.9) == tuple(v[0] for v in curve.interval(0.9))
    assert found.random_walk == found.usual.deviation
    assert found.white
    record = white(7)
    (means,) = al.readings(record).means
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


def test_the_minimum_is_inside_or_only_a_limit():
    rng = np.random.default_rng(4)
    walk = record_of(rng.standard_normal(20_000) + 0.02 * np.cumsum(rng.standard_normal(20_000)))
    assert al.readings(walk).inside
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
        low, high = found.usual.interval(0.9)
        held[0] += low <= math.sqrt(0.1) <= high
        for i, slope in enumerate(found.slopes[:2], 1):
            low, high = slope.interval(0.9)
            held[i] += low <= -0.5 <= high
    assert np.all(held / 300 > 0.86)
    assert np.all(held / 300 < 0.97)


def test_lost_readings_do_not_end_the_curve():
    y = np.random.default_rng(8).standard_normal(3000)
    whole = al.readings(record_of(y))
    y[::150] = np.nan
    found = al.readings(record_of(y))
    assert found.minimum.tau > whole.minimum.tau / 2


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
