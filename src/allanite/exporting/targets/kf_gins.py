"""KF-GINS: GNSS/INS integration of Wuhan University."""

from allanite.exporting.layouts import LineLayout
from allanite.exporting.target import ACCELEROMETER, GYRO, Target, TargetField
from allanite.phrases.phrase import say

KF_GINS = Target(
    name="kf-gins",
    title=say("imunoise of KF-GINS"),
    fields=(
        TargetField("arw", GYRO, "N", "deg/sqrt(h)"),
        TargetField("vrw", ACCELEROMETER, "N", "m/s/sqrt(h)"),
        TargetField("gbstd", GYRO, "K", "deg/h", weight=0.5, time=1),
        TargetField("abstd", ACCELEROMETER, "K", "mGal", weight=0.5, time=1),
        TargetField("corrtime", GYRO, "", "h", time=2),
    ),
    forms={".yaml": LineLayout("  {name}: [{triple}]", start=("imunoise:",), alone=("corrtime",))},
    source="src/kf-gins/gi_engine.cpp: densities arw^2 and 2 gbstd^2/T of continuous time; units of the loader: "
    "deg/sqrt(h), m/s/sqrt(h), deg/h, mGal, h",
    notes=(
        say("gbstd and abstd are those of a Gauss-Markov process, which with T = corrtime = 100 h is a random walk"),
        say("set initbgstd and initbastd: without them, KF-GINS starts with gbstd and abstd"),
        say("gsstd and asstd (scale factors, ppm) do not follow from a static recording"),
    ),
    each=True,
)
