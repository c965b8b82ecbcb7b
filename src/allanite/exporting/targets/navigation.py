"""Integrated navigation and its simulation."""

from allanite.core.syntax import MATLAB as MATLAB_SYNTAX
from allanite.core.syntax import PYTHON
from allanite.exporting.layouts import JSON_COMMENT, JsonLayout, LineLayout
from allanite.exporting.target import ACCELEROMETER, DENSITY, GYRO, TIME, WALK, Target, TargetField, pair, sectioned
from allanite.phrases.phrase import say

KF_GINS = Target(
    name="kf-gins", title=say("imunoise of KF-GINS"),
    fields=(
        TargetField("arw", GYRO, "N", "deg/sqrt(h)"), TargetField("vrw", ACCELEROMETER, "N", "m/s/sqrt(h)"),
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
)  # fmt: skip

NAVEGO = Target(
    name="navego", title=say("IMU errors of NaveGo, in SI"),
    fields=(
        *pair("arw", "vrw", *DENSITY), *pair("gb_psd", "ab_psd", *WALK), *pair("gb_corr", "ab_corr", *TIME),
    ),
    forms={".m": LineLayout("imu.{name} = [{triple}];", syntax=MATLAB_SYNTAX)},
    source="ins_gnss.m: kf.Q = diag([arw, vrw, gb_psd, ab_psd].^2), of continuous time; F_update.m: the bias "
    "decays with -1/gb_corr. conversions/imu_si_errors.m computes gb_psd = gb_dyn sqrt(gb_corr), or "
    "divided by it in other versions; neither drives the bias with its density, which is K",
    notes=(
        say("set these after imu_si_errors, which would overwrite gb_psd and ab_psd"),
        say("gb_dyn and ab_dyn, the standard deviations at the start, do not follow from the noise"),
    ),
    markov=True, each=True, comments=MATLAB_SYNTAX.pattern,
)  # fmt: skip

GRAVITY = 9.80665 / 9.7803267714  # PSINS has 9.7803267714 m/s^2 for 1 g

PSINS = Target(
    name="psins", title=say("imuerrset of PSINS"),
    fields=(
        TargetField("web", GYRO, "N", "deg/sqrt(h)"),
        TargetField("wdb", ACCELEROMETER, "N", "ug/sqrt(Hz)", weight=GRAVITY**2),
        TargetField("sqrtR0G", GYRO, "K", "deg/h/sqrt(h)"),
        TargetField("sqrtR0A", ACCELEROMETER, "K", "ug/sqrt(h)", weight=GRAVITY**2),
    ),
    forms={
        ".m": LineLayout(
            "{name} = {value};", syntax=MATLAB_SYNTAX, start=("% constant biases are not noise", "eb = 0; db = 0;"),
            end=(
                "TauG = inf; TauA = inf;",
                "imuerr = imuerrset(eb, db, web, wdb, sqrtR0G, TauG, sqrtR0A, TauA);",
            ),
        )
    },
    source="imuerrset.m: with TauG = inf, sqrtR0G is the rate random walk in deg/h/sqrt(h); wdb in ug/sqrt(Hz) "
    "with the g of glvf.m, 9.7803267714 m/s^2. imuadderr.m simulates sqg only with a finite TauG; filters"
    " of 15 states have no driving noise of the bias unless kf.Qt is given imuerr.sqg^2",
    comments=MATLAB_SYNTAX.pattern,
)  # fmt: skip

GNSS_INS_SIM = Target(
    name="gnss-ins-sim",
    title=say("IMU error model of gnss-ins-sim"),
    fields=(
        TargetField("gyro_arw", GYRO, "N", "deg/sqrt(h)"),
        TargetField("gyro_b_stability", GYRO, "K", "deg/h", weight=0.5, time=1),
        TargetField("gyro_b_corr", GYRO, "", "s", time=2), TargetField("accel_vrw", ACCELEROMETER, "N", "m/s/sqrt(h)"),
        TargetField("accel_b_stability", ACCELEROMETER, "K", "m/s^2", weight=0.5, time=1),
        TargetField("accel_b_corr", ACCELEROMETER, "", "s", time=2),
    ),
    forms={
        ".py": LineLayout(
            "    '{name}': np.array([{triple}]),",
            PYTHON,
            start=(
                "import numpy as np",
                "",
                "imu_err = {",
                "    # constant biases are not noise",
                "    'gyro_b': np.zeros(3),",
                "    'accel_b': np.zeros(3),",
            ),
            end=("}",),
        )
    },
    simulates=True,
    source="gnss_ins_sim/sim/imu_model.py; gnss_ins_sim/pathgen/pathgen.py, bias_drift: a Gauss-Markov process "
    "driven by b_stability sqrt(1 - exp(-2 dt/T)), which starts at 0. Versions before drove it by "
    "b_stability dt, which depends on the rate. Without b_corr the drift is white noise",
    notes=(
        "imu = imu_model.IMU(accuracy=imu_err, axis=6)",
        say("there is no random walk: T is much longer than a run"),
    ),
    markov=True,
    each=True,
)  # fmt: skip

MATLAB = Target(
    name="matlab", synonyms=("imusensor", "simulink"),
    title=say("parameters of MATLAB's imuSensor, for loadparams(imu, file, 'IMU')"),
    fields=sectioned(
        "Gyroscope", "Accelerometer", ("NoiseDensity", *DENSITY), ("RandomWalk", *WALK),
        ("BiasInstability", TargetField("", GYRO, "B", "rad/s", needed=False), "m/s^2"),
    ),
    forms={".json": JsonLayout(root="IMU", extra=(("NoiseType", "single-sided"),), each=True)}, simulates=True,
    source="MathWorks, pages of gyroparams, accelparams and imuSensor, and the example of the Allan variance, "
    "which sets single-sided noise to match N and K. The keys of the file are the names of the "
    "properties; no sample of a file was seen",
    notes=(
        say(
            "NoiseType must be single-sided: with the default, double-sided, imuSensor makes N and K smaller by sqrt(2)"
        ),
        say(
            "BiasInstability is flicker only with BiasInstabilityCoefficients = fractalcoef(n, 1), n at least f times "
            "the longest averaging time"
        ),
    ),
    each=True, comments=JSON_COMMENT,
)  # fmt: skip
