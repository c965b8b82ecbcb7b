"""The table of devices: micromechanical, optical, and those of two papers."""

from allanite.core.names import row_of
from allanite.phrases.phrase import say

from .device import Cause, Device

MEMS = Device(
    "mems", say("micromechanical (MEMS) gyroscope"), (say("gyro"),),
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
            say("bias instability"), (say("flicker noise of the electronics and of other parts"),),
            (
                say("estimate the bias in the navigation filter"),
                say("averaging longer than the minimum of the curve is no use"),
            ),
            say("Woodman 2007, section 3.2.3; allanite"),
        ),
        "K": Cause(
            say("rate random walk"), (say("temperature of the surroundings, and self-heating"),),
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
            (say("model it as a first-order state of the navigation filter"),), say("Koo 2012; allanite"),
        ),
    },
)  # fmt: skip

ACCELEROMETER = Device(
    "accelerometer", say("accelerometer"), (say("accelerometer"),),
    {
        "Q": Cause(
            say("velocity quantization noise"), (say("an output of velocity increments in whole steps"),),
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
            say("bias instability"), (say("flicker noise of the electronics and of other parts"),),
            (say("estimate the bias in the navigation filter"),), say("Woodman 2007, section 4.2.3; allanite"),
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
)  # fmt: skip


RLG = Device(
    "rlg", say("ring laser gyroscope"), (say("gyro"),),
    {
        "Q": Cause(
            say("quantization noise"), (say("the output counts whole interference fringes"),),
            (say("it does not accumulate: beyond a few seconds of navigation it can be ignored"),),
            say("IEEE 647, Annex C; allanite"),
        ),
        "N": Cause(
            say("angle random walk"),
            (say("spontaneous emission of photons"), say("lock-in: every turn of the dither leaves a random angle")),
            (
                say("better mirrors, for a smaller lock-in zone"), say("a higher frequency of the dither"),
                say("noise on the amplitude of the dither, so that the residual lock-in rate is small"),
            ),
            say(
                "IEEE 647, Annex C (emission, lock-in); Tehrani 2020 (residual lock-in rate, dither frequency); "
                "Enin 2017, introduction (dither, mirrors)"
            ),
        ),
        "B": Cause(
            say("bias instability"),
            (say("flicker noise of the electronics"), say("flicker noise of the plasma discharge")),
            (
                say(
                    "record the discharge currents together with the rate; check whether 'allanite compensate' removes "
                    "it"
                ),
            ),
            say("IEEE 647, Annex C (sources); allanite"),
        ),
        "K": Cause(
            say("rate random walk"),
            (
                say("uncertain; possibly an exponentially correlated process with a long correlation time"),
                say("slowly varying temperature"),
            ),
            (say("record longer, and with the temperature; check whether 'allanite compensate' removes it"),),
            say("IEEE 647, Annex C (sources); allanite"),
        ),
        "R": Cause(
            say("rate ramp"),
            (
                say("slow monotonic change of the intensity of the laser"), say("warm-up after switch-on"),
                say("a platform that accelerates slowly"),
            ),
            (say("exclude the warm-up"), say("control the intensity"), say("compensate by temperature")),
            say("IEEE 647, Annex C (sources); allanite"),
        ),
    },
)  # fmt: skip

FOG = Device(
    "fog", say("fiber-optic gyroscope"), (say("gyro"),),
    {
        "Q": Cause(
            say("quantization noise"), (say("the digital nature of the output"),),
            (
                say("finer steps of the output"),
                say("it does not accumulate: beyond a few seconds of navigation it can be ignored"),
            ),
            say("IEEE 952, Annex C; allanite"),
        ),
        "N": Cause(
            say("angle random walk"),
            (
                say(
                    "noise of the light with a correlation time much shorter than a sample: shot noise and relative "
                    "intensity noise of the source"
                ),
                say("thermal phase noise of the fiber, in long coils"),
            ),
            (
                say("suppress the intensity noise of the source by feedback"),
                say("a higher modulation frequency, against thermal phase noise"),
            ),
            say("IEEE 952, Annex C (correlation time); arXiv:2208.11213 (intensity and phase noise, both remedies)"),
        ),
        "B": Cause(
            say("bias instability"), (say("flicker noise of electronics and other components"),),
            (
                say(
                    "record supply voltage and temperature together with the rate; check whether 'allanite compensate' "
                    "removes it"
                ),
            ),
            say("IEEE 952, Annex C (source); allanite"),
        ),
        "K": Cause(
            say("rate random walk"),
            (
                say("uncertain; possibly an exponentially correlated process with a long correlation time"),
                say("varying temperature gradients along the coil (Shupe effect)"),
            ),
            (
                say("quadrupolar winding"), say("no heat source near the ends of the fiber"),
                say("record the temperature; check whether 'allanite compensate' removes it"),
            ),
            say("IEEE 952, Annex C; Shupe 1980; Zhuo (winding, heat sources); allanite"),
        ),
        "R": Cause(
            say("rate ramp"),
            (
                say("slow monotonic change of the intensity of the light source"),
                say("a coil that warms up (Shupe effect)"), say("a platform that accelerates slowly"),
            ),
            (
                say("exclude the warm-up"), say("control the intensity of the source"),
                say("compensate by the rate of change of the temperature"),
            ),
            say("IEEE 952, Annex C (source, platform); Shupe 1980; allanite"),
        ),
    },
)  # fmt: skip


CORRELATED = Cause(
    say("exponentially correlated error"),
    (say("a loop with definite dynamics; in the paper probably that of force unloading"),),
    (say("compare the time constant with those of the loops"), say("look for its hump in the Hadamard deviation")),
    say("Gazaryan, conclusion 4"),
)  # fmt: skip
"""Of one loop, or of each of two."""

STABILIZER = Device(
    "stabilizer", say("gyro stabilizer"), (say("dimensionless"), say("angle")),
    {
        "Q": Cause(
            say("white noise of sampling the stabilization error"),
            (say("conversion of the angle sensors' signals (resolvers) to numbers"),),
            (say("a finer converter, or a faster one whose samples are averaged"),),
            say("Gazaryan, table on p. 148 (name), p. 149 (resolvers, conversion in the control unit); allanite"),
        ),
        "N": Cause(
            say("random component of the angular stabilization error"),
            (say("mechanical and electronic parts of the stabilization loop together, not told apart by the paper"),),
            (
                say("read it at short averaging times, where drift is negligible (in the paper up to 0.2 s)"),
                say("look at the spectrum for lines of bearings, motors and structure"),
            ),
            say("Gazaryan, table on p. 148, conclusions 1 and 2, p. 143 (sources); allanite"),
        ),
        "B": Cause(
            say("instability of the zero position of the platform"),
            (say("not named by the paper; where no part of the curve is flat it is read at the minimum"),),
            (say("compare the minimum of the curve with the fitted coefficient before a cause is looked for"),),
            say("Gazaryan, table on p. 148, conclusion 3; allanite"),
        ),
        "K": Cause(
            say("random component of the rate of change of the stabilization error"),
            (say("random part of the platform's drift"),),
            (
                say("separate it from the steady drift by the Hadamard deviation, which does not see a trend"),
                say("repeat the record: two realisations do not give its mean size"),
            ),
            say("Gazaryan, table on p. 148, conclusion 5 and the remark after it"),
        ),
        "R": Cause(
            say("trend of the stabilization error: drift of the platform"),
            (say("systematic part of the platform's drift"), say("temperature and vibration may change it")),
            (
                say("estimate it at long averaging times (in the paper above 10 s) and compensate it"),
                say("estimate it together with the random part: it is not the Allan less the Hadamard deviation"),
            ),
            say("Gazaryan, table on p. 148, conclusions 1, 2 and 5; allanite"),
        ),
        "GM": CORRELATED, "GML": CORRELATED,
        "GM2": Cause(
            say("oscillation of the stabilization error"),
            (say("a loop that is weakly damped, or a resonance of the suspension or the structure"),),
            (
                say("compare its frequency with those of the loops and of the structure"),
                say("raise the damping of the loop: a lower gain, or more phase margin"),
            ),
            say("Gazaryan, conclusion 4 (loops); allanite"),
        ),
    },
    say("The names hold where the signal is the angle of the platform itself, not a rate."),
)  # fmt: skip

MSCSG = Device(
    "mscsg", say("magnetically suspended control and sensing gyro (MSCSG)"), (say("gyro"),),
    {
        "Q": Cause(
            say("quantization noise"), (say("the analogue-to-digital converter of the coil current"),),
            (
                say("more bits of the converter"), say("amplify the signal before it, within its range"),
                say("check with 'allanite budget': a converter of the current makes angle random walk rather than Q"),
            ),
            say("Geng 2021, section 3.1 and 3.2, 1); allanite"),
        ),
        "N": Cause(
            say("angle random walk"),
            (say("high-frequency micro-vibration"), say("the stray magnetic field of the rotor when the gyro is on")),
            (
                say("a controller that suppresses vibration (active disturbance rejection with an RBF network)"),
                say("damping elements in the path of the vibration"),
                say("mounting of several gyros such that errors cancel (double orthogonal or parallel)"),
            ),
            say("Geng 2021, section 3.1 and 3.2, 2)"),
        ),
        "B": Cause(
            say("bias instability"),
            (
                say("electronics that fluctuate with temperature and surroundings"),
                say("the current control: fluctuation at the frequency of the displacement sensor, unstable feedback"),
                say("bad contacts and worn connectors"), say("friction noise of cables that are bent"),
                say("electromagnetic interference"),
            ),
            (
                say("temperature compensation of the bridge, or of the output by a model"),
                say("small shielded connectors and low-noise cables"), say("layout and shielding of the electronics"),
                say("rotation modulation, best with two positions"),
            ),
            say("Geng 2021, section 3.1 and 3.2, 3)"),
        ),
        "K": Cause(
            say("rate random walk"), (say("not known; the paper calls for more work"),),
            (say("record longer first: an hour says little about it"),),
            say("Geng 2021, section 3.1 and 3.2, 4); allanite"),
        ),
        "R": Cause(
            say("rate ramp"),
            (
                say("temperature of the gyro"), say("magnetic leakage and internal interference"),
                say("imbalance of the rotor"), say("earth rotation, or a platform that accelerates slowly"),
            ),
            (
                say("measure the temperature (DS18B20) and compensate"),
                say("compensate the flux density of the air gap"), say("decouple the magnetic bearing and both axes"),
                say("a bias current in the coil against the static error"), say("balance the rotor, on line"),
            ),
            say("Geng 2021, section 3.1 and 3.2, 5)"),
        ),
    },
    say("The rate comes from the current of the coil by the scale factor of the torquer."),
)  # fmt: skip


DEVICES: dict[str, Device] = {device.name: device for device in (STABILIZER, MSCSG, RLG, FOG, MEMS, ACCELEROMETER)}
"""By name."""


def device(name: str) -> Device:
    """A device of the table.

    >>> device("fog").terms["R"].sources[0]
    'slow monotonic change of the intensity of the light source'
    """
    return row_of("device", name, DEVICES)
