"""The sampling rate in the lines above the numbers."""

import numpy as np
import pytest
from tests.rows import refused, rows

from allanite.core.errors import UsageError
from allanite.readers import read
from allanite.readers.columns.preamble import statement

NOISE = np.random.default_rng(1).standard_normal((300, 2)).round(4)


GYRO, XY = "gx [deg/s],gy [deg/s]", NOISE.T.tolist()


@rows(("line", "rate"), [
    ("Sample rate: 100 Hz", 100), ("// Update Rate: 100.0Hz", 100), ("# fs = 250", 250), ("Fs: 2e2 Hz", 200),
    ("Sampling Rate [Hz],100", 100), ("Sample Rate (Hz): 100", 100), ("Sampling frequency = 1.5 kHz", 1500),
    ('"sample_rate","100"', 100), ("Sample interval: 0.01 s", 100), ("Sampling period: 10 ms", 100),
    ("ODR 200Hz, range 250dps", 200), ("Частота дискретизации: 400 Гц", 400), ("Период опроса, мс: 10", 100),
    ("采样率：100Hz", 100), ("采样间隔: 10 毫秒", 100), ("Sample Rate:\t100.00 samples/s", 100),
    ("Imu,SampleRate 10Hz", 10), ("Sample Interval,4.0e-3", 250), ("Sample Interval,Analog:1.0E-03", 1000),
    ("XInc:,2.0E-03", 500), ("Sequence,Volt,-6.0e-03,5.0e-03,", 200),
])  # fmt: skip
def test_statements(line, rate):
    said = statement(7, line)
    assert said.rate == pytest.approx(rate)
    assert said.line == 7


@rows("line", [
    "FS = 250", "fs: 250 dps", "Rate: 100 Hz", "Baud rate: 115200", "Sample rate: 0 Hz", "Sample rate: 1,000 Hz",
    "Sampling time = 0.005", "Sample rate: 2023-01-04", "Sample rate: fast", "offset = 3", "gyrofs = 3",
    "Sample rate: 1e99 Hz", "Sample rate: 100,5 Hz", "sample rate" * 100 + ": 5",
])  # fmt: skip
def test_no_statements(line):
    assert statement(1, line) is None
    assert statement(1, "Sample rate: 100,5 Hz", ",").rate == 100.5  # where the decimal sign is a comma


@rows("line", ["Sample rate: 100 Hz", "# fs = 100", "Sampling interval: 10 ms"])
def test_the_rate_of_the_preamble_without_stamps(table, line):
    recording = read(table(GYRO, *XY, above=f"Device 7\n{line}\n"))
    assert [record.rate for record in recording] == [100.0, 100.0]
    assert any("rate 100.0 Hz from line 2" in note for note in recording.notes)
    assert not recording.findings


def test_a_line_as_wide_as_the_rows_is_no_damaged_row(write):
    path = write("Sample rate: 100 Hz\n" + "\n".join(" ".join(map(str, [*row, *row])) for row in NOISE))
    assert read(path, unit="deg/s")["column 1"].rate == 100.0
    # a comment with the rate names no column
    path = write("# fs=100\n" + "\n".join(map(str, NOISE[:, 0])))
    assert read(path, unit="deg/s").channels == ("column 1",)


def test_stamps_win_and_a_contradiction_is_a_warning(table):
    time = np.arange(300)
    recording = read(table(f"time [s],{GYRO}", time / 100, *XY, above="Sample rate: 200 Hz\n"))
    assert recording["gx"].rate == pytest.approx(100)
    (warning,) = recording.findings
    assert all(word in str(warning) for word in ("100.0 Hz", "200.0 Hz", "line 1", "a factor of 2 apart"))
    nominal = read(table(f"time [s],{GYRO}", (time / 99.32).round(6), *XY, above="Sample rate: 100 Hz\n"))
    assert nominal["gx"].rate == pytest.approx(99.32, rel=1e-5)
    assert not nominal.findings
    # the option wins
    recording = read(table(GYRO, *XY, above="Sample rate: 200 Hz\n"), rate=100)
    assert (recording["gx"].rate, [finding.name for finding in recording.findings]) == (100, ["given rate"])


def test_the_unit_of_integer_stamps_follows_from_it(table):
    time = 500 * np.arange(300)
    assert read(table(f"time,{GYRO}", time, *XY, above="Sample rate: 2 Hz\n"))["gx"].rate == pytest.approx(2)
    # without it, the one of two plausible rates that a sensor has
    alone = read(table(f"time,{GYRO}", time, *XY))
    assert alone["gx"].rate == pytest.approx(2000)
    assert any("in us: in ms their rate would be 2 Hz" in note for note in alone.notes)


def test_rates_that_contradict_each_other_are_refused_by_name(table):
    words = r"contradict each other, line 1 .*100 Hz.*, line 2 .*50 Hz.*rate=100"
    path = table(GYRO, *XY, above="Sample rate: 100 Hz\nUpdate rate: 50 Hz\n")
    refused(UsageError, words, lambda: read(path))
    above = "Sample rate: 100 Hz\nODR: 50 Hz\n"
    stamped = table(f"time [s],{GYRO}", np.arange(300) / 100, *XY, above=above)
    assert any("are not used" in note for note in read(stamped).notes)
