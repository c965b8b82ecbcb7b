"""Record to record: what each step does, and that its history says so."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, lfilter
from tests.rows import paired, refused, rows
from tests.unit.identification.records import forms_of

import allanite as al
from allanite.prepare import block_means, decimate, detrend, inspect, quiet_window
from allanite.prepare.readings import clipping
from allanite.prepare.resampled import filled
from allanite.prepare.stillness import lines
from allanite.prepare.view import View
from allanite.simulation.record import RING_LASERS, simulate_ring_laser


def finding_of(name, record):
    (finding,) = (finding for finding in inspect(record).findings if finding.name == name)
    return finding


@rows("m, kind", paired([1, 2, 7, 50], ["rate", "increment", "count", "angle"]))
def test_block_means_keep_the_curve(m, kind):
    whole = forms_of(np.random.default_rng(1).integers(-50, 50, 10_003), 0.1)[kind]
    blocks = block_means(whole, m)
    same = whole.with_values(whole.values[: 10_003 // m * m + (kind == "angle")], "cut")
    assert (blocks.rate, blocks.size) == (pytest.approx(100.0 / m), 10_003 // m)
    found = al.deviation(blocks, "adev", m=[1, 2, 5]).variance
    np.testing.assert_allclose(found, al.deviation(same, "adev", m=[m, 2 * m, 5 * m]).variance, rtol=1e-9)
    assert f"blocks of {m} samples" in blocks.history[-1]
    assert ("omitted" in blocks.history[-1]) == (10_003 % m > 0)
    for wrong in (0, 5002):
        refused(al.UsageError, "from 1 to 5001", lambda wrong=wrong: block_means(whole, wrong))


def test_decimation_keeps_what_is_slow_and_stops_what_would_fold():
    t = np.arange(100_000) / 1000.0
    for frequency, kept in ((1.0, 1.0), (30.0, 1.0), (72.0, 0.0), (130.0, 0.0), (391.0, 0.0)):
        line = al.Record(np.sin(2 * np.pi * frequency * t) + 1e4, 1000.0, "deg/s")
        small = decimate(line, 10)
        assert small.rate == 100.0
        assert np.std(small.values) * 2**0.5 == pytest.approx(kept, abs=2e-3)
        assert small.values.mean() == pytest.approx(1e4, abs=1e-2)
        assert "low-pass filtered at 40 Hz" in small.history[-1]
        assert small.start > 0
    refused(al.UsageError, "between 2 and", lambda: decimate(line, 1))
    refused(al.UsageError, "block_means", lambda: decimate(al.Record(np.arange(1000.0), 1.0, "deg", kind="angle"), 2))


@rows("statistic", al.statistics.STATISTICS)
def test_a_ramp_is_removed_for_a_statistic_that_does_not_see_it(statistic):
    ramp = al.Record(np.arange(5000.0), 100.0, "deg/h")
    if al.statistics.STATISTICS[statistic].order < 3:
        refused(al.UsageError, "is sensitive to a ramp", lambda: detrend(ramp, statistic))
    else:
        np.testing.assert_allclose(np.diff(detrend(ramp, statistic).values), 0.0, atol=1e-9)


@rows("kind", ["rate", "increment", "count", "angle"])
def test_a_ramp_is_removed_from_records_of_every_kind_and_with_gaps(kind):
    """A record with a gap was lost whole, and of an angle the mean rate was removed instead of the ramp."""
    record = forms_of(np.random.default_rng(1).integers(-50, 50, 5000) + np.arange(5000) // 10, 0.1)[kind]
    if kind != "count":
        lost = np.isin(np.arange(record.values.size), range(900, 1500))
        record = record.with_values(np.where(lost, np.nan, record.values), "a gap")
    less = detrend(record, "hdev")
    assert less.kind == ("increment" if kind == "count" else kind)
    rates, before = (np.diff(r.values) if kind == "angle" else r.values * (r.scale or 1.0) for r in (less, record))
    known, at = np.isfinite(before), np.arange(5000)
    assert np.isfinite(rates).tolist() == known.tolist()
    slope = np.polyfit(at[known], before[known], 1)[0]
    np.testing.assert_allclose(np.diff(rates), np.diff(before) - slope, rtol=1e-9, atol=1e-9)
    assert float(less.history[-1].split()[2]) == pytest.approx(slope * record.rate, rel=1e-5)  # in the unit
    refused(al.DataError, "at least 2 are needed", lambda: detrend(less.with_values(np.nan * less.values, ""), "hdev"))


def test_the_quiet_window_is_the_quiet_one():
    rng = np.random.default_rng(1)
    y = rng.standard_normal((2, 60_000))
    y[0, :30_000] *= 3
    y[1, 45_000:] += 20 * np.sin(np.arange(15_000) / 40)
    both = al.Recording((al.Record(y[0], 100.0, "deg/h", name="x"), al.Record(y[1], 100.0, "deg/h", name="y")))
    window = quiet_window(both, 120.0)
    start = window["x"].start
    assert start >= 300
    assert start + 120 <= 450
    assert window["x"].duration == window["y"].duration == 120.0
    assert "cut from" in window["x"].history[-1]
    for length in (601.0, 0.0):
        refused(al.UsageError, "does not fit", lambda length=length: quiet_window(both, length))


def test_small_steps_of_the_mean_are_motion():
    """Where blocks differ by more than their noise it is not as quiet as where there is a little more of that."""
    y = 0.01 * np.tile([-1.0, 1.0], 30_000)
    y[:30_000] += 0.015 * (np.arange(30_000) // 100 % 2)
    y[30_000:] *= 1.1
    window = quiet_window(al.Recording((al.Record(y, 100.0, "deg/s", name="x"),)), 120.0)
    assert window["x"].start >= 299


def test_fast_noise_is_the_white_part():
    y = np.random.default_rng(1).standard_normal(50_000)
    for bias, scale in ((0.0, 1.0), (1e6, 1.0), (5.0, 1e-3)):
        view = View(al.Record(scale * y + bias + 0.01 * scale * np.arange(50_000), 100.0, "deg/s"))
        assert view.fast == pytest.approx(scale, rel=0.02)


def test_a_gap_names_the_longest_whole_stretch():
    y = np.random.default_rng(1).standard_normal(10_000)
    y[[100, 8000, 8001]] = np.nan
    gaps = finding_of("gaps", al.Record(y, 100.0, "rad/s"))
    assert "prepare.trim(recording, 1.01, 80)" in gaps.remedy
    assert gaps.what == "3 of 10000 samples are missing (0.03 %), in 2 gaps, the first from 1 s"


@rows("name", ["gl1", "gl1-smooth"])
def test_a_healthy_ring_laser_raises_no_alarm_and_sway_of_many_pulses_does(name):
    """The residual of the dither, the frequency of the pulses and their pattern are within a pulse."""
    record = simulate_ring_laser(RING_LASERS[name], 12.4392, 400 * 900, 400.0, rng=np.random.default_rng(1))
    assert inspect(record).names == ()
    sway = np.rint(5 * np.sin(2 * np.pi * 3.0 * np.arange(400 * 900 + 1) / 400))
    lines = finding_of("lines", replace(record, values=record.values + np.diff(sway).astype(np.int64)))
    assert lines.what.startswith("spectral lines at 3")


def test_a_loud_part_makes_no_lines():
    y = np.random.default_rng(1).standard_normal(60_000)
    y[45_000:55_000] *= 7
    names = inspect(al.Record(y, 100.0, "deg/s")).names
    assert ("level" in names, "lines" in names) == (True, False)


@rows("taps", [butter(2, 1 / 3), butter(2, 1 / 2), (np.full(4, 0.25), [1.0])])
def test_the_stop_band_of_a_filter_has_no_lines(taps):
    """They were reported in 25 to 87 % of records: the median of an octave is a small part of the power within it."""
    records = (lfilter(*taps, np.random.default_rng(i).standard_normal(16_484))[100:] for i in range(20))
    assert sum(lines(View(al.Record(y, 100.0, "deg/s"))) is not None for y in records) <= 1


@rows(("low", "high"), [(-1.5, 1.5), (-np.inf, 1.0)])
def test_clipping_says_what_is_left_of_n(low, high):
    y = np.random.default_rng(1).standard_normal(2**16)
    clip = al.Record(np.clip(y, low, high), 100.0, "deg/h")
    found = clipping(View(clip))
    assert found.factor == pytest.approx(np.std(clip.values), rel=0.01)
    (finding,) = inspect(clip).findings
    assert finding.name == "clipped"
    assert f"N is {found.factor:.2g} times that of the sensor if the noise is white" in finding.consequence


def test_a_drift_that_leaves_the_range_has_no_factor():
    y = np.random.default_rng(1).standard_normal(2**14) + np.linspace(0, 50, 2**14)
    finding = finding_of("clipped", al.Record(np.minimum(y, 40), 100.0, "deg/h"))
    assert "times that of the sensor" not in finding.consequence


@rows("how", ["repeated", "interpolated"])
def test_samples_that_the_logger_has_filled_in_are_named(how):
    rng, n = np.random.default_rng(1), 2**15
    y = rng.standard_normal(n)
    lost = np.flatnonzero(rng.random(n) < 0.05)[1:-1]
    kept = np.delete(np.arange(n), lost)
    where = np.searchsorted(kept, lost) - 1
    y[lost] = y[kept[where]] if how == "repeated" else np.interp(lost, kept, y[kept])
    record = al.Record(y, 100.0, "deg/h")
    assert "N is too large by about" in finding_of("filled in", record).consequence
    assert filled(View(record)) == pytest.approx((0.05, 0.0) if how == "repeated" else (0.0, 0.05), abs=0.004)


@rows("n, missing", [(65, 0), (1003, 0), (1003, 40), (100_001, 0), (100_001, 70)])
def test_what_is_looked_at_part_by_part_is_that_of_all_samples(n, missing):
    rng = np.random.default_rng(n)
    y = np.round(rng.standard_normal(n), 1) + 5
    y[[5, 6, n // 2]] += 60.0
    y[rng.choice(n - 20, missing, replace=False) + 10] = np.nan
    view = View(al.Record(y, 2048.0, "deg/h"))
    left = y[np.isfinite(y)]
    bends = np.diff(left, 2)
    bends[[i for j in view.joints for i in (j - 2, j - 1)]] = 0.0
    np.testing.assert_allclose(view.bends(0, view.bent), bends, atol=1e-12)
    bends[[i for at in view.outlying for i in (at - 2, at - 1, at)]] = np.nan
    squares = np.square(bends[: len(bends) // 8 * 8])
    np.testing.assert_allclose(view.levels, np.nanmean(squares.reshape(8, -1), axis=1), rtol=1e-12)
    np.testing.assert_allclose(view.sweep.eights, np.nansum(squares.reshape(-1, 8), axis=1), rtol=1e-12)
    blocks = left[: left.size // view.span * view.span].reshape(-1, view.span)
    np.testing.assert_allclose(view.blocks, [blocks.mean(axis=1), blocks.std(axis=1)], rtol=1e-12)
    assert view.limited == [np.sum(left == left.min()), np.sum(left == left.max())]


@rows("step", [0.0, 0.01, 0.3, 1.0])
def test_rounded_samples_are_not_filled_in(step):
    y = np.random.default_rng(2).standard_normal(2**14)
    record = al.Record(np.rint(y / step) * step if step else y, 100.0, "deg/h")
    assert "filled in" not in inspect(record).names
