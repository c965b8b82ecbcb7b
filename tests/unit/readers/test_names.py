"""Names of columns: those that define a unit, those that are never a sensor, and clocks in two columns."""

import numpy as np
import pytest
from tests.rows import rows

from allanite.core.errors import UsageError
from allanite.readers import read
from allanite.readers.columns import headers

NOISE = np.random.default_rng(1).standard_normal((300, 8)).round(4)
EPOCH = 1_700_000_000


@pytest.fixture
def write(tmp_path):
    def write(names, columns):
        path = tmp_path / "imu.csv"
        rows = zip(*(column(range(300)) if callable(column) else column for column in columns), strict=True)
        path.write_text(",".join(names) + "\n" + "\n".join(",".join(map(str, row)) for row in rows) + "\n")
        return path

    return write


def vector(first, count=3):
    return [NOISE[:, i].tolist() for i in range(first, first + count)]


def constant(value):
    return [value] * 300


def axes(stem, mark=".", last="xyz"):
    return [f"{stem}{mark}{axis}" for axis in last]


CLOCK = ("time [s]", [i / 100 for i in range(300)])
IMU = [*axes("angular_velocity"), *axes("linear_acceleration")]
KNOWN = {
    "sensor_msgs": IMU,
    "rostopic": [f"field.{name}" for name in IMU],
    "plot": [f"/imu/data/{name.replace('.', '/')}" for name in IMU],
    "underscores": [name.replace(".", "_") for name in IMU],
    "px4": [f"{name}[{i}]" for name in ("gyro_rad", "accelerometer_m_s2") for i in range(3)],
    "euroc": [*axes("w_RS_S", "_"), *axes("a_RS_S", "_")],
    "euroc with units": [
        *(f"{n} [rad s^-1]" for n in axes("w_RS_S", "_")),
        *(f"{n} [m s^-2]" for n in axes("a_RS_S", "_")),
    ],
    "phyphox": [
        *(f"Gyroscope {axis} (rad/s)" for axis in "xyz"),
        *(f"Linear Acceleration {axis} (m/s^2)" for axis in "xyz"),
    ],
}


@rows("names", KNOWN.values(), ids=[*KNOWN])
def test_known_names(write, names):
    recording = read(write([CLOCK[0], *names], [CLOCK[1], *vector(0, 6)]))
    assert [record.signal.name for record in recording] == ["gyro"] * 3 + ["accelerometer"] * 3
    assert {record.kind for record in recording} == {"rate"}
    assert np.array_equal(recording[0].rate_values, NOISE[:, 0])
    assert any(names[0] in note and "unit rad" in note for note in recording.notes)


def test_underscores_alone_define_no_unit(write):
    with pytest.raises(UsageError, match="the unit is unknown"):
        read(write([CLOCK[0], *axes("angular_velocity", "_")], [CLOCK[1], *vector(0)]))
    # the length of a vector is no axis
    names = [CLOCK[0], "Gyroscope x (rad/s)", "Absolute (rad/s)", "Absolute acceleration (m/s^2)"]
    assert read(write(names, [CLOCK[1], *vector(0)])).channels == ("Gyroscope x",)
    # a unit against a known name is a warning
    recording = read(write([CLOCK[0], *IMU], [CLOCK[1], *vector(0, 6)]), unit="gyro=deg/s")
    assert recording[0].unit == "deg/s"
    (warning,) = recording.findings
    assert all(word in str(warning) for word in ("deg/s", "rad/s", "angular_velocity.x"))


IDENTIFIERS = [
    "frame_id", "header.frame_id", "header.seq", "sequence", "device_id", "gyro_device_id", "accel_device_id",
    "deviceId", "gyro_integral_dt", "accelerometer_integral_dt", "delta_angle_dt", "delta_velocity_dt",
    "accelerometer_clipping",
    "delta_velocity_clipping", "accel_clip_count", "clip_counter[0]", "gyro_calibration_count", "error_count",
    "gyro_status", "accel_flags", "gyro_temp", "acc_temperature", "angular_velocity_covariance_0", "orientation.x",
    "accelerometer_timestamp_relative",
]  # fmt: skip


