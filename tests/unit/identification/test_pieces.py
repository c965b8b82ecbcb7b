"""A rate with gaps under strong noise of the angle: the pieces against dense matrices, and against simulated truth."""

import numpy as np
import pytest
from tests.rows import rows
from tests.unit.identification.records import claimed, covariance_of, covers, record_of

import allanite as al
from allanite.identification.likelihood import pieces
from allanite.identification.likelihood.likelihood import Likelihood
from allanite.identification.likelihood.pieces import PieceReading, apart, rate_weights
from allanite.identification.likelihood.spectrum import spectrum
from allanite.identification.likelihood.whittle import column
from allanite.prepare.gaps import Gaps
from allanite.terms import TERMS

SIZE, RATIO, SPLIT = 400, 40.0, 0.08
AT = np.array([3, 4, 40, 90, 91, 200, 350])
GAPS = Gaps(SIZE, AT, np.ones_like(AT), np.zeros(AT.size, dtype=bool))
STARTS = np.concatenate(([0], AT))
LENGTHS = np.diff(np.append(STARTS, SIZE))
EDGES = np.concatenate((np.arange(1, 20), np.arange(20, SIZE, 20), [SIZE]))
HOW = PieceReading(*np.unique(LENGTHS, return_counts=True), RATIO, 1, SPLIT, EDGES)


def sines(L):
    k = np.arange(1, L + 1)
    return np.sqrt(2 / (L + 1)) * np.sin(np.pi * np.outer(k, k) / (L + 1))


def blocks(one):
    """A matrix of the whole record from those of its pieces."""
    whole = np.zeros((SIZE, SIZE))
    for start, L in zip(STARTS, LENGTHS, strict=True):
        whole[start : start + L, start : start + L] = one(int(L))
    return whole


def angle(L):
    return 2 * np.eye(L) - np.eye(L, k=1) - np.eye(L, k=-1)


def noisy(L):
    return np.eye(L) + RATIO * angle(L)


def weights(L):
    x = np.linalg.solve(noisy(L), np.ones(L))
    return x / x.sum()


def less_rate(L):
    return np.eye(L) - weights(L)


def high(L):
    return np.pi * np.arange(1, L + 1) / (L + 1) >= EDGES[HOW.low] * np.pi / SIZE - 1e-12


UPPER = blocks(lambda L: sines(L) @ less_rate(L))
LOWER = blocks(lambda L: np.eye(L) - sines(L)[:, high(L)] @ (sines(L) @ less_rate(L))[high(L)])
BIN = np.concatenate(
    [np.where(high(L), np.searchsorted(EDGES, np.arange(1, L + 1) * SIZE / (L + 1), "right") - 1, -1) for L in LENGTHS]
)


@rows("L", [1, 2, 7, 150])
def test_weights_of_the_rate_are_those_of_generalised_least_squares(L):
    w, v = rate_weights(L, RATIO)
    np.testing.assert_allclose(w, weights(L), rtol=1e-10)
    assert v == pytest.approx(w @ noisy(L) @ w)


WEIGHT = np.concatenate([1 / (1 + RATIO * np.diag(sines(L) @ angle(L) @ sines(L))) for L in LENGTHS])


def assert_means(found, values):
    """Weighted means over the bins above the split."""
    filled = [b for b in range(HOW.low, EDGES.size - 1) if (b == BIN).any()]
    literal = [np.average(values[b == BIN], weights=WEIGHT[b == BIN]) for b in filled]
    np.testing.assert_allclose(found[filled], literal, rtol=1e-8)


def test_the_parts_are_those_of_the_matrices():
    y = np.random.default_rng(1).standard_normal(SIZE)
    low, kept, power, _ = apart(y, GAPS, HOW)
    assert kept.all()
    np.testing.assert_allclose(low, LOWER @ y, atol=1e-12)
    assert_means(power, (UPPER @ y) ** 2)


def test_what_the_bins_tell():
    """The power of each over its expectation under the ratio is a chi-square with so many degrees of freedom."""
    share = np.diag(UPPER @ blocks(noisy) @ UPPER.T) * WEIGHT
    literal = [share[b == BIN].sum() for b in range(HOW.low, EDGES.size - 1)]
    np.testing.assert_allclose(HOW.told[HOW.low :], literal, atol=1e-9)


@rows("symbol", "QNBK")
def test_expectations_above_the_split_are_exact(symbol):
    C = blocks(lambda L: covariance_of(symbol, np.arange(L)))
    assert_means(HOW.upper(TERMS[symbol], np.full(EDGES.size - 1, np.nan)), np.diag(UPPER @ C @ UPPER.T))


@rows("symbol", "QN")
def test_expectations_below_it_are_exact_on_average_over_phases(symbol):
    C = blocks(angle if symbol == "Q" else np.eye)
    k = np.arange(1.0, HOW.low + 1)
    waves = np.exp(1j * np.pi / SIZE * np.outer(k, np.arange(SIZE)))
    each = [waves[:, start : start + L] @ LOWER[start : start + L] for start, L in zip(STARTS, LENGTHS, strict=True)]
    expected = sum(np.einsum("ki,ij,kj->k", one, C, one.conj()).real for one in each) / SIZE
    np.testing.assert_allclose(HOW.row(TERMS[symbol], GAPS, k), expected, rtol=0.02)


