"""GTSAM: preintegration of inertial measurements."""

from allanite.core.syntax import PYTHON
from allanite.exporting.layouts import LineLayout
from allanite.exporting.target import GYRO, Target, TargetField, pair
from allanite.phrases.phrase import say

WHITE = TargetField("", GYRO, "N", "(rad/s)^2/Hz", power=2)
BIAS = TargetField("", GYRO, "K", "(rad/s^2)^2/Hz", power=2)

GTSAM = Target(
    name="gtsam",
    synonyms=("combinedimufactor",),
    title=say("parameters of GTSAM's CombinedImuFactor, in Python"),
    fields=(
        *pair("setGyroscopeCovariance", "setAccelerometerCovariance", WHITE, "(m/s^2)^2/Hz"),
        *pair("setBiasOmegaCovariance", "setBiasAccCovariance", BIAS, "(m/s^3)^2/Hz"),
    ),
    forms={
        ".py": LineLayout(
            "params.{name}({value} * np.eye(3))",
            PYTHON,
            start=(
                "import gtsam",
                "import numpy as np",
                "",
                "params = gtsam.PreintegrationCombinedParams.MakeSharedU(9.80665)  # local gravity; z axis up",
            ),
        )
    },
    source="gtsam/navigation/CombinedImuFactor.h and PreintegrationParams.h: covariances of continuous time, "
    "which the integration divides by dt. The division was not read in the version of today",
    notes=(
        say(
            "setIntegrationCovariance and setBiasAccOmegaInt (its name differs between versions) do not follow from "
            "the noise"
        ),
    ),
)
