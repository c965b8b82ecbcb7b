"""Bias and degrees of freedom of a statistic: against the published tables, and against simulation."""

import numpy as np
import pytest
from tests.reference import edf as published
from tests.rows import rows

import allanite as al
from allanite.core.errors import UsageError
from allanite.planning.plan import properties

TABLE_1 = {"Q": (0.09, 0.74, 0.40), "N": (1.00, 0.0, 0.0), "B": (1.87, -1.05, 0.79), "K": (2.70, -1.53, 0.85),
           "F": (0.14, 0.82, 0.30)}  # fmt: skip
"""Howe and Tasset (2004), as Tang et al. (2015) quote them: Allan variance / Theo1 = a + b / (0.75 m)^c."""


@rows("symbol", TABLE_1)
def test_the_bias_of_theo1_is_that_of_the_published_fit(symbol):
    found = properties("theo1", m=[12, 100, 1000])
    a, b, c = TABLE_1[symbol]
    fit = a + b / (0.75 * found.m) ** c
    assert found.ratio[:, found.symbols.index(symbol)] == pytest.approx(fit, rel=0.08 if symbol == "F" else 0.045)


def test_degrees_of_freedom_of_theo1_near_the_published_formula():
    found = properties("theo1", m=[100, 720, 3600])
    formula = [published.theo1(0, m, 7201) for m in found.m.tolist()]
    assert found.edf[:, found.symbols.index("N")] == pytest.approx(formula, rel=0.1)


def test_a_statistic_of_second_differences_has_no_bias_and_hadamard_is_its_own_target():
    for name in ("adev", "oadev", "hdev", "ohdev"):
        assert properties(name, 500).ratio == pytest.approx(1.0)


def test_the_scatter_of_simulated_records():
    found = properties("totdev", 256, m=[64])
    model = al.Model("N 1 deg/sqrt(h)")
    draws = [
        al.deviation(al.simulate(model, 256, 1.0, rng=np.random.default_rng(seed)), "totdev", m=[64], noise=None)
        for seed in range(400)
    ]
    variance = np.array([curve.variance[0] for curve in draws])
    edf = 2 * variance.mean() ** 2 / variance.var()
    assert edf == pytest.approx(found.edf[0, found.symbols.index("N")], rel=0.25)


def test_averaging_times_or_factors():
    assert properties("theo1", 1000, taus=[7.5, 75.0]).m.tolist() == [10, 100]
    assert properties("oadev", 100, taus="decade").m.tolist()[:4] == [1, 2, 4, 10]


@rows("name, more, message", [
    ("mtie", {}, "mtie is not an estimate of the Allan or Hadamard variance"),
    ("tdev", {}, "tdev is not an estimate"), ("nothing", {}, "unknown statistic 'nothing'"),
    ("theo1", {"m": [11]}, "must be even"), ("theo1", {"taus": [8.0]}, "is not a multiple of 1.5 s"),
])  # fmt: skip
def test_bad_input(name, more, message):
    with pytest.raises(UsageError, match=message):
        properties(name, 1000, **more)


def test_limits_under_quantization_alone():
    """Only white angle noise: none of the terms is smooth."""
    record = al.simulate(al.Model("Q 1 arcsec"), 1000, 1.0, rng=np.random.default_rng(1))
    curve = al.deviation(record, "theo1", m=[10, 1000], noise=al.Model("Q 1 arcsec"))
    low, high = curve.interval(0.95)
    assert (low < curve.deviation).all()
    assert (curve.deviation < high).all()
