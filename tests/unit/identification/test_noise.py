"""The likelihood against dense matrices, the identification against simulated truth."""

import numpy as np
import pytest
from scipy.fft import dct
from tests import model_of
from tests.rows import paired, refused, rows
from tests.unit.identification.records import covariance_of, forms_of

import allanite as al
from allanite.identification.likelihood.law import ThetaProfile, select, subsets
from allanite.identification.likelihood.spectrum import spectrum
from allanite.identification.likelihood.whittle import likelihood
from allanite.statistics.moments.lagsums import lag_nodes, sum_nodes
from allanite.terms import TERMS, ramp_coefficients


def simulated(coefficients, size, rate=1.0, seed=1):
    return al.simulate(model_of(coefficients), size, rate, rng=np.random.default_rng(seed))


def transformed(symbol, n):
    T = dct(np.eye(n), axis=0, norm="ortho")[1:]
    return T @ covariance_of(symbol, np.arange(n)) @ T.T


def test_the_transform_is_diagonal_but_for_the_two_edges_of_quantization():
    n, k = 96, np.arange(1.0, 96)
    a = np.sqrt(2 / n) * np.cos(np.pi * k / (2 * n))
    edges = np.outer(a, a) + np.outer(a * (-1) ** k, a * (-1) ** k)
    for symbol, off, close in (("N", 0 * edges, 1e-9), ("K", 0 * edges, 1e-9), ("Q", edges, 1e-12)):
        np.testing.assert_allclose(transformed(symbol, n), np.diag(TERMS[symbol].dct(k, n)) + off, atol=close)
    for n in (128, 512):  # of flicker only nearly
        k = np.arange(1.0, n)
        np.testing.assert_allclose(np.diag(transformed("B", n)), TERMS["B"].dct(k, n), rtol=2e-3)


@rows("symbols", ["QN", "QNBK"])
def test_the_likelihood_of_single_coefficients_is_the_dense_one(symbols):
    """n is small enough that every bin holds one coefficient; flicker's small off-diagonal terms are what is left."""
    n, rng = 60, np.random.default_rng(1)
    y = rng.standard_normal(n).cumsum() + rng.standard_normal(n)
    ours = likelihood(spectrum(al.Record(y, 1.0, "1"), detrend=False), symbols)
    c = dct(y, norm="ortho")[1:]
    dense = np.array([transformed(s, n) for s in symbols])

    def exact(theta):
        C = np.tensordot(theta, dense, 1)
        return 0.5 * (np.linalg.slogdet(C)[1] + c @ np.linalg.solve(C, c))

    points = [np.array(p)[: len(symbols)] for p in ([3.0, 1, 1e-3, 0.5], [0.5, 2, 1e-3, 1], [8.0, 0.1, 1e-3, 2])]
    differences = [ours.value(p) - exact(p) for p in points]
    np.testing.assert_allclose(np.diff(differences), 0, atol=1e-9 if "B" not in symbols else 2e-2)


def test_the_ramp_is_integrated_out_exactly():
    n, rng = 60, np.random.default_rng(2)
    y = rng.standard_normal(n).cumsum() + 0.3 * np.arange(n)
    ours = likelihood(spectrum(al.Record(y, 1.0, "1"), detrend=False), "QNKR")
    c, d = dct(y, norm="ortho")[1:], ramp_coefficients(np.arange(1.0, n), n)
    dense = np.array([transformed(s, n) for s in "QNK"])

    def exact(theta):
        C = np.tensordot(theta, dense, 1)
        Ci = np.linalg.inv(C)
        told = d @ Ci @ d
        slope = d @ Ci @ c / told
        return 0.5 * (np.linalg.slogdet(C)[1] + np.log(told) + (c - slope * d) @ Ci @ (c - slope * d)), slope, 1 / told

    points = [np.array(p) for p in ([3.0, 1, 0.5], [0.5, 2, 1], [8.0, 0.1, 2])]
    np.testing.assert_allclose(np.diff([ours.value(p) - exact(p)[0] for p in points]), 0, atol=1e-9)
    for p in points:
        eta, variance, _ = ours.directions(p)
        assert (eta[-1], variance[-1, -1]) == pytest.approx(exact(p)[1:], rel=1e-9)


@rows("symbols", ["QNBKR", "QNBK"])
def test_gradient_is_that_of_the_value(symbols):
    record = simulated({"Q": 2.0, "N": 1.0, "B": 0.3, "K": 0.05}, 3000, seed=4)
    ours, point = likelihood(spectrum(record, detrend=False), symbols), np.array([3.0, 2.0, 0.2, 0.01])
    numeric = [(ours.value(point + h) - ours.value(point - h)) / (2 * h.sum()) for h in np.diag(1e-5 * point)]
    assert ours.gradient(point) == pytest.approx(np.array(numeric), rel=1e-4, abs=1e-4 * abs(ours.value(point)))


def test_minimum_and_profile():
    ours = likelihood(spectrum(simulated({"Q": 2.0, "N": 1.0, "B": 0.5}, 20_000, seed=5), detrend=True), "QNBKR")
    fitted = subsets(ours)
    everything = fitted[-1]
    for step in np.random.default_rng(6).uniform(0.9, 1.1, (50, 4)):
        assert ours.value(everything.theta * step) >= everything.value - 1e-6
    assert all(everything.value <= subset.value + 1e-6 for subset in fitted)
    for which in (0, 1, 2):
        profile = ThetaProfile(everything, which)
        for limit in (profile.lower(3.84), profile.upper(3.84)):
            others = ours.minimise(everything.free, everything.theta, (which, limit))[1]
            assert 2 * (others - everything.value) == pytest.approx(3.84, rel=5e-3)
    assert select(fitted).free.tolist() == [True, True, True, False]


