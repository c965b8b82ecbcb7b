"""Every row of STATISTICS against its referee, and every pair of row and term against the dense matrix."""

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from tests import examples, model_of
from tests.reference import REFEREES, largest
from tests.reference.dense import moments, quadratic_form
from tests.reference.terms import UndefinedError
from tests.reference.windows import windowed
from tests.rows import paired, refused, rows

import allanite as al
from allanite.kernels.theo import theo1
from allanite.statistics import GRIDS, STATISTICS, edf
from allanite.testing import check_statistic

ROWS = list(STATISTICS)
GAPPED = ["adev", "oadev", "hdev", "ohdev", "mdev", "theo1", "haar"]


def record_of(y, rate=1.0, **options):
    return al.Record(y, **({"rate": rate, "unit": "1", "kind": "rate"} | options))


FIRST = {name: (row.parts or (row,))[-1].step for name, row in STATISTICS.items()}
RATIO = 89  # samples from which theobr and theoh have a bias ratio


def factors_of(name, n):
    """Averaging factors that the row allows."""
    row = STATISTICS[name]
    m = np.arange(1, row.largest(n) + 1)
    step = np.array([part.step for part in row.parts or (row,)])
    m = m[m % step[((m > 0.2 * n) & (len(row.parts) > 1)).astype(int)] == 0]
    if name == "theoh":  # TheoBR begins beyond the joint
        m = m[(m <= n // 5) | (3 * m > 4 * (n // 5))]
    return [k for k in m.tolist() if name != "haar" or k & (k - 1) == 0]


@rows("name", ROWS)
def test_a_row_keeps_what_it_says(name):
    check_statistic(STATISTICS[name])


@rows("name", ROWS)
@given(data=st.data())
@settings(max_examples=examples(40), deadline=None)
def test_every_factor_equals_the_referee(name, data):
    n = data.draw(st.integers(*((RATIO, 130) if STATISTICS[name].parts else (4, 60))))
    rate = data.draw(st.sampled_from([1.0, 100.0, 0.1, 1 / 3]))
    y = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1))).standard_normal(n)
    for _ in range(data.draw(st.integers(0, 2))):
        y = np.cumsum(y)
    m = factors_of(name, n)
    curve = al.deviation(record_of(y, rate), name, m=m)
    x = np.concatenate(([0.0], np.cumsum(y))) / rate
    expected = np.array([REFEREES[name](x, k, 1 / rate) for k in m])
    np.testing.assert_allclose(curve.variance, expected, rtol=1e-10, atol=1e-10 * expected.max() * 1e-6)


