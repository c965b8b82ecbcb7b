"""Curves of records with gaps from means of what is there: against dense matrices, and in any pattern."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import toeplitz
from tests.rows import refused, rows

import allanite as al
from allanite.core.errors import AllaniteError
from allanite.core.estimate import averaged
from allanite.statistics.estimator import integrated
from allanite.statistics.moments.lagsums import second_difference
from allanite.statistics.moments.means import MeanMoments, mean_moments, relative, structure_at, takes_means
from allanite.terms import TERMS

SIZE = 300
SYMBOLS = "QNBK"
PARTS = {2: [-1, 1], 3: [1, -2, 1]}
CASES = [("oadev", 7), ("oadev", 30), ("oadev", 110), ("haar", 30), ("ohdev", 40), ("adev", 25), ("hdev", 20)]


def lossy():
    rng = np.random.default_rng(0)
    y = rng.standard_normal(SIZE)
    y[rng.random(SIZE) < 0.1] = np.nan
    y[100:130] = np.nan
    return al.Record(y, 1.0, "rad/s", kind="rate")


def literal(name, m):
    """The quadratic form of the variance in the readings, by its definition, and the number of windows."""
    row, record = al.statistics.STATISTICS[name], lossy()
    places = integrated(record, 2).places
    there = np.zeros(SIZE, dtype=bool)
    for start, n in places:
        there[start : start + n] = True
    signs, rows, worth = PARTS[row.differences], [], []
    for i in range(0, SIZE - len(signs) * m + 1, 1 if row.overlapped else m):
        at = [i + p * m + np.flatnonzero(there[i + p * m : i + (p + 1) * m]) for p in range(len(signs))]
        if all(one.size for one in at):
            rows.append(np.zeros(SIZE))
            for one, sign in zip(at, signs, strict=True):
                rows[-1][one] = sign / one.size
            worth.append(1 / sum(sign**2 / one.size for one, sign in zip(at, signs, strict=True)))
    R, h = np.array(rows), np.array(worth)
    norm = row.norm(np.array([m]))[0] / np.square(signs).sum()
    return (R.T * h**2) @ R / (m * h.sum() * norm), h.size, places


@rows(("name", "m"), CASES)
def test_the_variance_is_that_of_its_definition(name, m):
    A, count, _ = literal(name, m)
    record = lossy()
    y = np.nan_to_num(np.asarray(record.values))
    curve = al.deviation(record, name, m=[m], noise=None)
    assert curve.count[0] == count
    assert curve.variance[0] == pytest.approx(y @ A @ y, rel=1e-9)


@rows(("name", "m"), CASES)
def test_moments_are_those_of_dense_matrices(name, m):
    A, _, places = literal(name, m)
    row, terms = al.statistics.STATISTICS[name], [TERMS[s] for s in SYMBOLS]
    assert takes_means(row, m, places, SIZE)
    products = [A @ toeplitz(second_difference(term, SIZE) / 2) for term in terms]
    E = np.array([np.trace(one) for one in products])
    T = np.array([[np.sum(one * other.T) for other in products] for one in products])
    found = mean_moments(row, m, places, SIZE)
    expectation = found.expectation(terms)
    np.testing.assert_allclose(expectation[1], E[1], rtol=1e-12)
    np.testing.assert_allclose(expectation, E, rtol=0.04)
    r = relative([found.under(term) for term in terms])
    np.testing.assert_allclose(r[1:, 1:], (T / np.outer(E, E))[1:, 1:], rtol=0.05)
    # of windows that start every quarter of m, those under noise of the angle know less of each other than of all
    assert (T / np.outer(E, E))[0, 0] * 0.95 < r[0, 0] < 1.6 * (T / np.outer(E, E))[0, 0]


def test_white_noise_is_met_at_every_tau():
    model, ratio = al.Model((al.N(1, "deg/sqrt(h)"),)), []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        record = al.simulate(model, 1500, 1.0, rng=rng)
        values = np.array(record.values)
        values[rng.random(1500) < 0.3] = np.nan
        curve = al.deviation(al.Record(values, 1.0, record.unit, kind="rate"), noise=None, m=[1, 4, 16, 64, 256])
        ratio.append(curve.variance / al.expected(model, "oadev", curve.tau))
    error = np.std(ratio, axis=0) / np.sqrt(len(ratio))
    assert np.all(np.abs(np.mean(ratio, axis=0) - 1) < 3.3 * error)


@pytest.mark.slow("takes more than half a second")
def test_limits_hold_where_no_window_is_complete():
    model, inside = al.N(1, "deg/sqrt(h)") + al.K(60, "deg/h/sqrt(h)"), []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        record = al.simulate(model, 2048, 1.0, rng=rng)
        values = np.array(record.values)
        values[rng.random(2048) < 0.02] = np.nan
        lossy = al.Record(values, 1.0, record.unit, kind="rate")
        curve = al.deviation(lossy, m=[205, 410, 819], noise=model)
        low, high = curve.interval()
        truth = np.sqrt(al.expected(model, "oadev", curve.tau))
        inside.append((low < truth) & (truth < high))
    refused(al.DataError, "no complete window", lambda: al.deviation(lossy, m=[819], gaps="complete"))
    assert (np.mean(inside, axis=0) > 0.95 - 3 * 0.028).all()


def test_few_windows_close_together_have_limits():
    noise = np.random.default_rng(5).standard_normal(3000)
    noise[2200] = np.nan  # behind a hole of seven records, of which a reading lies before it
    record = al.Record(np.concatenate((noise[:1], np.full(21_000, np.nan), noise[1:])), 50.0, "deg/s")
    curve = al.deviation(record, m=[4, 128, 1024, 2048, 2900, 2990], noise=al.N(60 / 50**0.5, "deg/sqrt(h)"))
    low, high = curve.interval()
    assert np.isfinite([low, high]).all()
    assert (low < curve.deviation).all()
    assert (curve.deviation < high).all()


def test_what_the_joints_hide_is_refused():
    model, rng = al.sensor("rlg"), np.random.default_rng(1)
    record = al.simulate(model, 4096, 100.0, rng=rng)
    values = np.array(record.values)
    values[rng.random(4096) < 0.1] = np.nan
    torn = al.Record(values, 100.0, record.unit, kind="rate")
    curve = al.deviation(torn, noise=model)
    assert curve.m[-1] < 1024
    assert (curve.factor >= 0.03).all()
    assert np.isfinite(curve.interval()).all()
    refused(al.DataError, "averaging factor 1024", lambda: al.deviation(torn, m=[1, 1024], noise=model))


def test_a_whole_record_is_not_touched_and_another_word_is_refused():
    record = al.simulate(al.sensor("mems"), 3000, 1.0, rng=np.random.default_rng(1))
    one, two = (al.deviation(record, noise=al.sensor("mems"), gaps=gaps) for gaps in ("means", "complete"))
    np.testing.assert_array_equal(one.variance, two.variance)
    np.testing.assert_array_equal(one.interval(), two.interval())
    refused(al.UsageError, "gaps must be 'means' or 'complete'", lambda: al.deviation(lossy(), gaps="all"))


def lost(size, share, length, rng):
    """Bursts that start at random, until the share of the readings is reached."""
    gone = np.zeros(size, dtype=bool)
    while gone.mean() < share:
        start = int(rng.integers(0, size - length + 1))
        gone[start : start + length] = True
    return gone


GAPS = [name for name, row in al.statistics.STATISTICS.items() if row.gaps and row.order > 1]
"""Statistics that take gaps and have limits."""


@pytest.mark.slow("many patterns of gaps")
@rows("i", list(range(40)))
def test_limits_are_numbers_in_any_pattern(i):
    rng, noise = np.random.default_rng((1000, i)), al.N(1, "deg/sqrt(h)") + al.B(3, "deg/h")
    record = al.simulate(noise, int(rng.integers(200, 4097)), 1.0, rng=rng)
    values, length = np.array(record.values), int(rng.choice([1, 1, 3, 20, 100]))
    values[lost(values.size, float(rng.uniform(0.002, 0.5)), min(length, values.size // 4), rng)] = np.nan
    record = al.Record(values, 1.0, record.unit, kind="rate")
    for name in {"oadev", GAPS[i % len(GAPS)]}:
        try:
            curve = al.deviation(record, name, noise=noise)
        except AllaniteError:  # no window without a gap
            continue
        low, high = curve.interval()
        assert (np.isfinite(low) & np.isfinite(high) & (low > 0) & (low < high)).all(), name


def test_a_model_without_noise_of_the_joints_hides_nothing():
    quantized, drifting = al.Q(0.7, "arcsec"), al.K(10, "deg/h/sqrt(h)")
    values = al.simulate(quantized, 3000, 40.0, rng=np.random.default_rng(1)).values.copy()
    values[1466:1468] = np.nan
    torn = al.Record(values, 40.0, "rad/s", kind="rate")
    alone = al.deviation(torn, noise=quantized)
    both = al.deviation(torn, noise=averaged([quantized, drifting], [0.7, 0.3]))
    assert set(alone.m) <= set(both.m)
    assert np.isfinite(both.factor).all()
    assert al.deviation(torn, noise=drifting).m.size >= both.m.size


@rows("name", ["adev", "oadev", "ohdev"])
def test_complete_windows_are_counted_run_by_run(name):
    row, rng = al.statistics.STATISTICS[name], np.random.default_rng(4)
    lengths = rng.integers(1, 200, 30)
    places = [(0, int(n)) for n in lengths]
    m = np.arange(1, 120)
    counted = [sum(int(row.count(int(n), np.array([k]))[0]) for n in lengths) for k in m]
    whole = row.count(int(lengths.sum()) + 300, m)
    expected = np.array(counted) < 0.9 * whole
    np.testing.assert_array_equal(takes_means(row, m, places, int(lengths.sum()) + 300), expected)
    assert takes_means(row, 50, places, 10_000) == (counted[49] < 0.9 * row.count(10_000, np.array([50]))[0])


def test_a_shape_is_computed_once_a_lag_and_channels_with_the_same_gaps_share_it(monkeypatch):
    term, asked = TERMS["GM"].shaped((5.0,), 1.0), []
    lag = np.random.default_rng(1).integers(0, 50, (9, 99))
    for lags in (lag, lag * 1000):  # by a table, and one by one
        np.testing.assert_array_equal(structure_at(term, lags), term.structure(lags.astype(float)))
    counted = replace(term, structure=lambda t: [asked.append(t.size), term.structure(t)][1])
    mean_moments(al.statistics.STATISTICS["oadev"], 20, integrated(lossy(), 2).places, SIZE).under(counted)
    assert sum(asked) <= 3 * SIZE
    under, calls = MeanMoments.under, []
    monkeypatch.setattr(MeanMoments, "under", lambda *own: [calls.append(1), under(*own)][1])
    for factor in (1, 2, 3):
        model = al.N(factor, "deg/sqrt(h)") + al.GM(factor, "deg/h", time_constant=7.0)
        assert al.deviation(al.Record(factor * lossy().values, 1.0, "rad/s"), m=[20, 50], noise=model).edf.size == 2
        assert len(calls) == 4


def test_a_model_without_noise_is_refused_with_gaps_too():
    wave = al.Sine(1, "deg/s", frequency=0.1)
    refused(al.UsageError, "has no noise", lambda: al.deviation(lossy(), m=[20], noise=wave).edf)
