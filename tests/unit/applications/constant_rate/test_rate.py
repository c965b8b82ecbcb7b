"""Estimators of a constant rate against their referees, and what they refuse."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.linalg import toeplitz
from tests.reference import rate as referee
from tests.rows import paired, refused, rows

import allanite as al
from allanite.applications.constant_rate import RATE_ESTIMATORS, EstimatorSettings, estimate
from allanite.applications.constant_rate.linear import white_and_angle
from allanite.applications.constant_rate.predict import predicted_standard_error, rank

ARCSEC = math.pi / 180 / 3600
MODELS = {name: al.Model(text) for name, text in {
    "N": "N 3e-3 deg/sqrt(h)", "Q": "Q 0.25 arcsec", "QN": "N 3e-4 deg/sqrt(h), Q 0.25 arcsec",
    "K": "K 0.02 deg/h/sqrt(h)", "QNBK": "N 3e-3 deg/sqrt(h), Q 0.25 arcsec, B 0.01 deg/h, K 0.5 deg/h/sqrt(h)",
}.items()}  # fmt: skip


def counts(n=4000, rate=100.0, turning=12.3, seed=1):
    angle = turning * np.arange(n + 1) / rate + 0.3 * np.random.default_rng(seed).standard_normal(n + 1)
    pulses = np.diff(np.floor(angle / 0.33)).astype(int)
    return al.Record(pulses, rate=rate, unit="arcsec", kind="count", scale=0.33, name="z")


@rows("lines", [1, 2, 25, 300])
def test_conditional_is_the_mean_of_kept_lines(lines):
    record = counts()
    slopes = np.array(referee.lines(record.angle, record.rate, lines))
    found = estimate(record, "conditional", options=EstimatorSettings(lines=lines))
    away = np.abs(slopes - np.median(slopes))
    wanted = slopes[away <= 2 * 1.4826 * np.median(away) * (1 + 1e-9) + 1e-15].mean()
    assert found.value == pytest.approx(wanted, rel=1e-10)
    every = estimate(record, "conditional", options=EstimatorSettings(lines=lines, allowed=1.0))
    assert (every.value, every.details["kept"]) == (pytest.approx(slopes.mean(), rel=1e-12), 1.0)


@rows("method", [m for m in RATE_ESTIMATORS if m != "staircase"])
@rows("n", [3, 4, 50, 1001])
def test_a_rate_without_noise_is_given_back(method, n):
    record = al.Record(np.full(n, 7.0), rate=100.0, unit="deg/h")
    assert estimate(record, method, model=MODELS["QNBK"]).to("deg/h") == pytest.approx(7.0, rel=1e-11)


@given(st.integers(3, 300), st.floats(1e-6, 1e3))
def test_closed_weights_are_the_dense_ones(n, ratio):
    """q = 1, r = ratio^2: to 1e-12 of the largest weight."""
    r = ratio**2
    C = toeplitz(np.r_[1 + 2 * r, -r, np.zeros(n - 2)])
    found = white_and_angle(n, 2 * math.asinh(0.5 / ratio))
    # the dense solution itself is known to its condition only
    limit = max(1e-12, 2e-16 * np.linalg.cond(C)) * found.max()
    np.testing.assert_allclose(found, referee.best_linear(C), rtol=0, atol=limit)


@rows("rho", (0, 0.03, 0.1, 0.3, 1, 3))
def test_the_bound_of_many_samples_is_its_continuous_limit(rho):
    """N^2 / (T - 2 tc tanh(T / 2 tc)), where rho is sigma / (N sqrt T)."""
    T, N = 120.0, MODELS["N"]["N"].value
    tc = rho * math.sqrt(T / 400.0)
    lost = 2 * tc * math.tanh(T / (2 * tc)) if tc else 0.0
    error = predicted_standard_error(
        "optimal", MODELS["N"] + al.Q(rho * N * math.sqrt(T), "rad"), size=48_000, rate=400.0
    )
    assert error == pytest.approx(N / math.sqrt(T - lost), rel=1e-4)


@rows("method, frequency", paired(list(RATE_ESTIMATORS), [30.37, 412.7]))
def test_dither_is_taken_out_exactly(method, frequency):
    n, rate = 4001, 400.0
    t = np.arange(n + 1) / rate
    angle = 12.4 * t + 5.0 * np.sin(2 * np.pi * frequency * t + 0.4)
    record = al.Record(angle, rate=rate, unit="arcsec", kind="angle")
    options = EstimatorSettings(quantum=0.01)
    found = estimate(record, method, model=MODELS["QN"], dither=(frequency,), options=options)
    assert found.to("deg/h") == pytest.approx(12.4, abs=1e-9 if method != "staircase" else 1e-3)


@rows("method", ["mean", "hamming", "regression", "optimal"])
def test_dither_costs_the_methods_what_is_predicted(method):
    how = {"model": MODELS["N"], "dither": (13.3,)}
    made = referee.weights(lambda y: estimate(al.Record(y, 100.0, "rad/s"), method, **how).value, 60)
    assert abs(made @ np.cos(2 * np.pi * 13.3 * np.arange(60) / 100 + 1.0)) < 1e-12
    error = MODELS["N"]["N"].value * 10 * np.linalg.norm(made)
    assert predicted_standard_error(method, size=60, rate=100.0, **how) == pytest.approx(error, rel=1e-9)


@rows("frequency", [0.0, -1.0, math.nan, 400.0, 800.001, 0.05])
def test_dither_that_cannot_be_told_from_a_rate_is_refused(frequency):
    record = al.Record(np.ones(4000), rate=400.0, unit="deg/h")
    refused(al.UsageError, "dither", lambda: estimate(record, "mean", dither=(frequency,)))


BAD = [
    ([1.0, math.nan, 2.0], "mean", {}, "1 of 3 samples"), ([1.0, math.inf, 2.0, 3.0], "mean", {}, "first at sample 1"),
    ([1.0, 2.0], "mean", {}, "at least 3 samples"),
    (np.ones(9), "median", {}, "Known rate estimators: mean, hamming"),
    (np.ones(9), "mean", {"target": "end"}, "known targets: mean, constant"),
    (np.ones(9), "conditional", {"options": EstimatorSettings(lines=9)}, "do not fit into 9 samples"),
    (np.ones(9), "hamming", {"options": EstimatorSettings(window="x")}, "hann"),
    (np.ones(9), "optimal", {}, "it needs a noise model"), (np.ones(9), "staircase", {}, "quantum="),
    (np.ones(9), "optimal", {"model": MODELS["K"], "target": "constant"}, "drift is unbounded"),
    (np.ones(9), "mean", {"model": al.N(1.0, "m/s/sqrt(h)")}, "accelerometer"),
]  # fmt: skip


@rows("values, method, choices, words", BAD)
def test_bad_input_is_named(values, method, choices, words):
    record = al.Record(values, rate=1.0, unit="deg/h", name="z")
    refused(al.AllaniteError, words, lambda: estimate(record, method, **choices))


def test_dead_stuck_and_slipped_outputs_are_named():
    def counted(values):
        return al.Record(values, rate=100.0, unit="arcsec", kind="count", scale=0.33)

    for method in RATE_ESTIMATORS:
        found = estimate(counted(np.zeros(500, dtype=int)), method, model=MODELS["QN"])
        assert abs(found.to("deg/h")) <= (0.067 if method == "staircase" else 0)
        assert [f.name for f in found.findings] == ["dead"]
    values = counts().values
    (finding,) = estimate(counted(values + 500 * (np.arange(values.size) == 1234)), "mean").findings
    assert (finding.name, "sample 1234" in finding.what) == ("slip", True)
    assert [f.name for f in estimate(counted(np.full(5000, 7)), "mean").findings] == ["constant"]
    assert estimate(counts(), "mean").findings == ()


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
    white = rank(MODELS["N"], size=48_000, rate=400.0)
    assert white.verdict == "for this gyro averaging is already within 0.1 % of the optimum"
    assert white.rows()[1][0][0] in ("mean", "optimal")
    angle = rank(MODELS["QN"], size=48_000, rate=400.0, options=EstimatorSettings(quantum=0.33 * ARCSEC))
    assert angle.verdict.startswith("use optimal: 2.0")
    assert rank(MODELS["Q"], size=48_000, rate=400.0).verdict.startswith("use regression: ")
    assert angle.to_dict()["verdict"] == angle.verdict
    assert list(angle.errors) == list(RATE_ESTIMATORS)
