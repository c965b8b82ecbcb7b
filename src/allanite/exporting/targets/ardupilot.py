"""ArduPilot: the EKF3 of the autopilot."""

from dataclasses import replace

from allanite.exporting.layouts import LineLayout
from allanite.exporting.target import GYRO, Target, TargetField, pair
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
    forms={".param": LineLayout("{name},{value}")},
    source="libraries/AP_NavEKF3/AP_NavEKF3_core.cpp: variances of a step (dt EK3_GYRO_P_NSE)^2 and, of the bias"
    " of the angle, (dt^2 EK3_GBIAS_P_NSE)^2, with dt = 12 ms (EKF_TARGET_DT); ranges of the parameters. "
    "The step is a whole number of samples, and so up to 2 ms shorter or longer",
    notes=(say("the defaults are larger, since they cover vibration in flight: values of a bench are lower bounds"),),
    step=0.012,
)
