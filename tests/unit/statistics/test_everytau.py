"""Every averaging time at once against the definition, and what a curve of so many points is worth."""

import re
from functools import partial

import numpy as np
import pytest
from tests.rows import paired, refused, rows

import allanite as al
from allanite.kernels.squared import overlapped
from allanite.kernels.summed import modified
from allanite.reporting import table, to_csv
from allanite.statistics import _warn_of_long
from allanite.statistics.fast.everytau import MIN_FACTORS, dense, groups
from allanite.statistics.row import seconds
from allanite.study.survey import Deviations, survey

N = 20_000
second, third = partial(overlapped, order=2), partial(overlapped, order=3)
KINDS = ("white", "flicker", "random walk", "ramp", "ramp and white", "quantization")
ROWS = {"oadev": (2, False, second), "ohdev": (3, False, third), "mdev": (3, True, modified)}


def rate(kind, n=N, seed=1):
    rng = np.random.default_rng(seed)
    white = rng.standard_normal(n + 1)
    spectrum = np.fft.rfft(white[:n]) / np.sqrt(np.maximum(np.arange(n // 2 + 1), 1))
    return {
        "white": white[:n], "flicker": np.fft.irfft(spectrum, n), "random walk": np.cumsum(white[:n]),
        "ramp": 1.0 * np.arange(n), "ramp and white": 1e-3 * np.arange(n) + white[:n], "quantization": np.diff(white),
    }[kind]  # fmt: skip


def record_of(y, **options):
    return al.Record(np.asarray(y), **({"rate": 10.0, "unit": "deg/h", "kind": "rate", "name": "z"} | options))


@rows("kind, name", paired(KINDS, list(ROWS)))
def test_every_averaging_factor_equals_its_definition(name, kind):
    order, summed, direct = ROWS[name]
    y = rate(kind)
    x = np.concatenate(([0.0], np.cumsum(y - y[0])))
    m = np.arange(1, (x.size + summed - 1) // order + 1)
    found, expected = dense(x, m, order, summed=summed), direct(x, m)
    # of a ramp the third difference leaves nothing, and the rounding of the angle is 1e-16 of its 2e8
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-10)


def test_a_strong_vibration_leaves_the_noise_at_whole_periods():
    y = rate("white") + 1e5 * np.sin(2 * np.pi * np.arange(N) / 500)
    x = np.concatenate(([0.0], np.cumsum(y)))
    m = np.arange(1, N // 2 + 1)
    found, expected = dense(x, m, 2), second(x, m)
    assert expected[499] < 1e-9 * expected[249]
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    assert not dense(np.zeros(3001), np.arange(1, 1501), 2).any()


@rows("n, name", paired([300, 511, 513, 1537, 4099, 33_001, 300_007], list(ROWS)))
def test_every_length_of_a_record(name, n):
    """With no frame, one and many; the last group is all of the record."""
    order, summed, direct = ROWS[name]
    x = np.cumsum(rate("random walk", n, 2))
    m = np.arange(1, (x.size + summed - 1) // order + 1)
    found = dense(x, m, order, summed=summed)
    some = np.unique(np.geomspace(1, m[-1], 40).astype(int))
    np.testing.assert_allclose(found[some - 1], direct(x, some), rtol=1e-9)


@rows("n", [10, 1000, 100_000, 3_600_001])
@rows("summed", [False, True])
def test_groups_follow_each_other_to_the_end(n, summed):
    found = groups(n, 2, summed=summed)
    assert [high for _, high in found[:-1]] == [low for low, _ in found[1:]]
    assert not found or 2 * (found[-1][1] - 1) < n <= 2 * found[-1][1]


@rows("name", ["oadev", "haar", "ohdev", "mdev", "tdev"])
def test_a_record_with_gaps(name):
    y = rate("random walk")
    y[[3000, 3001, 12_000]] = np.nan
    curve = al.deviation(record_of(y), name, taus="all", gaps="complete")
    some = np.unique(np.geomspace(1, curve.m.size, 30).astype(int)) - 1
    few = al.deviation(record_of(y), name, m=curve.m[some], gaps="complete")
    np.testing.assert_allclose(curve.variance[some], few.variance, rtol=1e-9)
    np.testing.assert_array_equal(curve.count[some], few.count)


@rows("name", ["oadev", "mdev", "adev", "theo1", "totdev", "theoh"])
def test_threads_give_the_same_numbers(name):
    record = record_of(rate("flicker", 6000))
    one = al.deviation(record, name, taus="all")
    two = al.deviation(record, name, taus="all", threads=2)
    np.testing.assert_allclose(two.variance, one.variance, rtol=1e-13)
    refused(al.UsageError, "number of threads must be at least 1", lambda: al.deviation(record, name, threads=0))


@rows("name", ["oadev", "ohdev", "mdev"])
def test_limits_between_the_points_that_are_worked_out(name):
    model = al.N(0.5, "deg/sqrt(h)") + al.K(3.0, "deg/h/sqrt(h)")
    record = al.simulate(model, N, 10.0, rng=np.random.default_rng(1))
    curve = al.deviation(record, name, taus="all", noise=model)
    last = curve.m.size - 1
    some = np.unique(np.concatenate((np.geomspace(1, last, 20), last - np.geomspace(1, last / 3, 10))).astype(int))
    exact = al.deviation(record, name, m=curve.m[some], noise=model)
    for found, wanted in zip((*curve.interval(0.95), curve.edf), (*exact.interval(0.95), exact.edf), strict=True):
        np.testing.assert_allclose(found[some], wanted, rtol=0.02)


def test_bias_of_many_points_is_that_of_each():
    record = record_of(rate("white", 3000))
    model = al.N(1.0, "deg/sqrt(h)") + al.B(1.0, "deg/h")
    curve = al.deviation(record, "mtotdev", taus="all", noise=model, bias="exact")
    some = np.array([0, 7, 100, 500, 998])
    few = al.deviation(record, "mtotdev", m=curve.m[some], noise=model, bias="exact")
    np.testing.assert_allclose(curve.factor[some], few.factor, rtol=1e-3)


@pytest.mark.slow("takes more than half a second")
def test_a_curve_of_every_tau_has_its_limits_and_a_figure_of_few_points():
    record = record_of(rate("flicker", 300_000))
    curve = al.deviation(record, "oadev", taus="all")
    figure = al.plot(curve)
    assert curve.m.size == 150_000 > MIN_FACTORS
    assert all(len(line.get_xdata()) <= 400 for line in figure.axes[0].lines)


def test_what_takes_minutes_is_warned_of():
    row = al.statistics.STATISTICS["mtotdev"]
    m = np.arange(1, row.largest(200_000) + 1)
    assert 30 < seconds(row, 200_000, m) < 600
    assert seconds(row, 200_000, m[:100]) < 1
    assert seconds(al.statistics.STATISTICS["oadev"], 3_600_000, np.arange(1, 1_800_001)) == 0
    assert seconds(al.statistics.STATISTICS["theoh"], 3_600_000, np.array([1, 2, 1_000_000])) > 30
    words = r"mtotdev at 66667 averaging times of 200000 samples takes about \d+ min"
    with pytest.warns(al.statistics.LongJobWarning, match=words):
        _warn_of_long(row, 200_000, m, 1)


def test_a_table_of_every_tau_is_short_and_its_csv_whole():
    record = record_of(rate("white", 6000))
    found = survey(record, Deviations(taus="all", intervals=False))
    text = table(found)
    assert re.search(r"2\d of 3000 rows; --csv writes all", text)
    assert len(text.splitlines()) < 45
    assert len(to_csv(found).splitlines()) == 3001
