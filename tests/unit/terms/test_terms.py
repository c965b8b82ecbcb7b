"""Terms with a shape: their rows against the structure function, dense matrices and simulation."""

import dataclasses

import numpy as np
import pytest
from scipy.fft import dct
from tests.reference.dense import moments, quadratic_form

import allanite as al
from allanite.core.model import term
from allanite.terms import TERMS
from allanite.terms.angle_markov import angle_markov
from allanite.terms.markov import gauss_markov
from allanite.terms.oscillation import oscillation
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


def longest(x):
    """Cosines and products in long double."""
    return np.asarray(x, dtype=np.longdouble)


PI = np.longdouble("3.14159265358979323846264338327950288")


def of_an_oscillation(f, z, h):
    """Covariance of means over one interval, h apart, in long double."""
    w, z, h = 2 * PI * longest(f), np.clongdouble(z), longest(h)
    slow, fast = w * (z - np.sqrt(z * z - 1)), w * (z + np.sqrt(z * z - 1))
    found = 0
    for s, other in ((slow, fast), (fast, slow)):
        means = np.where(h == 0, 2 * (np.expm1(-s) + s), np.expm1(-s) ** 2 * np.exp(-s * (h - 1))) / s**2
        found = found + other / (other - s) * means
    return found.real


def of_an_angle(structure, h):
    """Covariance of the differences of an angle, h apart."""
    return 0.5 * (structure(h + 1) - 2 * structure(h) + structure(np.abs(h - 1)))


def diagonal(covariance, n):
    """The diagonal of T C T' for coefficients 1 .. n - 1, in long double."""
    lag = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    j, k = longest(np.arange(n)), longest(np.arange(1, n))
    basis = np.sqrt(longest(2) / n) * np.cos(PI * k[:, None] * (2 * j + 1) / (2 * n))
    return np.einsum("ki,ij,kj->k", basis, covariance(lag) - covariance(0 * lag), basis)


SHAPES = [(0.05, 0.15), (0.31, 0.02), (0.01, 2.5), (0.01, 1.0), (0.002, 0.7)]


@pytest.mark.parametrize("n", [64, 97])
@pytest.mark.parametrize("shape", SHAPES)
def test_row_of_the_transform_of_an_oscillation(shape, n):
    """Relative to the power of the record, of which rounding is a part where nothing else is left."""
    # at critical damping both exponentials are the same: the referee takes the next ones
    exact = diagonal(lambda h: of_an_oscillation(shape[0], shape[1] + 1e-7 * (shape[1] == 1), h), n).astype(float)
    found = oscillation(*shape).dct(np.arange(1.0, n), n)
    np.testing.assert_allclose(found, exact, rtol=1e-9 if shape[1] != 1 else 1e-6, atol=1e-14)


ANGLES = [*(angle_markov(T) for T in (0.02, 0.3, 3.0, 12.0)), TERMS["F"]]


@pytest.mark.parametrize("n", [64, 97])
@pytest.mark.parametrize("row", ANGLES, ids=["GMA 0.02", "GMA 0.3", "GMA 3", "GMA 12", "F"])
def test_row_of_the_transform_of_an_angle_error(row, n):
    """The angle at the ends of the record adds what `ends` says."""
    exact = diagonal(lambda h: of_an_angle(row.structure, h.astype(float)), n).astype(float)
    k = np.arange(1.0, n)
    ends = row.ends * 4 / n * np.cos(np.pi * k / (2 * n)) ** 2
    np.testing.assert_allclose(row.dct(k, n) + ends, exact, rtol=1e-9)


