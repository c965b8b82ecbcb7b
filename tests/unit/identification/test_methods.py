"""The methods that read a curve: against exact curves, simulated truth, and each other."""

import re
from dataclasses import replace

import numpy as np
import pytest
from tests import thinned
from tests.rows import refused, rows

import allanite as al
from allanite.core.model import term
from allanite.identification.curves.leastsquares import drift, moments_of, octaves, solve, standard_errors
from allanite.identification.curves.reading import rows_of
from allanite.statistics import covariance, edf, statistic_named
from allanite.statistics.moments.moments import expected_ratio
from allanite.study.analysis import Recipe

UNIT = {"Q": "s", "N": "sqrt(s)", "B": "1", "K": "1/sqrt(s)", "R": "1/s"}
TRUTH = {"Q": 3.0, "N": 1.0, "B": 0.2, "K": 0.02, "R": 2e-4}
RATE, SIZE = 2.0, 2**14


def model_of(**coefficients):
    return al.Model(tuple(term(s, v, UNIT[s]) for s, v in coefficients.items()))


def record_of(model, seed=1, size=SIZE):
    return al.simulate(model, size, RATE, rng=np.random.default_rng(seed))


def exact(statistic, model=None, taus="octave"):
    """A curve without scatter: the expectation of the model."""
    model = model or model_of(**TRUTH)
    curve = al.deviation(record_of(model), statistic, taus=taus, noise=None)
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
@rows(("method", "statistic"), thinned([r for r in READING if r[0] in ("gls", "nnls", "ls")], 6))
def test_an_exact_curve_gives_its_coefficients(method, statistic):
    curve = exact(statistic)
    fit = al.identify(curve, method, terms="QNBKR")
    seen = {t.symbol: t.value for t in fit.model}
    wanted = {s: v for s, v in TRUTH.items() if s != "R" or al.statistics.STATISTICS[statistic].order < 3}
    for symbol, value in wanted.items():
        assert seen[symbol] == pytest.approx(value, rel=2e-3)
    if len(wanted) < len(TRUTH):
        assert (fit["R"].status, fit["R"].value, fit["R"].upper) == ("absent", None, None)
        assert any(note == f"R: {statistic} is insensitive to signal ramp" for note in fit.notes)


@rows("statistic", ["oadev", "ohdev", "mdev", "theo1", "pdev", "mtotdev", "htotdev"])
def test_moments_are_those_of_the_statistics(statistic):
    m = (2, 4, 8, 64, 1024)
    theta = np.array([v**2 for v in TRUTH.values()])
    moments = moments_of((statistic,) * 5, tuple(TRUTH), m, SIZE, RATE)
    row, model = statistic_named(statistic), model_of(**TRUTH)
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
    wanted = solve(X, np.abs(X @ [1.0, -0.3, 1.0]), C)
    assert wanted.min() >= 0


@pytest.mark.slow("takes more than half a second")
def test_the_bias_ratio_of_a_hybrid_is_divided_out():
    """Whichever ratio the curve carries, its own or that of a model, and whatever the share up to which it is oadev."""
    model = model_of(N=1.0, K=0.02)
    record = record_of(model)
    fits = [
        al.identify(al.deviation(record, "theoh", bias=bias, noise=model, join=join), method, terms="NK")
        for method in ("gls", "nnls")
        for join in (0.05, 0.2)
        for bias in ("plain", "model")
    ]
    for plain, modelled in zip(fits[::2], fits[1::2], strict=True):
        for symbol in "NK":
            assert plain[symbol].value == pytest.approx(modelled[symbol].value, rel=1e-9)
    theo1, theobr = (al.identify(record, "gls", terms="NK", statistic=name) for name in ("theo1", "theobr"))
    assert theobr["K"].value == pytest.approx(theo1["K"].value, rel=1e-9)


@pytest.mark.slow("ensemble")
def test_standard_errors_of_gls_are_those_of_simulation():
    """60 records: the standard deviation of each value within 45 % of the mean standard error (5 sigma)."""
    model = model_of(N=1.0, B=0.3)
    fits = [al.identify(record_of(model, seed), "gls", terms="NB") for seed in range(1, 61)]
    for symbol, value in (("N", 1.0), ("B", 0.3)):
        found = np.array([fit[symbol].value for fit in fits])
        error = np.mean([fit[symbol].standard_error for fit in fits])
        assert found.std() == pytest.approx(error, rel=0.45)
        assert abs(found.mean() - value) < 5 * error / np.sqrt(60) + 0.1 * error
        # binomial, 60 records of 95 %: below 48 with a probability of 1e-5
        assert sum(low <= value <= high for low, high in (fit[symbol].interval() for fit in fits)) >= 48


