"""The methods that read a curve: against exact curves, simulated truth, and each other."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import nnls
from tests import model_of, thinned
from tests.rows import paired, refused, rows

import allanite as al
from allanite.identification.curves.leastsquares import drift, moments_of, octaves, solve, standard_errors
from allanite.identification.curves.reading import rows_of
from allanite.statistics import covariance, edf, statistic_named
from allanite.statistics.moments.moments import expected_ratio

TRUTH = {"Q": 3.0, "N": 1.0, "B": 0.2, "K": 0.02, "R": 2e-4}
RATE, SIZE = 2.0, 2**14


def record_of(seed=1, size=SIZE, **coefficients):
    return al.simulate(model_of(coefficients), size, RATE, rng=np.random.default_rng(seed))


def exact(statistic, taus="octave", **coefficients):
    """A curve without scatter: the expectation of a model."""
    model = model_of(coefficients or TRUTH)
    curve = al.deviation(record_of(**(coefficients or TRUTH)), statistic, taus=taus, noise=None)
    ratio = expected_ratio(al.statistics.STATISTICS["theo1"], model, SIZE, RATE, 30)
    factor = np.where(curve.factor != 1, ratio, 1.0)
    points = zip(rows_of(curve), curve.tau, strict=True)
    plain = [float(al.expected(model, row.name, [tau], rate=RATE, size=SIZE)[0]) for row, tau in points]
    return replace(curve, variance=plain * factor, factor=factor)


READING = [(name, statistic) for name, row in al.identification.METHODS.items() for statistic in row.allowed]


def test_the_table_is_complete():
    for name, row in al.identification.METHODS.items():
        assert row.title, name
        assert row.efficiency, name
        assert (row.takes is al.Curve) == bool(row.allowed)
        assert not row.allowed or row.statistic in row.allowed


@pytest.mark.slow("takes more than half a second")
@rows("method, statistic", thinned([r for r in READING if r[0] in ("gls", "nnls", "ls")], 6))
def test_an_exact_curve_gives_its_coefficients(method, statistic):
    curve = exact(statistic)
    fit = al.identify(curve, method, terms="QNBKR")
    blind = al.statistics.STATISTICS[statistic].order > 2
    for symbol in TRUTH if not blind else "QNBK":
        assert fit.model[symbol].value == pytest.approx(TRUTH[symbol], rel=2e-3)
    if blind:
        assert (fit["R"].status, fit["R"].value, fit["R"].upper) == ("absent", None, None)
        assert any(note == f"R: {statistic} is insensitive to signal ramp" for note in fit.notes)


@rows("statistic", ["oadev", "ohdev", "mdev", "theo1", "pdev", "mtotdev", "htotdev"])
def test_moments_are_those_of_the_statistics(statistic):
    m = (2, 4, 8, 64, 1024)
    theta = np.array([v**2 for v in TRUTH.values()])
    moments = moments_of((statistic,) * 5, tuple(TRUTH), m, SIZE, RATE)
    row, model = statistic_named(statistic), model_of(TRUTH)
    C = covariance(row, model, np.array(m), SIZE, RATE)
    np.testing.assert_allclose(moments.covariance(theta), C, rtol=1e-12)
    E = moments.columns @ theta
    # degrees of freedom are those of windows that are reduced from 20 samples on, the covariance is nearer to the truth
    np.testing.assert_allclose(2 * E**2 / np.diag(C), edf(row, model, np.array(m), SIZE, RATE), rtol=1e-4)


def test_the_solution_is_that_of_the_normal_equations_and_never_negative():
    rng = np.random.default_rng(1)
    X = rng.uniform(1, 2, (9, 3))
    root = rng.standard_normal((9, 9))
    C = root @ root.T + np.eye(9)
    weight = np.linalg.inv(C)
    V = X @ [1.0, 2.0, 3.0] + 0.01 * rng.standard_normal(9)
    F = X.T @ weight @ X
    np.testing.assert_allclose(solve(X, V, C), np.linalg.solve(F, X.T @ weight @ V), rtol=1e-8)
    np.testing.assert_allclose(standard_errors(X, V, C), np.sqrt(np.diag(np.linalg.inv(F))), rtol=1e-8)
    assert solve(X, np.abs(X @ [1.0, -0.3, 1.0]), C).min() >= 0


@pytest.mark.slow("takes more than half a second")
@rows("statistic, biases, options, truth", [
    ("theoh", ("plain", "model"), {"join": 0.05, "noise": model_of({"N": 1.0, "K": 0.02})}, {"N": 1.0, "K": 0.02}),
    ("theoh", ("plain", "model"), {"join": 0.2, "noise": model_of({"N": 1.0, "K": 0.02})}, {"N": 1.0, "K": 0.02}),
    ("theo1", (None, "published"), {}, {"N": 1.0, "B": 0.5}),
])  # fmt: skip
def test_the_bias_that_a_curve_carries_is_divided_out(statistic, biases, options, truth):
    """Its own ratio or that of a model, and whatever the share up to which a hybrid is oadev."""
    record = record_of(**truth)
    curves = [al.deviation(record, statistic, bias=bias, **options) for bias in biases]
    assert not np.allclose(*(curve.variance for curve in curves), rtol=0.01)
    for method in ("gls", "nnls"):
        plain, corrected = (al.identify(curve, method, terms="".join(truth)) for curve in curves)
        for symbol in truth:
            assert plain[symbol].value == pytest.approx(corrected[symbol].value, rel=1e-9)


@pytest.mark.slow("takes more than half a second")
def test_theobr_is_theo1_less_its_bias():
    record = record_of(N=1.0, K=0.02)
    theo1, theobr = (al.identify(record, "gls", terms="NK", statistic=name)["K"] for name in ("theo1", "theobr"))
    assert theobr.value == pytest.approx(theo1.value, rel=1e-9)


@pytest.mark.slow("ensemble")
def test_standard_errors_of_gls_are_those_of_simulation():
    """60 records: the standard deviation of each value within 45 % of the mean standard error (5 sigma)."""
    fits = [al.identify(record_of(seed, N=1.0, B=0.3), "gls", terms="NB") for seed in range(1, 61)]
    for symbol, value in (("N", 1.0), ("B", 0.3)):
        found = np.array([fit[symbol].value for fit in fits])
        error = np.mean([fit[symbol].standard_error for fit in fits])
        assert found.std() == pytest.approx(error, rel=0.45)
        assert abs(found.mean() - value) < 5 * error / np.sqrt(60) + 0.1 * error
        # binomial, 60 records of 95 %: below 48 with a probability of 1e-5
        assert sum(low <= value <= high for low, high in (fit[symbol].interval() for fit in fits)) >= 48


@pytest.mark.slow("takes more than half a second")
def test_gls_says_what_it_is_sure_of():
    fit = al.identify(record_of(N=1.0), "gls", terms="QNBKR")
    assert fit["N"].status == "identified"
    low, high = fit["N"].interval(0.95)
    assert low < fit["N"].value < high < 1.1
    assert low < fit["N"].interval(0.5)[0] < fit["N"].interval(0.5)[1] < high
    for symbol in "QBKR":
        e = fit[symbol]
        assert (e.status, e.value, e.standard_error) == ("absent", None, None)
        assert e.interval(0.95) == e.profile(0.95)  # two-sided, as for terms that are claimed
        assert e.interval(0.95)[0] == 0
        assert e.words().startswith("not identified, below ")
        assert e.profile(0.95)[1] > e.upper
    notes = " ".join(fit.notes)
    assert "fitted to 13 points of oadev, 0.5 to 2048 s" in notes
    assert "chi-square" in notes


@pytest.mark.slow("takes more than half a second")
def test_a_claim_is_a_rise_of_four():
    """An absent term is claimed in about 2.3 % of records: more than 12 of 100 with a probability below 1e-5."""
    fits = (al.identify(record_of(seed, N=1.0), "gls", terms="NB") for seed in range(1, 101))
    assert sum(fit["B"].claimed for fit in fits) <= 12


def test_the_ramp_of_a_curve_has_no_sign():
    fit = al.identify(record_of(N=1.0, R=-2e-3), "gls", terms="NR")
    assert fit["R"].value == pytest.approx(2e-3, rel=0.05)
    assert any("R is given without its sign" in note for note in fit.notes)


@pytest.mark.slow("takes more than half a second")
def test_a_dense_curve_is_read_at_octaves():
    dense, sparse = (al.deviation(record_of(**TRUTH), taus=taus) for taus in ("log", "octave"))
    fit = al.identify(dense, "gls")
    assert any("more between these octaves" in note for note in fit.notes)
    tau = dense.tau[octaves(dense)]
    assert tau[-1] <= SIZE / RATE / 4
    assert np.all(np.diff(np.log2(tau)) > 0.8)
    assert np.array_equal(sparse.m[octaves(sparse)], 2 ** np.arange(13))
    assert fit["N"].value == pytest.approx(al.identify(sparse, "gls")["N"].value, rel=0.02)


SHARES = dict.fromkeys(("oadev", "pdev", "mdev", "htotdev"), 0.25) | dict.fromkeys(("theo1", "theobr", "theoh"), 0.375)


@rows("statistic, share", SHARES.items())
@rows("taus", ["octave", "log"])
def test_gls_reads_as_far_as_a_statistic_is_known_well(statistic, share, taus):
    """In 2^14 samples an octave grid meets the last averaging time, 3/8 or a quarter of the record, itself."""
    curve = al.deviation(record_of(N=1.0), statistic, taus=taus, noise=None)
    last = curve.tau[octaves(curve)][-1] / (SIZE / RATE)
    assert share * (1 - 1e-9 if taus == "octave" else 0.9) < last <= share * (1 + 1e-9)


def test_gls_of_a_curve_with_gaps_scatters_more():
    record = record_of(N=1.0)
    at = np.arange(SIZE)
    gap = al.Record(np.where((at < 4000) | (at >= 9000), record.values, np.nan), RATE, record.unit)
    whole, lost = (al.identify(r, "gls", terms="NB") for r in (record, gap))
    assert any("gaps" in note for note in lost.notes)
    assert not any("gaps" in note for note in whole.notes)
    assert 1.1 < lost["N"].standard_error / whole["N"].standard_error < 1.4


@pytest.mark.slow("takes more than half a second")
def test_statistics_may_be_chosen():
    record = record_of(N=1.0, B=0.5)
    for statistic in al.identification.METHODS["gls"].allowed:
        fit = al.identify(record, "gls", terms="NB", statistic=statistic)
        assert (fit.curve.statistic, fit["N"].value) == (statistic, pytest.approx(1.0, rel=0.1))
        assert fit["B"].value == pytest.approx(0.5, rel=0.3)
        low, high = fit["N"].interval(0.95)
        assert 0.9 < low < fit["N"].value < high < 1.1
    assert al.identify(al.deviation(record)).method == "gls"


WRONG = [
    ({"method": "magic"}, "known methods: whittle, gls, joint, nnls, piecewise, ls, curve, slopes"),
    ({"band": (5, 1)}, "low < high"),
    ({"method": "nnls", "masks": [(0.1, 0.2)]}, "masks is for method 'whittle'"),
    ({"statistic": "oadev"}, "does not fit a curve"),
    ({"method": "joint", "statistic": "ohdev"}, "curve"),
    ({"method": "gls", "statistic": "adev"}, r"fits oadev, mdev, ohdev.*, not adev \(methods that fit adev: nnls"),
    ({"method": "gls", "statistic": "totdev"}, "not totdev$"),
    ({"method": "piecewise", "statistic": "theoh"}, "not theoh .methods that fit theoh: gls, nnls, curve.$"),
    ({"method": "curve", "statistic": "theo1"}, "fits adev, oadev, theobr, theoh, not theo1"),
    ({"method": "ls", "lines": False}, "lines is for method 'whittle', not for 'ls'"),
    ({"method": "gls", "ranges": {"N": (1, 2)}}, "ranges is for method 'piecewise', not for 'gls'"),
    ({"method": "piecewise", "ranges": {"X": (1, 2)}}, "ranges are given for X"),
    ({"method": "piecewise", "ranges": {"N": (0.1, 0.2)}}, "no point of the curve lies in the range 0.1 to 0.2 s of N"),
]


@rows("options, words", WRONG, ids=str)
def test_what_a_method_does_not_have_is_said(options, words):
    refused(al.UsageError, words, lambda: al.identify(record_of(N=1.0), **options))


SHAPELESS = [name for name, row in al.identification.METHODS.items() if not row.shapes]


@rows("method, symbol", paired(SHAPELESS, ["GM", "GMA", "Sine"]))
def test_terms_with_a_shape_are_refused(method, symbol):
    words = f"{symbol} .* has shape parameters as well: use method 'whittle'"
    refused(al.UsageError, words, lambda: al.identify(record_of(N=1.0), method, terms=f"N,{symbol}"))


CURVE = al.deviation(record_of(N=1.0))


@rows("source, options, error, words", [
    (CURVE, {"method": "gls", "statistic": "mdev"}, al.UsageError, "one of oadev, not of mdev"),
    (CURVE, {"method": "joint"}, al.UsageError, "needs the record"),
    (CURVE, {"method": "whittle"}, al.UsageError, "needs the record"),
    (CURVE, {"method": "ls", "band": (0, 1)}, al.UsageError, "band is for method 'whittle'"),
    (replace(CURVE, unit="deg/h"), {"method": "ls"}, al.UsageError, "curve in SI"),
    (replace(CURVE, size=0), {"method": "gls"}, al.UsageError, "length of the record"),
    (al.deviation(record_of(N=1.0), m=[1, 2]), {"method": "gls"}, al.DataError, "too few for 5 terms"),
    (replace(CURVE, variance=0 * CURVE.variance), {"method": "gls"}, al.DataError, "none of them zero"),
    (replace(CURVE, variance=CURVE.tau**2), {"method": "gls", "terms": "NR"}, al.DataError, "a ramp alone"),
    (record_of(N=1.0), {"band": (0, 1e-4)}, al.DataError, "fewer than 24"),
    (record_of(N=1.0, size=150), {}, al.DataError, "at least 200"),
])  # fmt: skip
def test_what_cannot_be_read_is_refused(source, options, error, words):
    refused(error, words, lambda: al.identify(source, **options))


def test_nnls_reads_up_to_a_tenth_never_below_zero_and_is_no_evidence():
    fit = al.identify(record_of(N=1.0), "nnls")
    assert all(e.value >= 0 and e.status == "reported" for e in fit)
    assert any(e.value > 0 for e in fit if e.symbol != "N")
    last = float(re.search(r"up to (\d+) s, a tenth of the record", fit.notes[0])[1])
    assert 0.9 * SIZE / RATE / 10 < last <= SIZE / RATE / 10


def test_nnls_minimises_the_relative_residuals():
    record = record_of(N=1.0, B=0.3)
    curve = al.deviation(record, taus="log")
    tau, variance = (x[curve.tau <= SIZE / RATE / 10] for x in (curve.tau, curve.variance))
    columns = [al.expected(model_of({symbol: 1.0}), "oadev", tau) / variance for symbol in "NB"]
    squares, _ = nnls(np.column_stack(columns), np.ones(tau.size))
    assert [e.value**2 for e in al.identify(record, "nnls", terms="NB")] == pytest.approx(squares, rel=1e-6)


@rows("statistic, share", [("oadev", 0.5), ("theoh", 0.75)])
def test_the_whole_curve_is_fitted_as_drawn(statistic, share):
    """To the end of the statistic, to lines of the Allan variance, with equal absolute weights."""
    fit = al.identify(exact("oadev", taus="log"), "curve", terms="QNBKR")
    assert [t.value for t in fit.model] == pytest.approx(list(TRUTH.values()), rel=2e-3)
    record = record_of(N=1.0, K=0.05)
    curve = al.deviation(record, statistic, taus="log")
    fit = al.identify(record, "curve", terms="NK", statistic=statistic)
    assert fit.notes[0].endswith(f"{curve.tau.size} points of {statistic}, 0.5 to {share * SIZE / RATE:g} s")
    assert all(e.status == "reported" for e in fit)
    squares = np.linalg.lstsq(np.column_stack((1 / curve.tau, curve.tau / 3)), curve.variance, rcond=None)[0]
    assert [e.value**2 for e in fit] == pytest.approx(squares, rel=1e-6)


def test_piecewise_is_the_mean_line_over_its_range():
    curve = al.deviation(record_of(N=2.0), taus="log")
    fit = al.identify(curve, "piecewise", terms="N", ranges={"N": (1.0, 10.0)})
    which = (curve.tau >= 1.0) & (curve.tau <= 10.0)
    line = np.mean(np.log(curve.deviation[which]) + 0.5 * np.log(curve.tau[which]))
    assert fit["N"].value == pytest.approx(np.exp(line), rel=1e-12)
    assert (fit["N"].value, fit.notes) == (pytest.approx(2.0, rel=0.05), ("N: fitted from 1 to 10 s",))


def test_piecewise_identifies_only_where_the_slope_is():
    fit = al.identify(exact("oadev", N=1.0, K=0.01), "piecewise")
    for symbol, value in (("N", 1.0), ("K", 0.01)):
        assert fit[symbol].status == "reported"
        assert value < fit[symbol].value < 1.3 * value
    for symbol in "QR":
        assert (fit[symbol].status, fit[symbol].value, fit[symbol].words()) == ("absent", None, "not identified")
        assert any(note.startswith(f"{symbol}: no part of the curve") for note in fit.notes)
    refused(al.DataError, "none of the terms", lambda: al.identify(exact("oadev", N=1.0), "piecewise", terms="K"))


def test_least_squares_reports_negative_squares():
    fit = al.identify(al.deviation(record_of(N=1.0, size=4096), taus="octave"), "ls")
    negative = [e for e in fit if e.status == "negative"]
    assert negative
    assert all(e.value < 0 for e in negative)
    assert len(fit.notes) == len(negative)
    assert not {e.symbol for e in negative} & {t.symbol for t in fit.model}


@rows("symbol, value", [("Q", 3.0), ("N", 2.0), ("K", 0.7)])
def test_slopes_read_pure_noise_and_say_when_a_slope_is_missing(symbol, value):
    fit = al.identify(al.deviation(record_of(size=100_000, **{symbol: value}), m=[1, 2, 4, 8, 16]), "slopes")
    assert fit[symbol].value == pytest.approx(value, rel=0.1)
    assert any(note.startswith("K: no part of the curve") for note in fit.notes) == (symbol != "K")


def test_joint_tells_a_ramp_from_a_random_walk():
    truth = {"N": 1.0, "K": 0.05, "R": 0.002}
    fit = al.identify(record_of(**truth), "joint", terms="NKR")
    for symbol, value in truth.items():
        assert fit[symbol].value == pytest.approx(value, rel=0.25)
    assert "below the 0.707 of a random walk" in " ".join(fit.notes)
    plain = al.identify(record_of(N=1.0, K=0.1), "joint", terms="NKR")
    assert "is no proof of a drift" in " ".join(plain.notes)


def test_drift_is_the_ramp_of_exact_curves():
    note, walk = (
        drift(*(exact(name, **truth) for name in ("oadev", "ohdev")), fitted=True)[0]
        for truth in ({"K": 0.02, "R": 1e-3}, {"N": 0.3, "K": 0.02})
    )
    assert "a ramp of about 0.001 1/s if there is only a random walk" in note
    assert 0.7071 <= float(re.search(r"is (0\.\d+) of the Allan", walk)[1]) < 0.72
    assert walk.endswith("the R of the fit is no evidence of a ramp")


@pytest.mark.slow("takes more than half a second")
def test_a_recipe_has_its_statistic_read():
    record = record_of(N=1.0, B=0.5)
    for statistic in ("theo1", "oadev"):
        (channel,) = al.analyze(record, al.Recipe(method="gls", statistic=statistic, terms="NB")).channels
        assert any(f"points of {statistic}, " in note for note in channel.fit.notes)
        assert channel.curve.statistic == statistic
