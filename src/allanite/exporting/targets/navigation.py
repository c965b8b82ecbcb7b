"""Integrated navigation and its simulation, visual and lidar odometry, and factor graphs."""

from dataclasses import replace

from allanite.core.syntax import MATLAB as MATLAB_SYNTAX, PYTHON
from allanite.exporting.content import JSON_COMMENT, JsonLayout, LineLayout
from allanite.exporting.target import ACCELEROMETER, DENSITY, GYRO, TIME, WALK, Target, TargetField, pair, sectioned
from allanite.phrases.phrase import say

KF_GINS = Target(
    name="kf-gins", title=say("imunoise of KF-GINS"),
    fields=(TargetField("arw", GYRO, "N", "deg/sqrt(h)"), TargetField("vrw", ACCELEROMETER, "N", "m/s/sqrt(h)"),
            TargetField("gbstd", GYRO, "K", "deg/h", weight=0.5, time=1),
            TargetField("abstd", ACCELEROMETER, "K", "mGal", weight=0.5, time=1),
            TargetField("corrtime", GYRO, "", "h", time=2)),
    forms={".yaml": LineLayout("  {name}: [{triple}]", start=("imunoise:",), alone=("corrtime",))},
    source="src/kf-gins/gi_engine.cpp: densities arw^2 and 2 gbstd^2/T of continuous time; units of the loader: "
    "deg/sqrt(h), m/s/sqrt(h), deg/h, mGal, h",
    notes=(say("gbstd and abstd are those of a Gauss-Markov process, which with T = corrtime = 100 h is a random walk"),
           say("set initbgstd and initbastd: without them, KF-GINS starts with gbstd and abstd"),
           say("gsstd and asstd (scale factors, ppm) do not follow from a static recording")),
    each=True,
)  # fmt: skip

NAVEGO = Target(name="navego", title=say("IMU errors of NaveGo, in SI"),
                fields=(*pair("arw", "vrw", *DENSITY),
                        *pair("gb_psd", "ab_psd", *WALK), *pair("gb_corr", "ab_corr", *TIME)),
                forms={".m": LineLayout("imu.{name} = [{triple}];", syntax=MATLAB_SYNTAX)},
                source="ins_gnss.m: kf.Q = diag([arw, vrw, gb_psd, ab_psd].^2), of continuous time; F_update.m: the "
                "bias decays with -1/gb_corr. conversions/imu_si_errors.m computes gb_psd = gb_dyn sqrt(gb_corr), or "
                "divided by it in other versions; neither drives the bias with its density, which is K",
                notes=(say("set these after imu_si_errors, which would overwrite gb_psd and ab_psd"),
                       say("gb_dyn and ab_dyn, the standard deviations at the start, do not follow from the noise")),
                markov=True, each=True, comments=MATLAB_SYNTAX.pattern)  # fmt: skip

GRAVITY = 9.80665 / 9.7803267714  # PSINS has 9.7803267714 m/s^2 for 1 g

PSINS = Target(
    name="psins", title=say("imuerrset of PSINS"),
    fields=(TargetField("web", GYRO, "N", "deg/sqrt(h)"),
            TargetField("wdb", ACCELEROMETER, "N", "ug/sqrt(Hz)", weight=GRAVITY**2),
            TargetField("sqrtR0G", GYRO, "K", "deg/h/sqrt(h)"),
            TargetField("sqrtR0A", ACCELEROMETER, "K", "ug/sqrt(h)", weight=GRAVITY**2)),
    forms={".m": LineLayout("{name} = {value};",
                            syntax=MATLAB_SYNTAX, start=("% constant biases are not noise", "eb = 0; db = 0;"),
                            end=("TauG = inf; TauA = inf;",
                                 "imuerr = imuerrset(eb, db, web, wdb, sqrtR0G, TauG, sqrtR0A, TauA);"))},
    source="imuerrset.m: with TauG = inf, sqrtR0G is the rate random walk in deg/h/sqrt(h); wdb in ug/sqrt(Hz) with "
    "the g of glvf.m, 9.7803267714 m/s^2. imuadderr.m simulates sqg only with a finite TauG; filters of 15 states have "
    "no driving noise of the bias unless kf.Qt is given imuerr.sqg^2", comments=MATLAB_SYNTAX.pattern,
)  # fmt: skip