@pytest.mark.parametrize("row", [*ANGLES, oscillation(0.05, 0.15), oscillation(0.31, 0.02), oscillation(0.2, 1.5)])
def test_increments_and_spectrum_belong_together(row):
    h = np.arange(20_000.0)
    near = h[:200]
    np.testing.assert_allclose(row.increments(near), direct_increments(row.structure, near), atol=1e-11)
    r, f = row.increments(h), np.array([0.05, 0.3, 0.5])
    summed = r[0] + 2 * np.cos(2 * np.pi * f[:, None] * h[1:]) @ r[1:]
    np.testing.assert_allclose(row.spectrum(f, 1.0) * 4 * np.sin(np.pi * f) ** 2, summed, rtol=1e-7)


def test_flicker_of_the_angle_is_a_sum():
    h = np.arange(1.0, 200.0)
    np.testing.assert_allclose(TERMS["F"].structure(h), 4 / np.pi * np.cumsum(1 / (2 * h - 1)), rtol=1e-12)


@pytest.mark.parametrize("T", CONSTANTS[:-1])
def test_spectrum_is_the_sum_of_the_covariances(T):
    h, f = np.arange(1.0, 40 * T + 10), np.array([0.001, 0.05, 0.3, 0.5])
    row = gauss_markov(T)
    r = covariance(T, h).astype(float)
    summed = [float(covariance(T, 0)) + 2 * np.sum(r * np.cos(2 * np.pi * x * h)) for x in f]
    np.testing.assert_allclose(row.spectrum(f, 1.0), summed, rtol=1e-8)


ROWS = [gauss_markov(0.3), gauss_markov(7.0), gauss_markov(300.0), sine(0.31), sine(0.02), sine(0.001)]
ROWS += [angle_markov(0.3), angle_markov(7.0), oscillation(0.05, 0.15), oscillation(0.3, 1.2), TERMS["F"]]
NAMES = ["GM 0.3", "GM 7", "GM 300", "Sine 0.31", "Sine 0.02", "Sine 0.001"]
NAMES += ["GMA 0.3", "GMA 7", "GM2 0.05", "GM2 0.3", "F"]


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
    "F": al.F(2.0, "rad"),
    "GMA": al.GMA(2.0, "rad", time_constant=1.5),
    "slow GMA": al.GMA(2.0, "rad", time_constant=8.0),
    "GM2": al.GM2(2.0, "rad/s", frequency=0.21, damping=0.15),
    "aperiodic GM2": al.GM2(2.0, "rad/s", frequency=0.21, damping=1.5),
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
        exact = E[0] * term.power(RATE) * (tau ** (2 * row.power))
        # a window of more than 64 points is extrapolated as of a smooth D: the logarithm is less so
        assert found == pytest.approx(exact, rel=1e-3 if kind == "F" else 2e-4, abs=1e-9)


@pytest.mark.parametrize("name", [n for n, row in al.STATISTICS.items() if not row.parts and not row.extreme])
def test_the_expected_curve_of_a_warm_up_is_that_of_its_waveform(name):
    row, term, n = al.STATISTICS[name], al.W(-2.0, "rad/s", time_constant=9.0), 200
    # the referee's windows begin at every sample
    for m in sorted({row.step, 6 * row.step, row.largest(n)} if row.order > 1 and row.overlapped else ()):
        flat = dataclasses.replace(term.sampled(RATE), structure=np.zeros_like)
        E, _ = moments(quadratic_form(row, m, n), [flat])
        tau = m * row.tau_factor / RATE
        found = al.expected(al.N(1.0, "rad/sqrt(s)") + term, name, [tau], rate=RATE, size=n)[0]
        beside = al.expected(al.N(1.0, "rad/sqrt(s)"), name, [tau], rate=RATE, size=n)[0]
        assert found - beside == pytest.approx(4 * E[0] * tau ** (2 * row.power), rel=1e-6, abs=1e-9 * beside)


