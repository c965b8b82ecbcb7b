"""Terms with a shape: their rows against the structure function, dense matrices and simulation."""

import dataclasses

import numpy as np
import pytest
from scipy.fft import dct
from tests.reference.dense import moments, quadratic_form

import allanite as al
from allanite.core.model import term
from allanite.terms.markov import gauss_markov
from allanite.terms.sine import sine

CONSTANTS = [0.02, 0.3, 3.0, 19.0, 21.0, 400.0, 1e5]


def direct_increments(D, h):
    return -0.5 * (6 * D(h) - 4 * D(np.abs(h - 1)) - 4 * D(h + 1) + D(np.abs(h - 2)) + D(h + 2))


def covariance(T, h):
    """Of means over one interval, h apart, in long double: differences of D would lose what is small."""
    u, h = 1 / np.longdouble(T), np.asarray(h, dtype=np.longdouble)
    return np.where(h == 0, 2 * (np.expm1(-u) + u), np.expm1(-u) ** 2 * np.exp(-u * (h - 1))) / u**2


@pytest.mark.parametrize("T", CONSTANTS)
def test_the_covariance_follows_from_the_structure_function(T):
    h, D = np.arange(50.0), gauss_markov(T).structure
    direct = 0.5 * (D(h + 1) - 2 * D(h) + D(np.abs(h - 1)))
    np.testing.assert_allclose(direct, covariance(T, h).astype(float), atol=1e-14 * (1 + h.max() ** 2), rtol=1e-12)


@pytest.mark.parametrize("T", CONSTANTS)
def test_increments_of_gauss_markov(T):
    h, row = np.arange(60.0), gauss_markov(T)
    np.testing.assert_allclose(row.increments(h), direct_increments(row.structure, h), atol=2e-12 * (1 + T) ** 1)


@pytest.mark.parametrize("T", CONSTANTS)
def test_the_driving_noise_of_a_long_time_constant_is_a_random_walk(T):
    """s sqrt(2/T) is K: the increments differ by terms of the order of 1/T."""
    if T >= 400:
        h = np.arange(3.0)
        np.testing.assert_allclose(
            gauss_markov(T).increments(h) * T / 2, al.TERMS["K"].increments(h), atol=1.5 / T, rtol=2 / T
        )


@pytest.mark.parametrize("T", CONSTANTS)
@pytest.mark.parametrize("n", [64, 97])
def test_row_of_the_transform(T, n):
    """The diagonal of T C T', exactly, edges included."""
    row, lag = gauss_markov(T), np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    C = covariance(T, lag) - covariance(T, 0)
    basis = dct(np.eye(n), axis=0, norm="ortho")[1:]
    exact = np.einsum("ki,ij,kj->k", basis, C, basis).astype(float)
    np.testing.assert_allclose(row.dct(np.arange(1.0, n), n), exact, rtol=1e-9 + 1e-13 * T, atol=1e-13)


@pytest.mark.parametrize("T", CONSTANTS[:-1])
def test_spectrum_is_the_sum_of_the_covariances(T):
    h, f = np.arange(1.0, 40 * T + 10), np.array([0.001, 0.05, 0.3, 0.5])
    row = gauss_markov(T)
    r = covariance(T, h).astype(float)
    summed = [float(covariance(T, 0)) + 2 * np.sum(r * np.cos(2 * np.pi * x * h)) for x in f]
    np.testing.assert_allclose(row.spectrum(f, 1.0), summed, rtol=1e-8)


ROWS = [gauss_markov(0.3), gauss_markov(7.0), gauss_markov(300.0), sine(0.31), sine(0.02), sine(0.001)]
NAMES = ["GM 0.3", "GM 7", "GM 300", "Sine 0.31", "Sine 0.02", "Sine 0.001"]


@pytest.mark.parametrize("row", ROWS, ids=NAMES)
def test_second_sum(row):
    """E(l+1) - 2 E(l) + E(l-1) = D(l) but for a constant, and for even polynomials of a sinusoid."""
    length = np.arange(40.0)
    E = row.summed(np.abs(np.arange(-1, 41.0)))
    second = E[2:] - 2 * E[1:-1] + E[:-2] - row.structure(length)
    basis = np.column_stack([length**0, length**2] if row.periodic else [length**0])
    rest = second - basis @ np.linalg.lstsq(basis, second, rcond=None)[0]
    assert np.abs(rest).max() < 1e-9 * np.abs(row.structure(length)).max()


@pytest.mark.parametrize("row", ROWS, ids=NAMES)
def test_derivatives(row):
    t = np.array([2.0, 5.0, 30.0])
    for order in range(1, 8):
        below = row.structure if order == 1 else lambda x, k=order - 1: row.derivative(k, x)
        step = 1e-4
        numeric = (below(t + step) - below(t - step)) / (2 * step)
        np.testing.assert_allclose(row.derivative(order, t), numeric, rtol=1e-5, atol=1e-7)


