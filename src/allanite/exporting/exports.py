"""The table of targets: a line each."""

from allanite.core.names import row_alike
from allanite.plugins import Registry

from .target import Target

from .targets.navigation import (  # isort: skip
    GNSS_INS_SIM, GTSAM, KALIBR, KF_GINS, LIO_SAM, MATLAB, NAVEGO, OPENVINS, ORB_SLAM3, PSINS, VINS_FUSION, VINS_MONO
)  # fmt: skip
from .targets.robots import (  # isort: skip
    ARDUPILOT, ARDUPILOT_TCAL, GAZEBO, GAZEBO_CLASSIC, PEGASUS, PX4, PX4_TC, ROBOT_LOCALIZATION, ROS_IMU)  # fmt: skip
from .targets.sheets import DATASHEET, STATESPACE

_OWN = (KALIBR, OPENVINS, ORB_SLAM3, VINS_MONO, VINS_FUSION, LIO_SAM, GTSAM, ROS_IMU, ROBOT_LOCALIZATION,
        PX4, ARDUPILOT, MATLAB, GNSS_INS_SIM, GAZEBO, GAZEBO_CLASSIC, PEGASUS, KF_GINS, PSINS, NAVEGO, STATESPACE,
        DATASHEET)  # fmt: skip

EXPORTS = Registry({row.name: row for row in _OWN}, "allanite.targets", kind=Target, key="name")
"""Targets of `allanite.export` by name."""

TEMPERATURE = {"px4": PX4_TC, "ardupilot": ARDUPILOT_TCAL}
"""Autopilots that take temperature polynomials, of `allanite.exporting.temperature_parameters`."""


def target_named(name: str) -> Target:
    """The row of a target; upper case and underscores do not matter."""
    return row_alike("target", name, EXPORTS)


def row_of_file(name: str) -> Target:
    """The row of a file that was written: of a target, or of the temperature parameters of an autopilot."""
    return next((row for row in TEMPERATURE.values() if row.name == name), None) or target_named(name)
