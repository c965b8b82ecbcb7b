"""Covariance between averaging times of statistics over windows: against full matrices, and against exact lag sums."""

import dataclasses
from functools import lru_cache

import numpy as np
import pytest
from tests import all_but, model_of
from tests.reference.dense import covariance as dense, quadratic_form, ramp_weights
from tests.reference.theo import theobr
from tests.rows import paired, rows

import allanite as al
from allanite.statistics import STATISTICS, covariance
from allanite.statistics.moments import profile
from allanite.statistics.moments.moments import by_term, covariance_by_term
from allanite.statistics.moments.profile import crossed
from allanite.statistics.moments.windowed import Pairs, WindowPair

MIXTURES = [
    {"Q": 1.0}, {"N": 1.0}, {"B": 1.0}, {"K": 1.0}, {"Q": 2.0, "N": 1.0, "B": 0.3, "K": 0.1, "R": 3e-3},
    {"N": 1.0, "K": 0.05, "R": 1e-3},
]  # fmt: skip
LONG = ["theo1", "pdev", "mtotdev", "htotdev"]
ROWS = [*LONG, "ttotdev", "oadev", "mdev", "ohdev", "tdev"]
SIZE, MIXED = 300, MIXTURES[4]


@lru_cache(maxsize=16)
def form(name, m, size):
    return quadratic_form(STATISTICS[name], m, size)


def exact(rows, m, size, model):
    """The covariance from full matrices."""
    forms = [form(row.name, k, size) for row, k in zip(rows, m.tolist(), strict=True)]
    scale = np.array([(k * row.tau_factor) ** (2.0 * row.power) for row, k in zip(rows, m.tolist(), strict=True)])
    return dense(forms, [t.row for t in model], [t.value**2 for t in model]) * np.outer(scale, scale)


def correlated(C, wanted):
    """Difference over the two standard deviations."""
    root = np.sqrt(np.diag(wanted))
    return np.abs((C - wanted) / np.outer(root, root)).max()


def off(name, factors, mixture, size=1000):
    """Difference of the covariance from the full matrix."""
    row, model, m = STATISTICS[name], model_of(mixture), np.array(factors)
    return correlated(covariance(row, model, m, size, 1.0), exact([row] * m.size, m, size, model))


@rows("name, mixture", paired(ROWS, MIXTURES))
def test_it_equals_the_full_matrix(name, mixture):
    m = np.unique([STATISTICS[name].step, 2, 4, 10, 16, 30, 64])
    assert off(name, m, mixture, SIZE) < 1e-6


@rows("mixture", MIXTURES, ids="".join)
def test_of_two_statistics_it_equals_the_full_matrix(mixture):
    rows = [STATISTICS[name] for name in ("oadev", "oadev", "theo1", "oadev", "theo1", "theo1")]
    m, model = np.array([1, 7, 8, 40, 100, 150]), model_of(mixture)
    wanted = exact(rows, m, SIZE, model)
    C = covariance_by_term(rows, model, m, SIZE, 1.0).sum(axis=(2, 3))
    assert correlated(np.where(np.eye(m.size, dtype=bool), wanted, C), wanted) < 1e-6


@rows("name", all_but(LONG, ["htotdev"], "full matrices"))
@pytest.mark.slow("full matrices")
def test_long_windows_equal_the_full_matrix(name):
    assert off(name, [2, 16, 64, 150, 240], MIXED) < 1e-6


@rows("name", LONG)
@pytest.mark.slow("full matrices")
def test_the_longest_window_is_near_the_full_matrix(name):
    assert off(name, [16, 240, STATISTICS[name].largest(1000)], MIXED) < 0.006


@pytest.mark.slow("full matrices")
@rows("mixture", [MIXED, {"N": 1.0, "B": 0.1}], ids="".join)
def test_of_a_hybrid_longer_windows_are_near_the_full_matrix(mixture):
    """The points of theoh that are fitted, and the longest one."""
    rows = [STATISTICS[name] for name in ("oadev", "oadev", "oadev", "theo1", "theo1", "theo1")]
    size, m, model = 1000, np.array([16, 64, 200, 256, 512, 1000]), model_of(mixture)
    wanted = exact(rows, m, size, model)
    assert correlated(covariance_by_term(rows, model, m, size, 1.0).sum(axis=(2, 3)), wanted) < 0.006


