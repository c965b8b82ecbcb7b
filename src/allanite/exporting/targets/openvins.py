"""OpenVINS: visual-inertial odometry."""

from allanite.exporting.layouts import LineLayout
from allanite.exporting.target import DENSITY, WALK, Target, pair
from allanite.phrases.phrase import say

OPENVINS = Target(
    name="openvins",
    title=say("kalibr_imu_chain.yaml of OpenVINS"),
    fields=(
        *pair("gyroscope_noise_density", "accelerometer_noise_density", *DENSITY),
        *pair("gyroscope_random_walk", "accelerometer_random_walk", *WALK),
    ),
    forms={
        ".yaml": LineLayout(
            "  {name}: {value}",
            first=("%YAML:1.0",),
            start=("imu0:", "  rostopic: /imu0", "  time_offset: 0.0", "  update_rate: {rate}", '  model: "kalibr"'),
        )
    },
    source="ov_msckf/src/state/Propagator.cpp: the covariance of a step is sigma^2/dt in front of Jacobians that hold "
    "dt, so that the fields are densities; config/euroc_mav/kalibr_imu_chain.yaml",
    notes=(say("T_i_b, Tw, Ta, Tg and the rotations are calibrations: take them over from your file"),),
    rated=True,
)
