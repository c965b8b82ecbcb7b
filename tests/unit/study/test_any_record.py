"""Records of any values, rate, gaps and length: a result or a refusal in words.

The first records of which `benchmarks/fuzz.py` takes many more; and those in which something was found.
"""

import numpy as np
import pytest
from tests import thinned
from tests.hostile import judged, worked
from tests.rows import refused, rows

import allanite as al
from allanite.prepare.stillness import level
from allanite.prepare.view import View


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
    changes = {change.symbol: change for change in al.compare(quantized(1), quantized(2)).channels[0].changes}
    assert changes["Q"].ratio == pytest.approx(1, abs=0.1)
    assert changes["Q"].p > 0.01


def test_equal_records_with_gaps_are_not_compared():
    refused(al.DataError, "identical samples", lambda: al.compare(quantized(1), quantized(1)))


@pytest.mark.slow("takes more than half a second")
def test_angles_alone_between_gaps_are_no_pieces():
    angle = np.cumsum(np.random.default_rng(3).standard_cauchy(1500))
    angle[np.random.default_rng(4).random(1500) < 0.3] = np.nan
    angle[1] = np.nan
    fit = al.identify(al.Record(angle, rate=100.0, unit="rad", kind="angle", name="a"))
    assert np.isfinite(fit["N"].value or 0.0)


def test_a_plan_of_more_samples_than_can_be_counted_is_refused():
    refused(al.UsageError, "number of samples must be between 1 and 9", lambda: al.plan(al.N(0.1, "deg/sqrt(h)"), 1e15))
