"""PX4: the EKF2 of the autopilot."""

from dataclasses import replace

from allanite.exporting.layouts import LineLayout
from allanite.exporting.target import GYRO, Target, TargetField, pair
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
    forms={".params": LineLayout("1\t1\t{name}\t{value}\t9")},
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
