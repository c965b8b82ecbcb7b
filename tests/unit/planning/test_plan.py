"""The Cramer-Rao bound against dense matrices, plans made of it, the verb, and properties of statistics."""

import json
import math

import numpy as np
import pytest
from tests.commands import ends, of_verb
from tests.reference import edf as published
from tests.rows import refused, rows

import allanite as al
from allanite.identification.likelihood import spectrum
from allanite.planning.plan import properties
from methods import dense

MODELS = {
    **al.planning.SENSORS, "NBK": "N 1 rad/sqrt(s), B 0.3 rad/s, K 0.1 rad/s^1.5", "QN": "Q 1 rad, N 0.1 rad/sqrt(s)",
    "GM": "N 1 rad/sqrt(s), GM 1 rad/s 5 s, K 0.01 rad/s^1.5",
}  # fmt: skip


@rows("name, n, rate, ramp", [
    ("mems", 600, 1.0, False), ("fog", 900, 1.0, True), ("rlg", 600, 100.0, True), ("NBK", 600, 1.0, True),
    ("QN", 600, 1.0, False), ("GM", 600, 1.0, True),
])  # fmt: skip
def test_the_bound_is_that_of_dense_matrices(name, n, rate, ramp):
    """At hundreds of readings to 0.5 % where a term can be detected; flicker is taken to correlate no coefficients."""
    model = al.Model(MODELS[name])
    found = al.bound(model, n, rate, ramp=ramp)
    noise = al.Model(tuple(t for t in model if t.row.waveform is None))
    errors, slope = dense(noise, n, rate, ramp)
    off = np.abs(found.errors[: errors.size] / errors - 1)
    assert (off < np.where(errors < 0.35, 5e-3, 5e-2)).all(), off
    if ramp:
        assert found.ramp == pytest.approx(slope, rel=5e-3)
    else:
        assert found.ramp is None


# what prototypes of the likelihood gave, in percent, at 10 min, 1 h, 6 h and 24 h of 100 Hz without a ramp
KNOWN = {
    "mems": {"N": (0.29, 0.12, 0.05, 0.02), "B": (17, 7, 2.9, 1.4), "K": (48, 19, 7.5, 3.8)},
    "fog": {
        "Q": (0.48, 0.19, 0.08, 0.04), "N": (0.79, 0.32, 0.13, 0.07), "B": (21, 8.1, 3.3, 1.7), "K": (83, 30, 12, 5.9)
    },
    "rlg": {"Q": (0.29, 0.12, 0.05), "N": (3.9, 1.5, 0.62), "B": (22, 8.7, 3.5)},
}  # fmt: skip


@rows("name", list(KNOWN))
def test_known_accuracies_by_length(name):
    found = al.plan(al.sensor(name), 100.0, ramp=False)
    for symbol, wanted in KNOWN[name].items():
        errors = 100 * found.errors[found.names.index(symbol)]
        for error, digits in zip(errors, wanted, strict=False):
            assert error == pytest.approx(digits, rel=0.05, abs=0.006)


def test_white_noise_alone():
    assert al.bound(al.N(1.0, "deg/sqrt(h)"), 5001, 10.0)["N"] == pytest.approx(1 / math.sqrt(2 * 5000))


def test_a_ramp_in_white_noise():
    """Least squares: variance 12 sigma^2 / (n^3 - n) per reading."""
    found = al.bound(al.N(1.0, "rad/sqrt(s)") + al.R(1e-3, "rad/s^2"), 1000, 1.0)
    assert found.ramp == pytest.approx(math.sqrt(12 / (1000**3 - 1000)), rel=1e-5)
    assert found["R"] == pytest.approx(found.ramp / 1e-3)


@pytest.mark.slow("takes more than half a second")
def test_a_sinusoid_in_white_noise():
    """The textbook: 2 sigma^2 / n for the amplitude; scatter of least squares over 200 records, within 25 %."""
    n, f, A = 512, 0.123, 0.7
    found = al.bound(al.N(1.0, "rad/sqrt(s)") + al.Sine(A, "rad/s", frequency=f), n, 1.0)
    t, rng, estimates = np.arange(n) + 0.5, np.random.default_rng(1), []
    for _ in range(200):
        y = A * np.sinc(f) * np.sin(2 * np.pi * f * t + rng.uniform(0, 6.28)) + rng.standard_normal(n)
        grid = f + np.linspace(-1.5, 1.5, 301) / n
        waves = np.exp(-2j * np.pi * np.outer(grid, t)) @ y
        best = np.argmax(np.abs(waves))
        estimates.append((2 / n * np.abs(waves[best]) / np.sinc(f), grid[best]))
    amplitude, frequency = np.std(estimates, axis=0)
    assert amplitude / A == pytest.approx(found["Sine"], rel=0.25)
    assert frequency / f == pytest.approx(found["Sine frequency"], rel=0.25)


