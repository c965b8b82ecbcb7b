"""Low-pass filters as factors of the expected power, and how a fit finds one."""

import math

import numpy as np
import pytest
from scipy.fft import dct
from scipy.linalg import toeplitz
from scipy.signal import butter, freqz, lfilter
from tests.rows import rows
from tests.unit.identification.records import RATE, RC, B, N, claimed, covers, record_of, settled

import allanite as al
from allanite.identification.likelihood.filters import FILTERS
from allanite.study.noise import noise_of

F = np.linspace(0.0, 0.49, 50)


def folded(power, averaged):
    """White noise behind an analog filter, sampled: the sum over the images, one by one; averaged over each sample."""
    images = F + np.arange(-3000, 3001)[:, None]
    gain = (power(np.abs(images)) * (np.sinc(images) ** 2 if averaged else 1.0)).sum(axis=0)
    return gain if averaged else gain / gain[0]


LONG = 0.03, 0.16
SHORT = 0.4, 0.8  # cut-offs of which averages are shorter than a sample, or nearly


@rows("name, power, averaged, cutoffs", [
    ("rc", lambda x, c: 1 / (1 + (x / c) ** 2), False, LONG + SHORT),
    ("butterworth", lambda x, c: 1 / (1 + (x / c) ** 4), False, LONG + SHORT),
    ("averaged rc", lambda x, c: 1 / (1 + (x / c) ** 2), True, LONG + SHORT),
    ("average", lambda x, c: np.sinc(0.443 * x / c) ** 2, False, LONG),
    ("bartlett", lambda x, c: np.sinc(0.3189 * x / c) ** 4, False, LONG),
])  # fmt: skip
def test_a_gain_is_the_sum_over_the_images(name, power, averaged, cutoffs):
    tolerance = 3e-4 if name in ("rc", "average") else 1e-6  # what the sum leaves out beyond its last image
    for cutoff in cutoffs:
        expected = folded(lambda x, cutoff=cutoff: power(x, cutoff), averaged)
        np.testing.assert_allclose(FILTERS[name].gain(F, cutoff), expected, atol=tolerance)


@rows("name, cutoff, taps", [
    *((f"bilinear {order}", cutoff, butter(order, 2 * cutoff)) for order in (1, 2) for cutoff in (0.05, 1 / 6, 0.4)),
    ("average", 0.443 / 4, (np.ones(4) / 4, 1.0)),
])  # fmt: skip
def test_a_digital_filter_is_that_of_scipy(name, cutoff, taps):
    _, response = freqz(*taps, 2 * np.pi * F)
    np.testing.assert_allclose(FILTERS[name].gain(F, cutoff), np.abs(response) ** 2, atol=1e-12)


@rows("name, cutoff", [("bilinear 2", 1 / 6), ("bilinear 1", 0.2), ("decimated", 0.15), ("butterworth", 0.05)])
def test_the_edges_of_a_record_are_those_of_the_filtered_noise(name, cutoff):
    """The literal variance of the transform of white noise, and of angle noise, with the covariance of the filter."""
    n, f = 300, np.arange(2049) / 4096
    T, k = dct(np.eye(n), axis=0, norm="ortho")[1:], np.arange(1, n)
    beyond, passed = k > n / 2, k < 0.1 * n * cutoff
    for power, edges in zip((0, 2), FILTERS[name].edges(cutoff), strict=True):
        r = np.fft.irfft(FILTERS[name].gain(f, cutoff) * (2 * np.sin(np.pi * f)) ** power)
        literal = np.einsum("kj,kj->k", T, T @ toeplitz(r[:n]))
        own = FILTERS[name].gain(k / (2 * n), cutoff) * (2 * np.sin(np.pi * k / (2 * n))) ** power
        shape = 2 / n * np.cos(np.pi * k / (2 * n)) ** 2
        np.testing.assert_allclose((own + edges * shape)[beyond], literal[beyond], rtol=0.02)
    mean = FILTERS[name].gain((np.arange(512) + 0.5) / 1024, cutoff).mean()
    np.testing.assert_allclose((own + 2 * mean * shape)[passed], literal[passed], rtol=0.02)


@rows("name", FILTERS)
def test_every_filter_lets_the_lowest_frequencies_pass(name):
    assert FILTERS[name].gain(np.array([1e-6]), 0.1)[0] == pytest.approx(1, abs=1e-6)
    assert (np.diff(FILTERS[name].gain(np.linspace(0, 0.2, 9), 0.2)) < 0).all()


SECOND = butter(2, 1 / 3)


def filtered(taps, seed, model=N + B):
    return record_of(settled(model, 2**16, seed, taps))


@rows("name, cutoff, taps", [
    ("rc", 1 / 12, RC), ("bilinear 2", 1 / 6, SECOND), ("average", 0.443 / 4, (np.ones(4) / 4, [1.0])),
])  # fmt: skip
def test_a_filter_is_found_with_its_cut_off_and_the_noise_before_it(name, cutoff, taps):
    record = filtered(taps, 3)
    fit = al.identify(record)
    found = fit.scope.filter
    assert found.row == name
    assert found.low < cutoff * RATE < found.high
    assert found.high < 1.1 * found.low
    assert fit.validity == "explained"
    assert covers(fit, N)
    assert np.ptp(fit["N"].interval()) < 0.05 * N.value
    assert fit["Q"].status == "not observable"
    assert "filter" in fit["Q"].reason
    assert "low-pass" in fit.scope.sentences[0]
    assert al.residuals(record, fit).explained


