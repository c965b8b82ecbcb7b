"""Deviations of a measured spectrum against those of the record itself."""

import numpy as np
import pytest
from tests.rows import paired, refused, rows

import allanite as al

MODEL = al.Q(1.0, "arcsec") + al.N(0.05, "deg/sqrt(h)") + al.B(2.0, "deg/h") + al.K(10.0, "deg/h/sqrt(h)")
RECORDS = [al.simulate(MODEL, 2**15, 10.0, rng=np.random.default_rng(seed)) for seed in range(12)]


@rows(
    "statistic, choices",
    paired(
        ["oadev", "mdev", "tdev", "ohdev", "haar"],
        [{}, {"bins": 20}, {"sides": "two"}, {"method": "multitaper", "bins": 20}],
    ),
)
def test_it_is_the_deviation_of_the_record(statistic, choices):
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
    for one, other in (("adev", "oadev"), ("hdev", "ohdev")):
        same = [al.deviation_of_spectrum(spectrum, name).variance for name in (one, other)]
        np.testing.assert_array_equal(*same)
    flat = type(spectrum)(**{**vars(spectrum), "density": np.full_like(spectrum.density, 2.0)})
    curve = al.deviation_of_spectrum(flat, taus=[0.1, 0.4, 1.6])
    np.testing.assert_allclose(curve.variance, 1 / curve.tau, rtol=1e-3)
    np.testing.assert_allclose(al.deviation_of_spectrum(flat.to("deg/h"), taus=[0.4]).variance, 1 / 0.4, rtol=1e-3)
    refused(al.UsageError, r"theo1 has no", lambda: al.deviation_of_spectrum(spectrum, "theo1"))
    refused(al.UsageError, r"not 1000 s", lambda: al.deviation_of_spectrum(spectrum, taus=[1000.0]))
    with pytest.raises(al.UsageError, match=r"multiples of the sample interval, 0.1 s"):
        al.deviation_of_spectrum(spectrum, taus=[0.25])
    refused(al.UsageError, r"taus must be 'octave'", lambda: al.deviation_of_spectrum(spectrum, taus="log"))


def test_a_measured_angle_is_a_signal_of_its_own():
    model = al.Model("N 0.3 arcsec*sqrt(s), GM 1.2 arcsec 2 s")
    record = al.simulate(model, 2**15, 40.0, rng=np.random.default_rng(1))
    curve, direct = al.deviation_of_spectrum(al.spectrum(record)), al.deviation(record, noise=None)
    assert (record.kind, curve.unit) == ("value", direct.unit)
    np.testing.assert_allclose(curve.deviation[:6], direct.deviation[:6], rtol=0.03)
