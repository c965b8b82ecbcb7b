"""Expectation and degrees of freedom of the statistics over windows and of the total deviation, from full matrices."""

from table import read

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from tests import examples
from tests.reference.dense import moments, quadratic_form
from tests.rows import paired, rows

import allanite as al
from allanite.statistics import STATISTICS
from allanite.statistics.moments import folded
from allanite.statistics.moments.compact import compact, products, ratios
from allanite.statistics.moments.windowed import relative, response

ROWS = ["theo1", "mtotdev", "ttotdev", "htotdev", "pdev", "totdev"]
TERMS = [al.terms.TERMS[s] for s in "QNBKR"]
PAIRS = np.array([[i, j] for i in range(5) for j in range(i + 1, 5)])
HOUR = 3_600_000


def shares_of(E):
    """Shares of the expectation: single noise terms, halves of every pair, 40 random mixtures; a ramp at most 0.9."""
    single = np.eye(5)[:4]
    halves = np.array([np.bincount(pair, minlength=5) / 2 for pair in PAIRS])
    mixtures = np.random.default_rng(1).dirichlet(np.full(5, 0.5), 60)
    p = np.vstack((single, halves, mixtures[mixtures[:, 4] < 0.9])) * (E != 0)
    p = p[p.sum(axis=1) > 0.1]
    return p / p.sum(axis=1, keepdims=True)


def degrees(p, r):
    return 1 / np.einsum("pi,ij,pj->p", p, r, p)


def found(row, m, n, terms=TERMS):
    count = int(row.count(n, np.array([m]))[0])
    return response(row, terms, m, n), relative(row, terms, m, count, n)


FACTORS = [1, 2, 3, 8, 16, 17, 21, 22, 25, 33, 42, 64, 66, 70, 90, 99, 100, 128, 150, 170, 199, 200]


def as_the_full_matrix(name, n, m, rel, of_ramp):
    """The expectation, and the degrees of freedom of many mixtures."""
    E, r = moments(quadratic_form(STATISTICS[name], m, n), TERMS)
    expected, ours = found(STATISTICS[name], m, n)
    np.testing.assert_allclose(expected[:4], E[:4], rtol=rel)
    np.testing.assert_allclose(expected[4], E[4], rtol=of_ramp)
    p = shares_of(E)
    np.testing.assert_allclose(degrees(p, ours), degrees(p, r), rtol=0.006)


@rows("name", ROWS)
@rows("n, factors", [(128, FACTORS[::2]), (200, FACTORS[1::2])])
def test_moments_equal_the_full_matrix(name, n, factors):
    step, largest = STATISTICS[name].step, STATISTICS[name].largest(n)
    for m in sorted({*factors, largest - step, largest}):
        if m <= largest and m % step == 0:  # the ramp's squares reach n^4
            as_the_full_matrix(name, n, m, *((1e-9, 1e-8) if m <= 64 else (1e-6, 1e-6)))


LONGER = {"theo1": [74, 300], "mtotdev": [101], "htotdev": [151, 171], "pdev": [171], "totdev": [255, 511]}


@pytest.mark.slow("seconds of analyses")
@rows("name, m", [(name, m) for name, factors in LONGER.items() for m in factors])
def test_longer_windows(name, m):
    as_the_full_matrix(name, 513, m, 3e-6, 3e-6)


def markov(T):
    """Gauss-Markov noise of the rate: no row of the table, and no power of t."""
    base = al.terms.TERMS["N"]
    return dataclasses.replace(
        base,
        structure=lambda t: T**2 * (t - T * -np.expm1(-t / T)),
        derivative=lambda k, t: (-1) ** k * T ** (3.0 - k) * np.exp(-t / T),
    )


@rows("T, name", paired([3.0, 20.0, 200.0], ROWS))
def test_any_structure_function_will_do(name, T):
    terms = [markov(T), al.terms.TERMS["N"]]
    for m, n in ((2, 100), (30, 180), (80, 250)):
        E, r = moments(quadratic_form(STATISTICS[name], m, n), terms)
        expected, ours = found(STATISTICS[name], m, n, terms)
        np.testing.assert_allclose(expected, E, rtol=1e-4)
        np.testing.assert_allclose(ours, r, rtol=0.006)


