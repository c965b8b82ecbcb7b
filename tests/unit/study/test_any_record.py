"""Records of any values, rate, gaps and length: a result or a refusal in words.

The first records of which `benchmarks/fuzz.py` takes many more; those in which something was found; and every third,
fifth or seventh sample missing, as in logs that are merged from two rates.
"""

import numpy as np
import pytest
from tests import thinned
from tests.hostile import judged, worked
from tests.rows import refused, rows

import allanite as al
from allanite.prepare import inspect
from allanite.prepare.stillness import level
from allanite.prepare.view import View
from allanite.study.channels import open_recording


@pytest.mark.nightly("seconds of processor time for what shorter tests look at, too")
@rows("first", thinned(range(0, 200, 20), 3))
def test_each_job_has_a_result_or_refuses_in_words(first):
    outcomes = {k: judged(worked, k) for k in range(first, first + 20)}
    assert set(outcomes.values()) <= {"taken", "refused"}, outcomes
    assert "taken" in outcomes.values()


def record(values, **more):
    """A record of a gyroscope."""
    return al.Record(np.asarray(values), rate=100.0, unit="deg/s", name="a", **more)


@rows("job", [al.identify, al.analyze])
def test_a_straight_line_has_no_noise(job):
    refused(al.DataError, "straight line: there is no noise", lambda: job(record(np.arange(3000.0))))


def test_a_part_without_noise_is_not_compared_with_others():
    values = np.random.default_rng(1).standard_normal(4000)
    values[:2000] = 0.0
    values[5] = np.nan
    assert level(View(record(values))) is None
    assert level(View(record(np.arange(4000.0)))) is None
    values[2000:3000] *= 10
    assert "changes by a factor of 9" in level(View(record(values))).what


@rows("statistic", ["theobr", "theoh"])
def test_a_constant_has_no_deviation(statistic):
    curve = al.deviation(record(np.full(3001, -2.04)), statistic, noise=None)
    np.testing.assert_allclose(curve.deviation, 0, atol=1e-15)


def quantized(seed):
    """A record of white angle noise with gaps."""
    rng = np.random.default_rng(seed)
    values = np.diff(rng.standard_normal(3000), prepend=0)
    values[rng.random(3000) < 0.01] = np.nan
    return record(values)


def test_records_that_are_read_by_pieces_only_are_compared():
    first, second = quantized(1), quantized(2)
    change = next(change for change in al.compare(first, second).channels[0].changes if change.symbol == "Q")
    assert change.ratio == pytest.approx(1, abs=0.1)
    assert change.p > 0.01
    refused(al.DataError, "identical samples", lambda: al.compare(first, first))  # gaps are no difference


@pytest.mark.slow("takes more than half a second")
def test_angles_alone_between_gaps_are_no_pieces():
    angle = np.cumsum(np.random.default_rng(3).standard_cauchy(1500))
    angle[np.random.default_rng(4).random(1500) < 0.3] = np.nan
    angle[1] = np.nan
    fit = al.identify(al.Record(angle, rate=100.0, unit="rad", kind="angle", name="a"))
    assert np.isfinite(fit["N"].value or 0.0)


def test_a_plan_of_more_samples_than_can_be_counted_is_refused():
    refused(al.UsageError, "number of samples must be between 1 and 9", lambda: al.plan(al.N(0.1, "deg/sqrt(h)"), 1e15))


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


def test_of_too_few_noise_has_a_limit_and_of_many_the_dropouts_are_no_interpolation():
    fit = al.identify(dropped(500, 3))
    assert fit["N"].claimed or fit["N"].upper > SIGMA
    findings = [(finding.name, finding.remedy) for finding in inspect(dropped(30000, 3)).findings]
    assert findings == [("gaps", "")]  # no stretch of two samples is offered


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
    values, at = np.random.default_rng(6).standard_normal(3000), np.isin(np.arange(3000), [400, 1100, 2700])
    spiked, missing = (al.Record(np.where(at, other, values), 10.0, "deg/h") for other in (values + 50, np.nan))
    for how, expected in (("mark", missing), ("keep", spiked)):
        np.testing.assert_array_equal(open_recording(spiked, al.Recipe(outliers=how))[0].values, expected.values)
