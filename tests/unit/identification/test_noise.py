"""The likelihood against dense matrices, the identification against simulated truth."""

import numpy as np
import pytest
from scipy.fft import dct
from tests.rows import paired, refused, rows

import allanite as al
from allanite.core.model import term
from allanite.identification.likelihood.law import ThetaProfile, select, subsets
from allanite.identification.likelihood.spectrum import spectrum
from allanite.identification.likelihood.whittle import likelihood
from allanite.statistics.moments.lagsums import lag_nodes, sum_nodes
from allanite.terms import TERMS, ramp_coefficients

UNIT = {"Q": "s", "N": "sqrt(s)", "B": "1", "K": "1/sqrt(s)", "R": "1/s"}


def model_of(**coefficients):
    return al.Model(tuple(term(s, v, UNIT[s]) for s, v in coefficients.items()))


def generalised_covariance(symbol, n):
    """Covariance of the rates up to a constant, from D alone."""
    lag = np.abs(np.subtract.outer(np.arange(n), np.arange(n))).astype(float)
    D = TERMS[symbol].structure
    return 0.5 * (D(lag + 1) - 2 * D(lag) + D(np.abs(lag - 1)))


def transformed(symbol, n):
    T = dct(np.eye(n), axis=0, norm="ortho")[1:]
    return T @ generalised_covariance(symbol, n) @ T.T


def test_the_transform_is_diagonal_but_for_the_two_edges_of_quantization():
    n, k = 96, np.arange(1.0, 96)
    a = np.sqrt(2 / n) * np.cos(np.pi * k / (2 * n))
    edges = np.outer(a, a) + np.outer(a * (-1) ** k, a * (-1) ** k)
    for symbol, off, close in (("N", 0 * edges, 1e-9), ("K", 0 * edges, 1e-9), ("Q", edges, 1e-12)):
        np.testing.assert_allclose(transformed(symbol, n), np.diag(TERMS[symbol].dct(k, n)) + off, atol=close)
    for n in (128, 512):  # of flicker only nearly
        k = np.arange(1.0, n)
        np.testing.assert_allclose(np.diag(transformed("B", n)), TERMS["B"].dct(k, n), rtol=2e-3)


def test_ramp_coefficients():
    n = 64
    np.testing.assert_allclose(
        ramp_coefficients(np.arange(1.0, n), n), dct(TERMS["R"].waveform(n), norm="ortho")[1:], atol=1e-11
    )


@rows("symbols", ["QN", "QNBK"])
def test_the_likelihood_of_single_coefficients_is_the_dense_one(symbols):
    """n is small enough that every bin holds one coefficient; flicker's small off-diagonal terms are what is left."""
    n, rng = 60, np.random.default_rng(1)
    y = rng.standard_normal(n).cumsum() + rng.standard_normal(n)
    ours = likelihood(spectrum(al.Record(y, 1.0, "1"), detrend=False), symbols)
    c = dct(y, norm="ortho")[1:]
    dense = [transformed(s, n) for s in symbols]

    def exact(theta):
        C = sum(t * d for t, d in zip(theta, dense, strict=True))
        return 0.5 * (np.linalg.slogdet(C)[1] + c @ np.linalg.solve(C, c))

    points = [np.array(p)[: len(symbols)] for p in ([3.0, 1, 1e-3, 0.5], [0.5, 2, 1e-3, 1], [8.0, 0.1, 1e-3, 2])]
    tolerance = 1e-9 if "B" not in symbols else 2e-2
    differences = [ours.value(p) - exact(p) for p in points]
    np.testing.assert_allclose(np.diff(differences), 0, atol=tolerance)


def test_the_ramp_is_integrated_out_exactly():
    n, rng = 60, np.random.default_rng(2)
    y = rng.standard_normal(n).cumsum() + 0.3 * np.arange(n)
    ours = likelihood(spectrum(al.Record(y, 1.0, "1"), detrend=False), "QNKR")
    c, d = dct(y, norm="ortho")[1:], ramp_coefficients(np.arange(1.0, n), n)
    dense = [transformed(s, n) for s in "QNK"]

    def exact(theta):
        C = sum(t * m for t, m in zip(theta, dense, strict=True))
        Ci = np.linalg.inv(C)
        slope = d @ Ci @ c / (d @ Ci @ d)
        return 0.5 * (np.linalg.slogdet(C)[1] + np.log(d @ Ci @ d) + (c - slope * d) @ Ci @ (c - slope * d)), slope

    points = [np.array(p) for p in ([3.0, 1, 0.5], [0.5, 2, 1], [8.0, 0.1, 2])]
    np.testing.assert_allclose(np.diff([ours.value(p) - exact(p)[0] for p in points]), 0, atol=1e-9)
    for p in points:
        assert ours.directions(p)[0][-1] == pytest.approx(exact(p)[1], rel=1e-9)


