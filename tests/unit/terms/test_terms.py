"""Terms with a shape in models, statistics and limits; their rows are tested in conformance/test_noise_terms.py."""

import dataclasses

import numpy as np
import pytest
from tests.reference.dense import moments, quadratic_form
from tests.rows import paired, refused, rows

import allanite as al
from allanite.core.kinds import title_of
from allanite.core.model import term
from allanite.core.units import signal_named
from allanite.statistics.table import STATISTICS
from allanite.terms import TERMS
from allanite.terms.oscillation import oscillation


def test_flicker_of_the_angle_is_a_sum():
    h = np.arange(1.0, 200.0)
    np.testing.assert_allclose(TERMS["F"].structure(h), 4 / np.pi * np.cumsum(1 / (2 * h - 1)), rtol=1e-12)


@rows("column", ["structure", "summed", "increments", "spectrum", "dct"])
def test_a_damping_ratio_of_one_is_between_its_neighbours(column):
    """There both time constants are equal, and each exponential of the sum becomes infinite."""
    at = {"spectrum": (np.array([0.01, 0.2]), 1.0), "dct": (np.arange(1.0, 64), 64)}.get(column, (np.arange(40.0),))
    below, critical, above = (getattr(oscillation(0.05, damping), column)(*at) for damping in (0.9999, 1.0, 1.0001))
    np.testing.assert_allclose(critical, (below + above) / 2, rtol=1e-5, atol=1e-6 * np.abs(critical).max())


RATE, WHITE = 4.0, al.N(1.0, "rad/sqrt(s)")
SHAPED = {"GM": al.GM(2.0, "rad/s", time_constant=1.5), "slow GM": al.GM(2.0, "rad/s", time_constant=80.0),
          "Sine": al.Sine(2.0, "rad/s", frequency=0.21), "fast Sine": al.Sine(2.0, "rad/s", frequency=1.7),
          "F": al.F(2.0, "rad"), "GMA": al.GMA(2.0, "rad", time_constant=1.5),
          "slow GMA": al.GMA(2.0, "rad", time_constant=8.0), "GM2": al.GM2(2.0, "rad/s", frequency=0.21, damping=0.15),
          "aperiodic GM2": al.GM2(2.0, "rad/s", frequency=0.21, damping=1.5)}  # fmt: skip


NAMES = [n for n, row in STATISTICS.items() if not row.parts and not row.extreme and row.order > 1]