GNSS_INS_SIM = Target(
    name="gnss-ins-sim", title=say("IMU error model of gnss-ins-sim"),
    fields=(TargetField("gyro_arw", GYRO, "N", "deg/sqrt(h)"),
            TargetField("gyro_b_stability", GYRO, "K", "deg/h", weight=0.5, time=1),
            TargetField("gyro_b_corr", GYRO, "", "s", time=2),
            TargetField("accel_vrw", ACCELEROMETER, "N", "m/s/sqrt(h)"),
            TargetField("accel_b_stability", ACCELEROMETER, "K", "m/s^2", weight=0.5, time=1),
            TargetField("accel_b_corr", ACCELEROMETER, "", "s", time=2)),
    forms={".py": LineLayout("    '{name}': np.array([{triple}]),", PYTHON,
                             start=("import numpy as np", "", "imu_err = {", "    # constant biases are not noise",
                                    "    'gyro_b': np.zeros(3),", "    'accel_b': np.zeros(3),"),
                             end=("}",))},
    simulates=True, source="gnss_ins_sim/sim/imu_model.py; gnss_ins_sim/pathgen/pathgen.py, bias_drift: a Gauss-Markov "
    "process driven by b_stability sqrt(1 - exp(-2 dt/T)), which starts at 0. Versions before drove it by b_stability "
    "dt, which depends on the rate. Without b_corr the drift is white noise",
    notes=("imu = imu_model.IMU(accuracy=imu_err, axis=6)",
           say("there is no random walk: T is much longer than a run")),
    markov=True, each=True,
)  # fmt: skip

MATLAB = Target(
    name="matlab",
    synonyms=("imusensor", "simulink"), title=say("parameters of MATLAB's imuSensor, for loadparams(imu, file, 'IMU')"),
    fields=sectioned("Gyroscope", "Accelerometer", ("NoiseDensity", *DENSITY), ("RandomWalk", *WALK),
                     ("BiasInstability", TargetField("", GYRO, "B", "rad/s", needed=False), "m/s^2")),
    forms={".json": JsonLayout(root="IMU", extra=(("NoiseType", "single-sided"),), each=True)}, simulates=True,
    source="MathWorks, pages of gyroparams, accelparams and imuSensor, and the example of the Allan variance, which "
    "sets single-sided noise to match N and K. The keys of the file are the names of the properties; no sample of a "
    "file was seen", notes=(say("NoiseType must be single-sided: with the default, double-sided, imuSensor makes N and "
                                "K smaller by sqrt(2)"),
                            say("BiasInstability is flicker only with BiasInstabilityCoefficients = fractalcoef(n, 1), "
                                "n at least f times the longest averaging time")),
    each=True, comments=JSON_COMMENT,
)  # fmt: skip


KALIBR = Target(name="kalibr", title=say("imu.yaml of kalibr"),
                fields=(*pair("gyroscope_noise_density", "accelerometer_noise_density", *DENSITY),
                        *pair("gyroscope_random_walk", "accelerometer_random_walk", *WALK)),
                forms={".yaml": LineLayout("{name}: {value}", start=("rostopic: /imu0", "update_rate: {rate}"))},
                source="kalibr_common/ConfigReader.py: all values must be above 0; kalibr itself divides the densities "
                "by sqrt(dt). Wiki page IMU Noise Model", notes=(say("set rostopic to the topic of the recording"),),
                rated=True)  # fmt: skip

OPENVINS = Target(name="openvins", title=say("kalibr_imu_chain.yaml of OpenVINS"), fields=KALIBR.fields,
                  forms={".yaml": LineLayout("  {name}: {value}", first=("%YAML:1.0",),
                                             start=("imu0:", "  rostopic: /imu0", "  time_offset: 0.0",
                                                    "  update_rate: {rate}", '  model: "kalibr"'))},
                  source="ov_msckf/src/state/Propagator.cpp: the covariance of a step is sigma^2/dt in front of "
                  "Jacobians that hold dt, so that the fields are densities; config/euroc_mav/kalibr_imu_chain.yaml",
                  notes=(say("T_i_b, Tw, Ta, Tg and the rotations are calibrations: take them over from your file"),),
                  rated=True)  # fmt: skip

