"""PX4: the EKF2 of the autopilot, and its thermal compensation."""

from dataclasses import replace

from allanite.core.syntax import PARAMETERS
from allanite.exporting.layouts import LineLayout
from allanite.exporting.target import ACCELEROMETER, GYRO, Target, TargetField, pair
from allanite.exporting.thermal import ThermalTarget
from allanite.phrases.phrase import say

NOISE = TargetField("", GYRO, "N", "rad/s", rate=1, span=(1e-4, 0.1))
WALK = TargetField("", GYRO, "K", "rad/s^2", rate=1, span=(0.0, 0.01))

gyro, accelerometer = pair("EKF2_GYR_NOISE", "EKF2_ACC_NOISE", NOISE, "m/s^2")

PX4 = Target(
    name="px4",
    synonyms=("ekf2", "px4-autopilot"),
    title=say("parameters of PX4's EKF2, for QGroundControl"),
    fields=(
        gyro,
        replace(accelerometer, span=(0.01, 1.0)),
        *pair("EKF2_GYR_B_NOISE", "EKF2_ACC_B_NOISE", WALK, "m/s^3"),
    ),
    forms={".params": LineLayout("1\t1\t{name}\t{value}\t9", PARAMETERS)},
    source="src/modules/ekf2/EKF/covariance.cpp: variances of a step (dt EKF2_GYR_NOISE)^2 and (dt "
    "EKF2_GYR_B_NOISE)^2 with dt = 10 ms (EKF2_PREDICT_US); ranges of the parameters",
    notes=(
        say(
            "the defaults of PX4 are 10 to 100 times as large, since they cover vibration in flight: values of a bench "
            "are lower bounds"
        ),
    ),
    step=0.01,
)

PX4_TC = ThermalTarget(
    name="px4-tc",
    title=say("thermal compensation of PX4, for QGroundControl"),
    fields=(),
    forms={".params": LineLayout("1\t1\t{name}\t{value}\t9", PARAMETERS)},
    source="src/modules/temperature_compensation/TemperatureCompensation.cpp (calc_thermal_offsets_3D: polynomial of "
    "the third degree, temperature limited to TMIN .. TMAX) and .h (at most 4 sensors); src/lib/sensor_calibration/"
    "Gyroscope.hpp and Accelerometer.hpp (Correct: data - thermal offset - offset, then rotation); format of the file "
    "and TREF in the middle of the range: Tools/process_sensor_caldata.py. Not verified: how a vehicle takes the file",
    notes=(
        say("set TC_G*_ID and TC_A*_ID to the device IDs of the sensors (as in CAL_GYRO*_ID and CAL_ACC*_ID); without "
            "them PX4 does not apply the correction"),
        say("the record must be that of sensor_gyro and sensor_accel, in their axes and without a correction"),
        say("after loading, restart and calibrate gyro and accelerometer again"),
    ),
    prefixes={n: f"TC_{{sensor}}{n}_" for n in range(4)},
    letters={GYRO: "G", ACCELEROMETER: "A"},
    coefficient="X{power}_{axis}",
    axes=("0", "1", "2"),
    enable="1\t1\tTC_{sensor}_ENABLE\t1\t6",
)  # fmt: skip