def test_the_parts_share_one_combination_of_each_piece():
    """That which its rate takes from the others: the sum of all squared canonical correlations says so."""
    C = blocks(noisy)
    parts = UPPER[BIN >= 0], LOWER
    upper, lower = (np.linalg.pinv(A @ C @ A.T, rcond=1e-8, hermitian=True) @ A @ C for A in parts)
    assert np.trace(upper @ LOWER.T @ lower @ parts[0].T) < LENGTHS.size


def lossy(model, seed, share, size=2**14):
    rng = np.random.default_rng(seed)
    values = al.simulate(model, size, 100.0, rng=rng).values
    return record_of(np.where(rng.random(size) < share, np.nan, values))


def test_without_gaps_or_noise_of_the_angle_the_joined_record_is_read():
    assert spectrum(lossy(al.sensor("rlg"), 1, 0.0), detrend=True).pieces is None
    assert spectrum(lossy(al.sensor("mems"), 1, 0.1), detrend=True).pieces is None
    assert spectrum(lossy(al.sensor("rlg"), 1, 0.01), detrend=True).pieces is not None


@pytest.mark.slow("takes more than half a second")
def test_the_spectrum_is_that_expected():
    model, total, told = al.Model("Q 0.5 arcsec, N 0.18 arcsec/sqrt(s)"), 0.0, 0.0
    for seed in range(8):
        record = lossy(model, seed, 0.02)
        seen = spectrum(record, detrend=False)
        power = sum(t.power(100.0) / record.rate_factor**2 * column(t.sampled(100.0), seen) for t in model)
        octave = np.floor(np.log2(seen.first / seen.size)).astype(int) + 14
        total = total + np.bincount(octave, (seen.power / power - 1) * seen.told, 14)
        told = told + np.bincount(octave, seen.told, 14)
    deviate = (total / np.sqrt(2 * told))[told > 30]
    assert deviate.size > 7
    assert np.abs(deviate).max() < 3.3


@pytest.mark.slow("ensemble")
def test_small_noise_of_the_rate_is_told_between_gaps():
    """Of 1 % lost at random: N to a tenth, and its limits hold the truth."""
    N = al.sensor("rlg")["N"]
    fits = [al.identify(lossy(al.sensor("rlg"), seed, 0.01, 2**15), lines=False) for seed in range(4)]
    assert all(fit["N"].claimed and abs(fit["N"].value / N.value - 1) < 0.3 for fit in fits)
    assert sum(covers(fit, N) for fit in fits) >= 3


def ratio(y, lengths):
    """Q^2 / N^2 of the coefficients one by one, beside a slow noise."""
    x, power = [], []
    for start, L in zip(np.cumsum(lengths) - lengths, lengths, strict=True):
        d = sines(L) @ y[start : start + L]
        x += [k / (L + 1) for k in range(2, L + 1, 2)]
        power += [d[k - 1] ** 2 for k in range(2, L + 1, 2)]
    x, power = np.array(x), np.array(power)
    every = [np.floor(-8 * np.log2(x)) == octave for octave in np.unique(np.floor(-8 * np.log2(x)))]
    S = np.array([[(4 * np.sin(np.pi / 2 * x[b]) ** 2).mean(), 1.0, (1 / x[b] ** 2).mean()] for b in every])
    none, count = np.zeros((len(every), 0)), np.array([b.sum() for b in every], float)
    mean = np.array([power[b].mean() for b in every])
    part = Likelihood(S, mean, count, none[:, :, None], none, np.zeros((0, 3)), np.zeros(0, bool))
    theta = part.minimise(np.ones(3, bool))[0]
    return theta[0] / theta[1]


def test_the_ratio_is_that_of_each_coefficient_and_no_long_piece_has_a_size_that_takes_memory(monkeypatch):
    rng, sizes = np.random.default_rng(2), []
    lengths = np.array([7, 1, 90, 31, 90, 2, 7] * 9)
    y = 3 * np.diff(rng.standard_normal(lengths.sum() + 1)) + rng.standard_normal(lengths.sum())
    for together in (pieces.TOGETHER, 100):
        monkeypatch.setattr(pieces, "TOGETHER", together)
        assert pieces._ratio(y, lengths) == pytest.approx(ratio(y, lengths), rel=1e-6)
    monkeypatch.setattr(pieces, "sine", lambda x, own=pieces.sine: [sizes.append(x.shape[-1]), own(x)][1])
    prime = 1 << 16  # and one more is a prime number: its transform takes six times the memory
    y = 3 * np.diff(rng.standard_normal(prime + 101)) + rng.standard_normal(prime + 100)
    assert pieces._ratio(y, np.array([prime, 100])) == pytest.approx(9, rel=0.2)
    assert len(sizes) == 2
    assert all(pieces.smooth(size + 1) for size in sizes)


def test_a_wave_is_looked_for_in_coefficients_that_stand_alone():
    # of the whole record two are known here: a wave and a ramp explained both, with certainty
    rng, size = np.random.default_rng(21), 16384
    values = al.simulate(al.Model("Q 30 arcsec, K 4 deg/h/sqrt(h)"), size, 1.0, rng=rng).values.copy()
    for start in rng.integers(0, size, 20):
        values[start : start + size // 220] = np.nan
    values[rng.random(size) < 0.01] = np.nan
    fit = al.identify(record_of(values, rate=1.0))
    assert claimed(fit) >= {"Q", "K"}
    assert fit.findings == ()
