"""Recognition of the staircase: the global minimum, the limits of counts without noise."""

import math

import numpy as np
import pytest
from tests import ALL
from tests.reference import rate as referee
from tests.rows import refused, rows

import allanite as al
from allanite.applications.constant_rate import EstimatorSettings, ExperimentSettings, estimate
from allanite.applications.constant_rate.linear import CUBE_ROOT, DITHERED

ARCSEC = math.pi / 180 / 3600
PULSE = 0.33
CERTIFIED = EstimatorSettings(certified=True)


def record_of(pulses, rate=1.0):
    """Counts whose running sum, from 0, is `pulses` less its first."""
    return al.Record(np.diff(pulses).astype(int), rate=rate, unit="arcsec", kind="count", scale=PULSE)


def noisy(n, slope, sigma, seed):
    rng = np.random.default_rng(seed)
    y = np.floor(slope * np.arange(n + 1) + rng.random() + sigma * rng.standard_normal(n + 1))
    return y - y[0]


def slope_of(found, rate=1.0):
    return found.value / (PULSE * ARCSEC * rate)


@rows("block", range(10))
def test_the_certified_search_finds_the_global_minimum(block):
    """200 small cases, seeds 1 to 200: of any slope, with noise of nothing to two pulses."""
    for seed in range(20 * block + 1, 20 * block + 21):
        rng = np.random.default_rng(seed)
        y = noisy(int(rng.integers(8, 40)), rng.uniform(-1.6, 1.6), rng.choice([0.0, 0.05, 0.3, 0.7, 2.0]), seed)
        found = estimate(record_of(y), "staircase", options=CERTIFIED)
        least = referee.global_staircase(y, 8 / len(y))
        assert found.details["misfit"] == least
        assert found.details["least possible misfit"] == least
        # and the slope that is given reaches it, up to what a corner of its cell rounds to
        near = slope_of(found) + np.array([0.0, 1e-9, -1e-9])
        if least > 0:
            assert min(referee.best_phase(y, a) for a in near) == least


@rows("seed", range(1, 11))
def test_counts_without_noise_give_limits_that_are_certain(seed):
    rng = np.random.default_rng(seed)
    slope, phase, n = rng.uniform(-2, 2), rng.random(), int(rng.integers(100, 5000))
    y = np.floor(slope * np.arange(n + 1) + phase)
    found = estimate(record_of(y), "staircase")
    low, high = (v / (PULSE * ARCSEC) for v in found.limits)
    assert found.details["misfit"] == 0
    assert low <= slope <= high
    assert found.interval(0.5) == found.interval(0.999) == found.limits
    # nothing outside the limits draws the same staircase, everything just inside does
    width = high - low
    for a, reaches in ((low, 1e-3), (high, -1e-3)):
        free = y - np.outer([a + reaches * width, a - np.sign(reaches) * width], np.arange(n + 1))
        assert (np.ptp(free, axis=1) < 1).tolist() == [True, False]
    assert width < 8 / n**2 * 40


def test_the_slope_of_few_counts_is_exact():
    """0 1 2 3 could have been counted at any slope from 2/3 to 4/3, and at none else."""
    low, high = (v / (PULSE * ARCSEC) for v in estimate(record_of(np.arange(4)), "staircase").limits)
    assert (low, high) == (pytest.approx(2 / 3), pytest.approx(4 / 3))


@rows("seed", range(1, 21 if ALL else 6))
def test_the_default_search_against_the_certified_one(seed):
    """Records of 48000: within 0.1 %, and never above what a descent reaches."""
    sigma = (0.0, 0.05, 0.5, 1.0, 2.0)[seed % 5]
    y = noisy(48_000, 0.094 + 1e-4 * seed, sigma, seed)
    found, best = (estimate(record_of(y), "staircase", options=o) for o in (EstimatorSettings(), CERTIFIED))
    assert best.details["least possible misfit"] == best.details["misfit"]
    assert best.details["misfit"] <= found.details["misfit"] <= best.details["misfit"] * 1.001
    down = estimate(record_of(y), "staircase", options=EstimatorSettings(descent=100))
    assert found.details["misfit"] <= down.details["misfit"]


