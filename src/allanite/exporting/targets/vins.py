"""VINS-Mono and VINS-Fusion: visual-inertial odometry, with the same preintegration."""

from dataclasses import replace

from allanite.exporting.layouts import LineLayout
from allanite.exporting.target import GYRO, Target, TargetField, pair
from allanite.phrases.phrase import say

NOISE = TargetField("", GYRO, "N", "rad/s", weight=2.0, rate=1)
WALK = TargetField("", GYRO, "K", "rad/s^2", rate=1)

VINS_MONO = Target(
    name="vins-mono",
    synonyms=("vins",),
    title=say("config file of VINS-Mono, its IMU part"),
    fields=(*pair("gyr_n", "acc_n", NOISE, "m/s^2"), *pair("gyr_w", "acc_w", WALK, "m/s^3")),
    forms={".yaml": LineLayout("{name}: {value}", first=("%YAML:1.0",))},
    source="vins_estimator/src/factor/integration_base.h: the midpoint of two samples whose noise is taken for "
    "independent has the covariance dt^2 gyr_n^2/2 per step, and the bias dt^2 gyr_w^2. N itself would be"
    " too small by sqrt(2 f)",
    notes=(say("g_norm is the local gravity and not part of the noise"),),
)

VINS_FUSION = replace(
    VINS_MONO,
    name="vins-fusion",
    synonyms=(),
    title=say("config file of VINS-Fusion, its IMU part"),
    source="vins_estimator/src/factor/integration_base.h, as in VINS-Mono",
)
