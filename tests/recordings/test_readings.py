"""Real recordings as they are read, PSINS text, R, MATLAB, ROS 2, PX4, plain text: figures found independently."""

import math
import shutil

import numpy as np
import pytest
from tests.rows import refused

from allanite.core.errors import UsageError
from allanite.readers import read

DEG_PER_HOUR = 180 / math.pi * 3600


def test_psins_needs_no_option_and_says_what_it_took_from_the_file(recordings):
    laser = read(recordings / "psins_lasergyro.imu")
    assert laser.channels == ("gx", "gy", "gz", "ax", "ay", "az")
    assert {(r.kind, r.rate, r.values.dtype.name) for r in laser} == {("count", 100.0, "int64")}
    assert [(r.unit, r.scale) for r in laser] == [("arcsec", 0.1)] * 3 + [("ug*s", 125.0)] * 3
    # 184732 lines: 10 comments, 1 blank, 3 header rows
    assert ({r.size for r in laser}, laser["gx"].values[:7].tolist()) == ({184718}, [0, 0, 0, 0, 2, 2, -4])
    assert [int(r.values[-1]) for r in laser] == [2, -4, 7, 0, 2, 80]
    rates = [np.mean(laser[name].rate_values) * DEG_PER_HOUR for name in ("gx", "gy", "gz")]
    assert rates == pytest.approx([-12.271, 0.438, 8.357], abs=6e-4)
    # Earth rate times the cosine of the latitude, 34.246 deg
    assert math.hypot(*rates[:2]) == pytest.approx(12.43, rel=0.02)
    force = math.hypot(*(np.mean(laser[name].rate_values) for name in ("ax", "ay", "az")))
    assert force / 9.80665 == pytest.approx(1.00155, abs=1e-5)
    assert any("9.78033" in note for note in laser.notes)
    assert any("kind count of 0.1 arcsec" in note for note in laser.notes)


def test_options_win_over_what_a_psins_file_says(recordings):
    path = recordings / "psins_lasergyro.imu"
    gyro = read(path, rate=125, scale=0.05, channels=["gz"])["gz"]
    assert (gyro.rate, gyro.scale, gyro.unit, gyro.kind) == (125.0, 0.05, "arcsec", "count")
    asked = read(path, unit="deg", scale=1e-4, kind="increment")
    assert (asked["gx"].unit, asked["gx"].kind, asked["gx"].scale) == ("deg", "increment", 1e-4)
    assert (asked["ax"].unit, asked["ax"].kind, asked["ax"].scale) == ("ug*s", "count", 125.0)


@pytest.mark.slow("takes more than half a second")
def test_matlab_73(recordings):
    path = recordings / "mpu6050_static10min" / "mpu6050_gyroscope.mat"
    refused(UsageError, r"sampling rate.*'gyroBuffer 1'", lambda: read(path, unit="deg/s"))
    gyros = read(path, unit="deg/s", rate=99.32, channels=["gyroBuffer"])
    assert gyros.channels == ("gyroBuffer 2", "gyroBuffer 3", "gyroBuffer 4")
    assert [round(float(np.mean(r.values)), 4) for r in gyros] == [4.5353, 0.0473, 1.1221]
    assert {r.size for r in gyros} == {65067}


def test_a_folder_of_ros_2_with_a_definition_beside_it(recordings, tmp_path):
    shutil.copy(recordings / "format_only_vn100_moving_0.db3", tmp_path / "data_circle2_0.db3")
    shutil.copy(recordings / "format_only_vn100_moving_db3_metadata.yaml", tmp_path / "metadata.yaml")
    refused(UsageError, r"imu_msg/IMUmsg is missing: put it beside the bag as IMUmsg\.msg", lambda: read(tmp_path))
    definition = (
        "std_msgs/Header header\nsensor_msgs/Imu imu\nsensor_msgs/MagneticField mag_field\nstring raw_imu_string"
    )
    (tmp_path / "IMUmsg.msg").write_text(definition)
    recording = read(tmp_path)
    assert (recording.channels, {r.size for r in recording}) == (("gx", "gy", "gz", "ax", "ay", "az"), {2617})
    assert recording[0].rate == pytest.approx(40.0002, abs=1e-4)
    assert any("'imu.header.stamp' is constant" in note for note in recording.notes)


def test_the_only_long_topic_of_an_autopilot(recordings):
    recording = read(recordings / "cubeorange_sample_log_small.ulg")
    assert "the log reports a dropout of its writer, of 0.03 s" in recording.notes
    assert [record.unit for record in recording] == ["rad/s"] * 3 + ["m/s^2"] * 3
    # 6.5 s with one hole of 0.161 s after the first sample: the median rate is right, the mean is not
    assert np.isnan(recording[0].values).sum() == 32
    gyros = [record.values for record in recording if record.signal.name == "gyro"]
    assert [np.nanmean(values) for values in gyros] == pytest.approx([0.0045, 0.0003, 0.0010], abs=5e-5)
    assert [np.nanstd(values) for values in gyros] == pytest.approx([0.0029, 0.0025, 0.0026], abs=5e-5)