@rows("name, kind", paired(NAMES, list(SHAPED)))
def test_expected_curves_equal_the_dense_form(name, kind):
    row, term, n = STATISTICS[name], SHAPED[kind], 200
    for m in sorted({row.step, 6 * row.step, row.largest(n) // (2 * row.step) * row.step, row.largest(n)}):
        # the referee knows a waveform, and of that the one phase; the mean over phases follows from D alone
        E, _ = moments(quadratic_form(row, m, n), [dataclasses.replace(term.sampled(RATE), waveform=None)])
        tau = m * row.tau_factor / RATE
        found = al.expected(al.Model((term,)), name, [tau], rate=RATE, size=n)[0]
        exact = E[0] * term.power(RATE) * (tau ** (2 * row.power))
        # a window of more than 64 points is extrapolated as of a smooth D: the logarithm is less so
        assert found == pytest.approx(exact, rel=1e-3 if kind == "F" else 2e-4, abs=1e-9)


@rows("name", [name for name in NAMES if STATISTICS[name].overlapped])  # the referee's windows begin at every sample
def test_the_expected_curve_of_a_warm_up_is_that_of_its_waveform(name):
    row, term, n = STATISTICS[name], al.W(-2.0, "rad/s", time_constant=9.0), 200
    for m in sorted({row.step, 6 * row.step, row.largest(n)}):
        E, _ = moments(quadratic_form(row, m, n), [dataclasses.replace(term.sampled(RATE), structure=np.zeros_like)])
        tau = m * row.tau_factor / RATE
        found = al.expected(WHITE + term, name, [tau], rate=RATE, size=n)[0]
        beside = al.expected(WHITE, name, [tau], rate=RATE, size=n)[0]
        assert found - beside == pytest.approx(4 * E[0] * tau ** (2 * row.power), rel=1e-6, abs=1e-9 * beside)


def adds_no_scatter(term):
    record = al.simulate(WHITE + term, 4000, RATE, rng=np.random.default_rng(1))
    curves = [al.deviation(record, "oadev", noise=model) for model in (WHITE, WHITE + term)]
    np.testing.assert_array_equal(curves[0].edf, curves[1].edf)
    return record


def test_a_warm_up_needs_the_length_of_the_record_and_does_not_scatter():
    warm = al.W(2.0, "rad/s", time_constant=9.0)
    with pytest.raises(al.UsageError, match="depends on the length of the record: pass size"):
        al.expected(WHITE + warm, "oadev", [1.0], rate=RATE)
    adds_no_scatter(warm)
    alone = al.simulate(warm, 400, RATE, rng=np.random.default_rng(1)).values
    t = np.arange(401.0) / RATE
    exact = 2 * np.diff(t + 9 * np.exp(-t / 9)) * RATE
    np.testing.assert_allclose(alone, exact - exact.mean(), atol=1e-12)


MIXED = {name: SHAPED[name] for name in ("GM", "slow GM", "F", "GMA", "GM2")} | {
    "sharp GM2": al.GM2(2.0, "rad/s", frequency=0.21, damping=0.02),
    "fast GM2": al.GM2(2.0, "rad/s", frequency=1.0, damping=0.05)}  # fmt: skip


@rows("kind, name", paired(list(MIXED), ["oadev", "mdev", "ohdev"]))
def test_degrees_of_freedom_equal_the_dense_ones(name, kind):
    row, n = STATISTICS[name], 160
    model = WHITE + MIXED[kind]
    for m in (1, 5, 30):
        E, r = moments(quadratic_form(row, m, n), [t.sampled(RATE) for t in model])
        E = E * np.array([t.power(RATE) for t in model])
        p = E / E.sum()
        assert al.statistics.edf(row, model, np.array([m]), n, RATE)[0] == pytest.approx(1 / (p @ r @ p), rel=1e-3)


def test_limits_are_those_of_the_noise_where_a_line_stands_in_the_model():
    line = al.Sine(2.0, "rad/s", frequency=0.21)
    record = adds_no_scatter(line)
    refused(al.UsageError, "no noise", lambda: al.deviation(record, "oadev", noise=al.Model((line,))).edf)
    wave = al.simulate(al.Sine(3.0, "rad/s", frequency=0.5, phase=0.3), 4000, RATE, rng=np.random.default_rng(1)).values
    t = (np.arange(4000) + 0.5) / RATE
    np.testing.assert_allclose(wave, 3 * np.sinc(0.125) * np.sin(2 * np.pi * 0.5 * t + 0.3), atol=1e-9)


def test_models_with_shapes_are_read_as_they_are_written():
    two = al.GM(1.0, "deg/h", time_constant=10.0) + al.GM(2.0, "deg/h", time_constant=100.0)
    assert "GM = 1 deg/h with time constant 10 s" in str(two)
    again = al.Model.from_dict(two.to_dict())
    assert [t.shape for t in again] == [(10.0,), (100.0,)]
    for words, call in (
        ("occurs 2 times", lambda: two["GM"]),
        ("each term may occur once", lambda: two + al.GM(3.0, "deg/h", time_constant=10.0)),
        ("time_constant in s", lambda: term("GM", 1.0, "deg/h")),
        ("between 1e-15 and", lambda: al.GM(1.0, "deg/h", time_constant=0.0)),
        ("must be finite and not negative", lambda: al.Model("GM2 -1 deg/h 0.5 Hz 0.2")),
    ):
        refused(al.UsageError, words, call)
    assert str(al.Sine(1.0, "deg/h", frequency=2.0)) == "Sine = 1 deg/h with frequency 2 Hz"
    assert (two + al.Sine(1.0, "deg/h", frequency=2.0)).noise == two
    text = "N 0.1 deg/sqrt(h), F 1 arcsec, GMA 2 arcsec 3 s, GM2 1 deg/h 0.5 Hz 0.2, W -3 deg/h 10 min"
    model = al.Model(text)
    assert str(model["GM2"]) == "GM2 = 1 deg/h with natural frequency 0.5 Hz, damping ratio 0.2"
    again = al.Model(str(model))
    assert [(t.symbol, t.shape) for t in again] == [(t.symbol, t.shape) for t in model]
    assert al.Model.from_dict(model.to_dict()) == model
    assert model["W"].shape == (600.0,)
    assert model["W"].value < 0


@rows("symbol, signal, title", [("F", "accelerometer", "flicker of the velocity"),
                                ("GMA", "voltage", "Gauss-Markov noise of the integrated voltage")])  # fmt: skip
def test_a_term_of_the_angle_is_called_after_the_integral_of_what_is_measured(symbol, signal, title):
    assert title_of(symbol, signal_named(signal)) == title
