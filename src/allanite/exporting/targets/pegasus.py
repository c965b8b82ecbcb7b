"""Pegasus: the IMU of a simulator of vehicles in Isaac Sim."""

from allanite.exporting.layouts import JSON_COMMENT, JsonLayout
from allanite.exporting.target import ACCELEROMETER, GYRO, Target, TargetField
from allanite.phrases.phrase import say

PEGASUS = Target(
    name="pegasus",
    title=say("IMU of the Pegasus Simulator in Isaac Sim"),
    fields=tuple(
        TargetField(name, sensor, term, unit, time=0 if term else 2, section=section)
        for sensor, section, units in (
            (GYRO, "gyroscope", ("rad/s/sqrt(Hz)", "rad/s^2/sqrt(Hz)", "s")),
            (ACCELEROMETER, "accelerometer", ("m/s^2/sqrt(Hz)", "m/s^3/sqrt(Hz)", "s")),
        )
        for name, term, unit in zip(
            ("noise_density", "random_walk", "bias_correlation_time"), ("N", "K", ""), units, strict=True
        )
    ),
    forms={".json": JsonLayout(rate="update_rate")},
    simulates=True,
    source="pegasus/simulator/logic/sensors/imu.py: white noise density/sqrt(dt), and a Gauss-Markov bias driven with "
    "the variance walk^2 T (1 - exp(-2 dt/T))/2 per step. In the version that was read the bias is not added to the "
    "samples, and the gyro has the correlation time of the accelerometer",
    notes=(
        "config = json.load(open(file)); config.pop('comment'); IMU(config)",
        say(
            "Isaac Sim itself has no noise of an IMU; in Isaac Lab the standard deviation of a step is N sqrt(f), "
            "without drift"
        ),
    ),
    rated=True,
    comments=JSON_COMMENT,
)
