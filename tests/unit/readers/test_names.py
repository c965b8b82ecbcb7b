"""Names of columns: those that define a unit, those that are never a sensor, and clocks in two columns."""

import numpy as np
import pytest
from tests.rows import refused, rows

from allanite.core.errors import UsageError
from allanite.readers import read
from allanite.readers.columns import headers

NOISE = np.random.default_rng(1).standard_normal((300, 8)).round(4)
EPOCH = 1_700_000_000


def axes(stem, mark="."):
    return [f"{stem}{mark}{axis}" for axis in "xyz"]


GX, *_ = SIX = NOISE.T[:6].tolist()
TIME = [i / 100 for i in range(300)]
IMU = [*axes("angular_velocity"), *axes("linear_acceleration")]
KNOWN = {
    "sensor_msgs": IMU,
    "rostopic": [f"field.{name}" for name in IMU],
    "plot": [f"/imu/data/{name.replace('.', '/')}" for name in IMU],
    "underscores": [name.replace(".", "_") for name in IMU],
    "px4": [f"{name}[{i}]" for name in ("gyro_rad", "accelerometer_m_s2") for i in range(3)],
    "euroc": [*axes("w_RS_S", "_"), *axes("a_RS_S", "_")],
    "euroc with units": [f"w_RS_S_{a} [rad s^-1]" for a in "xyz"] + [f"a_RS_S_{a} [m s^-2]" for a in "xyz"],
    "phyphox": [f"Gyroscope {a} (rad/s)" for a in "xyz"] + [f"Linear Acceleration {a} (m/s^2)" for a in "xyz"],
}


@rows("names", KNOWN.values(), ids=[*KNOWN])
def test_known_names(table, names):
    recording = read(table(["time [s]", *names], TIME, *SIX))
    assert [record.signal.name for record in recording] == ["gyro"] * 3 + ["accelerometer"] * 3
    assert {record.kind for record in recording} == {"rate"}
    assert np.array_equal(recording[0].rate_values, NOISE[:, 0])
    assert any(names[0] in note and "unit rad" in note for note in recording.notes)


def test_underscores_alone_define_no_unit(table):
    path = table(["time [s]", *axes("angular_velocity", "_")], TIME, *SIX[:3])
    refused(UsageError, "the unit is unknown", lambda: read(path))
    # the length of a vector is no axis
    names = ["time [s]", "Gyroscope x (rad/s)", "Absolute (rad/s)", "Absolute acceleration (m/s^2)"]
    assert read(table(names, TIME, *SIX[:3])).channels == ("Gyroscope x",)
    # a unit against a known name is a warning
    recording = read(table(["time [s]", *IMU], TIME, *SIX), unit="gyro=deg/s")
    assert recording[0].unit == "deg/s"
    (warning,) = recording.findings
    assert all(word in str(warning) for word in ("deg/s", "rad/s", "angular_velocity.x"))


IDENTIFIERS = [
    "frame_id", "header.frame_id", "header.seq", "sequence", "device_id", "gyro_device_id", "accel_device_id",
    "deviceId", "gyro_integral_dt", "accelerometer_integral_dt", "delta_angle_dt", "delta_velocity_dt",
    "accelerometer_clipping", "delta_velocity_clipping", "accel_clip_count", "clip_counter[0]", "error_count",
    "gyro_calibration_count", "gyro_status", "accel_flags", "gyro_temp", "acc_temperature",
    "angular_velocity_covariance_0", "orientation.x", "accelerometer_timestamp_relative",
]  # fmt: skip


@rows("name", IDENTIFIERS)
def test_identifiers_are_never_taken_for_a_sensor(table, name):
    assert headers.sensor_by_name(name) == "" or headers.is_other(name)
    numbers = np.random.default_rng(1).integers(0, 9, 300)
    for sensor, unit in (("gx", "rad/s"), ("ax", "m/s^2"), ("gx", {"gx": "rad/s"})):
        recording = read(table(["time [s]", sensor, name], TIME, GX, numbers), unit=unit)
        assert len(recording) == 1
        assert any("left out" in note and name in note for note in recording.notes)


@rows("name", ["gx", "gyro_x", "gyro_counts_x", "gx_count", "acc_calibrated_x", "gyroRateX"])
def test_signals_are_no_identifiers(name):
    assert not headers.identifies(name)
    assert not headers.is_other(name)


SECONDS = [EPOCH + (990 + 10 * i) // 1000 for i in range(300)]
NANO = [(990 + 10 * i) % 1000 * 1_000_000 for i in range(300)]
PAIR = ("sec", "nsec", "gx [rad/s]")


@rows("seconds, parts", [
    ("header.stamp.sec", "header.stamp.nanosec"), ("header.stamp.secs", "header.stamp.nsecs"), ("sec", "nsec"),
    ("stamp.sec", "stamp.nanosec"), ("secs", "nsecs"), ("/imu/header/stamp/sec", "/imu/header/stamp/nanosec"),
    ("header_stamp_sec", "header_stamp_nanosec"), ("field.header.stamp.secs", "field.header.stamp.nsecs"),
    ("Seconds", "Nanoseconds"),
])  # fmt: skip
def test_seconds_and_nanoseconds_are_one_clock(table, seconds, parts):
    recording = read(table([seconds, parts, "gx [rad/s]"], SECONDS, NANO, GX))
    assert (recording.channels, recording["gx"].rate) == (("gx",), pytest.approx(100, rel=1e-12))
    assert recording["gx"].start == pytest.approx(EPOCH + 0.99, abs=1e-6)
    assert not recording.findings
    assert any(seconds in note and parts in note and "joined" in note for note in recording.notes)


def test_no_digit_is_lost(table):
    jitter = np.random.default_rng(2).integers(0, 100, 300)
    stamps = EPOCH * 10**9 + 999_999_000 + np.arange(300) * 1000 + jitter
    path = table(PAIR, stamps // 10**9, stamps % 10**9, GX)
    rate = 299e9 / int(stamps[-1] - stamps[0])
    assert read(path)["gx"].rate == pytest.approx(rate, rel=1e-13)  # 1 MHz: a float64 resolves 2e-7 s of the epoch
    # microseconds
    path = table(["tv_sec", "tv_usec", "gx [rad/s]"], SECONDS, [n // 1000 for n in NANO], GX)
    assert read(path)["gx"].rate == pytest.approx(100)
    # what is not a part of a second is not joined
    whole = [i * 10_000_000 for i in range(300)]
    recording = read(table(PAIR, [n // 10**9 for n in whole], whole, GX))
    assert recording["gx"].rate == pytest.approx(100)
    assert any("not joined" in note for note in recording.notes)
    # a part that the user names stays alone
    path = table(PAIR, SECONDS, NANO, GX)
    assert any("resolution of 1 s" in str(finding) for finding in read(path, time="sec").findings)
    assert not any("joined" in note for note in read(path, time="none", rate=100).notes if "not" in note)
    # seconds with fractions are a clock of their own
    recording = read(table(["time_s", "time_ns", "gx [rad/s]"], TIME, [5] * 300, GX))
    assert recording["gx"].rate == pytest.approx(100)
    assert not any("joined" in note for note in recording.notes)
