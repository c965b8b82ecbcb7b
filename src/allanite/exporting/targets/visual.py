"""Visual and lidar odometry, and factor graphs."""

from dataclasses import replace

from allanite.core.syntax import PYTHON
from allanite.exporting.layouts import LineLayout
from allanite.exporting.target import DENSITY, GYRO, WALK, Target, TargetField, pair
from allanite.phrases.phrase import say

KALIBR = Target(
    name="kalibr", title=say("imu.yaml of kalibr"),
    fields=(
        *pair("gyroscope_noise_density", "accelerometer_noise_density", *DENSITY),
        *pair("gyroscope_random_walk", "accelerometer_random_walk", *WALK),
    ),
    forms={".yaml": LineLayout("{name}: {value}", start=("rostopic: /imu0", "update_rate: {rate}"))},
    source="kalibr_common/ConfigReader.py: all values must be above 0; kalibr itself divides the densities by "
    "sqrt(dt). Wiki page IMU Noise Model",
    notes=(say("set rostopic to the topic of the recording"),), rated=True,
)  # fmt: skip

OPENVINS = Target(
    name="openvins", title=say("kalibr_imu_chain.yaml of OpenVINS"), fields=KALIBR.fields,
    forms={
        ".yaml": LineLayout(
            "  {name}: {value}", first=("%YAML:1.0",),
            start=("imu0:", "  rostopic: /imu0", "  time_offset: 0.0", "  update_rate: {rate}", '  model: "kalibr"'),
        )
    },
    source="ov_msckf/src/state/Propagator.cpp: the covariance of a step is sigma^2/dt in front of Jacobians that hold "
    "dt, so that the fields are densities; config/euroc_mav/kalibr_imu_chain.yaml",
    notes=(say("T_i_b, Tw, Ta, Tg and the rotations are calibrations: take them over from your file"),), rated=True,
)  # fmt: skip

SAMPLED_NOISE = TargetField("", GYRO, "N", "rad/s", weight=2.0, rate=1)
SAMPLED_WALK = TargetField("", GYRO, "K", "rad/s^2", rate=1)

VINS_MONO = Target(
    name="vins-mono", synonyms=("vins",), title=say("config file of VINS-Mono, its IMU part"),
    fields=(*pair("gyr_n", "acc_n", SAMPLED_NOISE, "m/s^2"), *pair("gyr_w", "acc_w", SAMPLED_WALK, "m/s^3")),
    forms={".yaml": LineLayout("{name}: {value}", first=("%YAML:1.0",))},
    source="vins_estimator/src/factor/integration_base.h: the midpoint of two samples whose noise is taken for "
    "independent has the covariance dt^2 gyr_n^2/2 per step, and the bias dt^2 gyr_w^2. N itself would be"
    " too small by sqrt(2 f)",
    notes=(say("g_norm is the local gravity and not part of the noise"),),
)  # fmt: skip

VINS_FUSION = replace(
    VINS_MONO, name="vins-fusion", synonyms=(), title=say("config file of VINS-Fusion, its IMU part"),
    source="vins_estimator/src/factor/integration_base.h, as in VINS-Mono",
)  # fmt: skip

ORB_SLAM3 = Target(
    name="orb-slam3", title=say("settings file of ORB-SLAM3, its IMU part"),
    fields=(*pair("IMU.NoiseGyro", "IMU.NoiseAcc", *DENSITY), *pair("IMU.GyroWalk", "IMU.AccWalk", *WALK)),
    forms={".yaml": LineLayout("{name}: {value}", first=("%YAML:1.0",), start=("IMU.Frequency: {rate}",))},
    source="src/Tracking.cc: Calib(Tbc, Ng sqrt(f), Na sqrt(f), Ngw/sqrt(f), Naw/sqrt(f)) with f = IMU.Frequency; "
    "src/ImuTypes.cc: covariance of a step (Ng sqrt(f) dt)^2, of the bias Ngw^2/f",
    notes=(say("files without File.version want IMU.Frequency as an integer"),), rated=True,
)  # fmt: skip

LIO_SAM = Target(
    name="lio-sam", title=say("params.yaml of LIO-SAM, its IMU part"),
    fields=(*pair("imuGyrNoise", "imuAccNoise", *DENSITY), *pair("imuGyrBiasN", "imuAccBiasN", *WALK)),
    forms={".yaml": LineLayout("  {name}: {value}", start=("lio_sam:",))},
    source="src/imuPreintegration.cpp: gyroscopeCovariance = imuGyrNoise^2, to which GTSAM applies dt; the bias "
    "between two key frames has the standard deviation sqrt(deltaTij) imuGyrBiasN",
    notes=(
        say("ROS 2: the keys stand below /**: ros__parameters: instead of lio_sam:"),
        say("imuGravity is the local gravity and not part of the noise"),
    ),
)  # fmt: skip

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
            "setIntegrationCovariance, the error of the numerical integration, is not an Allan coefficient; "
            "neither is setBiasAccOmegaInt (its name differs between versions), the covariance of the initial biases"
        ),
    ),
)
