"""Typical sensors, as models: for simulation and planning before there is a recording."""

from allanite.core.aliases import public
from allanite.core.model import Model
from allanite.core.names import demand_name
from allanite.simulation.ring_laser import RING_LASERS

SENSORS: dict[str, str] = {
    "mems": "N 0.005 deg/sqrt(s), B 0.002 deg/s, K 3e-4 deg/s/sqrt(s)",
    "fog": "Q 0.4 arcsec, N 3 deg/h*sqrt(s), B 1 deg/h, K 0.09 deg/h/sqrt(s), R 0.002 deg/h/s",
    "rlg": "Q 0.5 arcsec, N 0.18 arcsec/sqrt(s), B 0.05 deg/h",
}
"""Models of typical gyros: MEMS, fiber-optic, ring laser. Orders of magnitude; not of any specific product."""


@public
def sensor(name: str) -> Model:
    """The model of a typical sensor, or of a known ring laser gyro.

    Parameters
    ----------
    name : str
        A key of `SENSORS` or of `RING_LASERS`, in small or capital letters.

    Raises
    ------
    UsageError
        The name is unknown.

    Examples
    --------
    >>> print(sensor("rlg"))
    Q = 0.5 arcsec, N = 0.003 deg/sqrt(h), B = 0.05 deg/h
    """
    known = name.lower()
    if known in RING_LASERS:
        return RING_LASERS[known].model
    demand_name("sensor", known, (*SENSORS, *RING_LASERS))
    return Model(SENSORS[known])