@rows("name", [name for name, row in STATISTICS.items() if not row.parts])
@rows("n", [4, 5, 9, 30, 61])
def test_the_largest_factor_is_that_of_the_referee(name, n):
    row, record = STATISTICS[name], record_of(np.random.default_rng(1).standard_normal(n))
    known = {"totdev": n - 1, "haar": n // 2}  # one less than the folded record reaches; not the dyadic ones only
    most = row.largest(n)
    assert most == known.get(name, largest(name, n))
    words = f"{most} for {n} samples" if most else "needs at least"
    refused(al.UsageError, words, lambda: al.deviation(record, name, m=[most + row.step]))


@rows("name", ["oadev", "adev", "ohdev", "hdev", "mdev", "pdev", "totdev", "mtotdev", "htotdev"])
def test_long_records_cross_every_block_border(name):
    y = np.cumsum(np.random.default_rng(1).standard_normal(20_011))
    m = [1, 2, 3, 64, 700] if name == "pdev" else [1, 2, 3, 1000, 4096, 6660]
    if name in ("mtotdev", "htotdev"):
        m, y = m[:3], y[:3000]
    x = np.concatenate(([0.0], np.cumsum((y - y.mean()).astype(np.longdouble))))
    expected = [float(REFEREES[name](x, k, 1)) for k in m]
    np.testing.assert_allclose(al.deviation(record_of(y), name, m=m).variance, expected, rtol=1e-10)


@rows("name", GAPPED)
@given(seed=st.integers(0, 10_000), lost=st.integers(1, 6), n=st.integers(20, 90))
@settings(max_examples=examples(30), deadline=None)
def test_windows_that_touch_a_gap_are_dropped(name, seed, lost, n):
    rng = np.random.default_rng(seed)
    y = rng.standard_normal(n)
    y[rng.integers(0, n, lost)] = np.nan
    for m in range(FIRST[name], STATISTICS[name].largest(n) + 1, FIRST[name]):
        try:
            variance, count = windowed(y, m, name)
        except UndefinedError:
            with pytest.raises(al.DataError):
                al.deviation(record_of(y), name, m=[m], gaps="complete")
        else:
            curve = al.deviation(record_of(y), name, m=[m], gaps="complete")
            assert (curve.count[0], curve.variance[0]) == (count, pytest.approx(variance, rel=1e-9))


def test_the_parabolic_deviation_leaves_out_the_last_window_of_every_run():
    y = np.random.default_rng(1).standard_normal(100)
    y[[20, 50, 70]] = np.nan
    assert al.deviation(record_of(y), "pdev", m=[2]).count[0] == windowed(y, 2, "pdev")[1] - 3


@rows("name", ROWS)
def test_gaps_leave_a_named_grid_shorter_or_are_refused(name):
    y = np.random.default_rng(1).standard_normal(1000)
    whole = al.deviation(record_of(y), name)
    y[[250, 251, 640]] = np.nan
    if not STATISTICS[name].gaps:
        with pytest.raises(al.DataError):
            al.deviation(record_of(y), name)
        return
    curve = al.deviation(record_of(y), name, gaps="complete")
    assert np.isfinite(curve.variance).all()
    assert curve.m[-1] <= whole.m[-1]
    assert np.all(curve.count < whole.count[: curve.m.size])


@rows("constant, name", paired([0.0, 1.0, -1e6, 1e9], [name for name, row in STATISTICS.items() if row.order > 1]))
def test_a_constant_changes_nothing(name, constant):
    y = np.round(np.random.default_rng(2).standard_normal(5000) * 2**20) / 2**20
    plain = al.deviation(record_of(y), name, taus="octave")
    moved = al.deviation(record_of(y + constant), name, taus="octave")
    np.testing.assert_allclose(moved.variance, plain.variance, rtol=1e-14)


@rows("name", ROWS)
@given(scale=st.floats(1e-6, 1e6), seed=st.integers(0, 1000))
@settings(max_examples=examples(20), deadline=None)
def test_scale_and_time_reversal(name, scale, seed):
    y = np.random.default_rng(seed).standard_normal(96)
    factors = [m for m in (1, 2, 8, 32) if m in factors_of(name, 96)]
    plain = al.deviation(record_of(y), name, m=factors).deviation
    np.testing.assert_allclose(al.deviation(record_of(scale * y), name, m=factors).deviation, scale * plain, rtol=1e-9)
    if name != "pdev":  # which leaves out the last window
        np.testing.assert_allclose(al.deviation(record_of(y[::-1]), name, m=factors).deviation, plain, rtol=1e-9)


@rows("name", ROWS)
def test_rate_increment_count_and_angle_are_one_record(name):
    counts = np.random.default_rng(3).integers(-50, 50, 3000)
    forms = [
        record_of(counts, 100.0, unit="arcsec", kind="count", scale=0.1),
        record_of(counts * 0.1, 100.0, unit="arcsec", kind="increment"),
        record_of(counts * 10.0, 100.0, unit="arcsec/s", kind="rate"),
        record_of(np.concatenate(([7], 7 + np.cumsum(counts))), 100.0, unit="arcsec", kind="angle", scale=0.1),
    ]
    first, *others = (al.deviation(record, name, taus="octave").variance for record in forms)
    for other in others:
        np.testing.assert_allclose(other, first, rtol=1e-11)


@rows("name", [name for name, row in STATISTICS.items() if row.order > 2])
def test_a_ramp_changes_nothing_for_third_differences(name):
    y = np.random.default_rng(5).standard_normal(400)
    plain = al.deviation(record_of(y), name).variance
    moved = al.deviation(record_of(y + 0.25 * np.arange(400)), name).variance
    np.testing.assert_allclose(moved, plain, rtol=1e-9)


@rows("name", ROWS)
def test_single_precision_costs_no_digits_and_channels_no_order(name):
    y = np.random.default_rng(6).standard_normal(500).astype(np.float32)
    z = np.random.default_rng(7).standard_normal(500)
    single = al.deviation(record_of(y), name).variance
    np.testing.assert_array_equal(single, al.deviation(record_of(y.astype(np.float64)), name).variance)
    al.deviation(record_of(z), name)
    np.testing.assert_array_equal(single, al.deviation(record_of(y), name).variance)


@rows("name", ["adev", "oadev", "hdev", "ohdev"])
def test_integers_are_exact_whatever_their_bias(name):
    counts = np.random.default_rng(4).integers(-3, 4, 4000)
    x = [0, *np.cumsum(counts).tolist()]
    record = record_of(counts + 10**15, unit="1", kind="rate")
    order, norm = (2, 2) if "adev" in name else (3, 6)
    for m in (1, 7, 1000):
        step = m if not name.startswith("o") else 1
        d = [
            sum((-1) ** k * math.comb(order, k) * x[i + k * m] for k in range(order + 1))
            for i in range(0, len(x) - order * m, step)
        ]
        exact = sum(v * v for v in d) / (norm * m**2 * len(d))
        assert al.deviation(record, name, m=[m]).variance[0] == pytest.approx(exact, rel=1e-15)


MIXTURES = ["Q", "N", "B", "K", "QN", "NB", "NK", "QNBK", "NKR", "NR"]
SIZES = {"Q": 3.0, "N": 1.0, "B": 0.5, "K": 0.1, "R": 0.02}


def mixture(symbols):
    return model_of({symbol: SIZES[symbol] for symbol in symbols})


def dense(A, model):
    """Expectation and degrees of freedom of a quadratic form."""
    E, r = moments(A, [t.row for t in model])
    E = E * np.array([t.value**2 for t in model])
    return E.sum(), E.sum() ** 2 / (E @ r @ E)


@rows("name", ["adev", "oadev", "haar", "hdev", "ohdev", "mdev", "tdev"])
@rows("symbols, m", paired(MIXTURES, [1, 3, 16, 40]))
def test_moments_equal_the_dense_matrix(name, symbols, m):
    n, row, model = 128, STATISTICS[name], mixture(symbols)
    E, freedom = dense(strided_form(row, m, n), model)
    assert al.expected(model, name, float(m), rate=1.0)[0] == pytest.approx(E * m ** (2.0 * row.power), rel=1e-8)
    assert edf(row, model, np.array([m]), n, 1.0)[0] == pytest.approx(freedom, rel=2e-6)


def strided_form(row, m, n):
    """The quadratic form, with windows every m samples where they do not overlap."""
    if row.overlapped:
        return quadratic_form(row, m, n)
    A = np.zeros((n + 1, n + 1))
    count = int(row.count(n, np.array([m]))[0])
    _, (weights,) = row.window(m)
    for i in range(count):
        A[i * m : i * m + weights.size, i * m : i * m + weights.size] += np.outer(weights, weights)
    return A / (count * float(row.norm(np.array([m]))[0]) * m**2)


@rows("name, symbols", paired(["oadev", "ohdev", "mdev"], ["Q", "N", "B", "K", "QNBK", "NKR"]))
def test_gaps_cut_the_moments_into_those_of_the_runs(name, symbols):
    n, m, row, model = 240, 8, STATISTICS[name], mixture(symbols)
    runs = [(100, 1), (59, 1), (79, 1)]
    A, at = np.zeros((n + 1, n + 1)), 0
    counts = [int(row.count(size, np.array([m]))[0]) for size, _ in runs]
    for (size, _), count in zip(runs, counts, strict=True):
        A[at : at + size + 1, at : at + size + 1] += quadratic_form(row, m, size) * count / sum(counts)
        at += size + 1  # one sample is lost
    found = edf(row, model, np.array([m]), runs, 1.0)[0]
    assert found == pytest.approx(dense(A, model)[1], rel=5e-3 if "B" in symbols else 2e-6)


GOLDEN = {  # confidence of Q, N, B, K alone and in equal shares, by exact lag sums
    ("oadev", 256, 1): (131.4079, 170.2225, 224.7336, 226.7655, 219.7272),
    ("oadev", 256, 8): (126.0955, 45.0611, 35.7201, 28.2479, 63.1525),
    ("oadev", 256, 64): (89.0687, 4.0194, 3.0161, 2.2494, 5.6898),
    ("oadev", 3_600_000, 1000): (1850665.04, 5397.7449, 4204.1564, 3336.2112, 8789.8083),
    ("oadev", 3_600_000, 360_000): (1582901.3, 12.8000, 9.9117, 7.7475, 20.3578),
    ("ohdev", 256, 8): (103.1659, 37.4083, 29.8236, 28.7627, 49.2645),
    ("ohdev", 256, 64): (63.8941, 2.8635, 2.0830, 1.8167, 3.8462),
    ("ohdev", 3_600_000, 1000): (1557424.4, 4625.5353, 3608.3664, 3481.5374, 7199.4414),
    ("mdev", 256, 8): (37.5652, 29.1054, 28.2712, 22.8312, 37.3511),
    ("mdev", 256, 64): (2.8848, 1.8363, 1.5869, 1.3007, 1.8644),
    ("mdev", 3_600_000, 1000): (4625.5366, 3481.5402, 3404.9163, 2762.4957, 4542.6559),
}


@rows("case", list(GOLDEN))
def test_golden_degrees_of_freedom(case):
    name, n, m = case
    row, symbols = STATISTICS[name], "QNBK"
    models = [model_of({symbol: 1.0}) for symbol in symbols]
    levels = [al.expected(model, name, float(m), rate=1.0)[0] for model in models]
    models.append(model_of({symbol: level**-0.5 for symbol, level in zip(symbols, levels, strict=True)}))
    found = [edf(row, model, np.array([m]), n, 1.0)[0] for model in models]
    np.testing.assert_allclose(found, GOLDEN[case], rtol=3e-6, atol=6e-5)


@rows("name", ["totdev", "mtotdev", "ttotdev", "htotdev", "theo1", "theobr", "theoh", "pdev"])
def test_every_row_has_confidence_limits(name):
    record = record_of(np.random.default_rng(1).standard_normal(2000))
    curve = al.deviation(record, name, noise=mixture("NK"))
    low, high = curve.interval(0.95)
    assert np.all((low < curve.deviation) & (curve.deviation < high) & (curve.edf >= 1))


@rows("grid", list(GRIDS))
@given(largest=st.integers(1, 3_000_000))
@settings(max_examples=examples(30), deadline=None)
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
        ({"taus": "often"}, "known grids: octave"), ({"taus": [0.4]}, "not a multiple"),
        ({"taus": [6.0]}, "above 0 s and up to 5 s for a record of 10 s, not 6 s"),
        ({"m": [0]}, "between 1 and 5"), ({"m": [1.5]}, "integers"), ({"m": []}, "between 1 and 5"),
        ({"statistic": "nadev"}, "unknown statistic 'nadev'; did you mean adev"),
    ]:  # fmt: skip
        refused(al.UsageError, words, lambda options=options: al.deviation(record, **options))