@rows("theta", [
    {"N": 1.0, "B": 0.3, "K": 0.01}, {"Q": 30.0, "N": 1.0, "B": 0.2}, {"Q": 3.0, "N": 1.0}, {"N": 1.0, "K": 0.1},
])  # fmt: skip
def test_information_equals_the_dense_fisher_information(theta):
    """Standard errors within 2 % of the exact Gaussian ones."""
    n = 512
    dense = {s: transformed(s, n) for s in theta}
    C = sum(v * dense[s] for s, v in theta.items())
    P = [np.linalg.solve(C, dense[s]) for s in theta]
    exact = np.array([[0.5 * np.trace(a @ b) for b in P] for a in P])
    record = al.Record(np.random.default_rng(1).standard_normal(n), 1.0, "1")
    ours = likelihood(spectrum(record, detrend=False), "".join(theta)).information(np.array(list(theta.values())))
    errors = [np.sqrt(np.diag(np.linalg.inv(F))) for F in (ours, exact)]
    np.testing.assert_allclose(*errors, rtol=0.02 if "Q" not in theta else 0.04)


MODELS = {"white": {"N": 1.0}, "fog": {"Q": 0.5, "N": 1.0, "B": 2.0}, "walk": {"N": 1.0, "K": 1.0}}


@rows("name, kind", paired(list(MODELS), ["increment", "count", "angle"]))
def test_every_kind_of_record_gives_the_same_coefficients(name, kind):
    y = simulated(MODELS[name], 20_000, 50.0, seed=7).values
    forms = forms_of(np.rint(y * 1e5).astype(np.int64), 1e-5 / 50, "deg", 50.0)
    reference, fit = al.identify(forms["rate"]), al.identify(forms[kind])
    for e in reference:
        assert fit[e.symbol].status == e.status
        if e.value is not None:
            assert fit[e.symbol].value == pytest.approx(e.value, rel=1e-4)
            np.testing.assert_allclose(fit[e.symbol].interval(), e.interval(), rtol=1e-3)
    for symbol, value in MODELS[name].items():
        assert fit[symbol].value == pytest.approx(np.radians(value), rel=0.3)
    whitened = [al.whitened(record, reference.model) for record in (forms["rate"], forms[kind])]
    np.testing.assert_allclose(*whitened, atol=2e-3)


def test_words_of_an_absent_term_and_terms_that_are_asked_for():
    record = al.simulate(al.N(0.1, "deg/sqrt(h)"), 30_000, 100.0, rng=np.random.default_rng(1))
    fit = al.identify(record)
    for symbol in "QBKR":
        e = fit[symbol]
        assert (e.status, e.value, e.interval()) == ("absent", None, e.profile(0.95))
        low, high = e.interval()
        assert low < 0 < high if symbol == "R" else low == 0.0  # a ramp has a sign
        assert max(high, -low) > e.upper  # two-sided beyond one-sided
        assert e.words().startswith("not identified, below ")
    assert (fit["N"].status, fit["N"].to("deg/sqrt(h)")) == ("identified", pytest.approx(0.1, rel=0.03))
    assert fit.goodness.explained

    assert [e.symbol for e in al.identify(record, terms="QNK")] == ["Q", "N", "K"]


@rows("terms, words", [
    ("NX", "known terms: Q, F, N, B, K, R, W, GM, GML, GMA, GM2, Sine"), ("NN", "once"), ("R", "at least one noise"),
    ("", "noise"),
])  # fmt: skip
def test_terms_that_cannot_be_asked_for(terms, words):
    refused(al.UsageError, words, lambda: al.identify(simulated({"N": 1.0}, 500), terms=terms))


@rows("sign", [-1, 1])
def test_a_ramp_has_its_sign_and_is_not_observable_above_a_band(sign):
    model = al.N(0.1, "deg/sqrt(h)") + al.R(sign * 0.01, "deg/h/s")
    record = al.simulate(model, 100_000, 100.0, rng=np.random.default_rng(1))
    fit, above = al.identify(record), al.identify(record, band=(1, 50))
    assert (fit["R"].to("deg/h/s"), fit["R"].status) == (pytest.approx(sign * 0.01, rel=0.1), "identified")
    low, high = fit["R"].interval(0.95)
    assert low < fit["R"].value < high
    assert above["N"].to("deg/sqrt(h)") == pytest.approx(0.1, rel=0.03)
    words = "not observable: the band begins at 1 Hz, above the frequencies where it would be visible"
    assert above["R"].words() == words


@rows("n", [10, 100, 1000, 12_345])
def test_sums_by_nodes_are_exact_for_polynomials(n):
    nodes, weights, starts = sum_nodes(np.array([3.0, 5.0]), np.array([n, 3]))
    for power in range(8):
        expected = [((first + np.arange(count)) ** power).sum() for first, count in ((3.0, n), (5.0, 3))]
        assert np.add.reduceat(weights * nodes**power, starts) == pytest.approx(expected, rel=1e-9)
    nodes, weights = lag_nodes([0.0, 7.0, 100.0], 100.0 + n)
    assert weights.sum() == pytest.approx(101 + n)
    exact = np.sqrt(np.abs(np.arange(101.0 + n) - 7)).sum()
    assert np.dot(weights, np.sqrt(np.abs(nodes - 7.0))) == pytest.approx(exact, rel=1e-5)