def test_removing_a_ramp_beforehand_changes_nothing():
    rng = np.random.default_rng(3)
    record = al.Record(rng.standard_normal(5000).cumsum() + 2.0 * np.arange(5000), 1.0, "1")
    for detrend in (False, True):
        fit = likelihood(spectrum(record, detrend=detrend), "NKR")
        theta, _ = fit.minimise(np.array([True, True]))
        slope = spectrum(record, detrend=detrend).slope + fit.directions(theta)[0][-1]
        assert (slope, theta[1]) == (pytest.approx(2.0, abs=0.1), pytest.approx(1.0, rel=0.15))


@rows("symbols", ["QNBKR", "QNBK", "NK"])
def test_gradient_is_that_of_the_value(symbols):
    record = al.simulate(model_of(Q=2.0, N=1.0, B=0.3, K=0.05), 3000, 1.0, rng=np.random.default_rng(4))
    ours = likelihood(spectrum(record, detrend=False), symbols)
    theta = {"Q": 3.0, "N": 2.0, "B": 0.2, "K": 0.01}
    point = np.array([theta[s] for s in symbols if s != "R"])
    for i in range(point.size):
        step = np.zeros_like(point)
        step[i] = 1e-5 * point[i]
        numeric = (ours.value(point + step) - ours.value(point - step)) / (2 * step[i])
        assert ours.gradient(point)[i] == pytest.approx(numeric, rel=1e-4, abs=1e-4 * abs(ours.value(point)))


def test_minimum_and_profile():
    record = al.simulate(model_of(Q=2.0, N=1.0, B=0.5), 20_000, 1.0, rng=np.random.default_rng(5))
    ours = likelihood(spectrum(record, detrend=True), "QNBKR")
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


def test_information_equals_the_dense_fisher_information():
    """Standard errors within 2 % of the exact Gaussian ones, n = 512, four mixtures."""
    n = 512
    dense = {s: transformed(s, n) for s in "QNBK"}
    k = np.arange(1.0, n)
    for theta in (
        {"N": 1.0, "B": 0.3, "K": 0.01},
        {"Q": 30.0, "N": 1.0, "B": 0.2},
        {"Q": 3.0, "N": 1.0},
        {"N": 1.0, "K": 0.1},
    ):
        C = sum(v * dense[s] for s, v in theta.items())
        P = [np.linalg.solve(C, dense[s]) for s in theta]
        exact = np.array([[0.5 * np.trace(a @ b) for b in P] for a in P])
        record = al.Record(np.random.default_rng(1).standard_normal(n), 1.0, "1")
        ours = likelihood(spectrum(record, detrend=False), "".join(theta)).information(np.array(list(theta.values())))
        errors = [np.sqrt(np.diag(np.linalg.inv(F))) for F in (ours, exact)]
        np.testing.assert_allclose(errors[0], errors[1], rtol=0.02 if "Q" not in theta else 0.04)
    assert k.size == n - 1


MODELS = {"white": {"N": 1.0}, "fog": {"Q": 0.5, "N": 1.0, "B": 2.0}, "walk": {"N": 1.0, "K": 1.0}}


@rows("name, kind", paired(list(MODELS), ["increment", "count", "angle"]))
def test_every_kind_of_record_gives_the_same_coefficients(name, kind):
    y = al.simulate(model_of(**MODELS[name]), 20_000, 50.0, rng=np.random.default_rng(7)).values
    counts = np.rint(y * 1e5).astype(np.int64)
    forms = {
        "rate": al.Record(counts * 1e-5, 50.0, "deg/s"),
        "increment": al.Record(counts * 1e-5 / 50, 50.0, "deg", kind="increment"),
        "count": al.Record(counts, 50.0, "deg", kind="count", scale=1e-5 / 50),
        "angle": al.Record(np.concatenate(([0], np.cumsum(counts))) * (1e-5 / 50), 50.0, "deg", kind="angle"),
    }
    reference, fit = al.identify(forms["rate"]), al.identify(forms[kind])
    for e in reference:
        assert fit[e.symbol].status == e.status
        if e.value is not None:
            assert fit[e.symbol].value == pytest.approx(e.value, rel=1e-4)
            np.testing.assert_allclose(fit[e.symbol].interval(), e.interval(), rtol=1e-3)
    for symbol, value in MODELS[name].items():
        rate = model_of(**{symbol: value})[symbol].value * np.pi / 180
        assert fit[symbol].value == pytest.approx(rate, rel=0.3)


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
    for terms, words in [
        ("NX", "known terms: Q, F, N, B, K, R, W, GM, GML, GMA, GM2, Sine"),
        ("NN", "once"),
        ("R", "at least one noise"),
        ("", "noise"),
    ]:
        with pytest.raises(al.UsageError, match=words):
            al.identify(record, terms=terms)


