"""MATLAB: imuSensor of the Navigation Toolbox."""

from allanite.exporting.layouts import JSON_COMMENT, JsonLayout
from allanite.exporting.target import ACCELEROMETER, GYRO, Target, TargetField
from allanite.phrases.phrase import say

FIELDS = tuple(
    TargetField(name, sensor, term, unit, section=section, needed=term != "B")
    for sensor, section, units in (
        (GYRO, "Gyroscope", ("rad/s/sqrt(Hz)", "rad/s^2/sqrt(Hz)", "rad/s")),
        (ACCELEROMETER, "Accelerometer", ("m/s^2/sqrt(Hz)", "m/s^3/sqrt(Hz)", "m/s^2")),
    )
    for name, term, unit in zip(("NoiseDensity", "RandomWalk", "BiasInstability"), "NKB", units, strict=True)
)

MATLAB = Target(
    name="matlab",
    synonyms=("imusensor", "simulink"),
    title=say("parameters of MATLAB's imuSensor, for loadparams(imu, file, 'IMU')"),
    fields=FIELDS,
    forms={".json": JsonLayout(root="IMU", extra=(("NoiseType", "single-sided"),), each=True)},
    simulates=True,
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
    each=True,
    comments=JSON_COMMENT,
)
