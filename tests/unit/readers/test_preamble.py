"""The sampling rate in the lines above the numbers."""

import numpy as np
import pytest
from tests.rows import rows

from allanite.core.errors import UsageError
from allanite.readers import read
from allanite.readers.columns.preamble import statement

NOISE = np.random.default_rng(1).standard_normal((300, 2)).round(4)


@pytest.fixture
def write(tmp_path):
    def write(above, header="gx [deg/s],gy [deg/s]", stamps=None):
        rows = [",".join(map(str, row)) for row in NOISE]
        rows = rows if stamps is None else [f"{stamps(i)},{row}" for i, row in enumerate(rows)]
        path = tmp_path / "gyro.csv"
        path.write_text("\n".join([*above, header, *rows, ""]))
        return path

    return write


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
    "Sample rate: 1e99 Hz", "sample rate" * 100 + ": 5",
])  # fmt: skip
def test_no_statements(line):
    assert statement(1, line) is None


def test_decimal_commas():
    assert statement(1, "Sample rate: 100,5 Hz", ",").rate == 100.5
    assert statement(1, "Sample rate: 100,5 Hz") is None


@rows("line", ["Sample rate: 100 Hz", "# fs = 100", "Sampling interval: 10 ms"])
def test_the_rate_of_the_preamble_without_stamps(write, line):
    recording = read(write(["Device 7", line]))
    assert [record.rate for record in recording] == [100.0, 100.0]
    assert any("rate 100.0 Hz from line 2" in note for note in recording.notes)
    assert not recording.findings


def test_a_line_as_wide_as_the_rows_is_no_damaged_row(tmp_path):
    path = tmp_path / "gyro.txt"
    path.write_text("Sample rate: 100 Hz\n" + "\n".join(" ".join(map(str, [*row, *row])) for row in NOISE))
    assert read(path, unit="deg/s")["column 1"].rate == 100.0
    # a comment with the rate names no column
    path = tmp_path / "gyro.txt"
    path.write_text("# fs=100\n" + "\n".join(map(str, NOISE[:, 0])))
    assert read(path, unit="deg/s").channels == ("column 1",)


def test_stamps_win_and_a_contradiction_is_a_warning(write):
    header = "time [s],gx [deg/s],gy [deg/s]"
    recording = read(write(["Sample rate: 200 Hz"], header, lambda i: i / 100))
    assert recording["gx"].rate == pytest.approx(100)
    (warning,) = recording.findings
    assert all(word in str(warning) for word in ("100.0 Hz", "200.0 Hz", "line 1", "a factor of 2 apart"))
    nominal = read(write(["Sample rate: 100 Hz"], header, lambda i: round(i / 99.32, 6)))
    assert nominal["gx"].rate == pytest.approx(99.32, rel=1e-5)
    assert not nominal.findings


def test_the_option_wins(write):
    recording = read(write(["Sample rate: 200 Hz"]), rate=100)
    assert recording["gx"].rate == 100
    (warning,) = recording.findings
    assert warning.name == "given rate"


def test_the_unit_of_integer_stamps_follows_from_it(write):
    header = "time,gx [deg/s],gy [deg/s]"
    stamps = write(["Sample rate: 2 Hz"], header, lambda i: 500 * i)
    assert read(stamps)["gx"].rate == pytest.approx(2)
    # without it, the one of two plausible rates that a sensor has
    alone = read(write([], header, lambda i: 500 * i))
    assert alone["gx"].rate == pytest.approx(2000)
    assert any("in us: in ms their rate would be 2 Hz" in note for note in alone.notes)


def test_rates_that_contradict_each_other_are_refused_by_name(write):
    with pytest.raises(UsageError, match=r"contradict each other, line 1 .*100 Hz.*, line 2 .*50 Hz.*rate=100"):
        read(write(["Sample rate: 100 Hz", "Update rate: 50 Hz"]))
    stamped = write(["Sample rate: 100 Hz", "ODR: 50 Hz"], "time [s],gx [deg/s],gy [deg/s]", lambda i: i / 100)
    assert any("are not used" in note for note in read(stamped).notes)
