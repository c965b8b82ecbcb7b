"""The simulator against the exact expectation, octave by octave."""

import numpy as np
import pytest
from tests.rows import paired, refused, rows

import allanite as al
from allanite.core.model import term
from allanite.statistics import STATISTICS, edf

UNIT = {"Q": "s", "N": "sqrt(s)", "B": "1", "K": "1/sqrt(s)", "R": "1/s"}
RUNS = 100


def as_expected(model, rate, **options):
    """100 records of 2048, seeds 1 to 100; 4.5 standard errors at 11 octaves, error probability below 1e-4."""
    records = [al.simulate(model, 2048, rate, rng=seed, **options) for seed in range(1, RUNS + 1)]
    curves = [al.deviation(record, noise=None) for record in records]
    mean = np.mean([c.variance for c in curves], axis=0)
    expected = al.expected(model, "oadev", curves[0].tau)
    freedom = edf(STATISTICS["oadev"], model, curves[0].m, 2048, rate)
    assert np.all(np.abs(mean / expected - 1) < 4.5 * np.sqrt(2 / freedom / RUNS))


@rows("symbols, rate", paired(["Q", "N", "B", "K", "QNBK", "NKR"], [1.0, 200.0]))
def test_every_octave_has_the_expected_variance(symbols, rate):
    size = {"Q": 0.5 / rate, "N": 1.0 / rate**0.5, "B": 0.3, "K": 0.02 * rate**0.5, "R": 1e-4 * rate}
    as_expected(al.Model(tuple(term(s, size[s], UNIT[s]) for s in symbols)), rate)


def test_the_same_seed_gives_the_same_record():
    model = al.N(1.0, "deg/sqrt(h)") + al.B(1.0, "deg/h")
    one, two = (al.simulate(model, 1000, 10.0, rng=7, name="x") for _ in range(2))
    np.testing.assert_array_equal(one.values, two.values)
    assert (one.unit, one.history) == ("rad/s", ("simulated: N = 1 deg/sqrt(h), B = 1 deg/h",))


@rows("n", [2, 3, 17, 1000, 1009])
def test_any_length(n):
    record = al.simulate(al.B(1.0, "deg/h"), n, 10.0, rng=1)
    assert record.size == n
    assert abs(record.values.mean()) < 1e-12


def test_what_is_refused():
    refused(al.UsageError, "between 2 and", lambda: al.simulate(al.N(1.0, "deg/sqrt(h)"), 1, 10.0, rng=1))
    with pytest.raises(al.UsageError, match="none in N = 1 deg/sqrt"):
        al.simulate(al.N(1.0, "deg/sqrt(h)"), 100, 10.0, rng=1, rounding=True)


@rows("symbol", ["N", "B", "K", "Q"])
def test_spectrum_and_structure_are_one_process(symbol):
    """Allan variance by the spectral integral against D."""
    model = al.Model((term(symbol, 1.0, UNIT[symbol]),))
    tau0, m = 0.25, 6
    # of the sampled rate, aliases included: the integral ends at half the sampling rate
    f = np.geomspace(1e-8, 0.5 / tau0, 400_001)
    block = np.sin(np.pi * f * m * tau0) / (m * np.sin(np.pi * f * tau0))
    kernel = 4 * block**2 * np.sin(np.pi * f * m * tau0) ** 2
    found = np.trapezoid(model.spectrum(f, tau0) * kernel * f, np.log(f))
    assert found == pytest.approx(al.expected(model, "oadev", m * tau0)[0], rel=1e-7)


ROUNDED = al.Q(20.0, "arcsec") + al.N(2.0, "deg/sqrt(h)") + al.K(1.0, "deg/h/sqrt(h)")


def rounding_error(seed, n=4000, rate=10.0):
    """Errors of the angle in steps, less their mean: rounded less the other terms of the same seed, summed."""
    rounded = al.simulate(ROUNDED, n, rate, rng=seed, rounding=True)
    others = al.simulate(al.Model(ROUNDED.terms[1:]), n, rate, rng=seed)
    step = ROUNDED.terms[0].value * np.sqrt(12)
    counts = rounded.values / rate / step
    np.testing.assert_allclose(counts, np.rint(counts), atol=1e-6)
    error = np.cumsum((rounded.values - others.values) / rate) / step
    return error - error.mean()


def test_a_rounded_angle_has_a_white_uniform_error_of_the_size_of_q():
    errors = np.array([rounding_error(seed) for seed in range(20)])
    power = np.square(errors)
    # of 80000 uniform errors the variance is known to 0.3 %, the kurtosis, which is 3 of Gaussian errors, to 0.2 %
    assert power.mean() == pytest.approx(1 / 12, rel=0.015)
    assert np.square(power).mean() / power.mean() ** 2 == pytest.approx(1.8, rel=0.01)
    assert np.abs(errors).max() < 0.53
    assert abs((errors[:, 1:] * errors[:, :-1]).mean() / power.mean()) < 4.5 / np.sqrt(errors.size)


def test_a_rounded_record_has_the_expected_variance():
    as_expected(ROUNDED, 10.0, rounding=True)


def test_without_rounding_the_record_is_the_gaussian_one():
    plain, same = (al.simulate(ROUNDED, 500, 10.0, rng=1, **options) for options in ({}, {"rounding": False}))
    np.testing.assert_array_equal(plain.values, same.values)
    # written down before there was a choice
    known = [28.950147784604845, -35.33117713056922, -12.668647520561898]
    np.testing.assert_allclose(plain.values[:3] * 1e4, known, rtol=1e-9)
