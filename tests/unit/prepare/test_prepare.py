"""Record to record: what each step does, and that its history says so."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, lfilter
from tests.rows import refused, rows

import allanite as al
from allanite.core.arrays import stretches
from allanite.prepare import block_means, decimate, detrend, inspect, mark_outliers, quiet_window
from allanite.prepare.readings import clipping
from allanite.prepare.resampled import filled
from allanite.prepare.stillness import lines
from allanite.prepare.view import View
from allanite.simulation.record import RING_LASERS, simulate_ring_laser

MODEL = al.N(3.0, "deg/h/sqrt(Hz)") + al.B(2.0, "deg/h")


def record(n=20_000, seed=1, **options):
    return al.simulate(MODEL, n, 100.0, rng=np.random.default_rng(seed), **options)


@rows("m", [1, 2, 7, 50])
@rows("kind", ["rate", "count", "angle"])
def test_block_means_keep_the_curve(m, kind):
    counts = np.random.default_rng(1).integers(-50, 50, 10_003)
    forms = {
        "rate": al.Record(counts * 1.0, 100.0, "deg/h"),
        "count": al.Record(counts, 100.0, "arcsec", kind="count", scale=0.1),
        "angle": al.Record(np.concatenate(([0], np.cumsum(counts))) * 0.1, 100.0, "arcsec", kind="angle"),
    }
    whole = forms[kind]
    blocks = block_means(whole, m)
    used = 10_003 // m * m
    extra = 1 if kind == "angle" else 0
    same = whole.with_values(whole.values[: used + extra], "cut")
    assert blocks.rate == pytest.approx(100.0 / m)
    assert blocks.size == 10_003 // m
    found = al.deviation(blocks, "adev", m=[1, 2, 5]).variance
    np.testing.assert_allclose(found, al.deviation(same, "adev", m=[m, 2 * m, 5 * m]).variance, rtol=1e-9)
    assert f"blocks of {m} samples" in blocks.history[-1]
    assert ("omitted" in blocks.history[-1]) == (10_003 % m > 0)


def test_block_means_refuse_what_is_no_block():
    for m in (0, 10_001):
        with pytest.raises(al.UsageError, match="from 1 to"):
            block_means(record(), m)


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


@rows("statistic", list(al.statistics.STATISTICS))
def test_a_ramp_is_not_removed_for_a_statistic_that_sees_it(statistic):
    if al.statistics.STATISTICS[statistic].order < 3:
        refused(al.UsageError, "is sensitive to a ramp", lambda: detrend(record(), statistic))


def test_outliers_are_marked_not_replaced():
    plain = record()
    sigma = np.std(np.diff(plain.values, 2)) / 6**0.5
    at = [50, 7000, 7001, 15_000]
    y = plain.values.copy()
    y[at] += 40 * sigma * np.array([1, 1, -1, -1])
    marked = mark_outliers(al.Record(y, 100.0, "rad/s", name="z"))
    found = np.flatnonzero(np.isnan(marked.values)).tolist()
    assert found == at
    assert marked.history[-1].startswith("4 outliers beyond 5.5 standard deviations, the first at 0.5 s")
    assert "gaps" in inspect(marked).names
    np.testing.assert_array_equal(np.delete(marked.values, found), np.delete(y, found))
    assert mark_outliers(plain) is plain


def test_marking_counts_keeps_their_size():
    counts = np.random.default_rng(1).integers(-5, 6, 5000)
    counts[100] = 900
    raw = al.Record(counts, 100.0, "arcsec", kind="count", scale=0.1)
    marked = mark_outliers(raw)
    assert marked.kind == "increment"
    good = np.isfinite(marked.values)
    np.testing.assert_allclose(marked.rate_values[good], raw.rate_values[good])


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
        with pytest.raises(al.UsageError, match="does not fit"):
            quiet_window(both, length)


def test_small_steps_of_the_mean_are_motion():
    """Where blocks differ by more than their noise it is not as quiet as where there is a little more of that."""
    y = 0.01 * np.tile([-1.0, 1.0], 30_000)
    y[:30_000] += 0.015 * (np.arange(30_000) // 100 % 2)
    y[30_000:] *= 1.1
    window = quiet_window(al.Recording((al.Record(y, 100.0, "deg/s", name="x"),)), 120.0)
    assert window["x"].start >= 299


def test_runs_of_true():
    mask = np.array([True, True, False, True, False, False, True])
    assert (stretches(mask).tolist(), stretches(np.zeros(3, dtype=bool)).shape) == ([[0, 2], [3, 4], [6, 7]], (0, 2))


def test_fast_noise_is_the_white_part():
    y = np.random.default_rng(1).standard_normal(50_000)
    for bias, scale in ((0.0, 1.0), (1e6, 1.0), (5.0, 1e-3)):
        view = View(al.Record(scale * y + bias + 0.01 * scale * np.arange(50_000), 100.0, "deg/s"))
        assert view.fast == pytest.approx(scale, rel=0.02)


def test_a_gap_names_the_longest_whole_stretch():
    y = record(10_000).values.copy()
    y[[100, 8000, 8001]] = np.nan
    quality = inspect(al.Record(y, 100.0, "rad/s"))
    assert quality.refusal == ""
    gaps = next(str(finding) for finding in quality.findings if finding.name == "gaps")
    assert "prepare.trim(recording, 1.01, 80)" in gaps
    assert "3 of 10000 samples are missing (0.03 %), in 2 gaps, the first from 1 s" in gaps


@rows("name", ["gl1", "gl1-smooth"])
def test_a_healthy_ring_laser_raises_no_alarm(name):
    """The residual of the dither, the frequency of the pulses and their pattern are within a pulse."""
    gyro = RING_LASERS[name]
    record = simulate_ring_laser(gyro, 12.4392, 400 * 900, 400.0, rng=np.random.default_rng(1))
    assert inspect(record).names == ()


def test_sway_of_many_pulses_is_still_found():
    gyro, t = RING_LASERS["gl1"], np.arange(400 * 900 + 1) / 400
    record = simulate_ring_laser(gyro, 12.4392, 400 * 900, 400.0, rng=np.random.default_rng(1))
    sway = np.diff(np.rint(5 * np.sin(2 * np.pi * 3.0 * t))).astype(np.int64)
    found = {one.name: one for one in inspect(replace(record, values=record.values + sway)).findings}
    assert found["lines"].what.startswith("spectral lines at 3")


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
    (finding,) = (
        one for one in inspect(al.Record(np.minimum(y, 40), 100.0, "deg/h")).findings if one.name == "clipped"
    )
    assert "times that of the sensor" not in finding.consequence


@rows("how", ["repeated", "interpolated"])
def test_samples_that_the_logger_has_filled_in_are_named(how):
    rng, n = np.random.default_rng(1), 2**15
    y = rng.standard_normal(n)
    lost = np.flatnonzero(rng.random(n) < 0.05)[1:-1]
    kept = np.delete(np.arange(n), lost)
    where = np.searchsorted(kept, lost) - 1
    y[lost] = y[kept[where]] if how == "repeated" else np.interp(lost, kept, y[kept])
    (finding,) = (one for one in inspect(al.Record(y, 100.0, "deg/h")).findings if one.name == "filled in")
    assert "N is too large by about" in finding.consequence
    assert filled(View(al.Record(y, 100.0, "deg/h"))) == pytest.approx(
        (0.05, 0.0) if how == "repeated" else (0.0, 0.05), abs=0.004
    )


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
