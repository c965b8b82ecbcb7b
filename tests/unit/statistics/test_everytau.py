"""Quick sums at many averaging times at once against the definition, and what a curve of so many points is worth."""

from functools import partial

import numpy as np
import pytest
from numba import njit
from tests import thinned
from tests.rows import paired, refused, rows

import allanite as al
from allanite.kernels.squared import overlapped
from allanite.kernels.summed import modified
from allanite.kernels.theo import theo1
from allanite.kernels.total import SHORT, modified_total, one_by_one as part
from allanite.statistics import _warn_of_long
from allanite.statistics.fast.everytau import MIN_FACTORS, dense, groups
from allanite.statistics.fast.theofft import theo1_sums
from allanite.statistics.row import seconds

N = 20_000
second, third = partial(overlapped, order=2), partial(overlapped, order=3)
KINDS = ("white", "flicker", "random walk", "ramp", "ramp and white", "quantization")
ROWS = {"oadev": (2, False, second), "ohdev": (3, False, third), "mdev": (3, True, modified)}


def rate(kind, n=N, seed=1):
    white = np.random.default_rng(seed).standard_normal(n + 1)
    spectrum = np.fft.rfft(white[:n]) / np.sqrt(np.maximum(np.arange(n // 2 + 1), 1))
    return {
        "white": white[:n], "flicker": np.fft.irfft(spectrum, n), "random walk": np.cumsum(white[:n]),
        "ramp": 1.0 * np.arange(n), "ramp and white": 1e-3 * np.arange(n) + white[:n], "quantization": np.diff(white),
    }[kind]  # fmt: skip


def angle(kind, n=N, seed=1):
    y = rate(kind, n, seed)
    return np.concatenate(([0.0], np.cumsum(y - y[0])))


def record_of(y):
    return al.Record(y, rate=10.0, unit="deg/h", name="z")


@rows("kind, name", paired(KINDS, list(ROWS)))
def test_every_averaging_factor_equals_its_definition(name, kind):
    order, summed, direct = ROWS[name]
    x = angle(kind)
    m = np.arange(1, (x.size + summed - 1) // order + 1)
    # of a ramp the third difference leaves nothing, and the rounding of the angle is 1e-16 of its 2e8
    np.testing.assert_allclose(dense(x, m, order, summed=summed), direct(x, m), rtol=1e-9, atol=1e-10)


def test_a_strong_vibration_leaves_the_noise_at_whole_periods():
    x = np.concatenate(([0.0], np.cumsum(rate("white") + 1e5 * np.sin(2 * np.pi * np.arange(N) / 500))))
    m = np.arange(1, N // 2 + 1)
    expected = second(x, m)
    assert expected[499] < 1e-9 * expected[249]
    np.testing.assert_allclose(dense(x, m, 2), expected, rtol=1e-9)
    assert not dense(np.zeros(3001), np.arange(1, 1501), 2).any()


@rows("n, name", paired([300, 511, 513, 1537, 4099, 33_001, 300_007], list(ROWS)))
def test_every_length_of_a_record(name, n):
    """With no frame, one and many; the last group is all of the record."""
    order, summed, direct = ROWS[name]
    x = np.cumsum(rate("random walk", n, 2))
    m = np.arange(1, (x.size + summed - 1) // order + 1)
    some = np.unique(np.geomspace(1, m[-1], 40).astype(int))
    np.testing.assert_allclose(dense(x, m, order, summed=summed)[some - 1], direct(x, some), rtol=1e-9)


@rows("n, summed", [(n, summed) for n in (10, 1000, 100_000, 3_600_001) for summed in (False, True)])
def test_groups_follow_each_other_to_the_end(n, summed):
    """What no group has is computed by the definition: right, but slow."""
    bounds = groups(n, 2, summed=summed)
    assert [high for _, high in bounds[:-1]] == [low for low, _ in bounds[1:]]
    assert not bounds or 2 * (bounds[-1][1] - 1) < n <= 2 * bounds[-1][1]


@pytest.mark.slow("takes more than half a second")
@rows("kind", thinned(KINDS, 2))
def test_every_even_averaging_factor_of_theo1_equals_its_definition(kind):
    x, m = angle(kind, 4500), 2 * np.arange(1, 2251)
    np.testing.assert_allclose(theo1_sums(x, m), theo1(x, m), rtol=1e-9)


@pytest.mark.slow("takes more than half a second")
@rows("kind, low", paired(KINDS, [64, 512, 4096]))
def test_a_few_large_factors_of_theo1_equal_their_definition(kind, low):
    """With many frames, two and one; the seams count."""
    x, m = angle(kind, 60_000, 2), 2 * np.unique(np.geomspace(low // 2, 4 * low - 1, 9).astype(int))
    np.testing.assert_allclose(theo1_sums(x, m), theo1(x, m), rtol=1e-9)


@rows("n", [2, 63, 64, 65, 511, 513, 1025, 2047, 16_385])
def test_theo1_of_every_length_of_a_record(n):
    x, m = angle("random walk", n, 3), 2 * np.arange(1, n // 2 + 1)
    some = np.unique(np.geomspace(1, m.size, 30).astype(int)) - 1
    np.testing.assert_allclose(theo1_sums(x, m)[some], theo1(x, m[some]), rtol=1e-9)


@njit
def one_by_one(x, m):
    """The part of that name, which has no wrapper for Python."""
    return part(x, m)


MANY = np.array([*range(1, 40), 97, 98, 250, 251, 600, 777, 998, 999, 1000])
WAVE = 1e7 * np.sin(2 * np.pi * np.arange(3001) / 50)


@rows("x, m", [
    *((angle(kind, 3000), MANY) for kind in KINDS), (np.diff(angle("random walk", 3000)), MANY),
    (angle("white", 3000) + WAVE, np.arange(SHORT, 110)),
    *((angle("random walk", 3000)[:n], np.arange(1, (n + 1) // 3 + 1)) for n in (30, 31, 32, 90, 155)),
])  # fmt: skip
def test_windows_of_the_modified_total_deviation_together_equal_every_window_by_itself(x, m):
    """Of any noise, under a strong vibration, and of few windows."""
    np.testing.assert_allclose(modified_total(x, m), [one_by_one(x, k) for k in m], rtol=1e-9, atol=1e-14)


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
    curves = [al.deviation(record, name, taus="all", threads=threads) for threads in (1, 2)]
    np.testing.assert_allclose(curves[1].variance, curves[0].variance, rtol=1e-13)
    refused(al.UsageError, "number of threads must be at least 1", lambda: al.deviation(record, name, threads=0))


@rows("name, n", [("oadev", N), ("ohdev", N), ("mdev", N), ("totdev", 700)])
def test_limits_between_the_points_that_are_worked_out(name, n):
    model = al.N(0.5, "deg/sqrt(h)") + al.K(3.0, "deg/h/sqrt(h)")
    record = al.simulate(model, n, 10.0, rng=np.random.default_rng(1))
    curve = al.deviation(record, name, taus="all", noise=model)
    last = curve.m.size - 1
    some = np.unique(np.concatenate((np.geomspace(1, last, 20), last - np.geomspace(1, last / 3, 10))).astype(int))
    exact = al.deviation(record, name, m=curve.m[some], noise=model)
    for found, wanted in zip((*curve.interval(0.95), curve.edf), (*exact.interval(0.95), exact.edf), strict=True):
        np.testing.assert_allclose(found[some], wanted, rtol=0.02 if n == N else 0.01)


def test_bias_of_many_points_is_that_of_each():
    record, model = record_of(rate("white", 3000)), al.N(1.0, "deg/sqrt(h)") + al.B(1.0, "deg/h")
    curve = al.deviation(record, "mtotdev", taus="all", noise=model, bias="exact")
    some = np.array([0, 7, 100, 500, 998])
    few = al.deviation(record, "mtotdev", m=curve.m[some], noise=model, bias="exact")
    np.testing.assert_allclose(curve.factor[some], few.factor, rtol=1e-3)


@pytest.mark.slow("takes more than half a second")
def test_a_curve_of_every_tau_has_its_limits_and_a_figure_of_few_points():
    curve = al.deviation(record_of(rate("flicker", 30_000)), "oadev", taus="all")
    assert curve.m.size == 15_000 > MIN_FACTORS
    assert all(len(line.get_xdata()) <= 400 for line in al.plot(curve).axes[0].lines)


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
