"""File by file: how ``analyze`` ends, topic, rate and clock, a finding, and the deviations that others computed.

Options are those without which a file is refused: what it does not say, or how far its sensor is at rest.
"""

import csv
import re
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from tests import thinned
from tests.commands import run
from tests.rows import rows

import allanite as al
from allanite.core.choices import choices_of
from allanite.prepare import trim

pytestmark = pytest.mark.usefixtures("analyzed_once")


class File(NamedTuple):
    """A file of the folder, and the choices of a recipe that it needs.

    `code` is the exit code. Patterns: `clock`, where the `rate` (of all channels; 0: there is none) is from, `found`, a
    finding, and `topic` of a log. `compared` has the channels of the table of references by unit, each with that of
    ours; `reference` is its name there, and `given` the rate that it used, where that is rounded.
    """

    name: str
    code: int
    found: str
    rate: float = 0.0
    clock: str = ""
    topic: str = ""
    options: dict[str, Any] = {}  # noqa: RUF012 - never changed
    compared: dict[str, dict[str, str]] = {}  # noqa: RUF012
    reference: str = ""
    given: float | None = None

    @property
    def words(self):
        """The options of the command."""
        return [word for key, value in self.options.items() for word in choices_of(al.Recipe)[key].words(value)]


def three(start, names="gx gy gz"):
    """Columns that are known by their positions."""
    return {name: str(start + i) for i, name in enumerate(names.split())}


def same(*names):
    """Columns whose names are those of the references."""
    return {name: name for name in names}


MPU = "mpu6050_static10min/"
GYROS, ACCELEROMETERS = same("gx", "gy", "gz"), same("ax", "ay", "az")
ADIS = {"deg/s": three(1), "g": three(4, "ax ay az")}
ROS = {"rad/s": GYROS, "m/s^2": ACCELEROMETERS}
BURSTS = r"bursty time stamps .*491\.3 Hz from the median step, 99\.3171 Hz from the mean"
CURVE = r"the unit is unknown; pass the unit of the samples, --unit UNIT"
FILES = [
    *(File(f"adis_16405_imu{i}.rda", 0,
           r"explained \(goodness of fit .* low-pass filtered: .* Q not observable: the filter hides",
           100.0, rf"'adis_16405_imu{i}/freq' in the file",
           options={"unit": "gyro=deg/s,accel=g"}, compared=ADIS if i < 3 else {}) for i in (1, 2, 3)),
    File("aegiverse_fog_0917.txt", 0, r"stuck in 1 place, .* 5 distinct values, quantized to 1\.5 °/h", 100.02865,
         r"column 'time', time stamps assumed to be in seconds",
         options={"unit": "deg/h"}, compared={"deg/h": same("fog")}),
    File("aegiverse_fpga_gyro_0802.txt", 0, r"the record is only 111\.3 s long", 96.071745, "column 1, ",
         options={"time": "1", "unit": "deg/s", "channels": ("2",)}, compared={"deg/s": {"col2": "2"}}),
    File("cubeorange_sample_log_small.ulg", 0, r"32 samples \(2\.4 %\) missing in 1 gap", 204.58273,
         r"column 'timestamp \[us\]'", r"sensor_combined/0 \(1298 rows at 199\.7 Hz\)",
         compared={"rad/s": {f"g{axis}": f"gyro_rad[{i}]" for i, axis in enumerate("xyz")}}),
    File("format_only_vn100_moving.mcap", 3, r"the body moved: gz moves from 0 s \(RMS over 20 times"),
    File("format_only_vn100_moving_0.db3", 2, r"IMUmsg is missing: put it beside the bag as IMUmsg\.msg",
         topic=r"/imu of type imu_msg/IMUmsg \(2617 rows at 40 Hz\)"),
    File("ig500n_milkytipo.txt", 0, r"5 outliers beyond 5\.6 standard deviations, the first at 3618\.51 s", 4.16,
         options={"rate": 4.16, "unit": "deg/s", "channels": ("7", "8", "9")}),
    File("imu_tk_xsens_gyro.mat", 0, r"the record is only 50 s long", 100.0,
         options={"unit": "deg/s", "rate": 100.0, "until": 50.0}, compared={"deg/s": three(2)},
         reference="imu_tk_xsens_gyro.mat[first 5000]"),
    File(MPU + "hmc5883l_compass.mat", 0, r"bursty time stamps .*424\.8 Hz from the median step", 76.933667,
         "column 'compassBuffer 1'", options={"time": "1", "unit": "uT"}),
    File(MPU + "mpu6050_accelerometer.mat", 0, BURSTS, 99.317138, "column 'accelBuffer 1'",
         options={"time": "1", "unit": "g"}, compared={"g": three(2, "ax ay az")}),
    File(MPU + "mpu6050_gyroscope.mat", 0, BURSTS, 99.317138, "column 'gyroBuffer 1'",
         options={"time": "1", "unit": "deg/s"}, compared={"deg/s": three(2)}),
    File(MPU + "mpu6050_temperature.mat", 0, BURSTS, 99.317138, "column 'temperatureBuffer 1'",
         options={"time": "1", "unit": "degC", "channels": ("2",)}),
    File("phone_acc2.txt", 0, r"quantization errors are not white: 3 distinct values", 5.0, "date and time",
         options={"unit": "m/s^2"}),
    File("phone_gyro4.txt", 0, r"resolution of 1 s .* quantized to 0\.001 rad/s", 5.0, "date and time",
         options={"unit": "rad/s"}, compared={"rad/s": three(3)}),
    File("psins_lasergyro.imu", 0, r"no model of these terms explains", 100.0,
         "the interval of 10 ms in the second header row", compared={"deg/h": GYROS, "g": ACCELEROMETERS}),
    File("vn100_car_idle.bag", 0, r"spectral lines at 10, 10\.8, 19\.8 Hz", 40.000076, "column 'header.stamp'",
         r"/imu of type sensor_stack/Vectornav \(2732 rows at 39\.85 Hz\)", compared=ROS, given=40.0003),
    File("xsens_mti_utbm_imu-test.bag", 0, r"the record is only 9\.779 s long", 100.00738, "column 'header.stamp'",
         r"/imu/data of type sensor_msgs/Imu \(978 rows at 100 Hz\)", compared=ROS, given=100.008),
    # no recordings
    *(File(f"avar_curves_smac/{name}_av.rda", 2, CURVE) for name in ("adis", "imar", "kvh1750", "ln200", "navchip")),
    File("avar_curve_cpt7/allan_variance.csv", 2, CURVE),
    File("avar_curve_cpt7/imu.yaml", 3, r"line 9 has 7 columns instead of 2"),
    File("format_only_vn100_moving_db3_metadata.yaml", 3, r"'sqlite3' is not a number"),
    File(MPU + "sensor-covariances.csv", 2, CURVE),
    File(MPU + "sensor-stats.csv", 2, CURVE),
    File("reference_oadev.csv", 3, r"time stamps of column 'tau_s' are earlier than the previous one"),
    File("CONVENTIONS.md", 3, "is not a number"),
    File("INDEX.md", 3, "is not a number"),
    File("SHA256SUMS", 3, "no rows of numbers were found"),
]  # fmt: skip


