"""Spectra against scipy's Welch and the models' exact ones, the truth of their intervals, and deviations of them."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy import signal
from tests import examples
from tests.rows import paired, refused, rows

import allanite as al
from allanite.core.model import term
from allanite.core.units import SIGNALS
from allanite.statistics.spectra.estimators import LARGEST_TAPERS, WINDOWS, slepian
from allanite.statistics.spectra.spectrum import METHODS

ALL = [*METHODS, al.Welch(40.0, "blackman"), al.Multitaper(2.5, 3, "equal")]


def record_of(y, rate=10.0, unit="rad/s", **options):
    return al.Record(np.asarray(y), rate=rate, unit=unit, name="z", **options)


def noise(n=4096, seed=1, **options):
    return record_of(np.random.default_rng(seed).standard_normal(n), **options)


@rows("window", WINDOWS)
@rows("length", [100, 101, 4096])
def test_welch_is_scipys(window, length):
    record = noise()
    found = al.spectrum(record, al.Welch(length / 10.0, window))
    f, expected = signal.welch(
        record.values, 10.0, window, nperseg=length, noverlap=length - length // 2, detrend="constant"
    )
    first = len(WINDOWS[window])
    np.testing.assert_allclose(found.frequency, f[first : (length + 1) // 2])
    np.testing.assert_allclose(found.density, expected[first : (length + 1) // 2], rtol=1e-7)


@rows("weights", ["equal", "eigen"])
def test_multitaper_is_its_definition(weights):
    record = noise(301)
    found = al.spectrum(record, al.Multitaper(3.0, 4, weights), sides="two")
    tapers, shares = signal.windows.dpss(301, 3.0, 4, return_ratios=True)
    parts = np.abs(np.fft.fft(tapers * (record.values - record.values.mean()))) ** 2 / 10
    expected = np.average(parts, axis=0, weights=shares if weights == "eigen" else None)
    np.testing.assert_allclose(found.density, expected[np.rint(found.frequency * 30.1).astype(int)], rtol=1e-10)


def test_long_tapers_are_the_short_ones_stretched():
    n = LARGEST_TAPERS + 34_465
    tapers, shares = slepian(n, 4.0, 7)
    direct, exact = signal.windows.dpss(n, 4.0, 7, return_ratios=True)
    np.testing.assert_allclose(np.abs((tapers * direct).sum(axis=1)), 1.0, atol=1e-12)
    np.testing.assert_allclose(tapers @ tapers.T, np.eye(7), atol=1e-8)
    np.testing.assert_allclose(shares, exact, rtol=1e-7)


@rows("method, symbol", paired(ALL, ["Q", "N", "B", "K"]))
def test_the_level_is_that_of_the_model(method, symbol):
    """Mean of 40 records within 5 standard errors at every tenth of a decade, where the resolution is fine enough."""
    unit = SIGNALS[0].si[al.terms.TERMS[symbol].power]
    model = al.Model((term(symbol, 1.0, unit),))
    spectra = [al.spectrum(al.simulate(model, 4096, 10.0, rng=seed), method, bins=10) for seed in range(1, 41)]
    ratio = np.mean([s.density for s in spectra], axis=0) / spectra[0].expected(model)
    error = np.sqrt(2 / (40 * spectra[0].dof))
    fine = spectra[0].frequency > 20 * spectra[0].resolution
    # a band of a tenth of a decade is not flat: a few per cent where the spectrum is steep
    slack = {"Q": 0.02, "N": 0.0, "B": 0.01, "K": 0.02}[symbol]
    assert np.all(np.abs(ratio - 1)[fine] < 5 * error[fine] + slack)
    assert fine.sum() > 5


def test_n_is_the_root_of_the_two_sided_density():
    model = al.N(0.1, "deg/sqrt(h)")
    record = al.simulate(model, 200_000, 100.0, rng=1)
    two = al.spectrum(record, sides="two")
    assert np.sqrt(two.density.mean()) == pytest.approx(model.value, rel=0.01)
    assert two.to("deg/h").amplitude_unit == "deg/h/sqrt(Hz)"
    assert np.sqrt(two.to("deg/h").density.mean()) == pytest.approx(model.to("deg/h/sqrt(Hz)"), rel=0.01)
    one = al.spectrum(record)
    np.testing.assert_allclose(one.density, 2 * two.density)
    np.testing.assert_allclose(one.expected(model), 2 * model.value**2)
    np.testing.assert_allclose(two.to("deg/h").expected(model), model.to("deg/h/sqrt(Hz)") ** 2)


@rows("method", ALL, ids=str)
def test_the_integral_is_the_mean_square(method):
    record = noise(50_000)
    found = al.spectrum(record, method)
    share = found.width.sum() / 5.0
    # the mean square of the part of the band that is there; its relative error is sqrt(2/n)
    assert (found.density * found.width).sum() == pytest.approx(record.values.var() * share, rel=0.01)
    binned = al.spectrum(record, method, bins=7)
    assert (binned.density * binned.width).sum() == pytest.approx((found.density * found.width).sum(), rel=1e-12)
    assert binned.width.sum() == pytest.approx(found.width.sum())


@rows("method", [m for m in ALL if not isinstance(m, str)] + list(METHODS), ids=str)
@rows("frequency", [0.731, 2.5])
def test_power_of_a_sine(method, frequency):
    amplitude, n = 3.0, 20_000
    record = record_of(amplitude * np.sin(2 * np.pi * frequency * np.arange(n) / 10.0 + 1) + 1e-3 * noise(n).values)
    found = al.spectrum(record, method)
    near = np.abs(found.frequency - frequency) < 4 * found.resolution
    assert (found.density * found.width)[near].sum() == pytest.approx(amplitude**2 / 2, rel=2e-3)
    assert found.density.max() * found.resolution == pytest.approx(amplitude**2 / 2, rel=0.3)


@rows("method, bins", paired(list(ALL), [None, 4, 20]))
def test_intervals_hold_the_truth_as_often_as_they_say(method, bins):
    """White noise, 300 records: the mean coverage of 90 % intervals, within 4 standard errors of so many records.

    Neighbouring values are dependent: the standard error is that of the records' own coverages.
    """
    held = []
    for seed in range(1, examples(300) + 1):
        low, high = al.spectrum(noise(1000, seed), method, bins=bins).interval(0.9)
        held.append(((low <= 0.2) & (high >= 0.2)).mean())
    assert abs(np.mean(held) - 0.9) < 4 * np.std(held) / np.sqrt(len(held)) + 0.006


@rows("method, bins", paired(list(ALL), [None, 5]))
@pytest.mark.slow("ensemble")
def test_the_degrees_of_freedom_are_those_of_the_scatter(method, bins):
    """2 mean^2 / variance over 1000 records; its standard error is about sqrt(2/1000) = 4.5 %, of every value."""
    density = np.array([al.spectrum(noise(600, seed), method, bins=bins).density for seed in range(1, 1001)])
    dof = al.spectrum(noise(600), method, bins=bins).dof
    found = 2 * density.mean(axis=0) ** 2 / density.var(axis=0, ddof=1)
    assert np.all(np.abs(np.log(found / dof)) < 0.3)
    assert np.mean(found / dof) == pytest.approx(1.0, abs=0.06)


@given(seed=st.integers(0, 999), scale=st.floats(1e-6, 1e6), rate=st.sampled_from([0.1, 1.0, 250.0]))
@settings(max_examples=examples(25), deadline=None)
def test_scale_rate_and_bias(seed, scale, rate):
    y = np.random.default_rng(seed).standard_normal(500)
    for method in METHODS:
        plain = al.spectrum(record_of(y, 1.0), method, bins=6)
        moved = al.spectrum(record_of(scale * (y + 3.0), rate), method, bins=6)
        np.testing.assert_allclose(moved.density * rate, plain.density * scale**2, rtol=1e-9)
        np.testing.assert_allclose(moved.frequency, plain.frequency * rate)
        np.testing.assert_allclose(moved.dof, plain.dof)


@given(n=st.integers(100, 3000), bins=st.integers(1, 60))
@settings(max_examples=examples(40), deadline=None)
def test_bins_are_whole_and_ordered(n, bins):
    for method in METHODS:
        fine, found = al.spectrum(noise(n), method), al.spectrum(noise(n), method, bins=bins)
        assert np.all(np.diff(found.frequency) > 0)
        assert found.width.sum() == pytest.approx(fine.width.sum())
        assert np.all(found.dof >= fine.dof.min() * (1 - 1e-12))
        assert np.all(found.dof <= 2.2 * n)


def test_segments_step_over_gaps():
    y = np.random.default_rng(2).standard_normal(3000)
    lost = y.copy()
    lost[1000:1100] = np.nan
    found = al.spectrum(record_of(lost), al.Welch(20.0))
    parts = [al.spectrum(record_of(part), al.Welch(20.0)) for part in (y[:1000], y[1100:])]
    # 9 segments fit before the gap and 18 behind it
    np.testing.assert_allclose(found.density, (9 * parts[0].density + 18 * parts[1].density) / 27)
    assert parts[1].dof[0] < found.dof[0] < parts[0].dof[0] + parts[1].dof[0] + 1e-9
    assert found.dof[0] == pytest.approx(parts[0].dof[0] + parts[1].dof[0], rel=0.01)


def test_kinds_are_one_record():
    counts = np.random.default_rng(3).integers(-50, 50, 3000)
    forms = [record_of(counts, unit="arcsec", kind="count", scale=0.1), record_of(counts * 1.0, unit="arcsec/s"),
             record_of(np.concatenate(([7], 7 + np.cumsum(counts))), unit="arcsec", kind="angle",
                       scale=0.1)]  # fmt: skip
    first, *others = (al.spectrum(form).density for form in forms)
    for other in others:
        np.testing.assert_allclose(other, first, rtol=1e-9)


def test_the_value_as_rows():
    found = al.spectrum(noise(), bins=8).to("deg/h")
    headings, rows = found.rows(0.9)
    assert (headings[1], headings[4]) == ("one-sided density [(deg/h)^2/Hz]", "amplitude [deg/h/sqrt(Hz)]")
    assert len(rows) == found.frequency.size
    low, high = found.interval(0.9)
    assert rows[3] == [v[3] for v in (found.frequency, found.density, low, high, found.amplitude, found.dof)]


def test_what_is_refused():
    record = noise(500)
    lost = noise(500).values.copy()
    lost[3] = np.nan
    for call, error, words in [
        (lambda: al.spectrum(record, "periodogram"), al.UsageError, "known methods: welch, multitaper"),
        (lambda: al.spectrum(record, sides="both"), al.UsageError, "'one' or 'two'"),
        (lambda: al.spectrum(record, bins=0), al.UsageError, "per decade"),
        (lambda: al.spectrum(record, bins=2.5), al.UsageError, "bins must be an integer"),
        (lambda: al.spectrum(record).interval(95), al.UsageError, "between 0 and 1"),
        (lambda: al.spectrum(record).to("m/s^2"), al.UnitError, "dimensions differ"),
        (lambda: al.Welch(window="kaiser"), al.UsageError, "known windows: boxcar"),
        (lambda: al.Welch(-1.0), al.UsageError, "between 1e-15"),
        (lambda: al.spectrum(record, al.Welch(51.0)), al.UsageError, "longest stretch"),
        (lambda: al.spectrum(record, al.Welch(0.3)), al.DataError, "too few"),
        (lambda: al.Multitaper(0.5), al.UsageError, "between 1 and 50"),
        (lambda: al.Multitaper(4.0, 9), al.UsageError, "1 to 8 tapers"),
        (lambda: al.Multitaper(weights="best"), al.UsageError, "'eigen' or 'equal'"),
        (lambda: al.spectrum(record_of(lost), "multitaper"), al.DataError, r"1 of 500 .* use method=welch"),
        (lambda: al.spectrum(record_of(np.full(300, np.nan))), al.DataError, "too few"),
    ]:
        refused(error, words, call)


MODEL = al.Q(1.0, "arcsec") + al.N(0.05, "deg/sqrt(h)") + al.B(2.0, "deg/h") + al.K(10.0, "deg/h/sqrt(h)")
RECORDS = [al.simulate(MODEL, 2**15, 10.0, rng=np.random.default_rng(seed)) for seed in range(12)]


@rows("statistic, choices", paired(["oadev", "mdev", "tdev", "ohdev", "haar"], [
    {}, {"bins": 20}, {"sides": "two"}, {"method": "multitaper", "bins": 20}]))  # fmt: skip
def test_the_deviation_of_a_spectrum_is_that_of_the_record(statistic, choices):
    """Mean ratio of the variances: 1 % at short averaging times, 5 % up to half of the longest."""
    curves = [al.deviation_of_spectrum(al.spectrum(record, **choices), statistic) for record in RECORDS]
    direct = [al.deviation(record, statistic, m=curves[0].m, noise=None) for record in RECORDS]
    assert curves[0].unit == direct[0].unit
    np.testing.assert_allclose(curves[0].tau, direct[0].tau)
    ratio = np.mean([c.variance for c in curves], axis=0) / np.mean([d.variance for d in direct], axis=0)
    assert ratio.size >= 8
    np.testing.assert_allclose(ratio[:5], 1, atol=0.01)
    np.testing.assert_allclose(ratio[:-1], 1, atol=0.06)


def test_closed_forms_and_what_a_spectrum_does_not_tell():
    spectrum = al.spectrum(RECORDS[0])
    for pair in (("adev", "oadev"), ("hdev", "ohdev")):
        np.testing.assert_array_equal(*(al.deviation_of_spectrum(spectrum, name).variance for name in pair))
    flat = type(spectrum)(**{**vars(spectrum), "density": np.full_like(spectrum.density, 2.0)})
    curve = al.deviation_of_spectrum(flat, taus=[0.1, 0.4, 1.6])
    np.testing.assert_allclose(curve.variance, 1 / curve.tau, rtol=1e-3)
    np.testing.assert_allclose(al.deviation_of_spectrum(flat.to("deg/h"), taus=[0.4]).variance, 1 / 0.4, rtol=1e-3)
    for choices, words in (
        ({"statistic": "theo1"}, "theo1 has no"), ({"taus": [1000.0]}, "not 1000 s"),
        ({"taus": [0.25]}, "multiples of the sample interval, 0.1 s"), ({"taus": "log"}, "taus must be 'octave'"),
    ):  # fmt: skip
        refused(al.UsageError, words, lambda choices=choices: al.deviation_of_spectrum(spectrum, **choices))


def test_a_measured_angle_is_a_signal_of_its_own():
    model = al.Model("N 0.3 arcsec*sqrt(s), GM 1.2 arcsec 2 s")
    record = al.simulate(model, 2**15, 40.0, rng=np.random.default_rng(1))
    curve, direct = al.deviation_of_spectrum(al.spectrum(record)), al.deviation(record, noise=None)
    assert (record.kind, curve.unit) == ("value", direct.unit)
    np.testing.assert_allclose(curve.deviation[:6], direct.deviation[:6], rtol=0.03)
