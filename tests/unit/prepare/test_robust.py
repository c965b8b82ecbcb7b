"""Outliers against sorted windows; lost readings against dense matrices and simulated truth."""

import numpy as np
import pytest
from scipy.fft import dct
from tests import all_but
from tests.rows import paired, refused, rows
from tests.unit.identification.records import covariance_of, forms_of, rates_of, record_of

import allanite as al
from allanite.identification.likelihood.spectrum import spectrum
from allanite.identification.likelihood.whittle import likelihood
from allanite.kernels.passing import HALF, off
from allanite.prepare import inspect, mark_outliers
from allanite.prepare.gaps import Gaps, joined
from allanite.prepare.outliers import outliers
from allanite.terms import TERMS, ramp_coefficients

SENSORS = {
    "MEMS": al.sensor("mems"),
    "FOG": al.Q(0.4, "arcsec") + al.N(3, "deg/h*sqrt(s)") + al.B(1, "deg/h") + al.K(0.09, "deg/h/sqrt(s)"),
    "RLG": al.sensor("rlg"),
}


def values_of(sensor, seed, n=2**16):
    return rates_of(SENSORS[sensor], n, seed)


def spiky(y, share, size, seed):
    rng = np.random.default_rng(seed)
    at = np.sort(rng.permutation(y.size)[: round(share * y.size)])
    y = y.copy()
    y[at] += size * np.std(np.diff(y, 2)) / 6**0.5 * rng.choice([-1.0, 1.0], at.size)
    return y, at


@rows("share, sensor", paired([2e-5, 1e-3, 1e-2, 1.8e-2], list(SENSORS)))
def test_spikes_are_found_and_nothing_else(sensor, share):
    y, at = spiky(values_of(sensor, 1), share, 20, 2)
    assert outliers(record_of(y)).at.tolist() == at.tolist()


