"""The compiled loops of the likelihood and the cosine transform against plain numpy, and minima of wrong models."""

import math

import numpy as np
import pytest
from numba import njit
from scipy.fft import dct
from scipy.optimize import nnls
from scipy.signal import butter
from tests import all_but
from tests.rows import paired, rows
from tests.unit.identification.records import record_of, settled

import allanite as al
from allanite.identification.likelihood import spectrum as transforms
from allanite.identification.likelihood.filters import FILTERS
from allanite.identification.likelihood.spectrum import cosine_transform, spectrum
from allanite.identification.likelihood.whittle import gain_of, likelihood
from allanite.identification.search.frame import frame_of
from allanite.identification.search.moves import exchanged, filters, less
from allanite.identification.search.search import search
from allanite.kernels.cosine import binned
from allanite.kernels.leastsquares import weighted_nnls
from allanite.kernels.whittle import _logarithms


@rows("n", [200, 201, 5000, 300_000])
def test_bins_hold_what_numpy_sums(n):
    y = np.random.default_rng(1).standard_normal(n).cumsum()
    record = al.Record(y, 1.0, "1")
    seen = spectrum(record, detrend=False)
    c = dct(y - record.constant, norm="ortho")
    squares, k = c * c, np.arange(n)
    ends = np.append(seen.first[1:], n)
    np.testing.assert_allclose(seen.power, np.add.reduceat(squares, seen.first) / seen.count, rtol=1e-12)
    np.testing.assert_array_equal(seen.peak, np.maximum.reduceat(squares, seen.first))
    assert seen.peak_at.tolist() == [a + int(squares[a:b].argmax()) for a, b in zip(seen.first, ends, strict=True)]
    size = np.sqrt(seen.power * seen.count)
    for sums, parity in ((seen.even, 0), (seen.odd, 1)):
        expected = np.add.reduceat(np.where(k % 2 == parity, c, 0.0), seen.first)
        np.testing.assert_allclose((sums - expected) / size, 0, atol=1e-12)


def test_long_bins_are_summed_to_the_last_digits():
    c = np.random.default_rng(2).standard_normal(200_001) + 3.0
    power, _, _, even, odd = binned(c, np.array([1, 200_001]))
    assert power[0] == pytest.approx(math.fsum(c[1:] ** 2) / 200_000, rel=1e-13)
    assert even[0] == pytest.approx(math.fsum(c[2::2]), rel=1e-13)
    assert odd[0] == pytest.approx(math.fsum(c[1::2]), rel=1e-13)


@pytest.mark.slow("takes more than half a second")
def test_logarithms():
    x = np.concatenate((10.0 ** np.random.default_rng(4).uniform(-300, 300, 10_000), np.linspace(0.7, 1.5, 1001)))
    logarithms = njit(_logarithms.py_func)  # a part has no wrapper for Python
    np.testing.assert_allclose(logarithms(x), np.log(x), rtol=1e-15, atol=1e-16)


@rows("seed", range(6))
def test_least_squares_from_any_start(seed):
    rng = np.random.default_rng(seed)
    columns, weight, power = np.exp(rng.normal(0, 2, (5, 80))), rng.uniform(0.1, 10, 80), rng.normal(1, 3, 80)
    expected = nnls((columns * np.sqrt(weight)).T, power * np.sqrt(weight))[0]
    assert 0 < np.count_nonzero(expected) < 5
    for first in (np.zeros(5), np.ones(5), rng.uniform(0, 1e3, 5) * (rng.random(5) < 0.5)):
        np.testing.assert_allclose(weighted_nnls(columns, power, weight, first), expected, rtol=1e-8, atol=1e-10)


def test_of_columns_that_are_alike_one_is_used():
    columns = np.ones((3, 40)) * np.array([[1.0], [3.0], [0.5]])
    for first in (np.zeros(3), np.ones(3)):
        found = weighted_nnls(columns, np.full(40, 6.0), np.ones(40), first)
        assert np.count_nonzero(found) == 1
        np.testing.assert_allclose(columns.T @ found, 6.0)


def filtered(*taps):
    return spectrum(record_of(settled(n=2**15, seed=5, behind=taps or None)), detrend=True)


