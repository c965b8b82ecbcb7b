"""Micromechanical gyroscopes, and accelerometers."""

from allanite.phrases.phrase import say

from .device import Cause, Device

MEMS = Device(
    "mems",
    say("micromechanical (MEMS) gyroscope"),
    (say("gyro"),),
    {
        "Q": Cause(
            say("quantization noise"),
            (say("an output of angle increments in whole steps; rounding of a rate makes angle random walk instead"),),
            (say("a finer range or more bits"), say("'allanite budget' says what the rounding of the output adds")),
            say("IEEE 952, Annex C; allanite"),
        ),
        "N": Cause(
            say("angle random walk"),
            (
                say("thermo-mechanical noise, much faster than the sampling"),
                say("noise of the amplifier, rounding of the rate"),
            ),
            (
                say("average several sensors: N falls with the root of their number"),
                say("a smaller range, if rounding shows"),
            ),
            say("Woodman 2007, section 3.2.2; allanite"),
        ),
        "B": Cause(
            say("bias instability"),
            (say("flicker noise of the electronics and of other parts"),),
            (
                say("estimate the bias in the navigation filter"),
                say("averaging longer than the minimum of the curve is no use"),
            ),
            say("Woodman 2007, section 3.2.3; allanite"),
        ),
        "K": Cause(
            say("rate random walk"),
            (say("temperature of the surroundings, and self-heating"),),
            (
                say("calibrate the bias over temperature"),
                say("record the temperature; see whether 'allanite compensate' removes it"),
                say("give the bias of the navigation filter this driving noise"),
            ),
            say("Woodman 2007, section 3.2.4; Shiau; allanite"),
        ),
        "R": Cause(
            say("rate ramp"),
            (say("self-heating after it is switched on"), say("temperature that rises or falls during the record")),
            (say("exclude the warm-up"), say("calibrate the bias over temperature")),
            say("Woodman 2007, section 3.2.4; Shiau; allanite"),
        ),
        "GM": Cause(
            say("exponentially correlated bias"),
            (say("a drift of the bias with one correlation time, such as that of its temperature"),),
            (say("model it as a first-order state of the navigation filter"),),
            say("Koo 2012; allanite"),
        ),
    },
)

ACCELEROMETER = Device(
    "accelerometer",
    say("accelerometer"),
    (say("accelerometer"),),
    {
        "Q": Cause(
            say("velocity quantization noise"),
            (say("an output of velocity increments in whole steps"),),
            (
                say("finer steps of the output"),
                say("it does not accumulate: beyond a few seconds of navigation it can be ignored"),
            ),
            say("IEEE 952, Annex C (of the same output of a gyro); allanite"),
        ),
        "N": Cause(
            say("velocity random walk"),
            (say("thermo-mechanical noise, much faster than the sampling"), say("vibration of the support")),
            (say("isolate the support, and look for lines in the spectrum"), say("average several sensors")),
            say("Woodman 2007, section 4.2.2; allanite"),
        ),
        "B": Cause(
            say("bias instability"),
            (say("flicker noise of the electronics and of other parts"),),
            (say("estimate the bias in the navigation filter"),),
            say("Woodman 2007, section 4.2.3; allanite"),
        ),
        "K": Cause(
            say("acceleration random walk"),
            (
                say("slowly varying temperature"),
                say("a support whose tilt wanders: 1 arcsec changes a horizontal axis by 4.8 ug"),
            ),
            (say("calibrate the bias over temperature"), say("a massive pier; measure its tilt beside the sensor")),
            say("Woodman 2007, section 4.2.4 (temperature); allanite"),
        ),
        "R": Cause(
            say("acceleration ramp"),
            (say("self-heating after it is switched on"), say("a support that tilts steadily")),
            (say("exclude the warm-up"), say("calibrate the bias over temperature")),
            say("Woodman 2007, section 4.2.4 (temperature); allanite"),
        ),
    },
)
