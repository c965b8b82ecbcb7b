"""A real PX4 log: figures found independently of this package."""

import numpy as np
import pytest
from click.testing import CliRunner
from tests.rows import rows

import allanite as al
from allanite.cli import main

pytest.importorskip("pyulog")
MEANS, DEVIATIONS = (0.0045, 0.0003, 0.0010), (0.0029, 0.0025, 0.0026)


def test_the_only_long_topic_of_an_autopilot(recordings):
    path = recordings / "cubeorange_sample_log_small.ulg"
    recording = al.read(path)
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


@rows(
    "options, code, words",
    [
        ([], 0, "32 samples (2.4 %) missing in 1 gap"),
        (["--channels", "sensor_gyro"], 2, "sensor_gyro/2 (6 rows at 1 Hz)"),
        (["--channels", "sensor_gyro/1"], 3, "6 samples are too few"),
        (["--channels", "vehicle_imu/0"], 3, "covers 4.888 ms of the 498.6 ms between messages"),
        (["--channels", "imu"], 2, "no table or column 'imu' in the file; it contains sensor_accel/0"),
    ],
)
def test_info_in_words(recordings, options, code, words):
    path = recordings / "cubeorange_sample_log_small.ulg"
    result = CliRunner().invoke(main, ["info", str(path), *options])
    assert result.exit_code == code
    assert words in " ".join(result.output.split())
