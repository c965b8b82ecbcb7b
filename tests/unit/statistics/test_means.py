"""Curves of records with gaps from means of what is there: against dense matrices, and in any pattern."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import toeplitz
from tests import thinned
from tests.rows import paired, refused, rows

import allanite as al
from allanite.core.errors import AllaniteError
from allanite.core.estimate import averaged
from allanite.statistics.estimator import integrated
from allanite.statistics.moments.lagsums import second_difference
from allanite.statistics.moments.means import MeanMoments, mean_moments, relative, structure_at, takes_means
from allanite.statistics.moments.moments import DISTINCT, grouped
from allanite.statistics.table import STATISTICS
from allanite.terms import TERMS

SIZE = 300
SYMBOLS = "QNBK"
PARTS = {2: [-1, 1], 3: [1, -2, 1]}
CASES = [("oadev", 7), ("oadev", 30), ("oadev", 110), ("haar", 30), ("ohdev", 40), ("adev", 25), ("hdev", 20)]
WHITE, FLICKER = al.N(1, "deg/sqrt(h)"), al.N(1, "deg/sqrt(h)") + al.B(3, "deg/h")


def lossy():
    rng = np.random.default_rng(0)
    y = rng.standard_normal(SIZE)
    y[rng.random(SIZE) < 0.1] = np.nan
    y[100:130] = np.nan
    return al.Record(y, 1.0, "rad/s", kind="rate")


def torn(model, size, lost, seed=1, rate=1.0):
    """A record that has lost some samples, or a share of them."""
    rng = np.random.default_rng(seed)
    record = al.simulate(model, size, rate, rng=rng)
    values = np.array(record.values)
    values[lost if isinstance(lost, slice) else rng.random(size) < lost] = np.nan
    return al.Record(values, rate, record.unit, kind="rate")


def literal(name, m):
    """The quadratic form of the variance in the readings, by its definition, and the number of windows."""
    row, record = STATISTICS[name], lossy()
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
    y, curve = np.nan_to_num(np.asarray(lossy().values)), al.deviation(lossy(), name, m=[m], noise=None)
    assert curve.count[0] == count
    assert curve.variance[0] == pytest.approx(y @ A @ y, rel=1e-9)


@rows(("name", "m"), CASES)
def test_moments_are_those_of_dense_matrices(name, m):
    A, _, places = literal(name, m)
    row, terms = STATISTICS[name], [TERMS[s] for s in SYMBOLS]
    assert takes_means(row, m, places, SIZE)
    products = [A @ toeplitz(second_difference(term, SIZE) / 2) for term in terms]
    E = np.array([np.trace(one) for one in products])
    T = np.array([[np.sum(one * other.T) for other in products] for one in products])
    found = mean_moments(row, m, places, SIZE)
    expectation = found.expectation(terms)
    np.testing.assert_allclose(expectation[1], E[1], rtol=1e-12)
    assert E[1] == pytest.approx(al.expected(al.N(1, "rad/sqrt(s)"), name, float(m), rate=1.0)[0], rel=1e-9)
    np.testing.assert_allclose(expectation, E, rtol=0.04)
    r, exact = relative([found.under(term) for term in terms]), T / np.outer(E, E)
    np.testing.assert_allclose(r[1:, 1:], exact[1:, 1:], rtol=0.05)
    # of windows that start every quarter of m, those under noise of the angle know less of each other than of all
    assert exact[0, 0] * 0.95 < r[0, 0] < 1.6 * exact[0, 0]


@pytest.mark.slow("takes more than half a second")
def test_limits_hold_where_no_window_is_complete():
    model, inside = WHITE + al.K(60, "deg/h/sqrt(h)"), []
    for seed in range(60):
        record = torn(model, 2048, 0.02, seed)
        curve = al.deviation(record, m=[205, 410, 819], noise=model)
        low, high = curve.interval()
        truth = np.sqrt(al.expected(model, "oadev", curve.tau))
        inside.append((low < truth) & (truth < high))
    refused(al.DataError, "no complete window", lambda: al.deviation(record, m=[819], gaps="complete"))
    assert (np.mean(inside, axis=0) > 0.95 - 3 * 0.028).all()


def test_few_windows_close_together_have_limits():
    noise = np.random.default_rng(5).standard_normal(3000)
    noise[2200] = np.nan  # behind a hole of seven records, of which a reading lies before it
    record = al.Record(np.concatenate((noise[:1], np.full(21_000, np.nan), noise[1:])), 50.0, "deg/s")
    curve = al.deviation(record, m=[4, 128, 1024, 2048, 2900, 2990], noise=al.N(60 / 50**0.5, "deg/sqrt(h)"))
    low, high = curve.interval()
    assert np.isfinite([low, high]).all()
    assert ((low < curve.deviation) & (curve.deviation < high)).all()


def test_what_the_joints_hide_is_refused():
    model = al.sensor("rlg")
    record = torn(model, 4096, 0.1, rate=100.0)
    curve = al.deviation(record, noise=model)
    assert curve.m[-1] < 1024
    assert (curve.factor >= 0.03).all()
    assert np.isfinite(curve.interval()).all()
    refused(al.DataError, "averaging factor 1024", lambda: al.deviation(record, m=[1, 1024], noise=model))


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


GAPS = [name for name, row in STATISTICS.items() if row.gaps and row.order > 1]
"""Statistics that take gaps and have limits."""


@pytest.mark.slow("many patterns of gaps")
@rows("i", list(range(40)))
def test_limits_are_numbers_in_any_pattern(i):
    rng = np.random.default_rng((1000, i))
    record = al.simulate(FLICKER, int(rng.integers(200, 4097)), 1.0, rng=rng)
    values, length = np.array(record.values), int(rng.choice([1, 1, 3, 20, 100]))
    values[lost(values.size, float(rng.uniform(0.002, 0.5)), min(length, values.size // 4), rng)] = np.nan
    record = al.Record(values, 1.0, record.unit, kind="rate")
    for name in {"oadev", GAPS[i % len(GAPS)]}:
        try:
            curve = al.deviation(record, name, noise=FLICKER)
        except AllaniteError:  # no window without a gap
            continue
        low, high = curve.interval()
        assert (np.isfinite(low) & np.isfinite(high) & (low > 0) & (low < high)).all(), name


@pytest.mark.slow("takes more than half a second")
@rows("share", thinned([0.01, 0.05, 0.2], 1))
def test_no_point_has_more_degrees_of_freedom_than_windows(share):
    for seed, statistic in paired(range(6), ["oadev", "ohdev"]):
        curve = al.deviation(torn(FLICKER, 4096, share, seed), statistic, taus="octave", noise=FLICKER)
        low, high = curve.interval()
        assert (low > 0).all()
        assert np.isfinite(high).all()
        assert (curve.edf <= curve.count * 1.001).all()


def test_a_model_without_noise_of_the_joints_hides_nothing():
    quantized, drifting = al.Q(0.7, "arcsec"), al.K(10, "deg/h/sqrt(h)")
    record = torn(quantized, 3000, slice(1466, 1468), rate=40.0)
    alone = al.deviation(record, noise=quantized)
    both = al.deviation(record, noise=averaged([quantized, drifting], [0.7, 0.3]))
    assert set(alone.m) <= set(both.m)
    assert np.isfinite(both.factor).all()
    assert al.deviation(record, noise=drifting).m.size >= both.m.size


@rows("name", ["adev", "oadev", "ohdev"])
def test_complete_windows_are_counted_run_by_run(name):
    row, rng = STATISTICS[name], np.random.default_rng(4)
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
    mean_moments(STATISTICS["oadev"], 20, integrated(lossy(), 2).places, SIZE).under(counted)
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


def windows(runs, row, m):
    return sum(int(row.count(size, np.array([m]))[0]) * times for size, times in runs)


@rows("name, m", paired(["oadev", "adev", "mdev", "theo1"], [2, 16, 48]))
def test_grouping_runs_between_gaps_keeps_their_windows(name, m):
    row, rng = STATISTICS[name], np.random.default_rng(m)
    for longest, count, rel in ((120, 25, 0.0), (3000, 3000, 0.03)):
        runs = [(int(n), 1) for n in rng.integers(1, longest, count)]
        found = grouped(runs, row, m)
        assert len(found) <= DISTINCT
        assert windows(found, row, m) == pytest.approx(windows(runs, row, m), rel=rel)
        assert all(windows([run], row, m) for run in found)  # one that holds none adds nothing
