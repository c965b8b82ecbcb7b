"""Estimators of a constant rate against their referees, and what they refuse."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.linalg import toeplitz
from tests.reference import rate as referee
from tests.rows import paired, refused, rows

import allanite as al
from allanite.applications.constant_rate import (
    RATE_ESTIMATORS,
    EstimatorSettings,
    estimate,
    predicted_standard_error,
    rank,
)
from allanite.applications.constant_rate.linear import white_and_angle
from allanite.applications.constant_rate.row import Task, without_dither
from allanite.applications.constant_rate.run import task_of

ARCSEC = math.pi / 180 / 3600
WHITE = al.N(3e-3, "deg/sqrt(h)")
MODELS = {"N": WHITE, "Q": al.Q(0.25, "arcsec"), "QN": al.N(3e-4, "deg/sqrt(h)") + al.Q(0.25, "arcsec"),
          "B": al.B(0.01, "deg/h"), "K": al.K(0.02, "deg/h/sqrt(h)"), "NB": WHITE + al.B(0.01, "deg/h"),
          "QNBK": WHITE + al.Q(0.25, "arcsec") + al.B(0.01, "deg/h") + al.K(0.5, "deg/h/sqrt(h)"),
          "QNKR": WHITE + al.Q(0.25, "arcsec") + al.K(0.5, "deg/h/sqrt(h)") + al.R(0.3, "deg/h^2")}  # fmt: skip


def model_of(name):
    found = MODELS[name]
    return found if isinstance(found, al.Model) else al.Model((found,))


def counts(n=4000, rate=100.0, turning=12.3, seed=1):
    angle = turning * np.arange(n + 1) / rate + 0.3 * np.random.default_rng(seed).standard_normal(n + 1)
    pulses = np.diff(np.floor(angle / 0.33)).astype(int)
    return al.Record(pulses, rate=rate, unit="arcsec", kind="count", scale=0.33, name="z")


def linear_weights(method, n, model=WHITE, **choices):
    record = al.Record(np.zeros(n), rate=100.0, unit="deg/h")
    setting = task_of(record, model, choices.pop("target", "mean"), **choices)
    return without_dither(RATE_ESTIMATORS[method].weights(setting), setting, weights=True)


@rows("lines", [1, 2, 25, 300])
def test_conditional_is_the_mean_of_kept_lines(lines):
    record = counts()
    slopes = np.array(referee.lines(record.angle, record.rate, lines))
    found = estimate(record, "conditional", options=EstimatorSettings(lines=lines))
    away = np.abs(slopes - np.median(slopes))
    wanted = slopes[away <= 2 * 1.4826 * np.median(away) * (1 + 1e-9) + 1e-15].mean()
    assert found.value == pytest.approx(wanted, rel=1e-10)
    every = estimate(record, "conditional", options=EstimatorSettings(lines=lines, allowed=1.0))
    assert every.value == pytest.approx(slopes.mean(), rel=1e-12)
    assert every.details["kept"] == 1.0


@rows("method", [m for m in RATE_ESTIMATORS if m != "staircase"])
@rows("n", [3, 4, 50, 1001])
def test_weights_are_unbiased_symmetric_and_sum_to_one(method, n):
    weights = linear_weights(method, n, model_of("QNBK"))
    assert weights.sum() == pytest.approx(1.0, abs=1e-11)
    np.testing.assert_allclose(weights, weights[::-1], atol=1e-8 / n)


@given(st.integers(3, 300), st.floats(1e-6, 1e3))
def test_closed_weights_are_the_dense_ones(n, ratio):
    """q = 1, r = ratio^2: to 1e-12 of the largest weight."""
    r = ratio**2
    C = toeplitz(np.r_[1 + 2 * r, -r, np.zeros(n - 2)])
    found = white_and_angle(n, 2 * math.asinh(0.5 / ratio))
    # the dense solution itself is known to its condition only
    limit = max(1e-12, 2e-16 * np.linalg.cond(C)) * found.max()
    np.testing.assert_allclose(found, referee.best_linear(C), rtol=0, atol=limit)


@rows("rho", [0.01, 0.1, 1.0, 3.0])
def test_closed_weights_to_twelve_digits(rho):
    n = 2000
    r = rho**2 * n
    C = toeplitz(np.r_[1 + 2 * r, -r, np.zeros(n - 2)])
    found = white_and_angle(n, 2 * math.asinh(0.5 / math.sqrt(r)))
    np.testing.assert_allclose(found, referee.best_linear(C), rtol=0, atol=1e-12)


@rows("method", RATE_ESTIMATORS)
def test_nothing_beats_the_optimum(method):
    for model in MODELS.values():
        bound = predicted_standard_error("optimal", model, size=500, rate=100.0)
        options = EstimatorSettings(quantum=0.3 * ARCSEC)
        error = predicted_standard_error(method, model, size=500, rate=100.0, options=options)
        assert math.isnan(error) or error >= bound * (1 - 1e-9)


# a.4 of the plan of these estimators: standard error over the bound against rho = sigma / (N sqrt T), 48000 samples
EFFICIENCY = {"mean": [1.000, 1.001, 1.010, 1.085, 1.724, 4.30, 13.5, 73.6],
              "hamming": [1.167, 1.167, 1.167, 1.168, 1.181, 1.309, 2.29, 11.0],
              "regression": [1.095, 1.095, 1.095, 1.094, 1.091, 1.081, 1.055, 1.001]}  # fmt: skip


@rows("which", range(8))
def test_efficiency_against_rho(which):
    rho = (0, 0.03, 0.1, 0.3, 1, 3, 10, 100)[which]
    T = 120.0
    sigma = rho * WHITE.value * math.sqrt(T)
    model = WHITE + al.Q(sigma, "rad")
    errors = {m: predicted_standard_error(m, model, size=48_000, rate=400.0) for m in (*EFFICIENCY, "optimal")}
    for method, wanted in EFFICIENCY.items():
        assert errors[method] / errors["optimal"] == pytest.approx(wanted[which], rel=0.01)
    # the continuous limit of the bound: N^2 / (T - 2 tc tanh(T / 2 tc))
    tc = rho * math.sqrt(T / 400.0) if rho else 0.0
    lost = 2 * tc * math.tanh(T / (2 * tc)) if tc else 0.0
    if rho <= 3:
        assert errors["optimal"] == pytest.approx(WHITE.value / math.sqrt(T - lost), rel=1e-4)


def test_a_ramp_is_no_error_of_the_mean_but_one_of_the_start():
    model = WHITE + al.R(10.0, "deg/h^2")
    mean, start = (predicted_standard_error("mean", model, size=1000, rate=10.0, target=t) for t in ("mean", "start"))
    assert mean == pytest.approx(predicted_standard_error("mean", WHITE, size=1000, rate=10.0))
    drift = model["R"].value * 99.9 / 2
    assert start == pytest.approx(math.hypot(mean, drift), rel=1e-3)
    # the optimal weights do not see the ramp at all, and pay for it
    assert predicted_standard_error("optimal", model, size=1000, rate=10.0, target="start") == pytest.approx(
        2 * mean, rel=2e-3
    )


@rows("method, frequency", paired(list(RATE_ESTIMATORS), [30.37, 412.7]))
def test_dither_is_taken_out_exactly(method, frequency):
    n, rate = 4001, 400.0
    t = np.arange(n + 1) / rate
    angle = 12.4 * t + 5.0 * np.sin(2 * np.pi * frequency * t + 0.4)
    record = al.Record(angle, rate=rate, unit="arcsec", kind="angle")
    options = EstimatorSettings(quantum=0.01)
    found = estimate(record, method, model=MODELS["QN"], dither=(frequency,), options=options)
    assert found.to("deg/h") == pytest.approx(12.4, abs=1e-9 if method != "staircase" else 1e-3)


def test_dither_costs_the_methods_what_is_predicted():
    weights = linear_weights("mean", 500, dither=(13.3,))
    wave = np.cos(2 * np.pi * 13.3 * np.arange(500) / 100 + 1.0)
    assert weights.sum() == pytest.approx(1.0)
    assert abs(weights @ wave) < 1e-12
    assert np.abs(linear_weights("mean", 500) @ wave) > 1e-5
    optimal = linear_weights("optimal", 500, model_of("QNBK"), dither=(13.3,))
    assert abs(optimal @ wave) < 1e-10


@rows("frequency", [0.0, -1.0, math.nan, 400.0, 800.001, 0.05])
def test_dither_that_cannot_be_told_from_a_rate_is_refused(frequency):
    record = al.Record(np.ones(4000), rate=400.0, unit="deg/h")
    refused(al.UsageError, "dither", lambda: estimate(record, "mean", dither=(frequency,)))


@rows("method", RATE_ESTIMATORS)
def test_counts_increments_angle_and_rate_are_the_same_data(method):
    record = counts(1000)
    steps = record.values * 0.33
    options = EstimatorSettings(quantum=0.33)
    same = [(al.Record(steps, rate=100.0, unit="arcsec", kind="increment"), options),
            (al.Record(np.r_[7.0, 7.0 + np.cumsum(steps)], rate=100.0, unit="arcsec", kind="angle"), options),
            (al.Record(steps * 100, rate=100.0, unit="arcsec/s", kind="rate"), options)]  # fmt: skip
    wanted = estimate(record, method, model=MODELS["QN"])
    for other, chosen in same:
        found = estimate(other, method, model=MODELS["QN"], options=chosen)
        assert found.value == pytest.approx(wanted.value, rel=1e-9)
        assert found.standard_error == pytest.approx(wanted.standard_error, rel=1e-9)


BAD = {"a reading that is no number": (lambda: ([1.0, math.nan, 2.0], "mean", {}), al.DataError, "1 of 3 samples"),
       "infinity": (lambda: ([1.0, math.inf, 2.0, 3.0], "mean", {}), al.DataError, "first at sample 1"),
       "two samples": (lambda: ([1.0, 2.0], "mean", {}), al.UsageError, "at least 3 samples"),
       "an unknown method": (lambda: (np.ones(9), "median", {}), al.UsageError, "Known rate estimators: mean, hamming"),
       "an unknown target": (lambda: (np.ones(9), "mean", {"target": "end"}), al.UsageError,
                             "known targets: mean, constant"),
       "too many lines": (lambda: (np.ones(9), "conditional", {"options": EstimatorSettings(lines=9)}), al.UsageError,
                          "do not fit into 9 samples"),
       "an unknown window": (lambda: (np.ones(9), "hamming", {"options": EstimatorSettings(window="x")}), al.UsageError,
                             "hann"),
       "no model": (lambda: (np.ones(9), "optimal", {}), al.UsageError, "it needs a noise model"),
       "the constant of a drift": (lambda: (np.ones(9), "optimal", {"model": MODELS["K"], "target": "constant"}),
                                   al.UsageError, "drift is unbounded"),
       "no quantum": (lambda: (np.ones(9), "staircase", {}), al.UsageError, "quantum="),
       "a model of another sensor": (lambda: (np.ones(9), "mean", {"model": al.N(1.0, "m/s/sqrt(h)")}), al.UnitError,
                                     "accelerometer")}  # fmt: skip


@rows("what", BAD)
def test_bad_input_is_named(what):
    make, error, words = BAD[what]
    values, method, choices = make()
    refused(error, words, lambda: estimate(al.Record(values, rate=1.0, unit="deg/h", name="z"), method, **choices))


def test_dead_stuck_and_slipped_outputs_are_named():
    dead = al.Record(np.zeros(500, dtype=int), rate=100.0, unit="arcsec", kind="count", scale=0.33)
    for method in RATE_ESTIMATORS:
        found = estimate(dead, method, model=MODELS["QN"])
        assert abs(found.to("deg/h")) <= (0.067 if method == "staircase" else 0)
        assert [f.name for f in found.findings] == ["dead"]
    record = counts()
    values = record.values.copy()
    values[1234] += 500
    slipped = al.Record(values, rate=100.0, unit="arcsec", kind="count", scale=0.33)
    (finding,) = estimate(slipped, "mean").findings
    assert finding.name == "slip"
    assert "sample 1234" in finding.what
    stuck = al.Record(np.full(5000, 7), rate=100.0, unit="arcsec", kind="count", scale=0.33)
    assert [f.name for f in estimate(stuck, "mean").findings] == ["constant"]
    assert estimate(record, "mean").findings == ()


def test_the_value_says_what_it_is():
    found = estimate(counts(), "optimal", model=MODELS["QN"])
    low, high = found.interval(0.95)
    assert (high - low) / 2 == pytest.approx(1.959964 * found.standard_error, rel=1e-6)
    assert found.to("deg/h") == pytest.approx(found.value / ARCSEC)
    data = found.to_dict()
    assert (data["type"], data["shown"]["value"]) == ("RateEstimate", pytest.approx(12.3, abs=0.1))
    refused(al.UnitError, "not a unit of the gyro", lambda: found.to("deg"))
    refused(al.UsageError, "between 0 and 1", lambda: found.interval(95))
    assert "no standard error" in estimate(counts(), "mean").words()
    record = al.Record(np.random.default_rng(1).standard_normal(1000) + 5, rate=10.0, unit="ug")
    found = estimate(record, "mean", model=al.N(0.01, "m/s/sqrt(h)"))
    assert found.words().endswith(" ug")
    assert found.to("ug") == pytest.approx(5.0, abs=0.2)


def test_the_ranking_says_which_method_to_use():
    white = rank(WHITE, size=48_000, rate=400.0)
    assert white.verdict == "for this gyro averaging is already within 0.1 % of the optimum"
    assert white.rows()[1][0][0] in ("mean", "optimal")
    angle = rank(MODELS["QN"], size=48_000, rate=400.0, options=EstimatorSettings(quantum=0.33 * ARCSEC))
    assert angle.verdict.startswith("use optimal: 2.0")
    assert rank(MODELS["Q"], size=48_000, rate=400.0).verdict.startswith("use regression: ")
    assert angle.to_dict()["verdict"] == angle.verdict
    assert list(angle.errors) == list(RATE_ESTIMATORS)
    setting = Task(10, 1.0, model_of("QNKR"))
    assert ([t.symbol for t in setting.wandering], [t.symbol for t in setting.settled]) == (["K", "R"], ["N", "Q"])
