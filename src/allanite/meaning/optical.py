"""Optical gyroscopes: ring laser and fiber optic."""

from .device import Cause, Device

RLG = Device(
    "rlg",
    "ring laser gyroscope",
    ("gyro",),
    {
        "Q": Cause(
            "quantization noise",
            ("the output counts whole interference fringes",),
            ("it does not accumulate: beyond a few seconds of navigation it can be ignored",),
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
            ("flicker noise of the electronics", "flicker noise of the plasma discharge"),
            ("record the discharge currents together with the rate; check whether 'allanite compensate' removes it",),
            "IEEE 647, Annex C (sources); allanite",
        ),
        "K": Cause(
            "rate random walk",
            ("uncertain; possibly an exponentially correlated process with a long correlation time",
             "slowly varying temperature"),
            ("record longer, and with the temperature; check whether 'allanite compensate' removes it",),
            "IEEE 647, Annex C (sources); allanite",
        ),
        "R": Cause(
            "rate ramp",
            ("slow monotonic change of the intensity of the laser", "warm-up after switch-on",
             "a platform that accelerates slowly"),
            ("exclude the warm-up", "control the intensity", "compensate by temperature"),
            "IEEE 647, Annex C (sources); allanite",
        ),
    },
)  # fmt: skip

FOG = Device(
    "fog",
    "fiber-optic gyroscope",
    ("gyro",),
    {
        "Q": Cause(
            "quantization noise",
            ("the digital nature of the output",),
            ("finer steps of the output",
             "it does not accumulate: beyond a few seconds of navigation it can be ignored"),
            "IEEE 952, Annex C; allanite",
        ),
        "N": Cause(
            "angle random walk",
            ("noise of the light with a correlation time much shorter than a sample: shot noise and relative intensity "
             "noise of the source", "thermal phase noise of the fiber, in long coils"),
            ("suppress the intensity noise of the source by feedback", "a higher modulation frequency, against thermal "
             "phase noise"),
            "IEEE 952, Annex C (correlation time); arXiv:2208.11213 (intensity and phase noise, both remedies)",
        ),
        "B": Cause(
            "bias instability",
            ("flicker noise of electronics and other components",),
            ("record supply voltage and temperature together with the rate; check whether 'allanite compensate' "
             "removes it",),
            "IEEE 952, Annex C (source); allanite",
        ),
        "K": Cause(
            "rate random walk",
            ("uncertain; possibly an exponentially correlated process with a long correlation time",
             "varying temperature gradients along the coil (Shupe effect)"),
            ("quadrupolar winding", "no heat source near the ends of the fiber",
             "record the temperature; check whether 'allanite compensate' removes it"),
            "IEEE 952, Annex C; Shupe 1980; Zhuo (winding, heat sources); allanite",
        ),
        "R": Cause(
            "rate ramp",
            ("slow monotonic change of the intensity of the light source", "a coil that warms up (Shupe effect)",
             "a platform that accelerates slowly"),
            ("exclude the warm-up", "control the intensity of the source",
             "compensate by the rate of change of the temperature"),
            "IEEE 952, Annex C (source, platform); Shupe 1980; allanite",
        ),
    },
)  # fmt: skip
