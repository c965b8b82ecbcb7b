"""The table of devices."""

from allanite.core.names import row_of

from .device import Device
from .micromechanical import ACCELEROMETER, MEMS
from .optical import FOG, RLG
from .platforms import MSCSG, STABILIZER

DEVICES: dict[str, Device] = {device.name: device for device in (STABILIZER, MSCSG, RLG, FOG, MEMS, ACCELEROMETER)}
"""By name."""


def device(name: str) -> Device:
    """A device of the table.

    Examples
    --------
    >>> device("fog").terms["R"].sources[0]
    'slow monotonic change of the intensity of the light source'
    """
    return row_of("device", name, DEVICES)
