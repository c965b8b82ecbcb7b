"""ORB-SLAM3: visual-inertial SLAM."""

from allanite.exporting.layouts import LineLayout
from allanite.exporting.target import DENSITY, WALK, Target, pair
from allanite.phrases.phrase import say

ORB_SLAM3 = Target(
    name="orb-slam3",
    title=say("settings file of ORB-SLAM3, its IMU part"),
    fields=(*pair("IMU.NoiseGyro", "IMU.NoiseAcc", *DENSITY), *pair("IMU.GyroWalk", "IMU.AccWalk", *WALK)),
    forms={".yaml": LineLayout("{name}: {value}", first=("%YAML:1.0",), start=("IMU.Frequency: {rate}",))},
    source="src/Tracking.cc: Calib(Tbc, Ng sqrt(f), Na sqrt(f), Ngw/sqrt(f), Naw/sqrt(f)) with f = IMU.Frequency; "
    "src/ImuTypes.cc: covariance of a step (Ng sqrt(f) dt)^2, of the bias Ngw^2/f",
    notes=(say("files without File.version want IMU.Frequency as an integer"),),
    rated=True,
)
