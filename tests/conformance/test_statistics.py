"""Every row of STATISTICS against its referee, and every pair of row and term against the dense matrix."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.reference.allan import REFEREES

import allanite as al
from allanite.statistics import GRIDS, covariance, edf

ROWS = list(al.STATISTICS)
UNITS = {symbol: al.units.SIGNALS[2].si[row.power] for symbol, row in al.TERMS.items()}


def record_of(y, rate=1.0, **options):
    return al.Record(y, **({"rate": rate, "unit": "1", "kind": "rate"} | options))


@pytest.mark.parametrize("name", ROWS)
@given(data=st.data())
@settings(max_examples=40, deadline=None)
def test_every_factor_equals_the_referee(name, data):
    n = data.draw(st.integers(4, 60))
    seed = data.draw(st.integers(0, 2**32 - 1))
    rate = data.draw(st.sampled_from([1.0, 100.0, 0.1, 1 / 3]))
    y = np.random.default_rng(seed).standard_normal(n)
    curve = al.deviation(record_of(y, rate), name, taus="all")
    expected = [REFEREES[name](y.tolist(), int(m), 1 / rate) for m in curve.m]
    np.testing.assert_allclose(curve.variance, expected, rtol=1e-10)
    assert curve.m[-1] == al.STATISTICS[name].largest(n)
    np.testing.assert_allclose(curve.tau, curve.m / rate)


@pytest.mark.parametrize("name", ROWS)
def test_long_records_cross_every_block_border(name):
    y = np.random.default_rng(1).standard_normal(20_011)
    factors = [1, 2, 3, 1000, 4096, 8191, 8192, 10_005]
    curve = al.deviation(record_of(y), name, m=factors)
    x = np.concatenate(([0.0], np.cumsum(y)))
    for m, found in zip(factors, curve.variance, strict=True):
        step = m if name == "adev" else 1
        d = (x[2 * m :] - 2 * x[m:-m] + x[: -2 * m])[::step]
        np.testing.assert_allclose(found, (d**2).mean() / (2 * m**2), rtol=1e-11)


@pytest.mark.parametrize("name", ROWS)
@pytest.mark.parametrize("constant", [0.0, 1.0, -1e6, 1e9])
def test_a_constant_changes_nothing(name, constant):
    y = np.round(np.random.default_rng(2).standard_normal(5000) * 2**20) / 2**20
    plain = al.deviation(record_of(y), name, taus="log")
    moved = al.deviation(record_of(y + constant), name, taus="log")
    np.testing.assert_allclose(moved.variance, plain.variance, rtol=1e-14)


@pytest.mark.parametrize("name", ROWS)
@given(scale=st.floats(1e-6, 1e6), seed=st.integers(0, 1000))
@settings(max_examples=20, deadline=None)
def test_scale_and_time_reversal(name, scale, seed):
    y = np.random.default_rng(seed).standard_normal(64)
    factors = [1, 2, 8, 32]
    plain = al.deviation(record_of(y), name, m=factors).deviation
    np.testing.assert_allclose(al.deviation(record_of(scale * y), name, m=factors).deviation, scale * plain, rtol=1e-9)
    np.testing.assert_allclose(al.deviation(record_of(y[::-1]), name, m=factors).deviation, plain, rtol=1e-9)


@pytest.mark.parametrize("name", ROWS)
def test_rate_increment_count_and_angle_are_one_record(name):
    counts = np.random.default_rng(3).integers(-50, 50, 3000)
    forms = [
        record_of(counts, 100.0, unit="arcsec", kind="count", scale=0.1),
        record_of(counts * 0.1, 100.0, unit="arcsec", kind="increment"),
        record_of(counts * 10.0, 100.0, unit="arcsec/s", kind="rate"),
        record_of(np.concatenate(([7], 7 + np.cumsum(counts))), 100.0, unit="arcsec", kind="angle", scale=0.1),
    ]
    curves = [al.deviation(record, name, taus="octave").variance for record in forms]
    for curve in curves[1:]:
        np.testing.assert_allclose(curve, curves[0], rtol=1e-11)


@pytest.mark.parametrize("name", ROWS)
def test_integers_are_exact_whatever_their_bias(name):
    counts = np.random.default_rng(4).integers(-3, 4, 4000)
    x = np.concatenate(([0], np.cumsum(counts)))
    record = record_of(counts + 10**15, unit="1", kind="rate")
    for m in (1, 7, 1000):
        step = m if name == "adev" else 1
        d = [int(v) for v in (x[2 * m :] - 2 * x[m:-m] + x[: -2 * m])[::step]]
        exact = sum(v * v for v in d) / (2 * m**2 * len(d))
        assert al.deviation(record, name, m=[m]).variance[0] == pytest.approx(exact, rel=1e-15)


def dense(name, model, m, n):
    """Expectation and degrees of freedom from the full covariance matrix of the angle, and 2 tr(A1 G A2 G)."""
    row = al.STATISTICS[name]
    lag = np.abs(np.subtract.outer(np.arange(n + 1), np.arange(n + 1))).astype(float)
    noise = [t for t in model if t.row.waveform is None]
    G = sum(-0.5 * t.value**2 * t.row.structure(lag) for t in noise)
    F = np.zeros((int(row.count(n, np.array([m]))[0]), n + 1))
    for i in range(F.shape[0]):
        start = i if row.overlapped else i * m
        F[i, [start, start + m, start + 2 * m]] = (1, -2, 1)
    C = F @ G @ F.T
    mean = sum(t.value for t in model if t.row.waveform is not None) * m**2
    norm = row.norm * m**2 * len(F)
    return (np.trace(C) + len(F) * mean**2) / norm, C, F, G, mean, norm


MIXTURES = ["Q", "N", "B", "K", "QN", "NB", "NK", "QNBK", "NKR", "NR"]


@pytest.mark.parametrize("name", ROWS)
@pytest.mark.parametrize("symbols", MIXTURES)
@pytest.mark.parametrize("m", [1, 3, 16, 50])
def test_moments_equal_the_dense_matrix(name, symbols, m):
    n = 128
    sizes = {"Q": 3.0, "N": 1.0, "B": 0.5, "K": 0.1, "R": 0.02}
    model = al.Model(tuple(al.model.term(s, sizes[s], UNITS[s]) for s in symbols))
    expectation, C, _, _, mean, norm = dense(name, model, m, n)
    assert al.expected(model, name, float(m))[0] == pytest.approx(expectation, rel=1e-9)
    variance = (2 * (C**2).sum() + 4 * mean**2 * C.sum()) / norm**2
    found = edf(al.STATISTICS[name], model, np.array([m]), n, 1.0)[0]
    assert found == pytest.approx(2 * expectation**2 / variance, rel=2e-6)


@pytest.mark.parametrize("symbols", ["N", "B", "K", "QNBK", "NKR"])
def test_covariance_between_times_equals_the_dense_matrix(symbols):
    n, factors = 160, [1, 2, 5, 16, 40]
    sizes = {"Q": 3.0, "N": 1.0, "B": 0.5, "K": 0.1, "R": 0.02}
    model = al.Model(tuple(al.model.term(s, sizes[s], UNITS[s]) for s in symbols))
    found = covariance(al.STATISTICS["oadev"], model, np.array(factors), n, 1.0)
    for i, a in enumerate(factors):
        _, _, Fa, G, mean_a, norm_a = dense("oadev", model, a, n)
        for j, b in enumerate(factors):
            _, _, Fb, _, mean_b, norm_b = dense("oadev", model, b, n)
            C = Fa @ G @ Fb.T
            exact = (2 * (C**2).sum() + 4 * mean_a * mean_b * C.sum()) / (norm_a * norm_b)
            assert found[i, j] == pytest.approx(exact, rel=1e-5, abs=1e-12 * found[i, i])


@pytest.mark.parametrize("grid", list(GRIDS))
@given(largest=st.integers(1, 3_000_000))
@settings(max_examples=30, deadline=None)
def test_grids(grid, largest):
    m = GRIDS[grid](largest if grid != "all" else min(largest, 1000))
    assert m[0] == 1
    assert np.all(np.diff(m) > 0)
    assert m[-1] <= largest
    if grid == "log":
        assert m[-1] == largest
        assert min(largest, 100) <= m.size <= 130


def test_wrong_grids_say_what_is_possible():
    record = record_of(np.arange(10.0) ** 2)
    for options, words in [
        ({"taus": "often"}, "known are octave"),
        ({"taus": [1.4]}, "no multiple"),
        ({"taus": [6.0]}, "between 1 and 5"),
        ({"m": [0]}, "between 1 and 5"),
        ({"m": [1.5]}, "integers"),
        ({"m": []}, "between 1 and 5"),
    ]:
        with pytest.raises(al.UsageError, match=words):
            al.deviation(record, "oadev", **options)
    with pytest.raises(al.UsageError, match="known are adev, oadev"):
        al.deviation(record, "nadev")


def test_a_sample_that_is_not_finite_is_named():
    y = np.ones(100)
    y[[17, 40]] = np.nan
    with pytest.raises(al.DataError, match=r"2 of 100 readings .* the first at sample 17"):
        al.deviation(record_of(y))