@rows(("sigma", "seed"), [(0.3, 1), (1.0, 2), (2.0, 3)])
def test_the_descent_of_the_paper_goes_from_the_count_to_the_line_of_regression(sigma, seed):
    y = noisy(2000, 0.31, sigma, seed)
    mean, regression = (slope_of(estimate(record_of(y), m)) for m in ("mean", "regression"))
    closeup = al.constant_rate.closeup(record_of(y), ExperimentSettings(2000, options=EstimatorSettings(descent=40)))
    path = closeup.descent / (PULSE * ARCSEC)
    direct = referee.descent(y, 40)
    assert path[0] == pytest.approx(direct[0]) == pytest.approx(mean)
    # both end at the line, but for what the steps of the counts do to them, in pulses over the interval
    reach = 4 * CUBE_ROOT * math.hypot(sigma, 1 / math.sqrt(12)) ** (2 / 3) * 2000 ** (-1 / 3)
    assert np.abs(np.array([path[-1], direct[-1]]) - regression).max() * 2000 < reach
    ends = [slope_of(estimate(record_of(y), "staircase", options=EstimatorSettings(descent=n))) for n in (0, 40)]
    assert ends == pytest.approx([path[0], path[-1]])


def test_a_descent_proves_nothing():
    refused(al.UsageError, "proves no optimum", lambda: EstimatorSettings(descent=5, certified=True))


@rows("kind, unit", [("increment", "arcsec"), ("angle", "arcsec"), ("rate", "arcsec/s")])
def test_readings_that_are_no_counts_need_a_quantum(kind, unit):
    y = noisy(500, 0.7, 0.4, 5)
    values = {"increment": np.diff(y), "angle": 7 + y, "rate": np.diff(y) * 100}[kind] * PULSE
    floating = al.Record(values, rate=100.0, unit=unit, kind=kind)
    refused(al.UsageError, "quantum=", lambda: estimate(floating, "staircase"))
    found = estimate(floating, "staircase", options=EstimatorSettings(quantum=PULSE, certified=True))
    wanted = estimate(record_of(y, 100.0), "staircase", options=CERTIFIED)
    assert (found.details["misfit"], found.value) == pytest.approx((wanted.details["misfit"], wanted.value))


def test_what_cannot_be_predicted_is_not():
    def predicted(sigma, method="staircase", **how):
        model = al.N(3e-4, "deg/sqrt(h)") + al.Q(sigma * PULSE, "arcsec")
        return al.constant_rate.predicted_standard_error(method, model, size=48_000, rate=400.0, **how)

    counted = {"options": EstimatorSettings(quantum=PULSE * ARCSEC)}
    assert math.isnan(predicted(0.9 * DITHERED, **counted))
    assert math.isnan(predicted(2 * DITHERED))
    regression = predicted(1.1 * DITHERED, "regression")
    assert regression < predicted(1.1 * DITHERED, **counted) < 1.01 * regression


@pytest.mark.slow("takes more than half a second")
@rows(("n", "sigma"), [(1000, 0.5), (1000, 2.0), (4000, 1.0)])
def test_the_excess_over_regression_is_the_cube_root_law(n, sigma):
    """100 records, seeds 1 to 100: 25 %, three and a half standard errors."""
    off = []
    for seed in range(1, 101):
        record = record_of(noisy(n, 0.31 + 1e-3 * seed, sigma, seed))
        pair = [slope_of(estimate(record, m)) for m in ("staircase", "regression")]
        off.append((pair[0] - pair[1]) * n)
    wanted = CUBE_ROOT * math.hypot(sigma, 1 / math.sqrt(12)) ** (2 / 3) * n ** (-1 / 3)
    assert np.sqrt(np.mean(np.square(off))) == pytest.approx(wanted, rel=0.25)