# r_ij of NN NB NK BB BK KK in the limit of long windows, by the number of windows over m (totdev: n/m)
SPOTS = {
    ("theo1", 1): (0.11786, 0.17429, 0.17388, 0.29302, 0.33881, 0.47011),
    ("theo1", 4): (0.03956, 0.05514, 0.04469, 0.09216, 0.09341, 0.13886),
    ("theo1", 0.1): (0.39304, 0.54961, 0.59628, 0.78753, 0.85899, 0.94106),
    ("mtotdev", 1): (0.38725, 0.41566, 0.43141, 0.47604, 0.53237, 0.64432),
    ("mtotdev", 8): (0.10400, 0.10024, 0.07498, 0.11197, 0.10469, 0.14492),
    ("htotdev", 1): (0.19711, 0.24365, 0.25158, 0.31532, 0.34084, 0.38726),
    ("htotdev", 8): (0.06113, 0.07243, 0.06791, 0.09239, 0.09367, 0.10400),
    ("pdev", 1): (0.46420, 0.48400, 0.49999, 0.52938, 0.57934, 0.67523),
    ("pdev", 8): (0.09428, 0.08840, 0.06497, 0.09525, 0.08667, 0.11676),
    ("totdev", 16): (0.04167, 0.04404, 0.03279, 0.05411, 0.04996, 0.06937),
    ("totdev", 4): (0.16667, 0.18140, 0.15385, 0.22326, 0.22442, 0.30194),
    ("totdev", 2): (0.33333, 0.38422, 0.40000, 0.47695, 0.53837, 0.66057),
    ("totdev", 1): (2 / 3, 0.76664, 0.8, 0.88800, 0.92760, 0.97143),
}
WHITE_SPOTS = {("mtotdev", 1): 0.19711, ("mtotdev", 8): 0.06113, ("pdev", 1): 0.33929, ("pdev", 8): 0.07678}


@rows("name, share", list(SPOTS))
def test_ratios_of_infinitely_fine_windows(name, share):
    m, count = 10_000_000, round(share * 10_000_000)
    r = relative(STATISTICS[name], TERMS[:4], m, count, count if name == "totdev" else 10 * m)
    np.testing.assert_allclose(r[1:, 1:][np.triu_indices(3)], SPOTS[name, share], rtol=2e-3)
    if (name, share) in WHITE_SPOTS:
        assert r[0, 0] == pytest.approx(WHITE_SPOTS[name, share], rel=1e-3)


@rows("m, name", [*paired([66, 96, 128], ["theo1", "mtotdev", "htotdev", "pdev"]),
                  *((m, "totdev") for m in (20, 45, 64))])  # fmt: skip
def test_an_hour_at_1_khz_against_windows_as_they_are(name, m):
    row, total = STATISTICS[name], name == "totdev"
    count = int(row.count(HOUR, np.array([m]))[0])
    windows = () if total else (compact(row.window, row.order, m), TERMS, row.order, 1.0, count)
    direct = ratios(*(folded._products(TERMS, m, HOUR, 1.0) if total else products(*windows)), TERMS)
    p = shares_of(np.ones(5) if total else response(row, TERMS, m, HOUR))
    np.testing.assert_allclose(degrees(p, relative(row, TERMS, m, count, HOUR)), degrees(p, direct), rtol=0.006)


@rows("n", [20, 31, 60, 89])
def test_white_angle_noise_in_the_total_deviation_is_a_whole_number(n):
    for m in range(1, n):
        if abs(2 * m - n) <= 2 or abs(3 * m - 2 * n) <= 6:
            continue
        E, r = moments(quadratic_form(STATISTICS["totdev"], m, n), TERMS[:1])
        assert folded.white_mean(m, n) == pytest.approx(E[0] * 2 * m**2 * (n - 1), rel=1e-12)
        assert folded.white_ratio(m, n) == pytest.approx(r[0, 0], rel=1e-12)


