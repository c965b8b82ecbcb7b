"""Real recordings as they are read, PSINS text, R, MATLAB, ROS 2, PX4, plain text: figures found independently."""

import math
import shutil

import numpy as np
import pytest
from tests.rows import refused, rows

from allanite.core.errors import UsageError
from allanite.readers import read

DEG_PER_HOUR = 180 / math.pi * 3600


@pytest.fixture(scope="module")
def laser(recordings):
    return read(recordings / "psins_lasergyro.imu")


def test_psins_needs_no_option_and_every_row_is_there(laser):
    assert laser.channels == ("gx", "gy", "gz", "ax", "ay", "az")
    assert {(r.kind, r.rate, r.values.dtype.name) for r in laser} == {("count", 100.0, "int64")}
    assert [(r.unit, r.scale) for r in laser] == [("arcsec", 0.1)] * 3 + [("ug*s", 125.0)] * 3
    # 184732 lines: 10 comments, 1 blank, 3 header rows
    assert ({r.size for r in laser}, laser["gx"].values[:7].tolist()) == ({184718}, [0, 0, 0, 0, 2, 2, -4])
    assert [int(r.values[-1]) for r in laser] == [2, -4, 7, 0, 2, 80]


def test_mean_rates_earth_rate_and_gravity(laser):
    rates = [np.mean(laser[name].rate_values) * DEG_PER_HOUR for name in ("gx", "gy", "gz")]
    assert rates == pytest.approx([-12.271, 0.438, 8.357], abs=6e-4)
    assert math.hypot(*rates[:2]) == pytest.approx(
        12.43, rel=0.02
    )  # Earth rate times the cosine of the latitude, 34.246 deg
    force = math.hypot(*(np.mean(laser[name].rate_values) for name in ("ax", "ay", "az")))
    assert force / 9.80665 == pytest.approx(1.00155, abs=1e-5)


def test_psins_says_what_it_took_from_the_file(laser):
    assert any("9.78033" in note for note in laser.notes)
    assert any("rate 100.0 Hz" in note and "second header row" in note for note in laser.notes)
    assert any("kind count of 0.1 arcsec" in note for note in laser.notes)


def test_options_win_over_what_a_psins_file_says(recordings):
    path = recordings / "psins_lasergyro.imu"
    gyro = read(path, rate=125, scale=0.05, channels=["gz"])["gz"]
    assert (gyro.rate, gyro.scale, gyro.unit, gyro.kind) == (125.0, 0.05, "arcsec", "count")
    asked = read(path, unit="deg", scale=1e-4, kind="increment")
    assert (asked["gx"].unit, asked["gx"].kind, asked["gx"].scale) == ("deg", "increment", 1e-4)
    assert (asked["ax"].unit, asked["ax"].kind, asked["ax"].scale) == ("ug*s", "count", 125.0)


def test_phone_text_with_dates(recordings):
    phone = read(recordings / "phone_gyro4.txt", rate=5, unit="rad/s")
    assert (phone.channels, {r.size for r in phone}) == (("column 3", "column 4", "column 5"), {38577})
    assert [float(np.std(r.values)) for r in phone] == pytest.approx([0.00119, 0.00106, 0.00102], abs=6e-6)


def test_fog_text_with_a_time_column_and_dates_around(recordings):
    fog = read(recordings / "aegiverse_fog_0917.txt", unit="deg/h")
    assert (fog.channels, fog["fog"].rate) == (("fog",), pytest.approx(100.03, abs=0.01))
    assert len(np.unique(fog["fog"].values)) == 5


@pytest.mark.slow("takes more than half a second")
@rows("name, mean, std", [("adis_16405_imu1", 0.4017, 0.3503), ("adis_16405_imu2", 0.3789, 0.3495)])
def test_r_matrix_of_an_imu(recordings, name, mean, std):
    path = recordings / f"{name}.rda"
    refused(UsageError, r"'Gyro\. X', .*'Accel\. Z': the unit is unknown; pass the unit ", lambda: read(path))
    gyros = read(path, unit="deg/s")
    assert gyros.channels == ("Gyro. X", "Gyro. Y", "Gyro. Z")
    assert {(r.rate, r.size) for r in gyros} == {(100.0, 1_000_000)}
    assert any(f"rate 100.0 Hz from '{name}/freq'" in note for note in gyros.notes)
    assert np.mean(gyros[0].values) == pytest.approx(mean, abs=5e-5)
    assert np.std(gyros[0].values) == pytest.approx(std, abs=5e-5)
    assert read(path, unit="g").channels == ("Accel. X", "Accel. Y", "Accel. Z")


@pytest.mark.slow("takes more than half a second")
def test_matlab_73(recordings):
    folder = recordings / "mpu6050_static10min"
    refused(UsageError, r"sampling rate.*'gyroBuffer 1'", lambda: read(folder / "mpu6050_gyroscope.mat", unit="deg/s"))
    stamped = read(folder / "mpu6050_gyroscope.mat", unit="deg/s", time="1[s]")
    assert stamped[0].rate == pytest.approx(99.317, abs=1e-3)
    assert [finding.name for finding in stamped.findings] == ["bursty time stamps"]
    gyros = read(folder / "mpu6050_gyroscope.mat", unit="deg/s", rate=99.32, channels=["gyroBuffer"])
    assert gyros.channels == ("gyroBuffer 2", "gyroBuffer 3", "gyroBuffer 4")
    assert [round(float(np.mean(r.values)), 4) for r in gyros] == [4.5353, 0.0473, 1.1221]
    assert {r.size for r in gyros} == {65067}


def test_an_ascii_mat(recordings):
    path = recordings / "imu_tk_xsens_gyro.mat"
    refused(UsageError, r"sampling rate .*rate=100.*'column 2'.*unit=", lambda: read(path))
    assert {r.size for r in read(path, rate=100, unit="deg/s", scale=0.01)} == {51175}


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


MEANS, DEVIATIONS = (0.0045, 0.0003, 0.0010), (0.0029, 0.0025, 0.0026)


def test_the_only_long_topic_of_an_autopilot(recordings):
    pytest.importorskip("pyulog")
    path = recordings / "cubeorange_sample_log_small.ulg"
    recording = read(path)
    assert "samples of sensor_combined/0 (1298 rows at 199.7 Hz)" in recording.notes
    assert "the log reports a dropout of its writer, of 0.03 s" in recording.notes
    gyros = [record for record in recording if record.signal.name == "gyro"]
    assert [record.unit for record in recording] == ["rad/s"] * 3 + ["m/s^2"] * 3
    # 6.5 s with one hole of 0.161 s after the first sample: the median rate is right, the mean is not
    assert gyros[0].rate == pytest.approx(204.58, abs=0.01)
    assert [finding.name for finding in recording.findings] == ["missing samples"]
    assert np.isnan(gyros[0].values).sum() == 32
    assert [np.nanmean(r.values) for r in gyros] == pytest.approx(MEANS, abs=5e-5)
    assert [np.nanstd(r.values) for r in gyros] == pytest.approx(DEVIATIONS, abs=5e-5)
