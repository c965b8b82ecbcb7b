"""Real recordings in R, MATLAB 7.3 and ASCII .mat files: figures found independently of this package."""

import shutil

import numpy as np
import pytest
from click.testing import CliRunner
from tests.rows import rows

from allanite.cli import main
from allanite.core.errors import UsageError
from allanite.readers import read


@pytest.mark.slow("takes more than half a second")
@rows("name, mean, std", [("adis_16405_imu1", 0.4017, 0.3503), ("adis_16405_imu2", 0.3789, 0.3495)])
def test_r_matrix_of_an_imu(recordings, name, mean, std):
    path = recordings / f"{name}.rda"
    with pytest.raises(UsageError, match=r"'Gyro\. X', .*'Accel\. Z': the unit is unknown; pass the unit "):
        read(path)
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
    with pytest.raises(UsageError, match=r"sampling rate.*'gyroBuffer 1'"):
        read(folder / "mpu6050_gyroscope.mat", unit="deg/s")
    stamped = read(folder / "mpu6050_gyroscope.mat", unit="deg/s", time="1[s]")
    assert stamped[0].rate == pytest.approx(99.317, abs=1e-3)
    assert [finding.name for finding in stamped.findings] == ["bursty time stamps"]
    gyros = read(folder / "mpu6050_gyroscope.mat", unit="deg/s", rate=99.32, channels=["gyroBuffer"])
    assert gyros.channels == ("gyroBuffer 2", "gyroBuffer 3", "gyroBuffer 4")
    assert [round(float(np.mean(r.values)), 4) for r in gyros] == [4.5353, 0.0473, 1.1221]
    assert {r.size for r in gyros} == {65067}


def test_an_ascii_mat(recordings):
    path = recordings / "imu_tk_xsens_gyro.mat"
    with pytest.raises(UsageError, match=r"sampling rate .*rate=100.*'column 2'.*unit="):
        read(path)
    assert {r.size for r in read(path, rate=100, unit="deg/s", scale=0.01)} == {51175}


def test_a_folder_of_ros_2_with_a_definition_beside_it(recordings, tmp_path):
    shutil.copy(recordings / "format_only_vn100_moving_0.db3", tmp_path / "data_circle2_0.db3")
    shutil.copy(recordings / "format_only_vn100_moving_db3_metadata.yaml", tmp_path / "metadata.yaml")
    with pytest.raises(UsageError, match=r"imu_msg/IMUmsg is missing: put it beside the bag as IMUmsg\.msg"):
        read(tmp_path)
    definition = (
        "std_msgs/Header header\nsensor_msgs/Imu imu\nsensor_msgs/MagneticField mag_field\nstring raw_imu_string"
    )
    (tmp_path / "IMUmsg.msg").write_text(definition)
    recording = read(tmp_path)
    assert recording.channels == ("gx", "gy", "gz", "ax", "ay", "az")
    assert {r.size for r in recording} == {2617}
    assert recording[0].rate == pytest.approx(40.0002, abs=1e-4)
    assert any("'imu.header.stamp' is constant" in note for note in recording.notes)


@pytest.mark.slow("takes more than half a second")
@rows(
    "name, options, code, words",
    [
        ("adis_16405_imu1.rda", [], 2, "--unit gyro=UNIT,accel=g"),
        ("adis_16405_imu1.rda", ["--unit", "deg/s"], 0, "1000000 samples, 2.78 h"),
        ("imu_tk_xsens_gyro.mat", [], 2, "--rate HZ"),
        ("imu_tk_xsens_gyro.mat", ["--rate", "100", "--scale", "0.01deg/s", "--until", "50"], 0, "rate in 0.01 °/s"),
        ("imu_tk_xsens_gyro.mat", ["--dtype", "i2", "--columns", "3"], 3, "not a multiple of the 6 bytes of a row"),
    ],
)
def test_info_in_words(recordings, name, options, code, words):
    result = CliRunner().invoke(main, ["info", str(recordings / name), *options])
    assert result.exit_code == code
    assert words in " ".join(result.output.split())