RATE = 4.0
SHAPED = {
    "GM": al.GM(2.0, "rad/s", time_constant=1.5),
    "slow GM": al.GM(2.0, "rad/s", time_constant=80.0),
    "Sine": al.Sine(2.0, "rad/s", frequency=0.21),
    "fast Sine": al.Sine(2.0, "rad/s", frequency=1.7),
}


@pytest.mark.parametrize("kind", list(SHAPED))
@pytest.mark.parametrize("name", [n for n, row in al.STATISTICS.items() if not row.parts and not row.extreme])
def test_expected_curves_equal_the_dense_form(name, kind):
    row, term, n = al.STATISTICS[name], SHAPED[kind], 200
    model = al.Model((term,))
    for m in sorted({row.step, 6 * row.step, row.largest(n) // (2 * row.step) * row.step, row.largest(n)}):
        if row.order < 2:
            continue
        # the referee knows a waveform, and of that the one phase; the mean over phases follows from D alone
        E, _ = moments(quadratic_form(row, m, n), [dataclasses.replace(term.sampled(RATE), waveform=None)])
        tau = m * row.tau_factor / RATE
        found = al.expected(model, name, [tau], rate=RATE, size=n)[0]
        exact = E[0] * 4.0 * (tau ** (2 * row.power))
        assert found == pytest.approx(exact, rel=2e-4, abs=1e-9)


@pytest.mark.parametrize("name", ["oadev", "mdev", "ohdev"])
@pytest.mark.parametrize("T", [1.5, 80.0])
def test_degrees_of_freedom_of_gauss_markov_equal_the_dense_ones(name, T):
    row, n = al.STATISTICS[name], 160
    model = al.N(1.0, "rad/sqrt(s)") + al.GM(2.0, "rad/s", time_constant=T)
    for m in (1, 5, 30):
        E, r = moments(quadratic_form(row, m, n), [t.sampled(RATE) for t in model])
        E = E * np.array([t.power(RATE) for t in model])
        p = E / E.sum()
        assert al.statistics.edf(row, model, np.array([m]), n, RATE)[0] == pytest.approx(1 / (p @ r @ p), rel=1e-3)


def test_limits_are_those_of_the_noise_where_a_line_stands_in_the_model():
    noise, line = al.N(1.0, "rad/sqrt(s)"), al.Sine(2.0, "rad/s", frequency=0.21)
    record = al.simulate(noise + line, 4000, RATE, rng=np.random.default_rng(1))
    curves = [al.deviation(record, "oadev", noise=model) for model in (al.Model((noise,)), noise + line)]
    np.testing.assert_array_equal(curves[0].edf, curves[1].edf)
    with pytest.raises(al.UsageError, match="no noise"):
        _ = al.deviation(record, "oadev", noise=al.Model((line,))).edf


@pytest.mark.parametrize("T", [0.05, 2.0, 100.0])
def test_simulated_curves_lie_on_the_expected_ones(T):
    """40 records; each octave within 5 standard errors: 1 failure in 1e5 runs by chance."""
    model = al.N(0.5, "rad/sqrt(s)") + al.GM(1.0, "rad/s", time_constant=T)
    records = [al.simulate(model, 2048, RATE, rng=np.random.default_rng(seed)) for seed in range(1, 41)]
    curves = [al.deviation(record, "oadev", noise=model) for record in records]
    mean = np.mean([c.variance for c in curves], axis=0)
    expected = al.expected(model, "oadev", curves[0].tau)
    assert np.all(np.abs(mean / expected - 1) < 5 * np.sqrt(2 / curves[0].edf / 40))


def test_a_sinusoid_has_its_amplitude_frequency_and_phase():
    wave = al.simulate(al.Sine(3.0, "rad/s", frequency=0.5, phase=0.3), 4000, RATE, rng=np.random.default_rng(1)).values
    t = (np.arange(4000) + 0.5) / RATE
    np.testing.assert_allclose(wave, 3 * np.sinc(0.125) * np.sin(2 * np.pi * 0.5 * t + 0.3), atol=1e-9)


def test_models_with_shapes():
    two = al.GM(1.0, "deg/h", time_constant=10.0) + al.GM(2.0, "deg/h", time_constant=100.0)
    assert "GM = 1 deg/h with time constant 10 s" in str(two)
    again = al.Model.from_dict(two.to_dict())
    assert [t.shape for t in again] == [(10.0,), (100.0,)]
    with pytest.raises(al.UsageError, match="occurs 2 times"):
        _ = two["GM"]
    with pytest.raises(al.UsageError, match="each term may occur once"):
        _ = two + al.GM(3.0, "deg/h", time_constant=10.0)
    with pytest.raises(al.UsageError, match="time_constant in s"):
        term("GM", 1.0, "deg/h")
    with pytest.raises(al.UsageError, match="above 0"):
        al.GM(1.0, "deg/h", time_constant=0.0)
    assert str(al.Sine(1.0, "deg/h", frequency=2.0)) == "Sine = 1 deg/h with frequency 2 Hz"
    assert (two + al.Sine(1.0, "deg/h", frequency=2.0)).noise == two
