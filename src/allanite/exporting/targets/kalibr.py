"""kalibr: camera-IMU calibration."""

from allanite.exporting.layouts import LineLayout
from allanite.exporting.target import DENSITY, WALK, Target, pair
from allanite.phrases.phrase import say

KALIBR = Target(
    name="kalibr",
    title=say("imu.yaml of kalibr"),
    fields=(
        *pair("gyroscope_noise_density", "accelerometer_noise_density", *DENSITY),
        *pair("gyroscope_random_walk", "accelerometer_random_walk", *WALK),
    ),
    forms={".yaml": LineLayout("{name}: {value}", start=("rostopic: /imu0", "update_rate: {rate}"))},
    source="kalibr_common/ConfigReader.py: all values must be above 0; kalibr itself divides the densities by "
    "sqrt(dt). Wiki page IMU Noise Model",
    notes=(say("set rostopic to the topic of the recording"),),
    rated=True,
)
