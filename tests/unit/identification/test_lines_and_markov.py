"""Gauss-Markov noise and sinusoids: found, ranked, taken out, and said."""

import math

import numpy as np
import pytest
from scipy.fft import dct
from scipy.optimize import minimize
from scipy.signal import lfilter
from tests.rows import paired, rows
from tests.unit.identification import records
from tests.unit.identification.records import RATE, B, K, N, rates_of

import allanite as al
from allanite.identification.likelihood.lines import BLOCKS, Wave
from allanite.identification.likelihood.spectrum import spectrum

GM = al.GM(0.004, "deg/s", time_constant=20.0)


def record_of(model, n=2**17, seed=1):
    return records.record_of(rates_of(model, n, seed))


def test_limits_of_a_time_constant_are_those_of_its_likelihood():
    """Where the deviance of the cosine transform, with the sizes of both terms free, is z^2 above its least."""
    n, rate, rng = 2**13, 10.0, np.random.default_rng(3)
    a = math.exp(-1 / 15)
    slow = lfilter([math.sqrt(1 - a * a)], [1, -a], rng.standard_normal(n + 1000))[1000:]
    y = slow + 2.0 * rng.standard_normal(n)
    power, angle = dct(y, norm="ortho")[1:] ** 2, np.pi * np.arange(1, n) / n

    def deviance(parameters, constant=None):
        white, size, *free = np.exp(parameters)
        a = math.exp(-1 / (rate * (constant or free[0])))
        S = white + size * (1 - a * a) / (1 - 2 * a * np.cos(angle) + a * a)
        return float((np.log(S) + power / S).sum())

    estimate = al.identify(al.Record(y, rate, "deg/h"), terms="N,GM", band="all")["GM"]
    start = [math.log(4.0), 0.0]
    exact = {"method": "Nelder-Mead", "options": {"xatol": 1e-8, "fatol": 1e-8}}
    least = minimize(deviance, [*start, math.log(estimate.shape[0])], **exact).fun
    for level, z in ((0.95, 1.959964), (0.68, 0.994458)):
        for limit in estimate.shape_limits(level)[0]:
            above = minimize(deviance, start, (limit,), **exact).fun - least
            assert math.sqrt(above) == pytest.approx(z, rel=0.02)


def test_gauss_markov_takes_the_place_of_flicker_where_the_record_says_so():
    fit = al.identify(record_of(N + GM, 2**18))
    assert ([e.symbol for e in fit], fit["GM"].status) == ([*"QNBKR", "GM"], "identified")
    assert fit["B"].status == "absent"
    (T,), ((low, high),) = fit["GM"].shape, fit["GM"].shape_limits(0.95)
    assert low < 20.0 < high
    assert low < T < high
    (markov,) = (c for c in fit.components if c.name == "noise" and c.claimed)
    assert f"time constant {T:.4g} s" in markov.words
    data = fit.to_dict()
    assert data["terms"][-1]["time_constant"]["value"] == T
    assert al.Model.from_dict(data["model"])["GM"].shape == fit.model["GM"].shape == (T,)
    assert all(a.aic > 8 for a in fit.alternatives if "GM" not in {t.symbol for t in a.model})


@pytest.mark.slow("takes more than half a second")
def test_flicker_stays_where_it_is_true():
    """About 1 % of records say otherwise: more than 2 of 6 with a probability of 2e-5."""
    fits = [al.identify(record_of(N + B + K, 2**16, seed)) for seed in range(1, 7)]
    assert sum("GM" in [e.symbol for e in fit] for fit in fits) <= 2


def test_terms_that_are_asked_for_are_obeyed():
    record = record_of(N + GM)
    for terms, symbols in (("N,GM,K", ["N", "GM", "K"]), ("QNBKR", [*"QNBKR"])):
        assert [e.symbol for e in al.identify(record, terms=terms)] == symbols
    assert al.identify(record, terms="QNGMK")["GM"].shape
    assert al.identify(record_of(N), terms="NGM")["GM"].status == "absent"
    alone = al.identify(record_of(GM), terms="GM")
    assert abs(alone["GM"].value - GM.value) < 5 * alone["GM"].standard_error


