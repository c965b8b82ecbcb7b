"""Every third, fifth or seventh sample missing, as in logs that are merged from two rates."""

import numpy as np
import pytest
from tests.rows import refused, rows

import allanite as al
from allanite.prepare import inspect
from allanite.study.channels import open_recording
from allanite.study.recipe import Recipe

SIGMA = 1.0 * np.pi / 180 / 3600 * np.sqrt(0.1)  # N of a standard deviation of 1 deg/h at 10 Hz, SI


def dropped(size, k, seed=2):
    """White noise without every k-th sample."""
    values = np.random.default_rng(seed).normal(size=size)
    values[::k] = np.nan
    return al.Record(values, 10.0, "deg/h", name="z")


@pytest.mark.nightly("seconds of processor time for what shorter tests look at, too")
@rows(("size", "k"), [(500, 5), (500, 7), (1000, 3), (1000, 5), (5000, 3), (5000, 7), (30000, 3)])
def test_white_noise_is_read_between_regular_dropouts(size, k):
    record = dropped(size, k)
    fit = al.analyze(record).channels[0].fit
    low, high = fit["N"].interval(0.999)
    assert low < SIGMA < high
    assert fit.goodness.p > 1e-3
    assert al.deviation(record).deviation[0] == pytest.approx(SIGMA * np.sqrt(10), rel=0.15)


def test_too_few_are_claimed_absent_with_a_limit():
    fit = al.identify(dropped(500, 3))
    assert fit["N"].claimed or fit["N"].upper > SIGMA


def test_dropouts_are_no_interpolation_and_offer_no_stretch_of_two_samples():
    found = {one.name: one for one in inspect(dropped(30000, 3)).findings}
    assert set(found) == {"gaps"}
    assert not found["gaps"].remedy


def test_every_second_sample_is_refused_with_a_cure_that_works():
    record = dropped(9000, 2)
    refused(al.DataError, r"record of these samples alone, at their rate: values\[::2\]", lambda: al.identify(record))
    half = al.Record(record.values[1::2], 5.0, "deg/h")
    assert al.identify(half)["N"].claimed


def test_a_log_of_two_rates_is_read_at_the_rate_of_the_channel(tmp_path):
    x = np.random.default_rng(2).normal(size=(4000, 2))
    rows = (f"{i / 100:.2f},{x[i, 0] if i % 2 else ''},{'' if i % 2 else x[i, 1]}\n" for i in range(len(x)))
    path = tmp_path / "two.csv"
    path.write_text("t [s],gz [deg/h],ax [m/s^2]\n" + "".join(rows))
    refused(al.DataError, r"read by themselves the channels|make a record of these samples", lambda: al.analyze(path))
    recording = al.read(path, channels=["gz"])
    assert (recording["gz"].rate, recording["gz"].start) == (50.0, pytest.approx(0.01))
    np.testing.assert_array_equal(recording["gz"].values, x[1::2, 0])
    assert any(note.startswith("rate 50 Hz, since only one row in 2 has samples of gz") for note in recording.notes)


@pytest.mark.slow("takes more than half a second")
@rows("seed", [11, 16])
def test_what_gaps_leave_unreadable_contradicts_nothing(seed):
    rng = np.random.default_rng(seed)
    record = al.simulate(al.Model("Q 0.5 arcsec, N 0.003 deg/sqrt(h), B 0.1 deg/h"), 2**15, 100.0, rng=rng)
    values = record.values.copy()
    for start in rng.integers(0, record.size - 20, 585):  # 30 % in bursts of 20
        values[start : start + 20] = np.nan
    channel = al.analyze(record.with_values(values, "dropouts", start=None)).channels[0]
    assert not channel.refusal
    assert channel.noise.explained


def test_outliers_that_are_to_be_marked_are_missing_for_every_job():
    values = np.random.default_rng(6).standard_normal(3000)
    at = [400, 1100, 2700]
    spiked, missing = values.copy(), values.copy()
    spiked[at] += 50.0
    missing[at] = np.nan
    for how, expected in (("mark", missing), ("keep", spiked)):
        found = open_recording(al.Record(spiked, rate=10.0, unit="deg/h"), Recipe(outliers=how))[0]
        curves = [
            al.deviation(record, "oadev", m=(1, 10), noise=None).deviation
            for record in (found, al.Record(expected, rate=10.0, unit="deg/h"))
        ]
        np.testing.assert_array_equal(*curves)
