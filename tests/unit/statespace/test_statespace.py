"""State spaces: exact discretisation, Allan curves from the matrices, filters that work."""

import numpy as np
import pytest
from scipy.linalg import expm
from tests.commands import of_verb
from tests.rows import paired, refused, rows

import allanite as al
from allanite.statespace.build import flicker_sum, joined
from allanite.terms.markov import markov_block
from allanite.terms.powers import integrators
from allanite.terms.waveforms import oscillator

WALK = integrators(("bias",), 0.5, density=0.09)
BLOCKS = {
    "slow": (0.01, markov_block(2.0, 1e4, 0.01)), "near": (0.01, markov_block(2.0, 0.05, 0.01)),
    "fast": (0.01, markov_block(2.0, 0.003, 0.01)), "sine": (0.3, oscillator(2.0, 0.7, 0.3)),
    "walk": (0.5, integrators(("bias",), 0.5, density=0.09, start=1.0)),
    "ramp": (0.5, joined([WALK, integrators(("bias", "ramp"), 0.5, density=0.04, start=0.2)])),
}  # fmt: skip
"""The step, s, and what is discretised."""


@rows("name", list(BLOCKS))
def test_the_discretisation_is_that_of_numerical_integration(name):
    """Gauss-Legendre over the interval of what an impulse of noise leaves in the states and in the mean."""
    h, block = BLOCKS[name]
    np.testing.assert_allclose(block.Phi, expm(block.F * h), rtol=1e-12, atol=1e-15)
    x, w = np.polynomial.legendre.leggauss(24)
    at, weight = (x + 1) / 2 * h, w / 2 * h

    def mean_after(s):
        """Row that gives the mean over the whole interval of what is there at the time h - s."""
        return sum(v * expm(block.F * u)[0] for u, v in zip(at * s / h, weight * s / h, strict=True)) / h

    np.testing.assert_allclose(block.mean, mean_after(h), rtol=1e-10, atol=1e-15)
    G = [np.vstack([expm(block.F * s), mean_after(s)]) for s in at]
    total = sum(v * g @ block.Qc @ g.T for g, v in zip(G, weight, strict=True))
    np.testing.assert_allclose(block.Q, total, rtol=1e-9, atol=1e-14 * max(np.abs(total).max(), 1e-30))


EXACT = {
    "N": "N 1 rad/sqrt(s), K 0 rad/s^1.5", "QK": "Q 0.3 rad, K 0.02 rad/s^1.5",
    "NKR": "N 1 rad/sqrt(s), K 0.02 rad/s^1.5, R 1e-3 rad/s^2",
    "GM": "N 0.2 rad/sqrt(s), GM 1 rad/s 3 s, GM 2 rad/s 300 s", "GMA": "N 0.2 rad/sqrt(s), GMA 0.3 rad 3 s",
    "Sine": "N 1 rad/sqrt(s), Sine 0.4 rad/s 0.11 Hz",
    "all": "Q 0.3 rad, N 1 rad/sqrt(s), K 0.02 rad/s^1.5, R 1e-3 rad/s^2, GM 1 rad/s 3 s, Sine 0.4 rad/s 0.11 Hz",
}  # fmt: skip


@rows("name, rate", paired(list(EXACT), [1.0, 50.0]))
def test_the_allan_variance_of_the_matrices_is_that_of_the_model(name, rate):
    model = al.Model(EXACT[name])
    space = al.state_space(model, rate, measurement="mean", tau=(1.0, 400.0))
    m = np.array([1, 2, 3, 7, 50, 391])
    np.testing.assert_allclose(space.allan(m), al.expected(model, "oadev", m / rate), rtol=2e-8)
    assert space.ripple < 1e-8
    assert np.linalg.eigvalsh(space.Qd).min() >= -1e-12 * np.abs(space.Qd).max()


def simulated(space, n, rng):
    """The recursion itself."""
    (x,), w = (rng.multivariate_normal(np.zeros(len(C)), C, count, "ignore", method="eigh")
               for C, count in ((space.P0, 1), (space.Qd, n)))  # fmt: skip
    y = np.empty(n)
    for k in range(n):
        x = space.Phi @ x + w[k]
        y[k] = space.H[0] @ x
    return y + np.sqrt(space.R[0, 0]) * rng.standard_normal(n)


@rows("measurement, text", [("mean", "Q 0.4 rad, "), ("sample", "")])
def test_the_recursion_has_the_curve_of_the_matrices(measurement, text):
    """12 records of 4096 steps; every octave within 5 standard errors of the mean: one failure in 1e5."""
    model = al.Model(text + "N 0.5 rad/sqrt(s), B 1 rad/s, K 0.05 rad/s^1.5")
    space = al.state_space(model, 2.0, tau=(1.0, 200.0), measurement=measurement)
    rng = np.random.default_rng(1)
    records = [al.Record(simulated(space, 4096, rng), 2.0, "rad/s") for _ in range(12)]
    curves = [al.deviation(record, "oadev", noise=model) for record in records]
    keep = curves[0].tau <= 200
    mean = np.mean([c.variance for c in curves], axis=0)[keep]
    error, wanted = np.sqrt(2 / curves[0].edf / len(records))[keep], space.allan(curves[0].m[keep])
    assert np.all(np.abs(mean / wanted - 1) < 5 * error)
    if measurement == "mean":
        np.testing.assert_allclose(wanted, al.expected(model, "oadev", curves[0].tau[keep]), rtol=0.05)


