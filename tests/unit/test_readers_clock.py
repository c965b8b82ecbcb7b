"""The sampling rate out of stamps: even grids, jitter, losses, clocks that drift, units that are not said."""

import numpy as np
import pytest

from allanite.errors import DataError, UsageError
from allanite.readers import read


@pytest.fixture
def stamped(tmp_path):
    def write(stamps, header="time [s]"):
        path = tmp_path / "gyro.csv"
        values = np.random.default_rng(3).integers(-9, 9, len(stamps))
        rows = (f"{stamp!r},{value}.5\n" for stamp, value in zip(np.asarray(stamps).tolist(), values, strict=True))
        path.write_text(f"{header},gx [deg/s]\n" + "".join(rows))
        return path

    return write


def test_rate_is_intervals_over_time_in_spite_of_jitter(stamped):
    jitter = np.random.default_rng(1).uniform(-0.3, 0.3, 1000)
    jitter[[0, -1]] = 0
    record = read(stamped(5.0 + (np.arange(1000) + jitter) * 0.01))["gx"]
    assert record.rate == pytest.approx(100.0, rel=1e-9)
    assert record.start == 5.0


def test_coarse_stamps_are_fine_while_they_follow_the_grid(stamped):
    record = read(stamped(np.arange(2001) * 5 // 2, "t_ms"))["gx"]
    assert record.rate == pytest.approx(400.0)


def test_a_gap_is_refused_with_place_size_and_remedy(stamped):
    stamps = np.arange(1000) * 0.01
    stamps[600:] += 0.5
    with pytest.raises(DataError) as caught:
        read(stamped(stamps))
    for words in ("not evenly spaced", "sample 599", "0.51 s, before sample 600", "--rate", "--time", "--from"):
        assert words in str(caught.value)


def test_bursts_are_refused_and_the_median_is_never_the_rate(stamped):
    bursts = (np.arange(100)[:, None] * 0.1 + np.arange(10) * 0.002).ravel()
    with pytest.raises(DataError, match="departs by"):
        read(stamped(bursts))
    recording = read(stamped(bursts), rate=100)
    assert recording["gx"].rate == 100.0
    assert any("taken as evenly spaced" in note for note in recording.notes)


def test_stamps_that_go_back(stamped):
    stamps = np.arange(1000) * 0.01
    stamps[500:] -= 3
    with pytest.raises(DataError, match="1 stamps go back in time, the first at sample 500"):
        read(stamped(stamps))


def test_stamps_of_whole_seconds(stamped):
    with pytest.raises(DataError, match="repeat"):
        read(stamped(np.arange(1000) // 5))


def test_constant_and_missing_stamps(stamped):
    with pytest.raises(DataError, match="not later than the first"):
        read(stamped(np.zeros(50)))
    stamps = np.arange(50.0)
    stamps[7] = np.nan
    with pytest.raises(DataError, match="no stamp at sample 7"):
        read(stamped(stamps))


def test_a_drifting_clock_is_no_gap(stamped):
    k = np.arange(100_000)
    recording = read(stamped((k + 3e-10 * k**2) * 0.01 + 0.001))  # 30 ppm over the record, 0.75 intervals in its middle
    assert recording["gx"].rate == pytest.approx(100.0, rel=1e-4)
    recording = read(stamped((k + 2e-9 * k**2) * 0.01))
    assert any("wanders by" in note and "ppm" in note for note in recording.notes)


def test_one_lost_sample_of_many_is_noted(stamped):
    stamps = np.delete(np.arange(1001), 500) * 0.01
    assert any("before sample 500" in note and "may be lost" in note for note in read(stamped(stamps)).notes)


@pytest.mark.parametrize(
    ("step", "unit", "rate"), [(10, "ms", 100), (5, "ms", 200), (10_000, "us", 100), (2500, "us", 400)]
)
def test_integer_stamps_without_unit(stamped, step, unit, rate):
    recording = read(stamped(np.arange(200) * step, "stamp"))
    assert recording["gx"].rate == pytest.approx(rate)
    assert any(f"taken as {unit}" in note for note in recording.notes)


@pytest.mark.parametrize("step", [1, 1000, 1_000_000, 100_000_000_000])
def test_ambiguous_integer_stamps_are_asked_for(stamped, step):
    path = stamped(np.arange(200) * step, "stamp")
    with pytest.raises(UsageError, match=r"--time 'stamp\[ms\]'"):
        read(path)
    assert read(path, time="stamp[us]")["gx"].rate == pytest.approx(1e6 / step)
    assert read(path, rate=50)["gx"].rate == 50.0


def test_fractions_without_unit_are_seconds(stamped):
    assert any("taken as seconds" in note for note in read(stamped(np.arange(200) * 0.25 + 0.1, "t")).notes)


def test_the_given_rate_wins_and_a_difference_is_noted(stamped):
    path = stamped(np.arange(200) * 0.01)
    assert not any("stamps" in note for note in read(path, rate=100.05).notes)
    assert any("100.0 Hz" in note and "200.0 Hz is used" in note for note in read(path, rate=200).notes)


def test_time_option(stamped):
    path = stamped(np.arange(200) * 0.01, "foo")
    assert read(path, time="foo")["gx"].rate == pytest.approx(100.0)
    assert read(path, time="1[ms]")["gx"].rate == pytest.approx(1e5)
    with pytest.raises(UsageError, match="no column 'bar'"):
        read(path, time="bar")
    with pytest.raises(UsageError, match="not a unit of time"):
        read(path, time="foo[kg]")
    with pytest.raises(UsageError, match="sampling rate"):
        read(stamped(np.arange(200) * 0.01), time="none")
    assert read(stamped(np.arange(200) * 0.01), time="none", rate=7)["gx"].start is None


def test_dates_with_time(tmp_path):
    path = tmp_path / "gyro.csv"
    rows = (
        f"2024-01-31 23:59:{59 + k // 100 - 60 * (k >= 100) if k < 100 else 0:02d}.{k % 100:02d},1.{k % 7}\n"
        for k in range(60)
    )
    path.write_text("time,gx [deg/s]\n" + "".join(rows))
    assert read(path)["gx"].rate == pytest.approx(100.0)


def test_nanoseconds_of_the_epoch_keep_their_digits(stamped):
    stamps = 1_700_000_000_000_000_001 + np.arange(1000) * 1_000_003
    assert read(stamped(stamps, "stamp [ns]"))["gx"].rate == pytest.approx(1e9 / 1_000_003, rel=1e-14)


def test_a_temperature_called_t_is_no_clock(tmp_path):
    path = tmp_path / "gyro.csv"
    path.write_text("gx [deg/s],T\n" + "1.5,36.0\n2.5,36.5\n" * 20)
    assert read(path, rate=10).channels == ("gx",)
    with pytest.raises(UsageError, match="sampling rate"):
        read(path)