@rows("name", IDENTIFIERS)
def test_identifiers_are_never_taken_for_a_sensor(write, name):
    assert headers.sensor_by_name(name) == "" or headers.is_other(name)
    columns = [CLOCK[1], *vector(0, 1), np.random.default_rng(1).integers(0, 9, 300).tolist()]
    for unit in ("rad/s", "m/s^2", {"gx": "rad/s"}):
        recording = read(write([CLOCK[0], "gx" if unit != "m/s^2" else "ax", name], columns), unit=unit)
        assert len(recording) == 1
        assert any("left out" in note and name in note for note in recording.notes)


@rows("name", ["gx", "gyro_x", "gyro_counts_x", "gx_count", "acc_calibrated_x", "gyroRateX"])
def test_signals_are_no_identifiers(name):
    assert not headers.identifies(name)
    assert not headers.is_other(name)


SECONDS = [EPOCH + (990 + 10 * i) // 1000 for i in range(300)]
NANO = [(990 + 10 * i) % 1000 * 1_000_000 for i in range(300)]


@rows("seconds, parts", [
    ("header.stamp.sec", "header.stamp.nanosec"), ("header.stamp.secs", "header.stamp.nsecs"), ("sec", "nsec"),
    ("stamp.sec", "stamp.nanosec"), ("secs", "nsecs"), ("/imu/header/stamp/sec", "/imu/header/stamp/nanosec"),
    ("header_stamp_sec", "header_stamp_nanosec"), ("field.header.stamp.secs", "field.header.stamp.nsecs"),
    ("Seconds", "Nanoseconds"),
])  # fmt: skip
def test_seconds_and_nanoseconds_are_one_clock(write, seconds, parts):
    recording = read(write([seconds, parts, "gx [rad/s]"], [SECONDS, NANO, *vector(0, 1)]))
    assert (recording.channels, recording["gx"].rate) == (("gx",), pytest.approx(100, rel=1e-12))
    assert recording["gx"].start == pytest.approx(EPOCH + 0.99, abs=1e-6)
    assert not recording.findings
    assert any(seconds in note and parts in note and "joined" in note for note in recording.notes)


def test_no_digit_is_lost(write):
    jitter = np.random.default_rng(2).integers(0, 100, 300)
    stamps = EPOCH * 10**9 + 999_999_000 + np.arange(300) * 1000 + jitter
    path = write(["sec", "nsec", "gx [rad/s]"], [stamps // 10**9, stamps % 10**9, *vector(0, 1)])
    rate = 299e9 / int(stamps[-1] - stamps[0])
    assert read(path)["gx"].rate == pytest.approx(rate, rel=1e-13)  # 1 MHz: a float64 resolves 2e-7 s of the epoch
    # microseconds
    path = write(["tv_sec", "tv_usec", "gx [rad/s]"], [SECONDS, [n // 1000 for n in NANO], *vector(0, 1)])
    assert read(path)["gx"].rate == pytest.approx(100)
    # what is not a part of a second is not joined
    whole = [i * 10_000_000 for i in range(300)]
    recording = read(write(["sec", "nsec", "gx [rad/s]"], [[n // 10**9 for n in whole], whole, *vector(0, 1)]))
    assert recording["gx"].rate == pytest.approx(100)
    assert any("not joined" in note for note in recording.notes)
    # a part that the user names stays alone
    path = write(["sec", "nsec", "gx [rad/s]"], [SECONDS, NANO, *vector(0, 1)])
    assert any("resolution of 1 s" in str(finding) for finding in read(path, time="sec").findings)
    assert not any("joined" in note for note in read(path, time="none", rate=100).notes if "not" in note)
    # seconds with fractions are a clock of their own
    path = write(["time_s", "time_ns", "gx [rad/s]"], [[i / 100 for i in range(300)], constant(5), *vector(0, 1)])
    recording = read(path)
    assert recording["gx"].rate == pytest.approx(100)
    assert not any("joined" in note for note in recording.notes)
