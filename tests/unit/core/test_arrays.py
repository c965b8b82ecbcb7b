"""Infinite samples of both signs: refused or left out, without a warning of numpy."""

import numpy as np
import pytest
from tests.rows import paired, refused, rows

import allanite as al
from allanite.core import arrays


@rows(
    "job, dtype, kind",
    paired(
        [al.analyze, al.deviation, al.dynamic, al.identify, al.spectrum, al.prepare.inspect],
        [np.float64, np.float32],
        ["rate", "angle"],
    ),
)
def test_infinite_samples_of_both_signs(job, dtype, kind):
    values = np.random.default_rng(1).standard_normal(3000).astype(dtype)
    values[[5, 9]] = np.inf, -np.inf
    record = al.Record(values, rate=100.0, unit="deg/h" if kind == "rate" else "deg", kind=kind)
    if job is al.prepare.inspect:
        assert "infinite" in str(job(record).findings[0])
        return
    refused(al.DataError, "2 of 3000 samples are infinite", lambda: job(record))


@pytest.mark.slow("takes more than half a second")
@rows("scale", [np.nan, 0.0, 1e-300, 1e200, 1e306, np.inf])
def test_a_channel_that_cannot_be_analyzed_stands_beside_one_that_can(scale, tmp_path):
    good = np.random.default_rng(1).standard_normal(3000)
    with np.errstate(invalid="ignore"):
        channels = [al.Record(y, rate=100.0, unit="deg/h", name=name) for name, y in (("a", good), ("b", scale * good))]
    study = al.analyze(al.Recording(tuple(channels)))
    assert not study.channels[0].refusal
    assert study.channels[1].refusal
    al.report(study, tmp_path / "page.html")
    assert study.channels[1].refusal.split(";")[0].split(" (")[0] in (tmp_path / "page.html").read_text("utf-8")


def test_mean_and_deviation_are_those_of_numpy():
    values = 1e5 + np.random.default_rng(1).standard_normal(1000)
    for given in (values, values.astype(np.int64), np.append(values, np.nan)):
        expected = np.nanmean(given), np.nanstd(given)
        np.testing.assert_allclose(arrays.mean_and_deviation(given), expected, rtol=1e-10)