@pytest.mark.slow("takes more than half a second")
def test_gls_says_what_it_is_sure_of():
    fit = al.identify(record_of(model_of(N=1.0)), "gls", terms="QNBKR")
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
    assert al.Fit.to_dict(fit)["method"] == "gls"


@pytest.mark.slow("takes more than half a second")
def test_a_claim_is_a_rise_of_four():
    """An absent term is claimed in about 2.3 % of records: more than 12 of 100 with a probability below 1e-5."""
    model = model_of(N=1.0)
    claimed = sum(al.identify(record_of(model, s), "gls", terms="NB")["B"].claimed for s in range(1, 101))
    assert claimed <= 12


def test_the_ramp_of_a_curve_has_no_sign():
    model = model_of(N=1.0, R=-2e-3)
    fit = al.identify(record_of(model), "gls", terms="NR")
    assert fit["R"].value == pytest.approx(2e-3, rel=0.05)
    assert any("R is given without its sign" in note for note in fit.notes)


@pytest.mark.slow("takes more than half a second")
def test_a_dense_curve_is_read_at_octaves():
    record = record_of(model_of(**TRUTH))
    dense, sparse = al.deviation(record, taus="log"), al.deviation(record, taus="octave")
    fit = al.identify(dense, "gls")
    assert any("more between these octaves" in note for note in fit.notes)
    tau = dense.tau[octaves(dense)]
    assert tau[-1] <= SIZE / RATE / 4
    assert np.all(np.diff(np.log2(tau)) > 0.8)
    assert np.array_equal(sparse.m[octaves(sparse)], 2 ** np.arange(13))
    reference = al.identify(sparse, "gls")
    assert fit["N"].value == pytest.approx(reference["N"].value, rel=0.02)


@rows(
    ("statistic", "share"), [("oadev", 0.25), ("pdev", 0.25), ("mdev", 0.25), ("htotdev", 0.25), ("theo1", 0.375),
                             ("theobr", 0.375), ("theoh", 0.375)],
)  # fmt: skip
@rows("taus", ["octave", "log"])
def test_gls_reads_as_far_as_a_statistic_is_known_well(statistic, share, taus):
    """In 2^14 samples an octave grid meets the last averaging time, 3/8 or a quarter of the record, itself."""
    curve = al.deviation(record_of(model_of(N=1.0)), statistic, taus=taus, noise=None)
    last = curve.tau[octaves(curve)][-1] / (SIZE / RATE)
    assert share * (1 - 1e-9 if taus == "octave" else 0.9) < last <= share * (1 + 1e-9)


def test_gls_of_a_curve_with_gaps_scatters_more():
    record = record_of(model_of(N=1.0))
    values = record.values.copy()
    values[4000:9000] = np.nan
    gaps = al.Record(values, RATE, record.unit)
    whole, lost = (al.identify(r, "gls", terms="NB") for r in (record, gaps))
    assert any("gaps" in note for note in lost.notes)
    assert not any("gaps" in note for note in whole.notes)
    assert 1.1 < lost["N"].standard_error / whole["N"].standard_error < 1.4


@pytest.mark.slow("takes more than half a second")
def test_a_corrected_bias_is_taken_back():
    record = record_of(model_of(N=1.0, B=0.5))
    plain, corrected = (al.deviation(record, "theo1", bias=bias) for bias in (None, "published"))
    assert not np.allclose(plain.variance, corrected.variance, rtol=0.1)
    for method in ("gls", "nnls"):
        a, b = (al.identify(curve, method, terms="NB")["B"].value for curve in (plain, corrected))
        assert a == pytest.approx(b, rel=1e-9)


@pytest.mark.slow("takes more than half a second")
def test_statistics_may_be_chosen():
    record = record_of(model_of(N=1.0, B=0.5))
    for statistic in al.identification.METHODS["gls"].allowed:
        fit = al.identify(record, "gls", terms="NB", statistic=statistic)
        assert (fit.curve.statistic, fit["N"].value) == (statistic, pytest.approx(1.0, rel=0.1))
        assert fit["B"].value == pytest.approx(0.5, rel=0.3)
        low, high = fit["N"].interval(0.95)
        assert 0.9 < low < fit["N"].value < high < 1.1
    assert al.identify(al.deviation(record)).method == "gls"


