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
    errors, slope = dense(al.Model(tuple(t for t in model if t.row.waveform is None)), n, rate, ramp)
    off = np.abs(found.errors[: errors.size] / errors - 1)
    assert (off < np.where(errors < 0.35, 5e-3, 5e-2)).all(), off
    assert found.ramp == (pytest.approx(slope, rel=5e-3) if ramp else None)


# what prototypes of the likelihood gave, in percent, at 10 min, 1 h, 6 h and 24 h of 100 Hz without a ramp
KNOWN = {
    ("mems", "N"): (0.29, 0.12, 0.05, 0.02), ("mems", "B"): (17, 7, 2.9, 1.4), ("mems", "K"): (48, 19, 7.5, 3.8),
    ("fog", "Q"): (0.48, 0.19, 0.08, 0.04), ("fog", "N"): (0.79, 0.32, 0.13, 0.07), ("fog", "B"): (21, 8.1, 3.3, 1.7),
    ("fog", "K"): (83, 30, 12, 5.9), ("rlg", "Q"): (0.29, 0.12, 0.05), ("rlg", "N"): (3.9, 1.5, 0.62),
    ("rlg", "B"): (22, 8.7, 3.5),
}  # fmt: skip


def test_known_accuracies_by_length():
    plans = {name: al.plan(al.sensor(name), 100.0, ramp=False) for name in ("mems", "fog", "rlg")}
    for (name, symbol), wanted in KNOWN.items():
        errors = 100 * plans[name].errors[plans[name].names.index(symbol)]
        assert errors[: len(wanted)] == pytest.approx(wanted, rel=0.05, abs=0.006), (name, symbol)


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
    grid = f + np.linspace(-1.5, 1.5, 301) / n
    for _ in range(200):
        y = A * np.sinc(f) * np.sin(2 * np.pi * f * t + rng.uniform(0, 6.28)) + rng.standard_normal(n)
        waves = np.abs(np.exp(-2j * np.pi * np.outer(grid, t)) @ y)
        best = np.argmax(waves)
        estimates.append((2 / n * waves[best] / np.sinc(f), grid[best]))
    wanted = found["Sine"] * A, found["Sine frequency"] * f
    assert np.std(estimates, axis=0) == pytest.approx(wanted, rel=0.25)


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


def test_the_length_that_is_needed_gives_the_accuracy():
    found = al.plan(al.sensor("fog"), 100.0, accuracy=0.05)
    for name, needed in zip(found.names, found.needed, strict=True):
        reached = al.bound(found.model, round(needed * 100), 100.0)[name]
        assert reached == pytest.approx(0.05, rel=2e-3) or (needed == 2.0 and reached < 0.05)


def test_a_term_that_is_not_known_to_be_absent_costs_as_much_as_a_tiny_one():
    def error(terms, model="N 0.1 deg/sqrt(h)", **how):
        return al.bound(al.Model(model), 2000, 1.0, terms=terms, **how)["N"]

    beside = error("known", "N 0.1 deg/sqrt(h), Q 1e-6 arcsec, B 1e-6 deg/h, K 1e-6 deg/h/sqrt(h)", ramp=True)
    assert error("auto") == pytest.approx(beside, rel=1e-3)
    assert error("QBKRN") == pytest.approx(beside, rel=1e-3)
    assert error("known") < error("Q") < beside


def test_two_processes_are_told_apart_by_their_time_constants():
    model = al.Model("N 1 deg/sqrt(h), GM 3 deg/h 10 s, GM 3 deg/h 100 s")
    names = al.bound(model, 10_000, 10.0).names
    assert names == ("N", "GM(10 s)", "GM(10 s) time constant", "GM(100 s)", "GM(100 s) time constant")


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
    (channel,) = json.loads(run(tmp_path / "first.npz", "--json", "-", code=0).stdout)["channels"]
    fitted = al.identify(record).valid
    assert (channel["name"], channel["model"]) == ("gz", fitted.to_dict())
    np.testing.assert_allclose(channel["errors"][0], al.plan(fitted, 100.0).errors[0])


@rows("arguments, words", [
    ((), "either a recording, or the noise"), (("file.csv", "--sensor", "fog"), "either a recording"),
    (("--sensor", "fog"), "--rate HZ"), (("--sensor", "hrg", "--rate", 1), "known sensors: mems, fog, rlg"),
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
    ratio = found.ratio[:, found.symbols.index(symbol)]
    assert ratio == pytest.approx(a + b / (0.75 * found.m) ** c, rel=0.08 if symbol == "F" else 0.045)


def test_degrees_of_freedom_of_theo1_near_the_published_formula():
    found = properties("theo1", m=[100, 720, 3600])
    formula = [published.theo1(0, m, 7201) for m in found.m.tolist()]
    assert found.edf[:, found.symbols.index("N")] == pytest.approx(formula, rel=0.1)


def test_a_statistic_of_second_differences_has_no_bias_and_hadamard_is_its_own_target():
    for name in ("adev", "oadev", "hdev", "ohdev"):
        assert properties(name, 500).ratio == pytest.approx(1.0)


def test_averaging_times_or_factors():
    assert properties("theo1", 1000, taus=[7.5, 75.0]).m.tolist() == [10, 100]
    assert properties("oadev", 100, taus="decade").m.tolist()[:4] == [1, 2, 4, 10]


WHITE = al.N(1.0, "deg/sqrt(h)")
REFUSED = [
    (lambda: al.bound(al.Sine(1.0, "deg/h", frequency=1.0), 1000, 10.0), "no noise"),
    (lambda: al.bound(WHITE, 7, 10.0), "at least 8"), (lambda: al.bound(WHITE, 70, 10.0)["K"], "unknown parameter 'K'"),
    (lambda: al.bound(WHITE, 70, 1.0, terms="X"), "terms must be 'known', 'auto' or symbols"),
    (lambda: al.plan(WHITE, 0.0), "between 1e-"), (lambda: al.plan(WHITE, 1.0, accuracy=0.0), "above 0 and"),
    (lambda: al.plan(WHITE, 1.0, durations=(-1.0,)), "between 1e-"),
    (lambda: properties("mtie", 1000), "mtie is not an estimate of the Allan or Hadamard variance"),
    (lambda: properties("tdev", 1000), "tdev is not an estimate"),
    (lambda: properties("nothing", 1000), "unknown statistic 'nothing'"),
    (lambda: properties("theo1", 1000, m=[11]), "must be even"),
    (lambda: properties("theo1", 1000, taus=[8.0]), "is not a multiple of 1.5 s"),
]  # fmt: skip


@rows("call, words", REFUSED)
def test_bad_input(call, words):
    refused(al.UsageError, words, call)


def test_limits_under_quantization_alone():
    """Only white angle noise: none of the terms is smooth."""
    noise = al.Model("Q 1 arcsec")
    curve = al.deviation(al.simulate(noise, 1000, 1.0, rng=1), "theo1", m=[10, 1000], noise=noise)
    low, high = curve.interval(0.95)
    assert ((low < curve.deviation) & (curve.deviation < high)).all()
