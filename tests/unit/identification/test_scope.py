"""Where a model holds: vibration, bands, misfits, and coefficients that the curve contradicts."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import iirpeak, lfilter
from tests.rows import refused, rows

import allanite as al
from allanite.core.estimate import Estimate
from allanite.core.ranges import demand_band
from allanite.core.validity import GRADES, Scope, worst
from allanite.identification.checks.contradiction import contradictions, held, measured
from allanite.study.noise import noise_of

RATE = 100.0
N = al.N(0.005, "deg/sqrt(s)")
B = al.B(0.002, "deg/s")


def white(n, seed):
    return al.simulate(N + B, n, RATE, rng=np.random.default_rng(seed)).values


def humped(n=2**16, seed=1, size=0.7):
    y, rng = white(n, seed), np.random.default_rng(seed + 1000)
    return al.Record(y + size * y.std() * lfilter(*iirpeak(20, 40, RATE), rng.standard_normal(n)), RATE, "rad/s")


def test_no_vibration_is_looked_for_where_all_frequencies_are_asked_for():
    fit = al.identify(humped(size=4), band="all")
    assert ([c.name for c in fit.components if c.name == "resonance"], fit.scope.masks) == ([], ())
    assert fit.validity == "unexplained"


def test_a_slope_that_vibration_explains_is_no_warning():
    rng, n = np.random.default_rng(1), 2**15
    shaking = lfilter([0.0158], [1, -1.853, 0.949], rng.standard_normal(n + 500))[500:]  # at 5 Hz, of quality 6
    (channel,) = al.analyze(al.Record(rng.standard_normal(n) + 10 * shaking, RATE, "deg/s")).channels
    assert channel.explained
    assert "slope" in channel.quality.names
    assert "slope" not in {finding.name for finding in channel.warnings}


@pytest.mark.slow("takes more than half a second")
@rows("seed", [1, 2])
def test_what_no_component_describes_is_a_factor_and_the_noise_is_that_below_it(seed):
    """White noise that rises fourfold around 10 Hz: no band is cut, and N is the level below."""
    n = 2**16
    c = np.fft.rfft(np.random.default_rng(seed).standard_normal(n))
    f = np.fft.rfftfreq(n, 1 / RATE)
    c *= np.sqrt(1 + 3 / (1 + (10 / np.maximum(f, 1e-9)) ** 4))
    fit = al.identify(al.Record(np.fft.irfft(c), RATE, "deg/s"))
    assert (fit.validity, fit.scope.band) == ("approximate", (0.0, RATE / 2))
    low, high = fit["N"].interval(0.99)
    truth = al.N(0.1, "deg/sqrt(s)").value
    assert 0.99 * low < truth < 1.01 * high  # angle noise behind a filter rises as well, and is as good within e^4
    assert high / low < 1.5


def test_a_small_misfit_is_allowed_for_in_the_limits():
    """A tilt of the spectrum by three per cent in n = 2^20: no component is so, and the limits are widened."""
    rng = np.random.default_rng(3)
    n = 2**20
    c = np.fft.rfft(rng.standard_normal(n))
    f = np.fft.rfftfreq(n, 1 / RATE)
    c *= 1 + 0.03 * np.sin(3 * np.log(np.maximum(f, 1e-4)))
    fit = al.identify(al.Record(np.fft.irfft(c), RATE, "deg/s"), terms="N")
    assert fit.validity == "approximate"
    assert 0.005 < fit.scope.misfit < 0.3
    (factor,) = {c.name for c in fit.components if c.claimed}
    assert factor == "factor"
    low, high = fit["N"].interval()
    assert fit["N"].value == pytest.approx(al.N(0.1, "deg/sqrt(s)").value, rel=0.03)
    assert high / low > 1.01


@rows("band", ["wide", (1.0,), (1.0, "2"), 5.0])
def test_a_band_that_is_none_is_refused(band):
    refused(al.UsageError, "'auto', 'all' or two frequencies", lambda: demand_band(band))
    refused(al.UsageError, "two frequencies", lambda: al.Recipe(band=band))


def test_columns_that_are_alike_are_not_both_used():
    """Above a few hertz a random walk and a slow Gauss-Markov noise are one shape."""
    for seed in range(4):
        fit = al.identify(al.Record(white(2**14, seed), RATE, "rad/s"), band=(8.0, 50.0))
        assert fit["N"].claimed


def test_the_worst_grade_counts():
    assert (worst("explained", "", "approximate"), worst(*GRADES)) == ("approximate", "unexplained")
    assert worst("") == ""


def test_a_coefficient_above_the_curve_is_not_valid():
    record = al.Record(white(2**14, 7), RATE, "rad/s")
    fit = al.identify(record)
    curve = al.deviation(record, "oadev", taus="octave")
    assert contradictions(fit, measured(fit, record)) == {}
    signal = fit.signal
    high = 10 * float(curve.deviation.max())
    wrong = Estimate("B", signal, high, high / 100, "identified", None, "test", lambda level: (0.98 * high, high))
    lying = al.Fit((fit["N"], wrong), "test", signal, fit.model, scope=fit.scope)
    ((symbol, reason),) = contradictions(lying, measured(lying, record)).items()
    assert symbol == "B"
    assert "upper limit of the measured one" in reason
    after = lying.invalid(reason, ("B",))
    assert (after["B"].status, after["B"].limits) == ("not valid", None)
    assert "not valid" in after["B"].words()
    assert after["N"].status == fit["N"].status


def test_white_noise_below_the_curve_is_not_valid():
    """Neither a value nor an upper limit: quick noise in its place has the same slope, slow noise has not."""
    record = al.Record(white(2**15, 4), RATE, "rad/s")
    fit = al.identify(record)
    signal, high = fit.signal, 0.5 * N.value

    def beside(symbol, shape, **claimed):
        low = Estimate(
            "N", signal, claimed.get("value"), high / 9, claimed["status"], high, "test", lambda _: (0.0, high)
        )
        other = Estimate(symbol, signal, 0.05, 1e-3, "identified", None, "test", lambda _: (0.049, 0.051), shape=shape)
        return al.Fit((low, other), "test", signal, fit.model, scope=fit.scope)

    for claimed in ({"status": "absent"}, {"status": "identified", "value": 0.4 * N.value}):
        quick = beside("GM", (0.03,), **claimed)
        assert "falls as white noise" in contradictions(quick, measured(quick, record))["N"]
    assert contradictions(fit, measured(fit, record)) == {}


@pytest.mark.slow("seconds of analyses")
def test_white_noise_is_not_struck_by_chance():
    """The octaves of the curve are many: at 1 % each, one record in forty lost its N."""
    struck = 0
    for seed in range(40):
        record = al.Record(np.random.default_rng([7, seed]).standard_normal(2**12), RATE, "deg/s")
        fit = al.identify(record, terms="N")
        struck += "N" in contradictions(fit, measured(fit, record))
    assert struck == 0


def test_the_model_holds_at_no_averaging_time_outside_its_scope():
    """Where the curve differs from the shortest time of a band on, the model holds nowhere."""
    record = al.Record(white(2**14, 9), RATE, "rad/s")
    fit = al.identify(record, band=(0.0, 1.0))
    scope = replace(fit.scope, until=None)
    assert scope.times[0] > 0.4
    wrong = Estimate("N", fit.signal, 3 * N.value, 0.01, "identified", None, "test", lambda _: (0.0, 9 * N.value))
    lying = al.Fit((wrong,), "test", fit.signal, al.Model("N 0.015 deg/s/sqrt(Hz)"), scope=scope)
    assert held(lying, measured(lying, record)) == 0


@pytest.mark.slow("takes more than half a second")
def test_a_record_that_nothing_explains_has_no_valid_coefficient():
    n = 2**15
    rng = np.random.default_rng(1)
    t = np.arange(n) / RATE
    sway = np.cumsum(rng.standard_normal(n)) * np.sin(2 * np.pi * 0.8 * t + 0.3 * np.cumsum(rng.standard_normal(n)))
    noise = noise_of(al.Record(sway + rng.standard_normal(n), RATE, "deg/h"), al.Recipe())
    assert noise.validity == "unexplained"
    assert not noise.explained
    assert {e.status for e in noise.fit} == {"not valid"}
    assert all(e.limits is None and e.upper is None for e in noise.fit)


def test_a_scope_says_what_it_holds():
    flat = np.ones(3)
    scope = Scope("auto", (0.0, 5.0), (), None, 0.0, 0.0, np.array([1.0, 20.0, 50.0]), flat, ("more above",))
    assert scope.limited
    assert not scope.whole
    assert scope.sentences[0].startswith("the model holds from 0 to 5 Hz")
    assert scope.sentences[-1] == "more above"
