"""PX4 logs: topics and their instances, batches, integrals, and what is said of damaged files."""

import struct

import numpy as np
import pytest
from tests.rows import refused, rows

import allanite as al

pyulog = pytest.importorskip("pyulog")
RNG = np.random.default_rng(5)
STAMPS = "uint64_t timestamp;uint64_t timestamp_sample;"
GYRO = STAMPS + "uint32_t device_id;float x;float y;float z;float temperature;"
FIFO = STAMPS + "float dt;float scale;uint8_t samples;int16_t[4] x;int16_t[4] y;int16_t[4] z;"
IMU = STAMPS + "float[3] delta_angle;float[3] delta_velocity;uint32_t delta_angle_dt;uint32_t delta_velocity_dt;"


def ulog(path, *topics):
    """A log of topics, each with its name, instance, fields and packed rows."""

    def message(kind, payload):
        return struct.pack("<HB", len(payload), ord(kind)) + payload

    data = b"ULog\x01\x12\x35\x01" + bytes(8)
    data += b"".join(message("F", f"{n}:{f}".encode()) for n, f in {t[0]: t[2] for t in topics}.items())
    for i, (name, instance, _, packed) in enumerate(topics):
        data += message("A", struct.pack("<BH", instance, i) + name.encode())
        data += b"".join(message("D", struct.pack("<H", i) + row) for row in packed)
    path.write_bytes(data)
    return path


def gyro(count, step=5000, start=10**9):
    values = RNG.normal(size=(count, 3)).astype("f4")
    stamps = start + step * np.arange(count)
    rows = [struct.pack("<QQI4f", t + 300, t, 77, *v, 25.0) for t, v in zip(stamps, values, strict=True)]
    return values, rows


@pytest.fixture
def log(tmp_path):
    (first, rows), (second, again), (_, accel) = gyro(400), gyro(300, 10_000), gyro(300, 2500)
    topics = [("sensor_gyro", 0, GYRO, rows), ("sensor_gyro", 1, GYRO, again), ("sensor_accel", 0, GYRO, accel)]
    return ulog(tmp_path / "a.ulg", *topics, ("cpuload", 0, "uint64_t timestamp;float load;", [])), first, second


@pytest.mark.slow("takes more than half a second")
def test_several_topics_are_listed_with_rate_and_count_and_chosen(log):
    path, _, second = log
    sizes = ("sensor_accel/0", 300, 400), ("sensor_gyro/0", 400, 200), ("sensor_gyro/1", 300, 100)
    listed = ", ".join(rf"{name} \({size} rows at {rate} Hz\)" for name, size, rate in sizes)
    words = rf"3 tables.*{listed}\); select one with channels='sensor_accel/0'"
    refused(al.UsageError, words, lambda: al.read(path))
    for key in ("sensor_gyro/1", "/SENSOR_GYRO/1"):
        recording = al.read(path, channels=[key])
        assert recording.channels == ("x", "y", "z")
        assert np.array_equal(np.column_stack([r.values for r in recording]), second.astype(float))
    assert (recording[0].unit, recording[0].kind, recording[0].rate) == ("rad/s", "rate", pytest.approx(100.0))
    assert recording.others[0].name == "temperature"
    assert any("sensor_gyro/0 (400 rows" in note for note in recording.notes)
    assert al.read(path, channels=["sensor_gyro/1/z"]).channels == ("z",)
    assert al.read(path, channels=["sensor_accel"])[0].unit == "m/s^2"
    refused(al.UsageError, "2 tables .*sensor_gyro/0.*select one", lambda: al.read(path, channels=["sensor_gyro"]))


def test_the_samples_are_those_of_pyulog(log):
    for topic in pyulog.ULog(str(log[0])).data_list:
        found = al.read(log[0], channels=[f"{topic.name}/{topic.multi_id}"])
        assert all(np.array_equal(found[axis].values, topic.data[axis]) for axis in "xyz")
        assert found[0].start == pytest.approx(topic.data["timestamp_sample"][0] * 1e-6, abs=1e-9)


def test_one_topic_is_taken_and_short_ones_are_not(tmp_path):
    path = ulog(tmp_path / "a.ulg", ("sensor_gyro", 0, GYRO, gyro(250)[1]), ("sensor_gyro", 1, GYRO, gyro(9)[1]))
    assert al.read(path)[0].size == 250
    assert "samples of sensor_gyro/0 (250 rows at 200 Hz)" in al.read(path).notes


def test_batches_are_unrolled(tmp_path):
    counts = RNG.integers(-900, 900, (100, 3, 4))
    sizes = np.tile([3, 4], 50)
    ends = 10**9 + np.cumsum(sizes) * 1000
    batches = list(zip(ends, sizes, counts, strict=True))
    rows = [struct.pack("<QQffB12h", t + 50, t, 1000.0, 0.5, n, *batch.ravel()) for t, n, batch in batches]
    recording = al.read(ulog(tmp_path / "a.ulg", ("sensor_gyro_fifo", 0, FIFO, rows)))
    expected = np.concatenate([batch[:, :n] for _, n, batch in batches], axis=1)
    assert recording[0].rate == pytest.approx(1000.0)
    assert np.array_equal(np.array([r.values for r in recording]), 0.5 * expected)
    assert recording[0].start == pytest.approx((ends[0] - 2000) * 1e-6)
    assert not recording.findings


@rows(("over", "kind", "unit"), [(5000, "increment", "rad"), (1000, "rate", "rad/s")])
def test_integrals_are_increments_if_they_cover_the_time_step(tmp_path, over, kind, unit):
    angles = RNG.normal(size=(300, 6)).astype("f4")
    rows = [struct.pack("<QQ6f2I", i * 5000, i * 5000, *v, over, over) for i, v in enumerate(angles)]
    recording = al.read(ulog(tmp_path / "a.ulg", ("vehicle_imu", 0, IMU, rows)))
    assert ([r.kind for r in recording], recording[0].unit) == ([kind] * 6, unit)
    scale = 1.0 if kind == "increment" else 1e3
    assert np.allclose(recording[1].values, scale * angles[:, 1].astype(float), rtol=1e-12)
    said = any("delta_angle covers 1 ms of the 5 ms between messages" in note for note in recording.notes)
    assert said == (kind == "rate")


def test_an_unknown_topic_asks_for_its_unit(tmp_path):
    rows = [struct.pack("<Qf", i * 5000, v) for i, v in enumerate(RNG.normal(size=300))]
    path = ulog(tmp_path / "a.ulg", ("fog", 0, "uint64_t timestamp;float out;", rows))
    words = r"no table of the file has inertial signals.*fog/0 \(300 rows.*channels='"
    refused(al.UsageError, words, lambda: al.read(path))
    refused(al.UsageError, "'out': the unit is unknown", lambda: al.read(path, channels=["fog/0"]))
    assert al.read(path, channels=["fog/0"], unit="deg/h")["out"].size == 300


def test_a_log_that_was_cut_off_or_damaged(log, write):
    whole = log[0].read_bytes()
    assert 200 <= al.read(write(whole[: len(whole) // 2], "cut.ulg"), channels=["sensor_gyro/0"])[0].size <= 400
    damaged = al.read(write(whole + b"\6\0D\x63\0abcd", "cut.ulg"), channels=["sensor_gyro/1"])  # of no topic
    assert "the log is damaged in places; the messages there are left out" in damaged.notes
    refused(al.DataError, "no rows", lambda: al.read(write(whole[:40], "cut.ulg")))
    refused(al.DataError, "does not begin like a PX4 log", lambda: al.read(write(RNG.bytes(900), "cut.ulg")))
