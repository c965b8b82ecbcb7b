"""Devices of two papers: a gyro stabilizer, and a gyro with a magnetically suspended rotor."""

from allanite.phrases.phrase import say

from .device import Cause, Device

CORRELATED = Cause(
    say("exponentially correlated error"),
    (say("a loop with definite dynamics; in the paper probably that of force unloading"),),
    (
        say("compare the time constant with those of the loops"),
        say("look for its hump in the Hadamard deviation"),
    ),
    say("Gazaryan, conclusion 4"),
)
"""Of one loop, or of each of two."""

STABILIZER = Device(
    "stabilizer",
    say("gyro stabilizer"),
    (say("dimensionless"), say("angle")),
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
        "GM": CORRELATED,
        "GML": CORRELATED,
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
)

MSCSG = Device(
    "mscsg",
    say("magnetically suspended control and sensing gyro (MSCSG)"),
    (say("gyro"),),
    {
        "Q": Cause(
            say("quantization noise"),
            (say("the analogue-to-digital converter of the coil current"),),
            (
                say("more bits of the converter"),
                say("amplify the signal before it, within its range"),
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
                say("bad contacts and worn connectors"),
                say("friction noise of cables that are bent"),
                say("electromagnetic interference"),
            ),
            (
                say("temperature compensation of the bridge, or of the output by a model"),
                say("small shielded connectors and low-noise cables"),
                say("layout and shielding of the electronics"),
                say("rotation modulation, best with two positions"),
            ),
            say("Geng 2021, section 3.1 and 3.2, 3)"),
        ),
        "K": Cause(
            say("rate random walk"),
            (say("not known; the paper calls for more work"),),
            (say("record longer first: an hour says little about it"),),
            say("Geng 2021, section 3.1 and 3.2, 4); allanite"),
        ),
        "R": Cause(
            say("rate ramp"),
            (
                say("temperature of the gyro"),
                say("magnetic leakage and internal interference"),
                say("imbalance of the rotor"),
                say("earth rotation, or a platform that accelerates slowly"),
            ),
            (
                say("measure the temperature (DS18B20) and compensate"),
                say("compensate the flux density of the air gap"),
                say("decouple the magnetic bearing and both axes"),
                say("a bias current in the coil against the static error"),
                say("balance the rotor, on line"),
            ),
            say("Geng 2021, section 3.1 and 3.2, 5)"),
        ),
    },
    say("The rate comes from the current of the coil by the scale factor of the torquer."),
)
