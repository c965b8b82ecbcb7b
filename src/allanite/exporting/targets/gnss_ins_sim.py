"""gnss-ins-sim: simulation of inertial sensors in Python."""

from allanite.core.syntax import PYTHON
from allanite.exporting.layouts import LineLayout
from allanite.exporting.target import ACCELEROMETER, GYRO, Target, TargetField
from allanite.phrases.phrase import say

GNSS_INS_SIM = Target(
    name="gnss-ins-sim",
    title=say("IMU error model of gnss-ins-sim"),
    fields=(
        TargetField("gyro_arw", GYRO, "N", "deg/sqrt(h)"),
        TargetField("gyro_b_stability", GYRO, "K", "deg/h", weight=0.5, time=1),
        TargetField("gyro_b_corr", GYRO, "", "s", time=2),
        TargetField("accel_vrw", ACCELEROMETER, "N", "m/s/sqrt(h)"),
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
)