def test_theo1_closed_forms():
    for m in (2, 10, 64, 1000, 1_000_000):
        M, tau = m / 2, 0.75 * m
        H = float(np.sum(1 / np.arange(1.0, M + 1)))
        allan = np.array([3 / tau**2, 1 / tau, 2 * math.log(2) / math.pi, tau / 3, tau**2 / 2])
        ratio = np.array([1 / (H + 1 / m), 1.0, math.nan, 27 / (10 + 6 / M - 4 / M**2), 0.0])
        ratio[4] = 81 / 22 / (1 + 6 / (11 * M) - 5 / (11 * M**2))
        measured = allan / response(STATISTICS["theo1"], TERMS, m, 10 * m)
        np.testing.assert_allclose(np.delete(measured, 2), np.delete(ratio, 2), rtol=1e-10)
    assert measured[2] == pytest.approx(3 / (3 - 2 * math.log(2)), rel=1e-5)


def test_pdev_closed_forms():
    m = 1_000_000
    E = response(STATISTICS["pdev"], TERMS, m, 10 * m) / np.array([1 / m**3, 1 / m, 1, m, m**2])
    np.testing.assert_allclose(E, [12, 6 / 5, 2 * (7 - math.log(16)) / (5 * math.pi), 13 / 35, 1 / 2], rtol=3e-6)


@rows("m", [64, 1000, 1_000_000])
def test_bias_of_the_total_statistics(m):
    """Q, N, B, K: the exact factors of Greenhall's and Howe's tables; m >= 8 there."""
    mvar = np.array([3 / m**3, 1 / (2 * m), (27 / 16 * math.log(3) - math.log(4)) * 2 / math.pi, 11 / 40 * m])
    hvar = np.array([1 / m, math.log(256 / 27) / (2 * math.pi), m / 6])
    modified, time, hadamard = (response(STATISTICS[f"{x}totdev"], TERMS[:4], m, 10 * m) for x in "mth")
    np.testing.assert_allclose(modified / mvar, [0.995, 0.771, 0.717, 0.679], atol=8e-4)
    np.testing.assert_allclose(time, modified / 3, rtol=1e-12)
    np.testing.assert_allclose(hadamard[1:] / hvar, [0.995, 0.851, 0.771], atol=6e-4)


@rows("share", [1 / 64, 1 / 8, 1 / 2])
def test_bias_of_the_total_deviation(share):
    m = int(HOUR * share)
    allan = np.array([3 / m**2, 1 / m, 2 * math.log(2) / math.pi, m / 3])
    factors = response(STATISTICS["totdev"], TERMS[:4], m, HOUR) / allan
    slopes = np.array([-4 / 3, 0, 1 / (3 * math.log(2)), 3 / 4])
    np.testing.assert_allclose(factors, 1 - slopes * share, rtol=1e-5)


@rows("name", ROWS)
@given(data=st.data())
@settings(max_examples=examples(60), deadline=None)
def test_any_record_has_at_least_one_degree_of_freedom(name, data):
    row = STATISTICS[name]
    n = int(10 ** data.draw(st.floats(1.1, 9)))
    m = max(row.step, int(row.largest(n) * 10 ** -data.draw(st.floats(0, 6))) // row.step * row.step)
    E, r = found(row, m, n)
    assert np.all(E[:4] > 0)
    np.testing.assert_allclose(r, r.T)
    assert np.all(degrees(shares_of(E), r) >= 0.995)


def test_the_committed_table_holds_what_is_claimed():
    errors = read("moments.md").rows("Windows")
    sizes = ("128", "256", "513", "3600000")
    assert {(r["statistic"], r["n"]) for r in errors} == {(k, n) for k in set(ROWS) - {"ttotdev"} for n in sizes}
    assert max(float(r[kind]) for r in errors for kind in ("single", "pairs", "random", "sensors")) <= 1.0
    assert max(float(r["expectation"]) for r in errors if r["expectation"] != "-") <= 1e-5