@rows("n", [10**4, 10**7, 10**11])
def test_the_bins_are_enough(monkeypatch, n):
    model = al.sensor("fog") + al.GM(3.0, "deg/h", time_constant=10.0)
    found = al.bound(model, n, 100.0)
    assert spectrum.edges_of(n).size < 750
    monkeypatch.setattr(spectrum, "PER_OCTAVE", 64)
    np.testing.assert_allclose(found.errors, al.bound(model, n, 100.0).errors, rtol=1e-3)


def test_what_cannot_be_seen_is_infinite():
    model = al.N(1.0, "deg/sqrt(h)") + al.Sine(1.0, "deg/h", frequency=1e-4)
    assert al.bound(model, 1000, 10.0)["Sine"] == math.inf
    refused(al.UsageError, "no noise", lambda: al.bound(al.Sine(1.0, "deg/h", frequency=1.0), 1000, 10.0))
    refused(al.UsageError, "at least 8", lambda: al.bound(al.N(1.0, "deg/sqrt(h)"), 7, 10.0))
    refused(al.UsageError, "unknown parameter 'K'", lambda: al.bound(al.N(1.0, "deg/sqrt(h)"), 70, 10.0)["K"])


def test_the_length_that_is_needed_gives_the_accuracy():
    found = al.plan(al.sensor("fog"), 100.0, accuracy=0.05)
    for name, needed in zip(found.names, found.needed, strict=True):
        reached = al.bound(found.model, round(needed * 100), 100.0)[name]
        assert reached == pytest.approx(0.05, rel=2e-3) or (needed == 2.0 and reached < 0.05)


def test_a_term_that_is_not_known_to_be_absent_costs_as_much_as_a_tiny_one():
    noise, n = al.N(0.1, "deg/sqrt(h)"), 2000
    tiny = al.Q(1e-6, "arcsec") + al.B(1e-6, "deg/h") + al.K(1e-6, "deg/h/sqrt(h)")
    beside = al.bound(noise + tiny, n, 1.0, ramp=True)["N"]
    assert al.bound(noise, n, 1.0, terms="auto")["N"] == pytest.approx(beside, rel=1e-3)
    assert al.bound(noise, n, 1.0, terms="QBKRN")["N"] == pytest.approx(beside, rel=1e-3)
    known = al.bound(noise, n, 1.0)["N"]
    assert known < al.bound(noise, n, 1.0, terms="Q")["N"] < beside
    refused(al.UsageError, "terms must be 'known', 'auto' or symbols", lambda: al.bound(noise, n, 1.0, terms="X"))


def test_two_processes_are_told_apart_by_their_time_constants():
    model = al.Model("N 1 deg/sqrt(h), GM 3 deg/h 10 s, GM 3 deg/h 100 s")
    names = al.bound(model, 10_000, 10.0).names
    assert names == ("N", "GM(10 s)", "GM(10 s) time constant", "GM(100 s)", "GM(100 s) time constant")


@rows("wrong", [{"rate": 0.0}, {"rate": 1.0, "accuracy": 0.0}, {"rate": 1.0, "durations": (-1.0,)}])
def test_a_plan_of_nothing_is_refused(wrong):
    refused(al.UsageError, r"between 1e-|above 0 and", lambda: al.plan(al.sensor("rlg"), **wrong))


run = of_verb("plan")


def test_the_verb_plans_for_a_sensor():
    result = run("--sensor", "mems", "--rate", 100, "--durations", "1 s,10 min,1 d", "--accuracy", 5, code=0)
    lines = result.stdout.splitlines()
    at = lines.index("mems  100 Hz, no ramp")
    assert lines[at + 2].strip() == "if all five terms are looked for, as analyze does"
    assert lines[at + 3].split()[-5:] == ["24", "h", "for", "5", "%"]
    assert lines[at + 5].split()[:6] == ["B", "7.2", "°/h", "-", "19", "%"]
    assert lines[at + 8].split() == ["R", "absent", "°/h²", "-", "<", "300", "<", "22"]
    assert lines[at + 10].strip() == "if it is known which terms there are"
    assert lines[at + 13].split() == ["B", "7.2", "°/h", "-", "17", "%", "1.4", "%", "1.97", "h"]
    whole = run("--sensor", "fog", "--rate", 100).stdout  # nothing more can be there
    assert "looked for" not in whole