def test_wrong_methods_and_bands():
    record = al.simulate(al.N(0.1, "deg/sqrt(h)"), 5000, 100.0, rng=np.random.default_rng(1))
    curve = al.deviation(record)
    for source, options, words in [
        (record, {"method": "magic"}, "known methods: whittle, gls, joint, nnls, piecewise, ls, curve, slopes"),
        (curve, {"method": "whittle"}, "needs the record"),
        (curve, {"method": "ls", "band": (0, 1)}, "band is for method 'whittle'"),
        (record, {"band": (5, 1)}, "low < high"),
        (curve.to("deg/h"), {"method": "ls"}, "curve in SI"),
    ]:
        with pytest.raises(al.UsageError, match=words):
            al.identify(source, **options)
    refused(al.DataError, "fewer than 24", lambda: al.identify(record, band=(0, 0.01)))
    with pytest.raises(al.DataError, match="at least 200"):
        al.identify(al.Record(np.random.default_rng(1).standard_normal(150), 1.0, "deg/s"))


def test_a_band_without_low_frequencies_says_nothing_of_slow_terms():
    record = al.simulate(al.N(0.1, "deg/sqrt(h)") + al.R(1.0, "deg/h/s"), 30_000, 100.0, rng=np.random.default_rng(1))
    fit = al.identify(record, band=(1, 50))
    assert fit["N"].to("deg/sqrt(h)") == pytest.approx(0.1, rel=0.03)
    assert (
        fit["R"].words() == "not observable: the band begins at 1 Hz, above the frequencies where it would be visible"
    )


@rows("sign", [-1, 1])
def test_a_ramp_has_its_sign(sign):
    model = al.N(0.1, "deg/sqrt(h)") + al.R(sign * 0.01, "deg/h/s")
    fit = al.identify(al.simulate(model, 100_000, 100.0, rng=np.random.default_rng(1)))
    assert (fit["R"].to("deg/h/s"), fit["R"].status) == (pytest.approx(sign * 0.01, rel=0.1), "identified")
    low, high = fit["R"].interval(0.95)
    assert low < fit["R"].value < high


def test_least_squares_reports_negative_squares():
    record = al.simulate(model_of(N=1.0), 4096, 1.0, rng=np.random.default_rng(1))
    fit = al.identify(al.deviation(record, taus="octave"), "ls")
    negative = [e for e in fit if e.status == "negative"]
    assert negative
    assert all(e.value < 0 for e in negative)
    assert len(fit.notes) == len(negative)
    assert not {e.symbol for e in negative} & {t.symbol for t in fit.model}


def test_slopes_read_pure_noise_and_say_when_a_slope_is_missing():
    for symbol, value in {"Q": 3.0, "N": 2.0, "K": 0.7}.items():
        record = al.simulate(model_of(**{symbol: value}), 200_000, 1.0, rng=np.random.default_rng(1))
        curve = al.deviation(record, taus=[1.0, 2.0, 4.0, 8.0, 16.0])
        assert al.identify(curve, "slopes")[symbol].value == pytest.approx(value, rel=0.1)
    record = al.simulate(model_of(N=2.0), 20_000, 1.0, rng=np.random.default_rng(1))
    curve = al.deviation(record, taus=[1.0, 2.0, 4.0, 8.0])
    assert any(note.startswith("K: no part of the curve") for note in al.identify(curve, "slopes").notes)


@rows("n", [10, 100, 1000, 12_345])
def test_sums_by_nodes_are_exact_for_polynomials(n):
    nodes, weights, starts = sum_nodes(np.array([3.0, 5.0]), np.array([n, 3]))
    for power in range(8):
        sums = np.add.reduceat(weights * nodes**power, starts)
        assert sums[0] == pytest.approx(sum((3.0 + i) ** power for i in range(n)), rel=1e-9)
        assert sums[1] == 5.0**power + 6.0**power + 7.0**power
    nodes, weights = lag_nodes([0.0, 7.0, 100.0], 100.0 + n)
    assert weights.sum() == pytest.approx(101 + n)
    assert np.dot(weights, np.sqrt(np.abs(nodes - 7.0))) == pytest.approx(
        np.sqrt(np.abs(np.arange(101.0 + n) - 7)).sum(), rel=1e-5
    )
