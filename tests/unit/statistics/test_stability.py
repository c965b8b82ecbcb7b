import math

import numpy as np
import pytest
from tests.rows import refused, rows

import allanite as al
from allanite.core.readings import FLICKER

NOISE = {"N": al.N(1.0, "rad/sqrt(s)"), "B": al.B(1.0, "rad/s"), "K": al.K(0.1, "rad/s^1.5")}


def record_of(y, rate=1.0):
    return al.Record(y, rate=rate, unit="rad/s", kind="rate")


def test_it_is_the_standard_deviation_of_whole_block_means():
    y = np.random.default_rng(1).standard_normal(1003)
    found = al.averaging_stability(record_of(y, 10.0), 2.5)
    means = y[:1000].reshape(40, 25).mean(axis=1)
    assert found.value == pytest.approx(means.std(ddof=1))
    assert (found.blocks, found.duration, found.seconds) == (40, 100.3, 2.5)
    y = np.random.default_rng(1).standard_normal(100)
    y[33] = np.nan
    found = al.averaging_stability(record_of(y), 10.0, model=NOISE["N"] + NOISE["K"])
    means = np.delete(y.reshape(10, 10).mean(axis=1), 3)
    assert (found.value, found.blocks) == (pytest.approx(means.std(ddof=1)), 9)


@rows(("symbol", "exact"), [("N", 1 / 10), ("K", 0.01 * 10 / 3 * 36 / 2)])
def test_the_expectation_has_its_closed_forms(symbol, exact):
    """White noise: N^2/tau; random walk: K/2 of the Allan variance, K the number of means."""
    found = al.averaging_stability(record_of(np.arange(360.0)), 10.0, model=al.Model((NOISE[symbol],)))
    assert found.expected**2 == pytest.approx(exact, rel=1e-9)


@rows("symbols", ["N", "B", "NK"])
def test_records_agree_with_the_expectation(symbols):
    """400 records, seeds 1..400: the mean square within 5 standard errors, missed once in a million tests."""
    model = al.Model(tuple(NOISE[s] for s in symbols))
    squares = []
    for seed in range(1, 401):
        record = al.simulate(model, 320, 1.0, rng=np.random.default_rng(seed))
        found = al.averaging_stability(record, 10.0, model=model)
        squares.append((found.value / found.expected) ** 2)
    assert abs(np.mean(squares) - 1) < 5 * np.std(squares) / 20


def test_wrong_lengths_are_refused():
    record = record_of(np.arange(30.0))
    refused(al.UsageError, "not a multiple of the sample interval", lambda: al.averaging_stability(record, 2.5))
    refused(al.DataError, "longest possible time is 15 s", lambda: al.averaging_stability(record, 20.0))


def test_the_minimum_of_a_curve_is_that_of_the_crossing_or_a_limit():
    model = al.N(1.0, "rad/sqrt(s)") + al.K(0.05, "rad/s^1.5")
    record = al.simulate(model, 200_000, 1.0, rng=np.random.default_rng(1))
    found = al.minimum(al.deviation(record, "oadev", taus="log", noise=model))
    assert found.inside
    assert found.tau == pytest.approx(math.sqrt(3) / 0.05, rel=0.5)
    assert found.value == pytest.approx(math.sqrt(2 * 0.05 / math.sqrt(3)) * FLICKER, rel=0.1)
    record = al.simulate(al.Model((NOISE["N"],)), 5000, 1.0, rng=np.random.default_rng(1))
    assert not al.minimum(al.deviation(record, noise=NOISE["N"] + NOISE["B"])).inside
