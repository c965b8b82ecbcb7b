"""ArduPilot: the EKF3 of the autopilot, and its temperature calibration."""

from dataclasses import replace

from allanite.core.syntax import PARAMETERS
from allanite.exporting.layouts import LineLayout
from allanite.exporting.target import ACCELEROMETER, GYRO, Target, TargetField, pair
from allanite.exporting.thermal import ThermalTarget
from allanite.phrases.phrase import say

NOISE = TargetField("", GYRO, "N", "rad/s", rate=1, span=(1e-4, 0.1))
WALK = TargetField("", GYRO, "K", "rad/s^2", rate=1, span=(1e-5, 1e-3))

gyro, accelerometer = pair("EK3_GYRO_P_NSE", "EK3_ACC_P_NSE", NOISE, "m/s^2")
gyro_bias, accelerometer_bias = pair("EK3_GBIAS_P_NSE", "EK3_ABIAS_P_NSE", WALK, "m/s^3")

ARDUPILOT = Target(
    name="ardupilot",
    synonyms=("ekf3", "arducopter"),
    title=say("parameters of ArduPilot's EKF3"),
    fields=(gyro, replace(accelerometer, span=(0.01, 1.0)), gyro_bias, replace(accelerometer_bias, span=(1e-5, 0.02))),
    forms={".param": LineLayout("{name},{value}", PARAMETERS)},
    source="libraries/AP_NavEKF3/AP_NavEKF3_core.cpp: variances of a step (dt EK3_GYRO_P_NSE)^2 and, of the bias"
    " of the angle, (dt^2 EK3_GBIAS_P_NSE)^2, with dt = 12 ms (EKF_TARGET_DT); ranges of the parameters. "
    "The step is a whole number of samples, and so up to 2 ms shorter or longer",
    notes=(say("the defaults are larger, since they cover vibration in flight: values of a bench are lower bounds"),),
    step=0.012,
)

ARDUPILOT_TCAL = ThermalTarget(
    name="ardupilot-tcal",
    title=say("IMU temperature calibration of ArduPilot"),
    fields=(),
    forms={".param": LineLayout("{name},{value}", PARAMETERS)},
    source="libraries/AP_InertialSensor/AP_InertialSensor_tempcal.cpp (correct_sensor: polynomial of the third degree "
    "without constant in 1e-6, TEMP_REFERENCE 35 degC, temperature and calibration temperature limited to TMIN .. "
    "TMAX) and AP_InertialSensor_Backend.cpp (_rotate_and_correct_gyro: before offsets, scale and board orientation); "
    "Tools/scripts/tempcal_IMU.py. Names of instances 4 and 5: list of parameters. The fifth degree of pull request "
    "27295 is not in them. Not verified: how a vehicle takes the file",
    notes=(
        say("the record must be in the axes of the sensor, before AHRS_ORIENTATION, and without a correction"),
        say("the other parameters are hidden until ENABLE is 1: load the file twice, and restart"),
        say("after loading, calibrate gyro and accelerometer again: the correction is zero at the temperature of the "
            "calibration (INS_GYR*_CALTEMP, INS_ACC*_CALTEMP)"),
    ),
    prefixes={**{n: f"INS_TCAL{n}_" for n in (1, 2, 3)}, **{n: f"INS{n}_TCAL_" for n in (4, 5)}},
    letters={GYRO: "GYR", ACCELEROMETER: "ACC"},
    coefficient="{sensor}{power}_{axis}",
    axes=("X", "Y", "Z"),
    reference=35.0,
    constant=False,
    scale=1e6,
    together=True,
    enable="{prefix}ENABLE,1",
)  # fmt: skip