@rows("n", [1000, BLOCKS, 50_001])
def test_a_wave_is_a_sine(n):
    wave = Wave(0.1234, 2.0, 0.7, 0.1)
    np.testing.assert_allclose(wave.values(n), 2 * np.sin(2 * np.pi * 0.1234 * (np.arange(n) + 0.5) + 0.7), atol=1e-9)


@pytest.mark.slow("takes more than half a second")
@rows("frequency, ratio, seed", [(12.0, 100.0, 1), (0.5, 100.0, 2), (3.3, 1000.0, 3)])
def test_sinusoids_are_found_and_taken_out(frequency, ratio, seed):
    """At a peak 100 times the noise a line is missed in fewer than 1 of 1e6 records."""
    model, n = N + B + K, 2**17
    level = float(model.spectrum(np.array([frequency]), 1 / RATE)[0]) * RATE
    size = math.sqrt(6 * ratio * level / n) / np.sinc(frequency / RATE)
    fit = al.identify(record_of(model + al.Sine(size, "rad/s", frequency=frequency, phase=1.0), n, seed))
    clean = al.identify(record_of(model, n, seed))
    (line,) = fit.lines
    assert line.frequency == pytest.approx(frequency, abs=0.6 * RATE / n)
    assert abs(line.amplitude - size) < 5 * line.standard_error
    assert line.standard_error == pytest.approx(math.sqrt(3 * level / n) / np.sinc(frequency / RATE), rel=0.5)
    assert fit.goodness.explained == clean.goodness.explained
    assert "a sinusoid was removed first" in fit.goodness.verdict
    assert fit.model["Sine"].shape[0] == line.frequency
    assert fit.to_dict()["lines"][0]["frequency"] == line.frequency
    # what is left of the noise is what was there without the line
    assert fit["N"].value == pytest.approx(clean["N"].value, rel=1e-3)
    assert al.identify(record_of(model, n, seed), lines=False)["N"].value == clean["N"].value


def test_lines_across_gaps():
    values = rates_of(N + B + al.Sine(0.004, "deg/s", frequency=2.0), 2**16)
    for start in range(5000, 60000, 9000):
        values[start : start + 700] = np.nan
    (line,) = al.identify(records.record_of(values)).lines
    assert line.frequency == pytest.approx(2.0, abs=1e-3)
    assert abs(line.amplitude - np.radians(0.004)) < 5 * line.standard_error


@pytest.mark.slow("ensemble")
def test_false_lines_are_rare():
    """In 60 records of noise: more than 4 at 1 % each have a probability of 4e-4."""
    fits = (al.identify(record_of(N + B + K, 2**13, seed), terms="NBK") for seed in range(1, 61))
    assert sum(bool(fit.lines) for fit in fits) <= 4


@pytest.mark.nightly("seconds of processor time for what shorter tests look at, too")
@pytest.mark.filterwarnings("error::RuntimeWarning")
@rows("n, pattern", paired([1000, 1024, 16384], [
    [1, -1], [0, 1, 0, -1], [1, 1, -1, -1], [0, 1, 2, 3, 4, 3, 2, 1], [0] * 15 + [1],
]))  # fmt: skip
def test_a_periodic_record_without_noise(n, pattern):
    # most coefficients of its transform are exactly zero
    record = records.record_of(np.resize(1e-3 * np.array(pattern), n))
    assert spectrum(record, detrend=True).power.min() > 0
    assert al.identify(record).validity == "unexplained"


@rows("band, seed", paired(["auto", "all", (1e-3, 4.9)], range(3)))
def test_noise_of_a_few_samples_is_not_taken_for_a_low_pass_filter(seed, band):
    model = al.N(0.5, "deg/sqrt(h)") + al.GM(0.1, "deg/s", time_constant=2.0)  # 20 samples
    fit = al.identify(al.simulate(model, 2**14, 10.0, rng=np.random.default_rng(seed)), band=band)
    assert (fit.validity, fit.scope.filter) == ("explained", None)
    assert fit["N"].value == pytest.approx(model["N"].value, rel=0.05)
    assert fit["GM"].value == pytest.approx(model["GM"].value, rel=0.05)
