"""Recordings with other options than `test_every_recording` has: how the command ends, the rate, what must be said."""

import re
from typing import NamedTuple

import pytest
from tests import all_but
from tests.commands import run
from tests.rows import rows


class Row(NamedTuple):
    """A command, its exit code, the rate of the first channel (None: there is none), and patterns in what is said."""

    file: str
    verb: str
    options: str
    code: int
    rate: float | None
    said: tuple[str, ...]


LOG = "cubeorange_sample_log_small.ulg"
TABLE = [
    Row("psins_lasergyro.imu", "info", "", 0, 100.0, (
        r"rate 100\.0 Hz from the interval of 10 ms in the second header row",
        r"lines at 3\.08", r"lines at 2\.05",
        r"gz .* slope near -0\.8 at .* N is not meaningful here",
        r"is modulated at 25 Hz",  # the author made 8 ms into 10 ms
    )),
    Row("psins_lasergyro.imu", "rate", "--channels gz --no-times", 0, None, (
        r"mean +8\.3537778 ", r"use mean: in 15 intervals",
        r"regression +0\.217 +0\.646 +worse +1\.76 +1\.28 \.\. 2\.42",
    )),
    Row("phone_gyro4.txt", "info", "", 2, None, (r"unit is unknown", r"--unit UNIT", r"'column 3'")),
    Row("adis_16405_imu1.rda", "info", "", 2, None, (r"unit is unknown", r"--unit gyro=UNIT,accel=g")),
    Row("imu_tk_xsens_gyro.mat", "info", "", 2, None,
        (r"pass --rate HZ", r"try: allanite info .* --time 'column 1\[s\]' --unit UNIT")),
    Row("imu_tk_xsens_gyro.mat", "info", "--rate 100 --scale 0.01deg/s --until 50", 0, None, (r"rate in 0\.01 °/s",)),
    Row("imu_tk_xsens_gyro.mat", "info", "--dtype i2 --columns 3", 3, None,
        (r"not a multiple of the 6 bytes of a row",)),
    Row(LOG, "info", "--channels sensor_gyro", 2, None, (r"sensor_gyro/2 \(6 rows at 1 Hz\)",)),
    Row(LOG, "info", "--channels sensor_gyro/1", 3, None, (r"6 samples are too few",)),
    Row(LOG, "info", "--channels vehicle_imu/0", 3, None,
        (r"covers 4\.888 ms of the 498\.6 ms between messages",)),
    Row(LOG, "info", "--channels imu", 2, None,
        (r"no table or column 'imu' in the file; it contains sensor_accel/0",)),
    Row("imu_tk_xsens_gyro.mat", "info", "--unit deg/s --rate 100", 3, 100.0, (r"moves from 52 s .* --until 52 ",)),
    Row("imu_tk_xsens_gyro.mat", "info", "--unit deg/s --time 1", 3, 100.01013,
        (r"moves from 5[12][\.\d]* s .* --until 51 ",)),
    Row("imu_tk_xsens_gyro.mat", "info", "--unit deg/s --rate 100 --until 52", 0, 100.0,
        (r"cut from 0 s to 52 s", r"52 s long")),
    Row("imu_tk_xsens_gyro.mat", "analyze", "--unit deg/s --time 1 --until 52", 0, 100.01013, (r"angle random walk",)),
    Row("vn100_car_idle.bag", "info", "", 0, 40.000076, (
        r"samples of /imu of type sensor_stack/Vectornav \(2732 rows at 39.85 Hz\)",
        r"rad/s, m/s² by the definition",
        r"'header\.stamp' is used as the clock, of 4 candidates",
        r"'imu\.header\.stamp' repeats 97 % of its time stamps", r"'receive time' scatters by 100 %",
        r"spectral lines at 10, 18\.3, 19\.8 Hz", r"gx gyroscope, rate in rad/s, .* 2732 samples",
    )),
    Row("vn100_car_idle.bag", "info", "--channels /gnss", 2, None, (r"'HDOP', .*: the unit is unknown",)),
    Row("vn100_car_idle.bag", "info", "--channels /imu/raw", 2, None, (r"no column 'raw'; columns: ",)),
    Row("vn100_car_idle.bag", "info", "--channels /imus", 2, None,
        (r"no table or column '/imus' in the file; "
         r"it contains .*/imu of type sensor_stack/Vectornav \(2732 rows",)),
]  # fmt: skip
LONG = [row for row in TABLE if row.verb != "info"]


@pytest.mark.slow("takes more than half a second")
@rows("row", all_but(TABLE, LONG), ids=lambda row: f"{row.file}-{row.verb}-{row.options}")
def test_what_is_said_of_a_recording(recordings, row):
    result = run(row.verb, recordings / row.file, *row.options.split())
    said = " ".join((result.stdout + " " + result.stderr).split())
    assert result.exit_code == row.code, said
    assert "Traceback" not in said
    for pattern in row.said:
        assert re.search(pattern, said), (pattern, said)
    if row.rate is not None:
        rates = re.findall(r"(?:gyroscope|accelerometer), .*?, ([\d.]+) Hz, \d+ samples", said)
        assert list(map(float, rates)) == pytest.approx([row.rate] * max(len(rates), 1), rel=1e-6)