def test_angle_noise_beside_a_filter_dominates_the_spectrum_somewhere_or_is_not_claimed():
    """Q is claimed from the shape of a Butterworth low-pass in 5 of 80 records, these among them, without that rule."""
    for seed in (2, 6, 23, 26, 73):
        rng = np.random.default_rng(seed)
        white, angle = 1e-3 * rng.standard_normal(4596), 8e-6 * rng.standard_normal(4597)
        absent = al.identify(record_of(lfilter(*SECOND, white)[500:]))["Q"]
        assert absent.status == "not observable"
        assert "dominates the spectrum at no frequency" in absent.reason
        present = al.identify(record_of(lfilter(*SECOND, white + RATE * np.diff(angle))[500:]))
        assert covers(present, al.Q(8e-6, "rad"), 0.997)


def test_the_cut_off_that_is_not_known_widens_the_limits():
    """The interval of N is that of the cut-offs left open: wider than with the cut-off known."""
    wide, known = (np.ptp(al.identify(filtered(taps, 2))["N"].interval()) for taps in (SECOND, None))
    assert wide > 1.2 * known


def decimated(order, cutoff, step, seed, *, times=6, n=2**16):
    """White noise behind a low-pass that runs at a multiple of the rate, rounded to steps, and its N, deg/sqrt(s).

    N is that of the samples: with what is folded to low frequencies, and the noise of the rounding.
    """
    y = math.sqrt(RATE * times) * np.random.default_rng(seed).standard_normal(times * (n + 512))
    b, a = butter(order, 2 * cutoff / times)
    y = lfilter(b, a, y)[512 * times :: times]
    _, folded = freqz(b, a, 2 * np.pi * np.arange(times) / times)
    N = math.sqrt((np.abs(folded) ** 2).sum() + step**2 / 12 / RATE)
    return al.Record(np.round(y / step) * step if step else y, RATE, "deg/s"), al.N(N, "deg/sqrt(s)").value


@rows("seed", [1, 2, 3])
def test_n_behind_a_low_pass_is_not_what_is_left_of_angle_noise(seed):
    """The gain of an RC and the rise of angle noise end in a plateau, called N: 0.58 of it, with limits of 4 %."""
    model, p = al.Q(2e-4, "deg") + al.N(0.002, "deg/sqrt(s)"), math.exp(-math.pi / 6)
    y = al.simulate(model, 4096 + 512, RATE, rng=np.random.default_rng(seed)).values
    fit = al.identify(al.Record(lfilter([1 - p], [1, -p], y)[512:], RATE, "rad/s"))
    assert covers(fit, model["N"], 0.9973)
    assert "filter" in [c.name for c in fit.components]


@rows("order, cutoff, step", [(2, 0.12, 0.0), (2, 0.12, 1.5), (2, 0.3, 4.0), (1, 0.35, 0.0), (1, 0.2, 2.0)])
def test_white_noise_behind_a_low_pass_is_no_other_noise(order, cutoff, step):
    """It was called a damped oscillation, and N was a small part of what it is."""
    record, N = decimated(order, cutoff, step, 3)
    (channel,) = al.analyze(record).channels
    fit = channel.noise.fit
    assert channel.explained
    assert fit.scope.filter is not None
    # angle noise may fill what a row for four times the rate leaves of a filter for six
    assert {"N"} <= claimed(fit) <= {"N", "Q"}
    assert fit["N"].value == pytest.approx(N, rel=0.03)
    assert "slope" not in {finding.name for finding in channel.warnings}


@pytest.mark.slow("seconds of analyses")
def test_angle_noise_before_a_filter_is_no_other_noise():
    """It lifts what the filter lowers: a damped oscillation, or quick Gauss-Markov noise, took a quarter of N."""
    fits = [al.identify(filtered(RC, [5, seed], al.sensor("fog"))) for seed in range(4)]
    assert not any({"GM", "GM2"} & claimed(fit) for fit in fits)
    assert sum(covers(fit, al.sensor("fog")["N"]) for fit in fits) >= 3


def test_the_curve_behind_a_filter_has_less_of_the_angle_noise():
    """The model was said to hold up to an averaging time that lies below those for which it holds at all."""
    noise = noise_of(filtered(RC, 11, al.sensor("rlg")), al.Recipe())
    assert noise.validity == "explained"
    assert {"Q", "N"} <= claimed(noise.fit)
    assert noise.fit.scope.until is None


def test_a_filter_whose_corner_lies_beyond_half_the_rate_is_found_where_plain_noise_seems_to_do():
    pole = math.exp(-2 * math.pi * 0.55)
    y = 10 * np.random.default_rng(5).standard_normal(2**17)
    fit = al.identify(al.Record(lfilter([1 - pole], [1, -pole], y), RATE, "deg/s"))
    assert fit.scope.filter is not None
    assert covers(fit, al.N(1.0, "deg/sqrt(s)"))
