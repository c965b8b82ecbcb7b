"""Optical gyroscopes: ring laser and fibre optic."""

from .device import Cause, Device

RLG = Device(
    "rlg",
    "ring laser gyroscope",
    ("gyro",),
    {
        "Q": Cause(
            "quantization noise",
            ("the output is counted in whole pulses of the interference fringes",),
            ("it does not add up: for navigation beyond seconds it can be ignored",),
            "IEEE 647, Annex C; allanite",
        ),
        "N": Cause(
            "angle random walk",
            ("spontaneous emission of photons", "lock-in: every turn of the dither leaves a random angle"),
            ("better mirrors, for a smaller lock-in zone", "a higher frequency of the dither",
             "noise on the amplitude of the dither, so that the residual lock-in rate is small"),
            "IEEE 647, Annex C (emission, lock-in); Tehrani 2020 (residual lock-in rate, dither frequency); "
            "Enin 2017, introduction (dither, mirrors)",
        ),
        "B": Cause(
            "bias instability",
            ("flicker of the electronics", "flicker of the plasma discharge"),
            ("record the currents of the discharge beside the rate; see whether 'allanite compensate' takes it off",),
            "IEEE 647, Annex C (sources); allanite",
        ),
        "K": Cause(
            "rate random walk",
            ("uncertain; perhaps the beginning of an exponentially correlated process of long correlation time",
             "temperature that wanders"),
            ("record longer, and with the temperature; see whether 'allanite compensate' takes it off",),
            "IEEE 647, Annex C (sources); allanite",
        ),
        "R": Cause(
            "rate ramp",
            ("slow monotonic change of the intensity of the laser", "warming up after it is switched on",
             "a platform that accelerates slowly"),
            ("leave out the warm-up (--from)", "control the intensity", "compensate by temperature"),
            "IEEE 647, Annex C (sources); allanite",
        ),
    },
)  # fmt: skip

FOG = Device(
    "fog",
    "fibre-optic gyroscope",
    ("gyro",),
    {
        "Q": Cause(
            "quantization noise",
            ("the digital nature of the output",),
            ("finer steps of the output", "it does not add up: for navigation beyond seconds it can be ignored"),
            "IEEE 952, Annex C; allanite",
        ),
        "N": Cause(
            "angle random walk",
            ("noise of the light with a correlation time much shorter than a sample: shot noise and relative intensity "
             "noise of the source", "thermal phase noise of the fibre, in long coils"),
            ("suppress the intensity noise of the source by feedback", "a higher modulation frequency, against thermal "
             "phase noise"),
            "IEEE 952, Annex C (correlation time); arXiv:2208.11213 (intensity and phase noise, both remedies)",
        ),
        "B": Cause(
            "bias instability",
            ("electronics and other parts that flicker",),
            ("record supply and temperature beside the rate; see whether 'allanite compensate' takes it off",),
            "IEEE 952, Annex C (source); allanite",
        ),
        "K": Cause(
            "rate random walk",
            ("uncertain; perhaps the beginning of an exponentially correlated process of long correlation time",
             "gradients of temperature that wander along the coil (Shupe effect)"),
            ("quadrupolar winding", "no heat source near the ends of the fibre",
             "record the temperature; see whether 'allanite compensate' takes it off"),
            "IEEE 952, Annex C; Shupe 1980; Zhuo (winding, heat sources); allanite",
        ),
        "R": Cause(
            "rate ramp",
            ("slow monotonic change of the intensity of the light source", "a coil that warms up (Shupe effect)",
             "a platform that accelerates slowly"),
            ("leave out the warm-up (--from)", "control the intensity of the source",
             "compensate by the rate of change of the temperature"),
            "IEEE 952, Annex C (source, platform); Shupe 1980; allanite",
        ),
    },
)  # fmt: skip
