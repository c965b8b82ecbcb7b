"""Limits of curves with gaps: runs between gaps are grouped by the windows that they hold."""

import numpy as np
import pytest
from tests import thinned
from tests.rows import paired, rows

import allanite as al
from allanite.statistics.moments.moments import DISTINCT, grouped
from allanite.statistics.table import STATISTICS

MODEL = al.N(1, "deg/sqrt(h)") + al.B(3, "deg/h")


def with_losses(seed, share, size=4096):
    rng = np.random.default_rng(seed)
    record = al.simulate(MODEL, size, 1.0, rng=rng)
    y = np.array(record.values)
    y[rng.random(size) < share] = np.nan
    return al.Record(y, rate=1.0, unit=record.unit, kind="rate")


@pytest.mark.slow("takes more than half a second")
@rows("share", thinned([0.01, 0.05, 0.2], 1))
def test_every_point_that_has_a_window_has_limits(share):
    for seed in range(6):
        record = with_losses(seed, share)
        for statistic in ("oadev", "ohdev"):
            curve = al.deviation(record, statistic, taus="octave", noise=MODEL)
            low, high = curve.interval()
            assert (low > 0).all()
            assert np.isfinite(high).all()
            assert (curve.edf <= curve.count * 1.001).all()


def windows(runs, row, m):
    return sum(int(row.count(size, np.array([m]))[0]) * times for size, times in runs)


@rows("name, m", paired(["oadev", "adev", "mdev", "theo1"], [2, 16, 48]))
def test_grouping_keeps_the_windows(name, m):
    row = STATISTICS[name]
    rng = np.random.default_rng(m)
    few = [(int(n), 1) for n in rng.integers(1, 120, 25)]
    assert windows(grouped(few, row, m), row, m) == windows(few, row, m)
    many = [(int(n), 1) for n in rng.integers(1, 3000, 3000)]
    found = grouped(many, row, m)
    assert len(found) <= DISTINCT
    assert windows(found, row, m) == pytest.approx(windows(many, row, m), rel=0.03)
    assert all(windows([run], row, m) for run in found)


def test_a_run_that_holds_no_window_adds_nothing():
    row = STATISTICS["oadev"]
    assert grouped([(100, 3), (7, 50)], row, 16) == [(100, 3)]
