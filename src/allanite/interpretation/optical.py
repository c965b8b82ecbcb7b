"""Optical gyroscopes: ring laser and fiber optic."""

from allanite.phrases.phrase import say

from .device import Cause, Device

RLG = Device(
    "rlg",
    say("ring laser gyroscope"),
    (say("gyro"),),
    {
        "Q": Cause(
            say("quantization noise"),
            (say("the output counts whole interference fringes"),),
            (say("it does not accumulate: beyond a few seconds of navigation it can be ignored"),),
            say("IEEE 647, Annex C; allanite"),
        ),
        "N": Cause(
            say("angle random walk"),
            (say("spontaneous emission of photons"), say("lock-in: every turn of the dither leaves a random angle")),
            (
                say("better mirrors, for a smaller lock-in zone"),
                say("a higher frequency of the dither"),
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
                say("slow monotonic change of the intensity of the laser"),
                say("warm-up after switch-on"),
                say("a platform that accelerates slowly"),
            ),
            (say("exclude the warm-up"), say("control the intensity"), say("compensate by temperature")),
            say("IEEE 647, Annex C (sources); allanite"),
        ),
    },
)

FOG = Device(
    "fog",
    say("fiber-optic gyroscope"),
    (say("gyro"),),
    {
        "Q": Cause(
            say("quantization noise"),
            (say("the digital nature of the output"),),
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
            say("bias instability"),
            (say("flicker noise of electronics and other components"),),
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
                say("quadrupolar winding"),
                say("no heat source near the ends of the fiber"),
                say("record the temperature; check whether 'allanite compensate' removes it"),
            ),
            say("IEEE 952, Annex C; Shupe 1980; Zhuo (winding, heat sources); allanite"),
        ),
        "R": Cause(
            say("rate ramp"),
            (
                say("slow monotonic change of the intensity of the light source"),
                say("a coil that warms up (Shupe effect)"),
                say("a platform that accelerates slowly"),
            ),
            (
                say("exclude the warm-up"),
                say("control the intensity of the source"),
                say("compensate by the rate of change of the temperature"),
            ),
            say("IEEE 952, Annex C (source, platform); Shupe 1980; allanite"),
        ),
    },
)
