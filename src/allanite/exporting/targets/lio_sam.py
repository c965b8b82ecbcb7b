"""LIO-SAM: lidar-inertial odometry."""

from allanite.exporting.layouts import LineLayout
from allanite.exporting.target import DENSITY, WALK, Target, pair
from allanite.phrases.phrase import say

LIO_SAM = Target(
    name="lio-sam",
    title=say("params.yaml of LIO-SAM, its IMU part"),
    fields=(*pair("imuGyrNoise", "imuAccNoise", *DENSITY), *pair("imuGyrBiasN", "imuAccBiasN", *WALK)),
    forms={".yaml": LineLayout("  {name}: {value}", start=("lio_sam:",))},
    source="src/imuPreintegration.cpp: gyroscopeCovariance = imuGyrNoise^2, to which GTSAM applies dt; the bias "
    "between two key frames has the standard deviation sqrt(deltaTij) imuGyrBiasN",
    notes=(
        say("ROS 2: the keys stand below /**: ros__parameters: instead of lio_sam:"),
        say("imuGravity is the local gravity and not part of the noise"),
    ),
)
