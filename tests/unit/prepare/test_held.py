"""Loggers that are faster than their sensor, noise that comes in bursts, and samples that were interpolated."""

import numpy as np
import pytest
from tests.rows import rows

import allanite as al
from allanite.core.record import Recording
from allanite.prepare.bursts import bursts
from allanite.prepare.held import as_sensed, held
from allanite.prepare.quality import inspect
from allanite.prepare.stillness import of_one_body
from allanite.prepare.view import View

SIZE = 6000


def logged(times, jitter=0.0, step=1e-4, channels=1, seed=1):
    """White noise of a sensor, and what a logger `times` as fast writes of it."""
    rng = np.random.default_rng(seed)
    own = np.rint(rng.standard_normal((SIZE + 9, channels)) / step) * step
    asked = np.arange(int(SIZE * times)) + jitter * rng.standard_normal(int(SIZE * times))
    return own, own[np.clip(((asked + 0.4) / times).astype(int), 0, SIZE + 8)]


@rows("times, jitter, step, channels", [
    (1.1, 0.0, 1e-4, 1), (1.25, 0.1, 1e-4, 3), (1.5, 0.0, 0.7, 1), (2, 0.2, 0.01, 1), (2.5, 0.1, 0.7, 3),
    (3, 0.0, 1.5, 1), (6.3, 0.2, 0.7, 1), (20, 0.2, 1e-4, 1), (20, 0.0, 0.7, 1),
])  # fmt: skip
def test_each_sample_of_the_sensor_is_used_once(times, jitter, step, channels):
    own, samples = logged(times, jitter, step, channels)
    hold = held(list(samples.T))
    assert hold.times == pytest.approx(times, rel=0.02)
    taken = samples[hold.at, 0]
    assert abs(np.mean(taken[1:] * taken[:-1])) < 0.08
    assert taken.std() == pytest.approx(own[:, 0].std(), rel=0.02)
    if not jitter:
        assert taken[5:50] in np.lib.stride_tricks.sliding_window_view(own[:100, 0], 45)


@rows("samples", [
    np.random.default_rng(1).standard_normal(20_000),
    np.rint(np.random.default_rng(2).standard_normal(20_000) / 1.5),
    np.rint(3 * np.sin(np.arange(20_000) / 15) + 0.05 * np.random.default_rng(3).standard_normal(20_000)),
    np.rint(np.cumsum(np.random.default_rng(4).standard_normal(20_000)) * 0.1),
    np.where(np.random.default_rng(5).random(20_000) < 0.1, 0.0, np.random.default_rng(6).standard_normal(20_000)),
])  # fmt: skip
def test_other_equal_neighbours_are_not_held(samples):
    assert held([samples]) is None


def test_a_gap_stays_a_gap_of_the_same_time():
    _, samples = logged(4)
    samples[8000:12_000] = np.nan
    hold = held([samples[:, 0]])
    assert (hold.at < 0).sum() == pytest.approx(1000, abs=2)
    assert hold.at.size == pytest.approx(SIZE, abs=2)


def test_sensors_of_one_recording_have_their_own_rates():
    gyro, accel = logged(2)[1][:, 0], np.random.default_rng(8).standard_normal(2 * SIZE)
    both = as_sensed(Recording((al.Record(gyro, 200.0, "deg/s", name="gx"), al.Record(accel, 200.0, "g", name="ax"))))
    assert [record.rate for record in both] == [100.0, 200.0]
    (finding,) = both.findings
    assert (finding.name, finding.what.startswith("gx: held from 100 Hz")) == ("held", True)
    assert as_sensed(both) is both


@rows("times, level, named", [(3.0, 0.2, True), (8.0, 0.02, True), (1.0, 0.2, False)])
def test_bursts_are_named_with_what_is_left_of_the_noise(times, level, named):
    rng = np.random.default_rng(7)
    y, loud = rng.standard_normal(20_000), np.zeros(20_000, dtype=bool)
    while loud.mean() < level:
        start = int(rng.integers(0, 19_900))
        loud[start : start + 40] = True
    finding = bursts(View(al.Record(np.where(loud, times * y, y), 100.0, "deg/s")))
    assert (finding is not None) == named
    if named:
        factor = 1 / np.sqrt(1 + loud.mean() * (times**2 - 1))
        assert float(finding.consequence.split("about ")[1].split()[0]) == pytest.approx(factor, rel=0.15)


def test_an_interpolation_is_one_of_all_channels():
    rng, at = np.random.default_rng(9), np.arange(20_000) * 0.93
    records = [al.Record(np.interp(at, np.arange(20_000), rng.standard_normal(20_000)), 100.0, "deg/s") for _ in "ab"]
    records += [al.Record(rng.standard_normal(20_000), 100.0, "deg/s")]
    found = [inspect(record) for record in records]
    assert ["resampled" in quality.names for quality in found] == [True, True, False]
    for count, named in ((2, True), (3, False)):
        together = of_one_body(records[:count], found[:count])
        assert all(("resampled" in quality.names) == named for quality in together)