def test_a_warm_up_needs_the_length_of_the_record_and_does_not_scatter():
    noise, warm = al.N(1.0, "rad/sqrt(s)"), al.W(2.0, "rad/s", time_constant=9.0)
    with pytest.raises(al.UsageError, match="depends on the length of the record: pass size"):
        al.expected(noise + warm, "oadev", [1.0], rate=RATE)
    record = al.simulate(noise + warm, 400, RATE, rng=np.random.default_rng(1))
    curves = [al.deviation(record, "oadev", noise=model) for model in (noise, noise + warm)]
    np.testing.assert_array_equal(curves[0].edf, curves[1].edf)
    alone = al.simulate(warm, 400, RATE, rng=np.random.default_rng(1)).values
    t = np.arange(401.0) / RATE
    exact = 2 * np.diff(t + 9 * np.exp(-t / 9)) * RATE
    np.testing.assert_allclose(alone, exact - exact.mean(), atol=1e-12)


MIXED = {
    "GM 1.5": al.GM(2.0, "rad/s", time_constant=1.5),
    "GM 80": al.GM(2.0, "rad/s", time_constant=80.0),
    "F": al.F(2.0, "rad"),
    "GMA": al.GMA(2.0, "rad", time_constant=1.5),
    "GM2": al.GM2(2.0, "rad/s", frequency=0.21, damping=0.15),
    "sharp GM2": al.GM2(2.0, "rad/s", frequency=0.21, damping=0.02),
    "fast GM2": al.GM2(2.0, "rad/s", frequency=1.0, damping=0.05),
}


@pytest.mark.parametrize("name", ["oadev", "mdev", "ohdev"])
@pytest.mark.parametrize("kind", MIXED)
def test_degrees_of_freedom_equal_the_dense_ones(name, kind):
    row, n = al.STATISTICS[name], 160
    model = al.N(1.0, "rad/sqrt(s)") + MIXED[kind]
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


SIMULATED = {f"GM {T}": al.GM(1.0, "rad/s", time_constant=T) for T in (0.05, 2.0, 100.0)} | {
    "F": al.F(1.0, "rad"),
    "GMA": al.GMA(1.0, "rad", time_constant=2.0),
    "GM2": al.GM2(1.0, "rad/s", frequency=0.3, damping=0.1),
}


@pytest.mark.parametrize("kind", SIMULATED)
def test_simulated_curves_lie_on_the_expected_ones(kind):
    """40 records; each octave within 5 standard errors: 1 failure in 1e5 runs by chance."""
    model = al.N(0.5, "rad/sqrt(s)") + SIMULATED[kind]
    records = [al.simulate(model, 2048, RATE, rng=np.random.default_rng(seed)) for seed in range(1, 41)]
    curves = [al.deviation(record, "oadev", noise=model) for record in records]
    mean = np.mean([c.variance for c in curves], axis=0)
    expected = al.expected(model, "oadev", curves[0].tau, rate=RATE)
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


def test_a_damping_has_no_unit_and_models_are_read_as_they_are_written():
    text = "N 0.1 deg/sqrt(h), F 1 arcsec, GMA 2 arcsec 3 s, GM2 1 deg/h 0.5 Hz 0.2, W -3 deg/h 10 min"
    model = al.parse_model(text)
    assert str(model["GM2"]) == "GM2 = 1 deg/h with natural frequency 0.5 Hz, damping ratio 0.2"
    again = al.parse_model(str(model))
    assert [(t.symbol, t.shape) for t in again] == [(t.symbol, t.shape) for t in model]
    assert al.Model.from_dict(model.to_dict()) == model
    assert model["W"].shape == (600.0,)
    assert model["W"].value < 0
    with pytest.raises(al.UsageError, match="must be finite and not negative"):
        al.parse_model("GM2 -1 deg/h 0.5 Hz 0.2")


def test_names_of_the_angle_follow_the_sensor():
    from allanite.core.titles import title_of
    from allanite.core.units import signal_named

    assert title_of("F", signal_named("accelerometer")) == "flicker of the velocity"
    assert title_of("GMA", signal_named("voltage")) == "Gauss-Markov noise of the integrated voltage"