@rows("text", ["N 1 rad/sqrt(s), ", "Q 0.3 rad, N 1 rad/sqrt(s), ", "GM 1 rad/s 5 s, N 1 rad/sqrt(s), "])
def test_a_filter_with_these_matrices_is_consistent(text):
    """Normalised innovations of exact records are white with variance 1: within 5 standard errors."""
    model = al.Model(text + "K 0.1 rad/s^1.5")
    space = al.state_space(model, 4.0, turn_on=10.0, measurement="mean")
    record = al.simulate(model, 6000, 4.0, rng=np.random.default_rng(1))
    x, P, innovations = np.zeros(len(space.Phi)), space.P0, []
    for y in record.values:
        x, P = space.Phi @ x, space.Phi @ P @ space.Phi.T + space.Qd
        S = space.H @ P @ space.H.T + space.R
        gain, innovation = (P @ space.H.T / S)[:, 0], y - space.H[0] @ x
        innovations.append(innovation / np.sqrt(S[0, 0]))
        x, P = x + gain * innovation, P - np.outer(gain, space.H[0] @ P)
    z = np.array(innovations[100:])
    assert z.var() == pytest.approx(1, abs=5 * np.sqrt(2 / z.size))
    for lag in (1, 2, 10):
        assert abs(np.mean(z[lag:] * z[:-lag])) < 5 / np.sqrt(z.size)


@rows("tau, ripple", [((1.0, 1000.0), 0.02), ((0.1, 1e4), 0.005), ((3.0, 8.0), 0.02)])
def test_the_sum_is_flicker_in_its_range(tau, ripple):
    """By the exact expectation of the terms, on a grid of its own."""
    found = flicker_sum(tau, ripple=ripple)
    pairs = zip(found.sizes, found.time_constants, strict=True)
    model = al.Model(tuple(al.GM(size, "1", time_constant=T) for size, T in pairs if size > 0))
    at = np.geomspace(*tau, 97)
    ratio = np.sqrt(al.expected(model, "oadev", at) / al.expected(al.B(1.0, "1"), "oadev", at)) - 1
    assert np.abs(ratio).max() <= 1.01 * found.ripple <= 1.01 * ripple
    assert ratio.max() > 0.8 * found.ripple
    assert ratio.min() < -0.8 * found.ripple
    assert flicker_sum(tau, order=found.sizes.size).ripple == found.ripple


def test_the_deviation_from_the_model_is_told():
    space = al.state_space(al.sensor("fog"), 100.0, tau=(1.0, 1000.0), ripple=0.02)
    at = np.unique(np.rint(np.geomspace(100, 100_000, 60)).astype(int))
    off = np.sqrt(space.allan(at) / al.expected(space.model, "oadev", at / 100)) - 1
    assert np.abs(off).max() == pytest.approx(space.ripple, rel=0.1)
    assert 0.001 < space.ripple < 0.02
    assert space.measurement == "mean"  # because of Q
    assert len(space.states) == len(space.units) == len(space.Phi) == 8
    assert ((space.units[1], space.units[6]), space.F.shape, len(space.notes)) == (("rad/s^2", "rad"), (6, 6), 4)


@rows("text, measurement", [("N 0.1 deg/sqrt(h), GM 1 deg/h 100 s", "sample"),
                            ("N 0.001 deg/sqrt(h), GM 10 deg/h 0.02 s", "mean")])  # fmt: skip
def test_the_simpler_measurement_is_taken_where_it_does(text, measurement):
    assert al.state_space(al.Model(text), 100.0).measurement == measurement


@rows("text, options, words", [
    ("N 1 deg/sqrt(h)", {}, "measurement noise alone"),
    ("Q 1 arcsec", {"measurement": "sample"}, "needs measurement='mean'"),
    ("B 1 deg/h", {"tau": (10.0, 1.0)}, "0 < low < high"), ("B 1 deg/h", {"order": 0}, "between 1 and 40"),
    ("B 1 deg/h", {"ripple": 0.0}, "above 0"), ("B 1 deg/h", {"measurement": "median"}, "auto, mean or sample"),
    ("K 1 deg/h/sqrt(h)", {"turn_on": -1.0}, "between 0 and 1e.30"),
])  # fmt: skip
def test_what_is_refused(text, options, words):
    refused(al.UsageError, words, lambda: al.state_space(al.Model(text), 10.0, **options))


run = of_verb("statespace")


@pytest.mark.slow("takes more than half a second")
def test_the_verb_prints_matrices_that_can_be_pasted(tmp_path):
    result = run("--sensor", "mems", "--rate", 50, "--turn-on", "30 deg/h", "--plot", tmp_path / "a.png", code=0)
    pasted = {}
    block = result.stdout[result.stdout.index("  Phi = ") : result.stdout.index("\n\n  Phi is the transition")]
    exec("\n".join(line[2:] if line[2] != " " else line for line in block.splitlines()), {}, pasted)  # noqa: S102
    space = al.state_space(al.sensor("mems"), 50.0, turn_on=30 * np.pi / 180 / 3600)
    assert set(pasted) == {"Phi", "Qd", "H", "R", "P0"}
    for name, matrix in pasted.items():
        np.testing.assert_array_equal(np.array(matrix, dtype=float), getattr(space, name))
    assert (tmp_path / "a.png").stat().st_size > 10_000


@rows("arguments", [("--tau", "1"), ("--tau", "0,3"), ("--turn-on", "3"), ("--order", "99")])
def test_wrong_options_are_refused(arguments):
    assert run("--sensor", "mems", "--rate", 10, *arguments).exit_code == 2