@pytest.mark.slow("takes more than half a second")
@rows("file", thinned(FILES, 4, "every recording"), ids=lambda file: file.name)
def test_what_the_command_says_of_a_file(recordings, file):
    result = run("analyze", recordings / file.name, *file.words)
    said = " ".join((result.stdout + " " + result.stderr).split())
    assert result.exit_code == file.code, said
    assert "Traceback" not in said
    assert re.search(file.found, said), said
    assert re.search(file.topic, said), said
    if file.clock:
        assert re.search(rf"rate [\d.]+ Hz from {file.clock}", said), said
    rates = [float(rate) for rate in re.findall(r", ([\d.]+) Hz, \d+ samples", said)]
    assert rates == pytest.approx([file.rate] * len(rates), rel=1e-6)
    assert bool(rates) == bool(file.rate)


def read(recordings, file, unit, channels):
    """The channels of a file as the references have them: to their end, with gaps closed."""
    given = {"rate": file.given or file.options.get("rate"), "time": file.options.get("time")}
    given["unit"] = unit if file.options else None
    return trim(al.read(recordings / file.name, channels=list(channels), **given), None, file.options.get("until"))


def as_theirs(record, file, unit):
    """A record as the reference took it: gaps closed, and of PSINS the row of scale factors as the first reading."""
    if file.name.endswith(".imu"):
        first = 0.1 if unit == "deg/h" else 125.0
        values = np.concatenate(([first], record.values)) * record.scale
        return al.Record(values, record.rate, record.unit, kind="increment")
    gaps = np.isnan(record.values)
    return replace(record, values=record.values[~gaps]) if gaps.any() else record


def published(recordings, name):
    """The rows of a file in the table of references by channel."""
    with (recordings / "reference_oadev.csv").open() as table:
        every = [row for row in csv.DictReader(table) if row["file"] == name]
    return {channel: [row for row in every if row["channel"] == channel] for channel in {r["channel"] for r in every}}


def compare(record, unit, theirs):
    """Hold the deviations of a record against those of the table, which have nine digits."""
    curve = al.deviation(record, m=[int(row["m"]) for row in theirs]).to(unit)
    np.testing.assert_allclose(curve.deviation, [float(row["oadev"]) for row in theirs], rtol=2e-8)
    assert curve.count.tolist() == [int(row["n_terms"]) for row in theirs]


@pytest.mark.slow("takes more than half a second")
@rows("file, unit", [(file, unit) for file in FILES for unit in file.compared],
      ids=lambda value: getattr(value, "name", value))  # fmt: skip
def test_deviations_are_those_that_others_computed(recordings, file, unit):
    channels = file.compared[unit]
    every = published(recordings, file.reference or file.name.rpartition("/")[2])
    for record, name in zip(read(recordings, file, unit, channels.values()), channels, strict=True):
        assert record.rate == pytest.approx(float(every[name][0]["rate_hz_used"]), rel=1e-6)
        compare(as_theirs(record, file, unit), unit, every[name])


def test_deviations_of_a_quiet_window_are_those_that_others_computed(recordings):
    laser = al.read(recordings / "psins_lasergyro.imu", channels=["gx", "gy", "gz"])
    every = published(recordings, "psins_lasergyro.imu[600-900s]")
    for name in laser.channels:
        values = laser[name].values[59_999:90_000]
        assert trim(laser, 600, 900)[name].values.tolist() == values[1:].tolist()
        # their window begins one reading earlier, as the row of scale factors was the first reading
        compare(replace(laser[name], values=values[:-1]), every[name][0]["unit"], every[name])