@rows("symbols, cutoff", paired(["QNBKR", "NBK", "QNK", "BKR", "NK"], [0.02, 0.3, 0.9]))
def test_the_minimum_of_a_wrong_model_is_one(symbols, cutoff):
    """What a filter took away no term explains: scoring alone would converge slowly, and there may be two minima."""
    ours = likelihood(filtered(*butter(1, cutoff)), symbols)
    free = np.ones(ours.S.shape[1], dtype=bool)
    first, value = ours.minimise(free)
    for start in (None, first, 2 * first, np.full(first.size, first.max())):
        theta, least = ours.minimise(free, start)
        slope = ours.gradient(theta) / (ours.count @ (ours.S / ours.expectation(theta)[:, None]))
        assert (slope > -1e-4).all()
        assert (np.abs(slope[theta > 0]) < 1e-4).all()
        assert least <= value + 1e-5 or start is not first


def test_a_start_where_nothing_makes_noise_is_left():
    ours = likelihood(filtered(), "NBK")
    free = np.ones(3, dtype=bool)
    assert ours.minimise(free, np.zeros(3))[1] == pytest.approx(ours.minimise(free)[1], abs=1e-5)
    theta, value = ours.minimise(np.array([True, False, False]), np.zeros(3), (0, 0.0))
    assert value == math.inf
    assert not theta.any()


@rows("row, b, a", [
    ("rc", [0.4], [1, -0.6]), ("bilinear 2", *butter(2, 1 / 3)), ("bilinear 1", *butter(1, 0.2)),
    ("average", np.ones(4) / 4, [1.0]),
])  # fmt: skip
def test_the_filter_is_that_of_an_exhaustive_search(row, b, a):
    """Every cut-off of a fine grid, each likelihood made anew."""
    seen = filtered(b, a)
    used = seen.frequency(seen.first) < 45
    best = search(frame_of(seen, "NBKR", used), moves=(less, exchanged, filters), unexplained=False).best
    assert best.state.filter.label == row
    (cutoff,) = best.state.filter.shape
    whole = likelihood(seen, "NBKR").only(used)

    def least(name, cutoff):
        power = gain_of(name, cutoff, seen)
        mean = float(power @ seen.count / seen.count.sum())
        return 2 * whole.behind(power[used], mean, FILTERS[name].edges(cutoff), 0).minimise(best.free)[1]

    assert best.value == pytest.approx(least(row, cutoff), abs=0.02)
    coarse = [least(name, c) for name, other in FILTERS.items() for c in other.widest * 2.0 ** -np.arange(7)]
    assert min(coarse) > best.value - 0.02
    fine = cutoff * np.exp(np.arange(-60, 61) * 2.5e-3)
    fine = fine[fine <= FILTERS[row].widest]
    assert abs(math.log(fine[int(np.argmin([least(row, c) for c in fine]))] / cutoff)) < 5.1e-3


FACTORED = [4, 8, 12, 16, 30, 36, 60, 100, 128, 1000, 1024, 7200, 30_030, 131_072, 360_000]
OTHER = [5, 1001, 1002, 2_000_006]


@rows("n", all_but([*FACTORED, *OTHER], [131_072, 360_000, 2_000_006]))
def test_rows_and_columns_or_no_matrix(n, monkeypatch):
    monkeypatch.setattr(transforms, "LONG_RECORD", 4)
    assert (transforms._rows(n) > 0) == (n in FACTORED)
    y = np.random.default_rng(n).standard_normal(n)
    np.testing.assert_allclose(cosine_transform(y.copy()), dct(y, norm="ortho"), rtol=0, atol=1e-14)
    if n in (1000, 1001):
        expected = dct(y - 0.25 * (np.arange(n) - (n - 1) / 2), norm="ortho")
        np.testing.assert_allclose(cosine_transform(y.copy(), 0.25), expected, rtol=0, atol=1e-10)


def test_a_random_walk_keeps_its_high_frequencies(monkeypatch):
    monkeypatch.setattr(transforms, "LONG_RECORD", 4)
    y = np.cumsum(np.random.default_rng(1).standard_normal(360_000))
    high = slice(180_000, None)
    np.testing.assert_allclose(cosine_transform(y.copy())[high], dct(y, norm="ortho")[high], rtol=0, atol=1e-10)
