"""Micromechanical gyroscopes, and accelerometers."""

from .device import Cause, Device

MEMS = Device(
    "mems",
    "micromechanical (MEMS) gyroscope",
    ("gyro",),
    {
        "Q": Cause(
            "quantization noise",
            ("an output of angle increments in whole steps; rounding of a rate makes angle random walk instead",),
            ("a finer range or more bits", "'allanite budget' says what the rounding of the output adds"),
            "IEEE 952, Annex C; allanite",
        ),
        "N": Cause(
            "angle random walk",
            ("thermo-mechanical noise, much faster than the sampling", "noise of the amplifier, rounding of the rate"),
            ("average several sensors: N falls with the root of their number", "a smaller range, if rounding shows"),
            "Woodman 2007, section 3.2.2; allanite",
        ),
        "B": Cause(
            "bias instability",
            ("flicker noise of the electronics and of other parts",),
            ("estimate the bias in the navigation filter", "averaging longer than the minimum of the curve is no use"),
            "Woodman 2007, section 3.2.3; allanite",
        ),
        "K": Cause(
            "rate random walk",
            ("temperature of the surroundings, and self-heating",),
            ("calibrate the bias over temperature", "record the temperature; see whether 'allanite compensate' takes "
             "it off", "give the bias of the navigation filter this driving noise"),
            "Woodman 2007, section 3.2.4; Shiau; allanite",
        ),
        "R": Cause(
            "rate ramp",
            ("self-heating after it is switched on", "temperature that rises or falls during the record"),
            ("exclude the warm-up", "calibrate the bias over temperature"),
            "Woodman 2007, section 3.2.4; Shiau; allanite",
        ),
        "GM": Cause(
            "exponentially correlated bias",
            ("a drift of the bias with one correlation time, such as that of its temperature",),
            ("model it as a first-order state of the navigation filter",),
            "Koo 2012; allanite",
        ),
    },
)  # fmt: skip

ACCELEROMETER = Device(
    "accelerometer",
    "accelerometer",
    ("accelerometer",),
    {
        "Q": Cause(
            "velocity quantization noise",
            ("an output of velocity increments in whole steps",),
            ("finer steps of the output",
             "it does not accumulate: beyond a few seconds of navigation it can be ignored"),
            "IEEE 952, Annex C (of the same output of a gyro); allanite",
        ),
        "N": Cause(
            "velocity random walk",
            ("thermo-mechanical noise, much faster than the sampling", "vibration of the support"),
            ("isolate the support, and look for lines in the spectrum", "average several sensors"),
            "Woodman 2007, section 4.2.2; allanite",
        ),
        "B": Cause(
            "bias instability",
            ("flicker noise of the electronics and of other parts",),
            ("estimate the bias in the navigation filter",),
            "Woodman 2007, section 4.2.3; allanite",
        ),
        "K": Cause(
            "acceleration random walk",
            ("slowly varying temperature",
             "a support whose tilt wanders: 1 arcsec changes a horizontal axis by 4.8 ug"),
            ("calibrate the bias over temperature", "a massive pier; measure its tilt beside the sensor"),
            "Woodman 2007, section 4.2.4 (temperature); allanite",
        ),
        "R": Cause(
            "acceleration ramp",
            ("self-heating after it is switched on", "a support that tilts steadily"),
            ("exclude the warm-up", "calibrate the bias over temperature"),
            "Woodman 2007, section 4.2.4 (temperature); allanite",
        ),
    },
)  # fmt: skip