@rows("size, part", paired([31, 32, 1023, 1024, 1025, 5000], [700, 1024, 10**9]))
def test_far_off_is_that_of_sorted_windows(size, part):
    y = np.random.default_rng(size).normal(size=size)
    y[[0, size // 2, size - 1]] += 5.0
    limit = 2.0 + np.arange(-(-size // part)) % 2
    padded = np.concatenate((y[1:2], y, y[-2:-1]))
    bend = np.abs((y - padded[:-2]) + (y - padded[2:]))
    expected = []
    for i in range(size):
        start = min(max(i - HALF, 0), size - 31)
        median = np.sort(y[start : start + 31])[HALF]
        most = limit[i // part]
        expected += [i] if bend[i] > most and abs(y[i] - median) > most else []
    assert len(expected) > 2
    np.testing.assert_array_equal(off(y, limit, part), expected)


@rows("length", [2, 5, 14])
def test_runs_of_outliers_are_found_whole(length):
    y = np.random.default_rng(1).standard_normal(50_000)
    at = (np.arange(1000, 49_000, 4000)[:, None] + np.arange(length)).ravel()
    y[at] += 30
    assert outliers(record_of(y)).at.tolist() == at.tolist()


@rows("sigma, bias", paired([0.01, 0.05, 0.2, 0.35, 0.5, 0.6, 0.7, 0.8, 1.0, 1.5, 2.2], [0.0, 0.3, 0.5]))
def test_coarse_readings_are_no_outliers(sigma, bias):
    """Steps of 0.5 to 100 standard deviations: the median absolute residual is often zero."""
    y = np.rint(np.random.default_rng(1).standard_normal(50_000) * sigma + bias)
    found = outliers(record_of(y + 0.0))
    assert found.at.size == found.heavy == 0


@rows("rate", [0.0, 0.4, 7.0, 90.0, 1000.0])
def test_pulses_of_an_undithered_counter_are_no_outliers(rate):
    angle = np.cumsum(np.random.default_rng(1).standard_normal(50_000) * 0.018) + rate * np.arange(50_000) / 100
    counts = np.diff(np.floor(angle / 1.73)).astype(np.int64)
    assert outliers(al.Record(counts, 100.0, "arcsec", kind="count", scale=1.73)).at.size == 0


@rows("y", [np.random.default_rng(1).laplace(size=100_000), np.random.default_rng(1).standard_t(4, 100_000)])
def test_heavy_tails_are_named_and_kept(y):
    record = record_of(y)
    found = outliers(record)
    assert found.at.size == 0
    assert found.heavy > 50
    assert mark_outliers(record) is record
    assert "heavy tails" in inspect(record).names


def test_a_noise_level_that_changes_makes_no_outliers():
    y = np.random.default_rng(1).standard_normal(200_000) * np.repeat([1, 3], 100_000)
    assert outliers(record_of(y)).at.size == 0


@rows("kind", ["rate", "increment", "count", "angle"])
def test_marking_keeps_every_other_rate(kind):
    counts = np.random.default_rng(1).integers(-9, 10, 5000)
    counts[[100, 2000]] = 900, -700
    record = forms_of(counts, 0.1)[kind]
    marked = mark_outliers(record)
    rates = marked.rate_values
    assert np.flatnonzero(np.isnan(rates)).tolist() == [100, 2000]
    np.testing.assert_allclose(np.delete(rates, [100, 2000]), np.delete(record.rate_values, [100, 2000]))
    assert marked.kind == ("rate" if kind == "rate" else "increment")
    assert "gaps" in inspect(marked).names
    assert marked.history[-1].startswith("2 outliers beyond 5.2 standard deviations, the first at 1 s")


def test_wrong_points_of_an_angle_are_lost_and_the_angle_kept():
    angle = np.concatenate(([0.0], np.cumsum(values_of("RLG", 1)))) / 100
    spoilt = angle.copy()
    spoilt[[700, 30_000]] += 30 * np.std(np.diff(angle))
    marked = mark_outliers(record_of(spoilt, "rad", kind="angle"))
    assert (marked.kind, np.flatnonzero(np.isnan(marked.values)).tolist()) == ("angle", [700, 30_000])
    whole, fit = (al.identify(record_of(x, "rad", kind="angle")) for x in (angle, spoilt))
    assert fit["N"].value == pytest.approx(whole["N"].value, rel=2e-3)
    spoilt[40_000:] += 1.0
    assert mark_outliers(record_of(spoilt, "rad", kind="angle")).kind == "increment"


@rows("kind", ["rate", "angle"])
@pytest.mark.slow("ensemble")
def test_shut_gaps_keep_small_noise_under_quantization(kind):
    """400 gaps of 5 samples: an angle tells N as if they were not there, a rate loses most of it."""
    ratios = []
    for seed in (1, 2, 3):
        y = values_of("RLG", seed)
        angle = np.concatenate(([0.0], np.cumsum(y))) / 100
        bad = lost(y.size, seed, 400, 5)
        whole = al.identify(record_of(y), terms="QNB")
        angle[:-1][bad], y[bad] = np.nan, np.nan
        record = record_of(y) if kind == "rate" else record_of(angle, "rad", kind="angle")
        fit = al.identify(record, terms="QNB")
        ratios.append((fit["N"].value or 0.0) / whole["N"].value - 1)
    assert (np.abs(ratios).max() < 0.03) == (kind == "angle")


def test_identification_leaves_outliers_out():
    y, _ = spiky(values_of("MEMS", 1), 1e-3, 20, 2)
    truth = al.identify(record_of(values_of("MEMS", 1)))["N"].value
    fit, kept = al.identify(record_of(y)), al.identify(record_of(y), outliers="keep")
    assert fit["N"].value == pytest.approx(truth, rel=1e-3)
    assert kept["N"].value > 1.1 * truth
    refused(al.UsageError, "'mark'", lambda: al.identify(record_of(y), outliers="fill"))


def lost(n, seed, count, length):
    bad = np.zeros(n, dtype=bool)
    for start in np.random.default_rng(seed).integers(20, n - length - 20, count):
        bad[start : start + length] = True
    return bad


@rows("symbol", ["Q", "N", "K"])
def test_rows_are_the_diagonal_of_the_joined_covariance(symbol):
    """Exact but for the walk's own corner (its jumps are not quite those of white increments): 2 %."""
    there = np.flatnonzero(~lost(600, 1, 6, 25))
    n = there.size
    values = np.full(600, np.nan)
    values[there] = there % 5
    _, gaps, left = joined(record_of(values, rate=1.0))
    assert left.tolist() == there.tolist()
    T = dct(np.eye(n), axis=0, norm="ortho")[1:65]
    dense = np.diag(T @ covariance_of(symbol, there) @ T.T)
    k = np.arange(1.0, 65.0)
    edges = TERMS[symbol].edge * (4 / n) * np.cos(np.pi * k / (2 * n)) ** 2
    np.testing.assert_allclose(gaps.row(TERMS[symbol], k) + edges, dense, rtol=0.02 if symbol == "K" else 1e-9)


def test_far_up_the_joints_count_on_average():
    gaps = Gaps(10_000, np.array([100, 4000, 9000]), np.array([50, 7, 900]), np.zeros(3, dtype=bool))
    k = np.arange(5000.0, 9000.0)
    for symbol in "QNBK":
        row = TERMS[symbol]
        share = row.edge * 3 / gaps.size
        expected = row.dct(k, gaps.size) * (1 - share) + 2 * share
        expected = expected * 1.0957 if symbol == "K" else expected
        np.testing.assert_allclose(gaps.row(row, k), expected, rtol=1e-9)


def test_a_ramp_is_found_at_its_true_times():
    y = 1e-3 * np.random.default_rng(1).standard_normal(5000) + 0.01 * np.arange(5000)
    y[1000:3000] = np.nan
    y[:5] = np.nan
    seen = spectrum(record_of(y), detrend=True)
    found = likelihood(seen, "NR")
    theta, _ = found.minimise(np.array([True]))
    assert seen.slope + found.directions(theta)[0][-1] == pytest.approx(0.01, rel=1e-5)
    np.testing.assert_allclose(
        spectrum(record_of(np.arange(300.0) % 7), detrend=True).ramp, ramp_coefficients(np.arange(1.0, 65.0), 300)
    )


@pytest.mark.slow("takes more than half a second")
@rows(
    ("sensor", "count", "length"),
    all_but([("MEMS", 20, 160), ("FOG", 500, 5), ("RLG", 20, 160)], [("FOG", 500, 5), ("RLG", 20, 160)]),
)
def test_gaps_hardly_move_the_coefficients(sensor, count, length):
    """The same 5 records with and without gaps: their mean difference is far below one record's standard error."""
    symbols = "".join(term.symbol for term in SENSORS[sensor])
    ratios, errors = [], []
    for seed in range(1, 6):
        y = values_of(sensor, seed)
        whole = al.identify(record_of(y), terms=symbols)
        y[lost(y.size, seed, count, length)] = np.nan
        fit = al.identify(record_of(y), terms=symbols)
        ratios.append(fit["N"].value / whole["N"].value)
        errors.append(whole["N"].standard_error / whole["N"].value)
    # a tenth of the angle's closures are lost with 20 gaps in RLG's: its N scatters by a standard error more
    assert abs(np.mean(ratios) - 1) < (0.5 if sensor != "RLG" else 1.2) * np.mean(errors)


@rows("where, value, words", [
    (slice(150, None), np.nan, "4850 of 5000 samples are missing; 150 remain"), (slice(300, None), np.nan, "a tenth"),
    (slice(None, None, 2), np.nan, "of 2500 that remain, 0 are followed by the next one"),
    (slice(7, 9), np.inf, "2 of 5000 samples are infinite, the first at sample 7"),
])  # fmt: skip
def test_too_little_is_refused(where, value, words):
    y = np.random.default_rng(1).standard_normal(5000)
    y[where] = value
    assert words in inspect(record_of(y)).refusal
    refused(al.DataError, words, lambda: al.identify(record_of(y)))


def test_lost_ends_are_no_gaps():
    y = values_of("FOG", 1)
    cut = np.concatenate((np.full(500, np.nan), y, np.full(300, np.nan)))
    one, two = al.identify(record_of(y)), al.identify(record_of(cut))
    for estimate in one:
        assert two[estimate.symbol].status == estimate.status
        if estimate.value is not None:
            assert two[estimate.symbol].value == pytest.approx(estimate.value, rel=1e-6)
