"""Limits where a deterministic term outweighs the noise, or the statistic removes it."""

import warnings

import numpy as np
from tests.rows import paired, rows

import allanite as al
from allanite.statistics.confidence.chisquares import Eigenvalues
from allanite.statistics.confidence.limits import TermKinds, _mixtures
from allanite.statistics.moments import lagsums
from allanite.statistics.table import STATISTICS

MODELS = ["R 0.08 rad/s^2, GM 0.02 rad/s 2 s", "R 100 rad/s^2, GM 0.02 rad/s 2 s", "R 1 rad/s^2, N 1e-6 rad/s/sqrt(Hz)",
          "R 1 rad/s^2"]  # fmt: skip


@rows("statistic, model", paired(["mdev", "tdev", "oadev", "hdev", "ohdev", "totdev", "theo1"], MODELS))
def test_every_limit_is_a_number(model, statistic):
    record = al.simulate(al.Model(model), 20_000, 40.0, rng=np.random.default_rng(1))
    m = 2 * np.unique(np.geomspace(5, 3000, 60).astype(int))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        curve = al.deviation(record, statistic, m=m.tolist(), noise=al.Model(model))
        low, high = curve.interval(0.95)
    assert np.isfinite([curve.edf, low, high]).all()
    assert (low <= high).all()


def test_a_third_difference_removes_a_ramp():
    noise = al.N(1, "rad/s/sqrt(Hz)")
    record = al.simulate(noise, 20_000, 40.0, rng=np.random.default_rng(1))
    models = al.Model((noise,)), noise + al.R(1e3, "rad/s^2")
    alone, beside = (al.deviation(record, "ohdev", m=[30, 300, 3000], noise=model) for model in models)
    np.testing.assert_allclose(beside.edf, alone.edf, rtol=1e-12)
    np.testing.assert_allclose(beside.interval(0.95), alone.interval(0.95), rtol=1e-9)


@rows("m", [5, 10, 34])
def test_covariance_of_modified_windows_far_apart(m):
    """Where some of the differences are taken from derivatives and the others are not."""
    term = al.GM(1.0, "rad/s", time_constant=2.0).sampled(40.0)
    window = np.zeros(3 * m)
    for k in range(m):
        window[[k, k + m, k + 2 * m]] += 1, -2, 1
    lags = np.arange(30.0, 50.0) * m
    distance = np.subtract.outer(np.arange(3.0 * m), np.arange(3.0 * m))
    dense = [-0.5 * window @ term.structure(np.abs(lag + distance)) @ window for lag in lags]
    found = lagsums.covariance_of_windows(STATISTICS["mdev"], term, m, np.append(0.0, lags))
    np.testing.assert_allclose(found[1:], dense, atol=1e-6 * found[0])


def test_weights_of_a_form_of_nearly_one_eigenvalue_are_not_negative():
    rng, kinds = np.random.default_rng(1), TermKinds(*(np.array([kind]) for kind in (True, False, False)))
    mass, rest = rng.uniform(0.2, 1, 2000), 10.0 ** rng.uniform(-12, -6, 2000)
    lead = np.array([1 - rest, 0.3 * rest * rng.random(2000), 1e-3 * rest]).T
    squares = (lead**2).sum(axis=1)
    spectrum = Eigenvalues(lead, squares + 3 * rest * rng.random(2000))
    wanted = mass**2 * squares * (1 + 3 * rest * rng.random(2000))
    fit, laws = _mixtures(spectrum, mass[:, None], np.eye(1), kinds, wanted)
    assert fit.size > 1000
    assert laws.weight.min() >= 0
