"""Devices of two papers: a gyro stabilizer, and a gyro with a magnetically suspended rotor."""

from .device import Cause, Device

STABILIZER = Device(
    "stabilizer",
    "gyro stabilizer",
    ("dimensionless", "angle"),
    {
        "Q": Cause(
            "white noise of sampling the stabilization error",
            ("conversion of the angle sensors' signals (resolvers) to numbers",),
            ("a finer converter, or a faster one whose samples are averaged",),
            "Gazaryan, table on p. 148 (name), p. 149 (resolvers, conversion in the control unit); allanite",
        ),
        "N": Cause(
            "random component of the angular stabilization error",
            ("mechanical and electronic parts of the stabilization loop together, not told apart by the paper",),
            ("read it at short averaging times, where drift has no part (in the paper up to 0.2 s)",
             "look at the spectrum for lines of bearings, motors and structure"),
            "Gazaryan, table on p. 148, conclusions 1 and 2, p. 143 (sources); allanite",
        ),
        "B": Cause(
            "instability of the zero position of the platform",
            ("not named by the paper; where no part of the curve is flat it is read at the minimum",),
            ("compare the minimum of the curve with the fitted coefficient before a cause is looked for",),
            "Gazaryan, table on p. 148, conclusion 3; allanite",
        ),
        "K": Cause(
            "random component of the rate of change of the stabilization error",
            ("random part of the platform's drift",),
            ("separate it from the steady drift by the Hadamard deviation, which does not see a trend",
             "repeat the record: two realisations do not give its mean size"),
            "Gazaryan, table on p. 148, conclusion 5 and the remark after it",
        ),
        "R": Cause(
            "trend of the stabilization error: drift of the platform",
            ("systematic part of the platform's drift", "temperature and vibration may change it"),
            ("estimate it at long averaging times (in the paper above 10 s) and compensate it",
             "take the random part off, which the Hadamard deviation gives"),
            "Gazaryan, table on p. 148, conclusions 1, 2 and 5",
        ),
        "GM": Cause(
            "exponentially correlated error",
            ("a loop with definite dynamics; in the paper probably that of force unloading",),
            ("compare the time constant with those of the loops", "look for its hump in the Hadamard deviation"),
            "Gazaryan, conclusion 4",
        ),
    },
    "The names hold where the signal is the angle of the platform itself, not a rate.",
)  # fmt: skip

MSCSG = Device(
    "mscsg",
    "magnetically suspended control and sensing gyro (MSCSG)",
    ("gyro",),
    {
        "Q": Cause(
            "quantization noise",
            ("the analogue-to-digital converter of the coil current",),
            ("more bits of the converter", "amplify the signal before it, within its range",
             "check with 'allanite budget': a converter of the current makes angle random walk rather than Q"),
            "Geng 2021, section 3.1 and 3.2, 1); allanite",
        ),
        "N": Cause(
            "angle random walk",
            ("high-frequency micro-vibration", "the stray magnetic field of the rotor when the gyro is on"),
            ("a controller that suppresses vibration (active disturbance rejection with an RBF network)",
             "damping elements in the path of the vibration",
             "mounting of several gyros such that errors cancel (double orthogonal or parallel)"),
            "Geng 2021, section 3.1 and 3.2, 2)",
        ),
        "B": Cause(
            "bias instability",
            ("electronics that fluctuate with temperature and surroundings",
             "the current control: fluctuation at the frequency of the displacement sensor, unstable feedback",
             "bad contacts and worn connectors", "friction noise of cables that are bent",
             "electromagnetic interference"),
            ("temperature compensation of the bridge, or of the output by a model",
             "small shielded connectors and low-noise cables", "layout and shielding of the electronics",
             "rotation modulation, best with two positions"),
            "Geng 2021, section 3.1 and 3.2, 3)",
        ),
        "K": Cause(
            "rate random walk",
            ("not known; the paper calls for more work",),
            ("record longer first: an hour says little about it",),
            "Geng 2021, section 3.1 and 3.2, 4); allanite",
        ),
        "R": Cause(
            "rate ramp",
            ("temperature of the gyro", "magnetic leakage and internal interference", "imbalance of the rotor",
             "earth rotation, or a platform that accelerates slowly"),
            ("measure the temperature (DS18B20) and compensate", "compensate the flux density of the air gap",
             "decouple the magnetic bearing and both axes", "a bias current in the coil against the static error",
             "balance the rotor, on line"),
            "Geng 2021, section 3.1 and 3.2, 5)",
        ),
    },
    "The rate comes from the current of the coil by the scale factor of the torquer.",
)  # fmt: skip
