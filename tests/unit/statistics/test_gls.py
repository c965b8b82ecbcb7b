"""Covariance of rates and generalised least squares against dense algebra."""

import numpy as np
import pytest
from scipy.fft import dct
from scipy.linalg import toeplitz
from tests import thinned
from tests.rows import paired, refused, rows

import allanite as al
from allanite.statistics.moments.gls import Covariance, autocovariance
from allanite.statistics.moments.lagsums import FAR_LAG
from allanite.terms import TERMS as TABLE

TERMS = {"Q": al.Q(0.3, "arcsec"), "N": al.N(1e-3, "deg/sqrt(h)"), "B": al.B(0.02, "deg/h"),
         "K": al.K(0.05, "deg/h/sqrt(h)"), "R": al.R(0.1, "deg/h^2")}  # fmt: skip
MIXTURES = ["Q", "N", "B", "K", "QN", "NB", "QK", "QB", "QNBK", "QNBKR"]


def covariance(symbols, n, rate=400.0):
    return Covariance(tuple(TERMS[s] for s in symbols), n, rate)


def test_white_and_angle_noise_are_three_numbers_and_nothing_is_refused():
    c = autocovariance((TERMS["Q"], TERMS["N"]), 5, 400.0)
    q, r = TERMS["N"].value ** 2 * 400, (TERMS["Q"].value * 400) ** 2
    np.testing.assert_allclose(c, [q + 2 * r, -r, 0, 0, 0], rtol=1e-14, atol=0)
    refused(al.UsageError, "at least one noise term", lambda: covariance("R", 10).solve(np.arange(10.0)))


@rows("symbols", ["B", "K", "QNBK"])
def test_the_covariance_is_that_of_the_increments(symbols):
    """Second differences of c are the covariance of first differences of the rate, near and far."""
    n = 200
    c = autocovariance([TERMS[s] for s in symbols], n, 1.0)
    h = np.arange(1, n - 1)
    wanted = sum(TERMS[s].value ** 2 * TABLE[s].increments(h.astype(float)) for s in symbols)
    np.testing.assert_allclose(2 * c[h] - c[h - 1] - c[h + 1], wanted, atol=2e-11 * np.abs(c).max())
    assert n > FAR_LAG


@rows("symbols, n", paired(list(MIXTURES), [3, 17, 400]))
def test_solve_is_the_dense_solution(symbols, n):
    given = covariance(symbols, n)
    b = np.random.default_rng(1).standard_normal(n)
    v = given.solve(b)
    assert abs(v.sum()) < 1e-9 * np.abs(v).sum()
    P = np.eye(n) - 1 / n
    wanted = np.linalg.pinv(P @ toeplitz(given.first_row) @ P, rcond=1e-13, hermitian=True) @ (b - b.mean())
    np.testing.assert_allclose(v, wanted, atol=1e-7 * np.abs(wanted).max())


@pytest.mark.slow("takes more than half a second")
@rows(("symbols", "n"), thinned([*((symbols, 2**17) for symbols in MIXTURES), ("QB", 2**20), ("QNBKR", 2**20)], 2))
def test_a_million_samples_are_solved(symbols, n):
    given = covariance(symbols, n)
    b = np.zeros(n)
    b[: n // 2] = 1.0
    v = given.solve(b)
    rest = given.times(v) - b
    assert np.abs(rest - rest.mean()).max() < 1e-4


@rows("symbols", ["QN", "QNBK"])
def test_variance_of_a_contrast(symbols):
    given = covariance(symbols, 300)
    v = np.random.default_rng(2).standard_normal(300)
    v -= v.mean()
    assert given.variance(v) == pytest.approx(v @ toeplitz(given.first_row) @ v, rel=1e-10)


@rows("symbols", ["N", "K", "QNBK"])
def test_whitened_records_have_variance_one(symbols):
    """40 records of 4096, seeds 1 to 40: the mean square within 5 standard errors, 1.7 % (error probability 6e-7)."""
    given = covariance(symbols, 4096, 10.0)
    model = al.Model(given.terms)
    records = [al.simulate(model, 4096, 10.0, rng=np.random.default_rng(seed)) for seed in range(1, 41)]
    power = np.mean([np.mean(dct(record.values, norm="ortho")[1:] ** 2 / given.spectrum) for record in records])
    # the edges of quantization, two loose directions in 4096
    assert power == pytest.approx(1.0, abs=0.017 + 2 / 4096)


def test_generalised_least_squares_is_dense_gls():
    n, rng = 250, np.random.default_rng(3)
    given = covariance("QNBK", n)
    X = np.column_stack([np.arange(n), np.cos(np.arange(n) * 0.3)])
    y = rng.standard_normal(n)
    solved = np.column_stack([given.solve(column) for column in X.T])
    error = np.linalg.inv(X.T @ solved)
    beta = error @ (solved.T @ y)
    C = toeplitz(given.first_row) + 10 * given.first_row[0]  # any constant covariance leaves contrasts as they are
    W = np.linalg.inv(C)
    full = np.column_stack([np.ones(n), X])
    wanted = np.linalg.inv(full.T @ W @ full)
    np.testing.assert_allclose(beta, (wanted @ full.T @ W @ y)[1:], rtol=1e-6)
    np.testing.assert_allclose(error, wanted[1:, 1:], rtol=1e-6)
    # the norm of the residual is ruled by the walk; that of the preconditioned residual is what converges
    model = al.N(0.03734, "deg/sqrt(h)") + al.K(31.61, "deg/h/sqrt(h)")
    assert al.constant_rate.rank(model, size=1200, rate=20.0).best > 0
