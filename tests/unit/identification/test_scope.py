"""Where a model holds: vibration, bands, misfits, and coefficients that the curve contradicts."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, iirpeak, lfilter
from tests import thinned
from tests.rows import refused, rows
from tests.unit.identification.records import RATE, N, rates_of, record_of, settled

import allanite as al
from allanite.core.estimate import Estimate
from allanite.identification.checks.contradiction import contradictions, held, measured
from allanite.study.noise import noise_of

SHAKING = lfilter(*iirpeak(20, 40, RATE), np.random.default_rng(1001).standard_normal(2**16))


@rows("y", [rates_of(n=2**16) + 0.0035 * SHAKING, settled(n=2**16, behind=butter(2, 1 / 3))])
def test_nothing_but_terms_is_looked_for_where_all_frequencies_are_asked_for(y):
    fit = al.identify(record_of(y), band="all")
    assert (fit.validity, fit.scope.filter, fit.scope.masks) == ("unexplained", None, ())
    assert "resonance" not in [c.name for c in fit.components]


def test_a_slope_that_vibration_explains_is_no_warning():
    rng, n = np.random.default_rng(1), 2**15
    shaking = lfilter([0.0158], [1, -1.853, 0.949], rng.standard_normal(n + 500))[500:]  # at 5 Hz, of quality 6
    (channel,) = al.analyze(al.Record(rng.standard_normal(n) + 10 * shaking, RATE, "deg/s")).channels
    assert channel.explained
    assert "slope" in channel.quality.names
    assert "slope" not in {finding.name for finding in channel.warnings}


def shaped(n, seed, gain):
    """White noise whose spectrum is multiplied by a gain."""
    c, f = np.fft.rfft(np.random.default_rng(seed).standard_normal(n)), np.fft.rfftfreq(n, 1 / RATE)
    return record_of(np.fft.irfft(c * gain(np.maximum(f, 1e-9))), "deg/s")


@pytest.mark.slow("takes more than half a second")
@rows("seed", thinned([1, 2], 1))
def test_what_no_component_describes_is_a_factor_and_the_noise_is_that_below_it(seed):
    """White noise that rises fourfold around 10 Hz: no band is cut, and N is the level below."""
    fit = al.identify(shaped(2**16, seed, lambda f: np.sqrt(1 + 3 / (1 + (10 / f) ** 4))))
    assert (fit.validity, fit.scope.band) == ("approximate", (0.0, RATE / 2))
    low, high = fit["N"].interval(0.99)
    truth = al.N(0.1, "deg/sqrt(s)").value
    assert 0.99 * low < truth < 1.01 * high  # angle noise behind a filter rises as well, and is as good within e^4
    assert high / low < 1.5


def test_a_small_misfit_is_allowed_for_in_the_limits():
    """A tilt of the spectrum by three per cent in n = 2^20: no component is so, and the limits are widened."""
    fit = al.identify(shaped(2**20, 3, lambda f: 1 + 0.03 * np.sin(3 * np.log(np.maximum(f, 1e-4)))), terms="N")
    assert fit.validity == "approximate"
    assert 0.005 < fit.scope.misfit < 0.3
    assert {c.name for c in fit.components if c.claimed} == {"factor"}
    low, high = fit["N"].interval()
    assert fit["N"].value == pytest.approx(al.N(0.1, "deg/sqrt(s)").value, rel=0.03)
    assert high / low > 1.01


@rows("band", ["wide", (1.0,), (1.0, "2"), 5.0])
def test_a_band_that_is_none_is_refused(band):
    refused(al.UsageError, "'auto', 'all' or two frequencies", lambda: al.Recipe(band=band))


def test_columns_that_are_alike_are_not_both_used():
    """Above a few hertz a random walk and a slow Gauss-Markov noise are one shape."""
    for seed in range(4):
        assert al.identify(record_of(rates_of(n=2**14, seed=seed)), band=(8.0, 50.0))["N"].claimed


def test_a_coefficient_above_the_curve_is_not_valid():
    record = record_of(rates_of(n=2**14, seed=7))
    fit = al.identify(record)
    assert contradictions(fit, measured(fit, record)) == {}
    high = 10 * float(al.deviation(record, "oadev", taus="octave").deviation.max())
    wrong = Estimate("B", fit.signal, high, high / 100, "identified", None, "test", lambda _: (0.98 * high, high))
    lying = al.Fit((fit["N"], wrong), "test", fit.signal, fit.model, scope=fit.scope)
    ((symbol, reason),) = contradictions(lying, measured(lying, record)).items()
    assert symbol == "B"
    assert "upper limit of the measured one" in reason
    after = lying.invalid(reason, ("B",))
    assert (after["B"].status, after["B"].limits) == ("not valid", None)
    assert "not valid" in after["B"].words()
    assert after["N"].status == fit["N"].status


def test_white_noise_below_the_curve_is_not_valid():
    """Neither a value nor an upper limit: quick noise in its place has the same slope."""
    record = record_of(rates_of(n=2**15, seed=4))
    fit = al.identify(record)
    signal, high = fit.signal, 0.5 * N.value
    quick = Estimate("GM", signal, 0.05, 1e-3, "identified", None, "test", lambda _: (0.049, 0.051), shape=(0.03,))
    for status, value in (("absent", None), ("identified", 0.4 * N.value)):
        low = Estimate("N", signal, value, high / 9, status, high, "test", lambda _: (0.0, high))
        lying = al.Fit((low, quick), "test", signal, fit.model, scope=fit.scope)
        assert "falls as white noise" in contradictions(lying, measured(lying, record))["N"]
    assert contradictions(fit, measured(fit, record)) == {}


@pytest.mark.slow("seconds of analyses")
def test_white_noise_is_not_struck_by_chance():
    """The octaves of the curve are many: at 1 % each, one record in forty lost its N."""
    for seed in range(40):
        record = record_of(np.random.default_rng([7, seed]).standard_normal(2**12), "deg/s")
        fit = al.identify(record, terms="N")
        assert "N" not in contradictions(fit, measured(fit, record))


def test_the_model_holds_at_no_averaging_time_outside_its_scope():
    """Where the curve differs from the shortest time of a band on, the model holds nowhere."""
    record = record_of(rates_of(n=2**14, seed=9))
    fit = al.identify(record, band=(0.0, 1.0))
    scope = replace(fit.scope, until=None)
    assert scope.times[0] > 0.4
    wrong = Estimate("N", fit.signal, 3 * N.value, 0.01, "identified", None, "test", lambda _: (0.0, 9 * N.value))
    lying = al.Fit((wrong,), "test", fit.signal, al.Model("N 0.015 deg/s/sqrt(Hz)"), scope=scope)
    assert held(lying, measured(lying, record)) == 0


@pytest.mark.slow("takes more than half a second")
def test_a_record_that_nothing_explains_has_no_valid_coefficient():
    n, rng = 2**15, np.random.default_rng(1)
    t = np.arange(n) / RATE
    sway = np.cumsum(rng.standard_normal(n)) * np.sin(2 * np.pi * 0.8 * t + 0.3 * np.cumsum(rng.standard_normal(n)))
    noise = noise_of(al.Record(sway + rng.standard_normal(n), RATE, "deg/h"), al.Recipe())
    assert noise.validity == "unexplained"
    assert not noise.explained
    assert {(e.status, e.limits, e.upper) for e in noise.fit} == {("not valid", None, None)}