@pytest.mark.slow("takes more than half a second")
def test_the_verb_plans_from_a_first_recording(tmp_path):
    record = al.simulate(al.sensor("mems"), 60_000, 100.0, rng=1, unit="deg/h", name="gz")
    al.write(record, tmp_path / "first.npz")
    result = run(tmp_path / "first.npz", "--json", "-", code=0)
    (channel,) = json.loads(result.stdout)["channels"]
    fitted = al.identify(record).valid
    assert (channel["name"], channel["model"]) == ("gz", fitted.to_dict())
    np.testing.assert_allclose(channel["errors"][0], al.plan(fitted, 100.0).errors[0])
    assert "not taken into account: " in run(tmp_path / "first.npz").stdout


@rows("arguments, words", [
    ((), "either a recording, or the noise"), (("file.csv", "--sensor", "fog"), "either a recording"),
    (("--sensor", "fog"), "--rate HZ"), (("--sensor", "hrg", "--rate", 1), "known sensors: mems, fog, rlg"),
    (("--sensor", "fog", "--rate", 1, "--accuracy", 0), "above 0"),
    (("--sensor", "fog", "--rate", 1, "--band", "0,2"), "--band applies to a recording"),
    (("--sensor", "fog", "--rate", 1, "--from", 3), "--from applies to a recording"),
])  # fmt: skip
def test_what_the_verb_refuses(arguments, words):
    ends(run(*arguments), 2, words)


TABLE_1 = {"Q": (0.09, 0.74, 0.40), "N": (1.00, 0.0, 0.0), "B": (1.87, -1.05, 0.79), "K": (2.70, -1.53, 0.85),
           "F": (0.14, 0.82, 0.30)}  # fmt: skip
"""Howe and Tasset (2004), as Tang et al. (2015) quote them: Allan variance / Theo1 = a + b / (0.75 m)^c."""


@rows("symbol", TABLE_1)
def test_the_bias_of_theo1_is_that_of_the_published_fit(symbol):
    found = properties("theo1", m=[12, 100, 1000])
    a, b, c = TABLE_1[symbol]
    fit = a + b / (0.75 * found.m) ** c
    assert found.ratio[:, found.symbols.index(symbol)] == pytest.approx(fit, rel=0.08 if symbol == "F" else 0.045)


def test_degrees_of_freedom_of_theo1_near_the_published_formula():
    found = properties("theo1", m=[100, 720, 3600])
    formula = [published.theo1(0, m, 7201) for m in found.m.tolist()]
    assert found.edf[:, found.symbols.index("N")] == pytest.approx(formula, rel=0.1)


def test_a_statistic_of_second_differences_has_no_bias_and_hadamard_is_its_own_target():
    for name in ("adev", "oadev", "hdev", "ohdev"):
        assert properties(name, 500).ratio == pytest.approx(1.0)


def test_the_scatter_of_simulated_records():
    found = properties("totdev", 256, m=[64])
    model = al.Model("N 1 deg/sqrt(h)")
    draws = [al.deviation(al.simulate(model, 256, 1.0, rng=seed), "totdev", m=[64], noise=None) for seed in range(400)]
    variance = np.array([curve.variance[0] for curve in draws])
    edf = 2 * variance.mean() ** 2 / variance.var()
    assert edf == pytest.approx(found.edf[0, found.symbols.index("N")], rel=0.25)


def test_averaging_times_or_factors():
    assert properties("theo1", 1000, taus=[7.5, 75.0]).m.tolist() == [10, 100]
    assert properties("oadev", 100, taus="decade").m.tolist()[:4] == [1, 2, 4, 10]


@rows("name, more, message", [
    ("mtie", {}, "mtie is not an estimate of the Allan or Hadamard variance"),
    ("tdev", {}, "tdev is not an estimate"), ("nothing", {}, "unknown statistic 'nothing'"),
    ("theo1", {"m": [11]}, "must be even"), ("theo1", {"taus": [8.0]}, "is not a multiple of 1.5 s"),
])  # fmt: skip
def test_bad_input(name, more, message):
    refused(al.UsageError, message, lambda: properties(name, 1000, **more))


def test_limits_under_quantization_alone():
    """Only white angle noise: none of the terms is smooth."""
    record = al.simulate(al.Model("Q 1 arcsec"), 1000, 1.0, rng=1)
    curve = al.deviation(record, "theo1", m=[10, 1000], noise=al.Model("Q 1 arcsec"))
    low, high = curve.interval(0.95)
    assert (low < curve.deviation).all()
    assert (curve.deviation < high).all()