WRONG = [
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


@rows(("options", "words"), WRONG, ids=str)
def test_what_a_method_does_not_have_is_said(options, words):
    refused(al.UsageError, words, lambda: al.identify(record_of(model_of(N=1.0)), **options))


@rows("method", [name for name, row in al.identification.METHODS.items() if not row.shapes])
@rows("symbol", ["GM", "GMA", "Sine"])
def test_terms_with_a_shape_are_refused(method, symbol):
    with pytest.raises(al.UsageError, match=f"{symbol} .* has shape parameters as well: use method 'whittle'"):
        al.identify(record_of(model_of(N=1.0)), method, terms=f"N,{symbol}")


def test_curves_that_cannot_be_read():
    curve = al.deviation(record_of(model_of(N=1.0)))
    refused(al.UsageError, "one of oadev, not of mdev", lambda: al.identify(curve, "gls", statistic="mdev"))
    refused(al.UsageError, "needs the record", lambda: al.identify(curve, "joint"))
    refused(al.UsageError, "length of the record", lambda: al.identify(replace(curve, size=0), "gls"))
    with pytest.raises(al.DataError, match="too few for 5 terms"):
        al.identify(al.deviation(record_of(model_of(N=1.0)), m=[1, 2]), "gls")
    refused(al.DataError, "none of them zero", lambda: al.identify(replace(curve, variance=0 * curve.variance), "gls"))
    refused(al.DataError, "a ramp alone", lambda: al.identify(replace(curve, variance=curve.tau**2), "gls", terms="NR"))


def test_nnls_reads_up_to_a_tenth_and_never_below_zero():
    fit = al.identify(record_of(model_of(N=1.0)), "nnls")
    assert all(e.value >= 0 and e.status == "reported" for e in fit)
    last = float(re.search(r"up to (\d+) s, a tenth of the record", fit.notes[0])[1])
    assert 0.9 * SIZE / RATE / 10 < last <= SIZE / RATE / 10


def test_nnls_is_no_evidence():
    """Of white noise alone quantization is above zero in 87 of 100, fewer than 4 of 10 have 5e-5."""
    fits = [al.identify(record_of(model_of(N=1.0), seed, 2**16), "nnls", terms="QNBK") for seed in range(1, 11)]
    assert sum(fit["Q"].value > 0 for fit in fits) >= 4


def test_ls_of_a_laser_gyro_is_negative():
    """In 92 of 100 records; in fewer than 5 of 10 with a probability of 5e-5."""
    model = al.Q(0.5, "arcsec") + al.N(0.18, "arcsec/sqrt(s)") + al.B(0.05, "deg/h")
    records = (al.simulate(model, 2**16, 100.0, rng=np.random.default_rng(seed)) for seed in range(1, 11))
    fits = [al.identify(record, "ls", terms="QNB") for record in records]
    assert sum(any(e.status == "negative" for e in fit) for fit in fits) >= 5


def test_points_of_a_curve_are_not_equally_good():
    """As the page of methods says: the standard deviation of the first and last variance of an hour at 100 Hz."""
    model = al.N(0.005, "deg/sqrt(s)") + al.B(0.002, "deg/s") + al.K(3e-4, "deg/s/sqrt(s)")
    first, last = np.sqrt(2 / edf(statistic_named("oadev"), model, np.array([1, 90_000]), 360_000, 100.0))
    assert first == pytest.approx(0.003, rel=0.1)
    assert 0.8 < last < 0.95


def test_nnls_minimises_the_relative_residuals():
    record = record_of(model_of(N=1.0, B=0.3))
    curve = al.deviation(record, taus="log")
    fit = al.identify(record, "nnls", terms="NB")
    which = curve.tau <= SIZE / RATE / 10

    def misfit(N, B):
        return np.sum((1 - al.expected(model_of(N=N, B=B), "oadev", curve.tau[which]) / curve.variance[which]) ** 2)

    N, B = fit["N"].value, fit["B"].value
    least = misfit(N, B)
    for a, b in ((1.01, 1), (0.99, 1), (1, 1.02), (1, 0.98)):
        assert misfit(a * N, b * B) > least


@rows(("statistic", "share"), [("oadev", 0.5), ("theoh", 0.75)])
def test_the_whole_curve_is_fitted_as_drawn(statistic, share):
    """To the end of the statistic, to lines of the Allan variance, with equal absolute weights."""
    lines = exact("oadev", taus="log")
    fit = al.identify(lines, "curve", terms="QNBKR")
    assert [t.value for t in fit.model] == pytest.approx(list(TRUTH.values()), rel=2e-3)
    record = record_of(model_of(N=1.0, K=0.05))
    curve = al.deviation(record, statistic, taus="log")
    fit = al.identify(record, "curve", terms="NK", statistic=statistic)
    assert fit.notes[0].endswith(f"{curve.tau.size} points of {statistic}, 0.5 to {share * SIZE / RATE:g} s")
    assert all(e.status == "reported" for e in fit)
    X = np.column_stack((1 / curve.tau, curve.tau / 3))
    squares = np.linalg.lstsq(X, curve.variance, rcond=None)[0]
    assert [e.value**2 for e in fit] == pytest.approx(squares, rel=1e-6)


def test_piecewise_is_the_mean_line_over_its_range():
    curve = al.deviation(record_of(model_of(N=2.0)), taus="log")
    fit = al.identify(curve, "piecewise", terms="N", ranges={"N": (1.0, 10.0)})
    which = (curve.tau >= 1.0) & (curve.tau <= 10.0)
    line = np.mean(np.log(curve.deviation[which]) + 0.5 * np.log(curve.tau[which]))
    assert fit["N"].value == pytest.approx(np.exp(line), rel=1e-12)
    assert (fit["N"].value, fit.notes) == (pytest.approx(2.0, rel=0.05), ("N: fitted from 1 to 10 s",))


def test_piecewise_identifies_only_where_the_slope_is():
    fit = al.identify(exact("oadev", model_of(N=1.0, K=0.01)), "piecewise")
    for symbol, value in (("N", 1.0), ("K", 0.01)):
        assert fit[symbol].status == "reported"
        assert value < fit[symbol].value < 1.3 * value
    for symbol in "QR":
        assert (fit[symbol].status, fit[symbol].value, fit[symbol].words()) == ("absent", None, "not identified")
        assert any(note.startswith(f"{symbol}: no part of the curve") for note in fit.notes)
    with pytest.raises(al.DataError, match="none of the terms"):
        al.identify(exact("oadev", model_of(N=1.0)), "piecewise", terms="K")


def test_joint_tells_a_ramp_from_a_random_walk():
    truth = {"N": 1.0, "K": 0.05, "R": 0.002}
    fit = al.identify(record_of(model_of(**truth)), "joint", terms="NKR")
    for symbol, value in truth.items():
        assert fit[symbol].value == pytest.approx(value, rel=0.25)
    assert "below the 0.707 of a random walk" in " ".join(fit.notes)
    plain = al.identify(record_of(model_of(N=1.0, K=0.1)), "joint", terms="NKR")
    assert "is no proof of a drift" in " ".join(plain.notes)


def test_drift_is_the_ramp_of_exact_curves():
    truth = model_of(K=0.02, R=1e-3)
    note = drift(exact("oadev", truth), exact("ohdev", truth), fitted=True)[0]
    assert "a ramp of about 0.001 1/s if there is only a random walk" in note
    walk = model_of(N=0.3, K=0.02)
    note = drift(exact("oadev", walk), exact("ohdev", walk), fitted=True)[0]
    assert 0.7071 <= float(re.search(r"is (0\.\d+) of the Allan", note)[1]) < 0.72
    assert note.endswith("the R of the fit is no evidence of a ramp")


@pytest.mark.slow("takes more than half a second")
def test_a_recipe_has_its_statistic_read():
    record = record_of(model_of(N=1.0, B=0.5))
    for statistic in ("theo1", "oadev"):
        study = al.analyze(record, Recipe(method="gls", statistic=statistic, terms="NB"))
        fit = study.channels[0].fit
        assert any(f"points of {statistic}, " in note for note in fit.notes)
        assert study.channels[0].curve.statistic == statistic
    for method, statistic in (("gls", "totdev"), ("piecewise", "ohdev"), ("slopes", "mdev")):
        recipe = Recipe(method=method, statistic=statistic, terms="NB")
        refused(
            al.UsageError,
            f"method '{method}' fits .*, not {statistic}",
            lambda recipe=recipe: al.analyze(record, recipe),
        )