SAMPLED_NOISE = TargetField("", GYRO, "N", "rad/s", weight=2.0, rate=1)
SAMPLED_WALK = TargetField("", GYRO, "K", "rad/s^2", rate=1)

VINS_MONO = Target(
    name="vins-mono", synonyms=("vins",), title=say("config file of VINS-Mono, its IMU part"),
    fields=(*pair("gyr_n", "acc_n", SAMPLED_NOISE, "m/s^2"), *pair("gyr_w", "acc_w", SAMPLED_WALK, "m/s^3")),
    forms={".yaml": LineLayout("{name}: {value}", first=("%YAML:1.0",))},
    source="vins_estimator/src/factor/integration_base.h: the midpoint of two samples whose noise is taken for "
    "independent has the covariance dt^2 gyr_n^2/2 per step, and the bias dt^2 gyr_w^2. N itself would be too small by "
    "sqrt(2 f)", notes=(say("g_norm is the local gravity and not part of the noise"),),
)  # fmt: skip

VINS_FUSION = replace(VINS_MONO, name="vins-fusion", synonyms=(), title=say("config file of VINS-Fusion, its IMU part"),
                      source="vins_estimator/src/factor/integration_base.h, as in VINS-Mono")  # fmt: skip

ORB_SLAM3 = Target(
    name="orb-slam3", title=say("settings file of ORB-SLAM3, its IMU part"),
    fields=(*pair("IMU.NoiseGyro", "IMU.NoiseAcc", *DENSITY), *pair("IMU.GyroWalk", "IMU.AccWalk", *WALK)),
    forms={".yaml": LineLayout("{name}: {value}", first=("%YAML:1.0",), start=("IMU.Frequency: {rate}",))},
    source="src/Tracking.cc: Calib(Tbc, Ng sqrt(f), Na sqrt(f), Ngw/sqrt(f), Naw/sqrt(f)) with f = IMU.Frequency; "
    "src/ImuTypes.cc: covariance of a step (Ng sqrt(f) dt)^2, of the bias Ngw^2/f",
    notes=(say("files without File.version want IMU.Frequency as an integer"),), rated=True,
)  # fmt: skip

LIO_SAM = Target(name="lio-sam", title=say("params.yaml of LIO-SAM, its IMU part"),
                 fields=(*pair("imuGyrNoise", "imuAccNoise", *DENSITY), *pair("imuGyrBiasN", "imuAccBiasN", *WALK)),
                 forms={".yaml": LineLayout("  {name}: {value}", start=("lio_sam:",))},
                 source="src/imuPreintegration.cpp: gyroscopeCovariance = imuGyrNoise^2, to which GTSAM applies dt; "
                 "the bias between two key frames has the standard deviation sqrt(deltaTij) imuGyrBiasN",
                 notes=(say("ROS 2: the keys stand below /**: ros__parameters: instead of lio_sam:"),
                        say("imuGravity is the local gravity and not part of the noise")))  # fmt: skip

WHITE = TargetField("", GYRO, "N", "(rad/s)^2/Hz", power=2)
BIAS = TargetField("", GYRO, "K", "(rad/s^2)^2/Hz", power=2)

GTSAM = Target(
    name="gtsam", synonyms=("combinedimufactor",), title=say("parameters of GTSAM's CombinedImuFactor, in Python"),
    fields=(*pair("setGyroscopeCovariance", "setAccelerometerCovariance", WHITE, "(m/s^2)^2/Hz"),
            *pair("setBiasOmegaCovariance", "setBiasAccCovariance", BIAS, "(m/s^3)^2/Hz")),
    forms={".py": LineLayout("params.{name}({value} * np.eye(3))", PYTHON, start=(
        "import gtsam", "import numpy as np", "",
        "params = gtsam.PreintegrationCombinedParams.MakeSharedU(9.80665)  # local gravity; z axis up"))},
    source="gtsam/navigation/CombinedImuFactor.h and PreintegrationParams.h: covariances of continuous time, "
    "which the integration divides by dt. The division was not read in the version of today",
    notes=(
        say("setIntegrationCovariance, the error of the numerical integration, is not an Allan coefficient; "
            "neither is setBiasAccOmegaInt (its name differs between versions), the covariance of the initial biases"),
    ),
)  # fmt: skip