def test_upper_case_in_the_name_of_a_statistic_does_not_matter():
    record = al.Record(np.random.default_rng(1).standard_normal(1000), rate=1.0, unit="deg/h", name="gx")
    assert [al.deviation(record, name).statistic for name in ("OADEV", "TheoH")] == ["oadev", "theoh"]
    assert al.Recipe(statistic="MDEV").statistic == "mdev"
    assert al.Accumulator(1.0, "deg/h", statistic="TDEV").row.name == "tdev"
    assert al.identify(record, "gls", statistic="OADEV")["N"].value > 0


@pytest.mark.slow("seconds of analyses")
@rows("m", [12, 100, 1000])
def test_theo1_of_a_long_random_walk_keeps_its_digits(m):
    """By the path that the program takes by itself, against the definition: in extended precision as far as it goes."""
    record = record_of(np.cumsum(np.random.default_rng(1).standard_normal(720_000)), 100.0)
    found = al.deviation(record, "theo1", m=[m], noise=None).variance[0]
    x = np.concatenate(([0], np.cumsum(record.values.astype(np.longdouble) - record.constant)))
    windows, ahead = x.size - m, range(1, m // 2 + 1 if m <= 100 else 0)
    parts = [(((x[:windows] - x[v:][:windows]) + (x[m:] - x[m - v :][:windows])) ** 2).sum() / v for v in ahead]
    total = sum(parts) if parts else theo1(x.astype(np.float64), np.array([m]))[0]
    assert found == pytest.approx(float(total / (0.75 * windows * m**2)), rel=1e-8)
