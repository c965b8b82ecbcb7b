"""The experiment, simulated: what the system would have measured with known errors."""

from collections.abc import Mapping

import numpy as np

from allanite.extending import FloatArray, demand_name, public, readout_noise

from .geometry import Gimbals, demand_angles
from .harmonics import NUISANCES, Harmonics


@public
def simulate(
    gimbals: Gimbals,
    harmonics: Mapping[str, Harmonics],
    *,
    nuisance: Mapping[str, float] | None = None,
    sigma: float,
    walk: float = 0.0,
    rng: "np.random.Generator",
) -> FloatArray:
    """Measured minus computed cosine of the angle between the momentum vectors, with known errors of the sensors.

    The errors are added to the angles and the cosine is computed of them, without linearising.

    Parameters
    ----------
    gimbals : Gimbals
        Where the gimbals stand.
    harmonics : mapping of angle to Harmonics
        The errors of their sensors, rad.
    nuisance : mapping of name to value, optional
        Keys of `design.NUISANCES`, rad (rad/s for A3).
    sigma : float
        Standard deviation of the white noise of a sample, rad.
    walk : float
        Step of a random walk from sample to sample, rad.
    rng : numpy.random.Generator
        The source of randomness.

    Returns
    -------
    array, shape (n,)
    """
    measured = readings(gimbals, harmonics)
    z = measured.cosine - gimbals.cosine
    for name, value in (nuisance or {}).items():
        demand_name("nuisance", name, NUISANCES)
        z += value * NUISANCES[name].column(gimbals)
    return z + readout_noise(z.size, sigma=sigma, walk=walk, rng=rng)


@public
def readings(gimbals: Gimbals, harmonics: Mapping[str, Harmonics]) -> Gimbals:
    """The angles as sensors with these errors read them."""
    demand_angles(harmonics)
    return gimbals.moved(**{angle: h.read(getattr(gimbals, angle)) for angle, h in harmonics.items()})