@pytest.mark.slow("seconds of analyses")
@rows("name, noise, size", paired(["theo1", "pdev", "mtotdev"], "QNBK", all_but([1000, 2000], [2000], "full matrices")))
def test_what_a_ramp_and_a_noise_add_equals_the_full_matrix(name, noise, size):
    """Over the roots of its own diagonal."""
    row, model, m = STATISTICS[name], model_of({noise: 1.0, "R": 1.0}), np.array([2, 8, 64, 240, size // 3])
    m -= m % row.step
    lag = np.abs(np.subtract.outer(np.arange(size + 1.0), np.arange(size + 1.0)))
    scale = (m * row.tau_factor) ** (2.0 * row.power)
    v = np.array([ramp_weights(row, k, size) for k in m.tolist()]) * scale[:, None]
    wanted = -2 * v @ model.terms[0].row.structure(lag) @ v.T
    C = covariance_by_term([row] * m.size, model, m, size, 1.0)
    assert correlated(C[..., 0, 1] + C[..., 1, 0], wanted) < 1e-6


@rows("name", ["theo1", "pdev", "mtotdev"])
def test_a_ramp_beside_very_long_windows(name, monkeypatch):
    """Above a length they are summed in a record of fewer samples that last longer."""
    row, size, terms = STATISTICS[name], 2**16, [al.terms.TERMS[s] for s in "NBK"]
    m = row.step * 2 ** np.arange(0, 14, 3)
    wanted = crossed([row] * m.size, m, size, terms)
    monkeypatch.setattr(profile, "MAX_SAMPLES", 2**12)
    found = crossed([row] * m.size, m, size, terms)
    for k in range(len(terms)):
        assert 0 < correlated(found[..., k], wanted[..., k]) < 2e-3


@pytest.mark.slow("takes more than half a second")
@rows("name, ramp", paired(["theo1", "pdev", "mtotdev"], all_but([1e-4, 1e-3, 1e-2], [1e-4, 1e-2], "full matrices")))
def test_beside_a_ramp_reduced_windows_are_near_the_full_matrix(name, ramp):
    assert off(name, [2, 8, 64, 240], {"N": 1.0, "B": 0.3, "K": 0.02, "R": ramp}) < 0.006


def modified(m):
    return np.ones(1), np.repeat([1.0, -2.0, 1.0], m)[None, :]


@rows("name, window", [("oadev", None), ("mdev", modified)])
@rows("terms", ["QN", "NB", "NK", "NBK"])
def test_long_windows_are_near_exact_lag_sums(name, window, terms):
    """The rule for any window, applied to differences, of which the exact sums are known up to any length."""
    size, m = 2**18, 2 ** np.arange(1, 17, 3)
    row = dataclasses.replace(STATISTICS[name], window=window or STATISTICS[name].window)
    model = model_of({s: {"Q": 100.0, "N": 1.0, "B": 0.01, "K": 1e-4}[s] for s in terms})
    wanted = covariance(row, model, m, size, 1.0)
    root = np.sqrt([by_term(row, model, k, size, 1.0) for k in m.tolist()])
    pairs = Pairs([t.sampled(1.0) for t in model])
    found = np.zeros_like(wanted)
    for i, j in zip(*np.triu_indices(m.size), strict=True):
        a, b = m[i], m[j]
        counts = (float(row.count(size, a)), float(row.count(size, b)))
        r = pairs.within(WindowPair((row, row), (int(a), int(b)), counts))
        found[i, j] = found[j, i] = 2 * (root[i] * root[j]) @ r @ (root[i] * root[j])
    assert correlated(found, wanted) < 1e-4


@pytest.mark.slow("ensemble")
def test_that_of_a_hybrid_has_the_scatter_of_its_ratio():
    """First order: the derivatives of the literal definition, at a record whose plain variances are as expected."""
    model, size = model_of({"N": 1.0, "K": 0.03}), 300
    row, m, rng = STATISTICS["theobr"], np.array([20, 100, 200]), np.random.default_rng(1)
    angles = [np.append(0.0, np.cumsum(al.simulate(model, size, 1.0, rng=rng).values)) for _ in range(750)]
    found = np.array([[theobr(x, k, 1.0) for x in angles] for k in m.tolist()])
    C, seen = covariance(row, model, m, size, 1.0), np.cov(found)
    # 750 records: 5 % of a variance, and as much beyond the first order
    np.testing.assert_allclose(np.sqrt(np.diag(C)), np.sqrt(np.diag(seen)), rtol=0.12)
    assert correlated(C, seen) < 0.2
    plain = covariance(STATISTICS["theo1"], model, m, size, 1.0)
    assert C[0, 0] / plain[0, 0] > 1


@rows("name", ["totdev", "adev", "mtie"])
def test_what_is_not_known_is_refused(name):
    with pytest.raises(al.UsageError):
        covariance(STATISTICS[name], model_of({"N": 1.0}), np.array([2, 4]), SIZE, 1.0)
