"""Gazebo: the noise of an IMU in SDF, and the IMU plugin of gazebo-classic."""

from allanite.core.syntax import XML
from allanite.exporting.content import Content, number
from allanite.exporting.layouts import LineLayout, spread, told
from allanite.exporting.target import ACCELEROMETER, DENSITY, GYRO, WALK, Target, TargetField, pair
from allanite.phrases.phrase import say

SECTIONS = (
    (GYRO, "angular_velocity", ("rad/s", "rad/s^2/sqrt(Hz)")),
    (ACCELEROMETER, "linear_acceleration", ("m/s^2", "m/s^3/sqrt(Hz)")),
)


def sdf(content: Content) -> str:
    """The element `imu` of a sensor."""
    lines = [part for line in content.header for part in XML.comments(line)]
    lines.append("<imu>")
    for section in dict.fromkeys(entry.section for entry in content.entries):
        entries = content.of(section)
        lines += [f"  {part}" for entry in entries for part in XML.comments(f"{entry.name}: {told(entry)}")]
        lines.append(f"  <{section}>")
        for i, axis in enumerate("xyz"):
            inner = "".join(f"<{e.name}>{number(spread(e.values)[i])}</{e.name}>" for e in entries)
            lines.append(f'    <{axis}><noise type="gaussian"><mean>0.0</mean>{inner}</noise></{axis}>')
        lines.append(f"  </{section}>")
    return "\n".join([*lines, "</imu>"]) + "\n"


GAZEBO = Target(
    name="gazebo",
    synonyms=("sdf", "gz"),
    title=say("noise of an IMU in SDF, for Gazebo"),
    fields=tuple(
        field
        for sensor, section, (white, walk) in SECTIONS
        for field in (
            TargetField("stddev", sensor, "N", white, rate=1, section=section),
            TargetField("dynamic_bias_stddev", sensor, "K", walk, section=section),
            TargetField("dynamic_bias_correlation_time", sensor, "", "s", time=2, section=section),
        )
    ),
    forms={".sdf": sdf},
    simulates=True,
    source="gz-sensors, src/GaussianNoiseModel.cc: white noise of stddev per sample; the bias is a Gauss-Markov "
    "process driven with the variance dynamic_bias_stddev^2 T (1 - exp(-2 dt/T))/2 per step: "
    "dynamic_bias_stddev is K, not a standard deviation. The copy of 2018 had no dynamic bias",
    notes=(say("f is the update_rate of the sensor"), say("SDF 1.6 or later")),
    markov=True,
    each=True,
    comments=XML.pattern,
)

GAZEBO_CLASSIC = Target(
    name="gazebo-classic",
    title=say("IMU plugin of gazebo-classic (RotorS, PX4 SITL, UUV simulator)"),
    fields=(
        *pair("gyroscopeNoiseDensity", "accelerometerNoiseDensity", *DENSITY),
        *pair("gyroscopeRandomWalk", "accelerometerRandomWalk", *WALK),
        *pair("gyroscopeBiasCorrelationTime", "accelerometerBiasCorrelationTime",
              TargetField("", GYRO, "", "s", time=2), "s"),
    ),
    forms={
        ".sdf": LineLayout(
            "  <{name}>{value}</{name}>",
            syntax=XML,
            start=('<plugin name="imu_plugin" filename="libgazebo_imu_plugin.so">',),
            end=("</plugin>",),
        )
    },
    simulates=True,
    source="rotors_gazebo_plugins/src/gazebo_imu_plugin.cpp: white noise density/sqrt(dt), and a Gauss-Markov "
    "bias driven with the variance walk^2 T (1 - exp(-2 dt/T))/2 per step",
    notes=(say("gyroscopeTurnOnBiasSigma and accelerometerTurnOnBiasSigma do not follow from a static recording"),),
    markov=True,
    comments=XML.pattern,
)  # fmt: skip
