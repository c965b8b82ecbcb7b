"""Corrections of bias: their factor, what it makes of expectations, and what is refused."""

import numpy as np
import pytest
from tests import model_of
from tests.rows import paired, refused, rows

import allanite as al
from allanite.core.units import SIGNALS

BIASED = [name for name, row in al.statistics.STATISTICS.items() if row.target and not row.parts]


def rate(**coefficients):
    """A model of a rate, SI."""
    return model_of(coefficients, SIGNALS[0])


def record_of(model, n=2000, seed=1):
    return al.simulate(model, n, 1.0, rng=np.random.default_rng(seed))


@rows("symbols, name", paired(["Q", "N", "B", "K", "NK"], BIASED))
def test_the_exact_factor_makes_the_expectation_that_of_the_target(name, symbols):
    model = rate(**dict.fromkeys(symbols, 1.0))
    curve, plain = (al.deviation(record_of(model), name, noise=model, bias=bias) for bias in ("exact", None))
    np.testing.assert_allclose(curve.variance, plain.variance * curve.factor)
    own = al.expected(model, name, curve.tau, rate=1.0, size=2000)
    rate_of_target = {"rate": 1.0} if name != "theo1" else {}
    wanted = al.expected(model, al.statistics.STATISTICS[name].target, curve.tau, **rate_of_target)
    np.testing.assert_allclose(curve.factor * own, wanted, rtol=1e-9)


@rows("name", ["oadev", "ohdev", "mdev", "pdev"])
def test_what_estimates_itself_has_no_bias(name):
    model = rate(N=1.0)
    assert set(al.deviation(record_of(model, 500), name, noise=model, bias="exact").factor) == {1.0}


def test_published_factors_go_by_the_power_law_that_is_found():
    record = record_of(rate(N=1.0))
    curve = al.deviation(record, "mtotdev", m=[10], bias="published")
    assert curve.factor[0] == pytest.approx(1 / 0.73)
    assert "bias factor" in curve.rows()[0]


def test_the_model_takes_the_place_of_the_ratio_of_theobr_and_does_not_scatter():
    model = rate(N=1.0, K=0.1)
    record = record_of(model, 1000)
    raw = al.deviation(record, "theo1", m=[500], noise=model)
    by_model = al.deviation(record, "theobr", m=[500], noise=model, bias="model")
    ratio = al.expected(model, "oadev", raw.tau) / al.expected(model, "theo1", raw.tau, rate=1.0)
    np.testing.assert_allclose(by_model.variance, raw.variance * ratio, rtol=1e-9)
    np.testing.assert_allclose(by_model.edf, raw.edf)
    assert al.deviation(record, "theobr", m=[500], noise=model, bias="plain").edf < raw.edf


def test_limits_on_one_side_are_those_of_the_wider_interval():
    model = rate(N=1.0)
    curve = al.deviation(record_of(model), noise=model)
    low, high = curve.interval(0.9)
    np.testing.assert_allclose(curve.lower(0.95), low, rtol=1e-12)
    np.testing.assert_allclose(curve.upper(0.95), high, rtol=1e-12)


@rows("name, options, words", [
    ("oadev", {"bias": "best"}, "known bias corrections: exact, published, model"),
    ("theo1", {"bias": "model"}, "for theobr, theoh"), ("theoh", {"bias": "exact"}, "takes"),
    ("theo1", {"bias": "exact", "noise": None}, "a bias correction depends on the noise"),
    ("theo1", {"bias": "published", "noise": rate(N=1.0)}, "noise='auto'"),
    *((name, {"noise": rate(N=1.0)}, f"this {name} has no .*: mtie and tierms never") for name in ("mtie", "tierms")),
])  # fmt: skip
def test_corrections_and_limits_that_make_no_sense_are_refused(name, options, words):
    refused(al.UsageError, words, lambda: al.deviation(record_of(rate(N=1.0)), name, **options).edf)
